"""Reasons for statements that do not hold: read from runs, said with their numbers."""

from __future__ import annotations

import csv
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from studies.full_scale import reasons, stored_runs
from studies.full_scale.judging import FAILS, judge
from studies.full_scale.statements import STATEMENTS


def test_liquid_counts_at_the_last_output_above() -> None:
    """Sphere 0 passes at output 1 (0.5 before), sphere 2 at output 2 (3 before), sphere 1 never; 10 in all."""
    classes = [SimpleNamespace(name="small", type=1), SimpleNamespace(name="near_mesh", type=2)]
    line = SimpleNamespace(
        passed=np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1]], dtype=bool),
        liquid=np.array([[0.5, 1, 2], [0.4, 1, 3], [0.1, 1, 3.3]]),
        types=np.array([1, 1, 2]),
        initial_film=np.array([4.0, 4.0, 2.0]),
    )
    run: Any = SimpleNamespace(scene=SimpleNamespace(classes=classes), timeline=line)
    assert stored_runs.carried(run) == {"small": pytest.approx(0.05), "near_mesh": pytest.approx(0.3)}


def test_trials_are_compared_by_their_means_from_half_a_second_on(tmp_path: Path) -> None:
    """Y of 1, 0.8 and 0.4 at 0, 0.5 and 1 s: 0.6; the small ones' of half of that 0.3."""
    table = pd.DataFrame({"time_since_opening_s": [-0.1, 0.0, 0.5, 1.0], "fraction_retained": [1.0, 1.0, 0.8, 0.4]})
    for kind, share in (("small", 0.5), ("near_mesh", 1.0)):
        table[f"fraction_retained_{kind}"] = share * table["fraction_retained"]
    run: Any = SimpleNamespace(path=Path("deep-3"), table=lambda name: table)
    reasons.curves([run]).to_csv(tmp_path / "7.csv", index=False)
    of = reasons._trials(tmp_path)
    assert (of("deep", 3, "all"), of("deep", 3, "small")) == (pytest.approx(0.6), pytest.approx(0.3))


def test_each_statement_that_fails_is_named_and_an_unknown_reason_reported() -> None:
    assert reasons.grouped({3: reasons.reason(3, {})})[0] == "- Statement 3: not looked for yet."


def test_stored_runs_that_contradict_the_paper_have_their_reasons() -> None:
    """Expect a reason from stored tables for each statement that is not confirmed."""
    campaign, rigs = (stored_runs.variants(folder) for folder in (stored_runs.CAMPAIGN, stored_runs.RIGS))
    runs = stored_runs.default(campaign[""], rigs[stored_runs.DEFAULT])
    failed = [s.number for s in STATEMENTS if judge(s, runs).verdict == FAILS]
    with open("docs/full_scale/reasons.csv", newline="", encoding="utf-8") as file:
        stored = {int(row["statement"]): row["reason"] for row in csv.DictReader(file)}
    page = Path("docs/full_scale.md").read_text()
    assert set(failed) <= set(stored) <= {n for numbers in reasons.GROUPS.values() for n in numbers}
    assert all(stored[n] == reasons.reason(n, runs) for n in stored)
    assert all(f"**{title}**" in page and stored[numbers[0]] in page for title, numbers in reasons.GROUPS.items())
