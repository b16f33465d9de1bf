"""The word at the top of a custom scene's page and its table of what was not checked come from one place."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pywet import stages
from pywet.cases.screening import verdict
from pywet.runs.rundir import RunDir
from tests.cases.screening import synthetic

ROW = {"scale": "1", "count": 3, "largest": 0.0, "median": 0.0, "tolerance": 1e-12}
NOT_CHECKED = "capillary: the law neck is not built in and was not checked; its forces are taken as logged"


@pytest.mark.parametrize(
    ("changes", "word", "grade"),
    [
        ({}, "yes", "good"),
        ({"not_checked": [NOT_CHECKED]}, "in part", "fair"),
        ({"not_checked": ["capillary: solved again for a sample of 1000 records"]}, "in part", "fair"),
        ({"quantities": {"capillary": {**ROW, "largest": 0.1}}, "not_checked": [NOT_CHECKED]}, "no", "bad"),
    ],
)
def test_the_head_is_green_only_where_all_was_checked(changes: dict, word: str, grade: str, tmp_path: Path) -> None:
    """Green needs an empty list; how many points are in it is in the sentence; a deviation is red whatever else is missing."""
    run = synthetic.make(tmp_path / "run")
    stages.results(run)
    summary = json.loads((run / "summary.json").read_text())
    summary["checks"], summary["ledger_error"] = [{**c, "ok": True} for c in summary["checks"]], 0.0
    (run / "summary.json").write_text(json.dumps(summary))
    replay = {"ok": True, "quantities": {"capillary": ROW}, "unchecked": [], "not_checked": [], **changes}
    (run / "replay.json").write_text(json.dumps(replay))
    outcome = verdict.check_result(RunDir(run))
    assert (outcome.word, outcome.grade) == (word, grade)
    listed = verdict.not_checked(replay)
    assert grade == "bad" or not listed or f"; {len(listed)} point" in outcome.sentence
    assert (grade == "good") == (not listed and grade != "bad")
