"""The sweep over moisture and stroke: pooled numbers in closed form, the stored table, the table of the page."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pywet.products.partition import wilson
from studies.wet_strip import figure, measures

ROOT = Path(__file__).resolve().parents[2]


def rows(*passed: int) -> pd.DataFrame:
    """Seeds of one point in which so many of the class of ratio 0.9 passed, and all finer ones."""
    given = {f"unders_{name}": [figure.INSERTED[name]] * len(passed) for name in ("d05", "d07", "d08")}
    return pd.DataFrame({**given, "unders_d09": passed, "unders_d12": [0] * len(passed)})


def test_seeds_are_pooled() -> None:
    """30 of 80 spheres of ratio 0.9; by mass (80/8 + 40 0.343 + 40 0.512 + 15 0.729)/(... + 40 0.729) of the undersize."""
    share, low, high = figure.passed(rows(10, 20), "d09")
    assert (share, low, high) == (0.375, *wilson(30, 80))
    fine = 80 * 0.5**3 + 40 * 0.7**3 + 40 * 0.8**3
    mean, half = figure.recovery(rows(10, 20))
    assert mean == pytest.approx((fine + 15 * 0.9**3) / (fine + 40 * 0.9**3))
    assert half == pytest.approx(1.959964 * 0.9**3 * (80 * 0.375 * 0.625) ** 0.5 / (2 * (fine + 40 * 0.9**3)), rel=1e-6)


def test_the_stored_runs_are_consistent_and_the_page_has_their_numbers() -> None:
    """No more spheres left than entered; the recovery of a run follows from its counts, the table of the page from them."""
    table = pd.read_csv(figure.STORED)
    assert not table.duplicated(["moisture_percent", "amplitude_mm", "seed"]).any()
    for name, count in figure.INSERTED.items():
        assert (table[f"unders_{name}"] + table[f"overs_{name}"] <= count).all()
    for k in range(len(table)):
        assert figure.recovery(table.iloc[k : k + 1])[0] == pytest.approx(table["recovery"][k], rel=1e-5)
    assert "\n".join(figure.page_rows(table)) in (ROOT / "docs" / "screens.md").read_text()
    assert [*figure.INSERTED] == [*measures.CLASSES]
