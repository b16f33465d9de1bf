"""A sweep as jobs: done once, a failed run named by the last rule and done again by the next call."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pywet.collisions.wall import wall
from pywet.errors import PywetError
from pywet.sweep import table
from pywet.sweep.workflow_jobs import ALL, Jobs
from tests.error_codes import raises_code
from tests.sweep.files import WALL, write


def test_a_failed_run_stops_no_other_and_is_a_job_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Table and page are made of what there is; the verdict names the failure and takes the job's file away."""
    monkeypatch.chdir(tmp_path)
    collide = wall.collide

    def refuse(problem: Any) -> Any:
        if problem.friction == 0.2:
            raise PywetError("no collision today")
        return collide(problem)

    monkeypatch.setattr(wall, "collide", refuse)
    jobs = Jobs(write(tmp_path, WALL))
    assert jobs.missing() == [ALL] and jobs.minutes(ALL, 1) == 10 and jobs.minutes(ALL, 2) == 20
    done = jobs.folder / "jobs" / f"{ALL}.json"
    jobs.run(ALL, done)
    assert json.loads(done.read_text()) == {"runs": 6, "with_results": 3}
    jobs.show()
    made = table.read(jobs.folder)
    assert made["status"].tolist() == [table.DONE] * 3 + [table.FAILED] * 3
    with raises_code("sweep.failed_jobs", given=3, says="point 4, seed 0: no collision today"):
        jobs.verdict(tmp_path / "verdict.txt")
    assert not done.exists() and not (tmp_path / "verdict.txt").exists()
    monkeypatch.setattr(wall, "collide", collide)
    again = Jobs(tmp_path / "sweep.yaml")
    assert again.missing() == [ALL]
    again.run(ALL, done)
    again.verdict(tmp_path / "verdict.txt")
    assert json.loads((tmp_path / "verdict.txt").read_text()) == {"runs": 6, "failed": 0}
    assert Jobs(tmp_path / "sweep.yaml").missing() == []


def test_a_job_of_a_changed_sweep_is_refused(tmp_path: Path) -> None:
    jobs = Jobs(write(tmp_path, WALL))
    with raises_code("sweep.stale_job"):
        jobs.run("1-0-0123456789abcdef", tmp_path / "done.json")
    before = jobs.word
    assert Jobs(write(tmp_path, {**WALL, "gather": ["e_n"]})).word != before
