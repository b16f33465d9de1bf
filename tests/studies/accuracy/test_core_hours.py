"""The curve of error over core-hours, and the tables of docs/accuracy.md that are made with it."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest

from pywet import config
from studies.accuracy import core_hours

ROOT = Path(__file__).parents[3]
CONFIG = config.load(ROOT / "config")


def test_the_tables_of_the_page_are_made_from_the_stored_study() -> None:
    text = core_hours.PAGE.read_text()
    assert core_hours.with_blocks(text, core_hours.blocks(CONFIG)) == text
    assert core_hours.with_blocks("<!-- a -->\nold\n<!-- end of a -->", {"a": ["new"]}) == (
        "<!-- a -->\nnew\n<!-- end of a -->"
    )


@pytest.mark.parametrize("kind", ["moist", "dry"])
def test_a_longer_run_on_the_curve_is_more_accurate(kind: str) -> None:
    """At reduced scale no combination beats the default by more than the law's share of the liquid, 2 %."""
    line, default = core_hours.front(CONFIG, kind, "reduced")
    assert len(line) > 4
    assert all(a.seconds < b.seconds and a.error > b.error for a, b in pairwise(line))
    faster = [p for p in line if p.seconds < default.seconds]
    assert faster and all(p.error > default.error for p in faster)
    assert default.error == pytest.approx(0.020 if kind == "moist" else 0.0075, abs=5e-4)
