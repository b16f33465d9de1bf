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
from tests.cases.script import scripts
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
    (job,), (file,) = jobs.missing, jobs.files
    assert job.startswith(ALL) and jobs.minutes(job, 1) == 10 and jobs.minutes(job, 2) == 20
    done = Path(file)
    jobs.run(job, done)
    assert json.loads(done.read_text()) == {"runs": 6, "with_results": 3}
    jobs.show()
    made = table.read(jobs.folder)
    assert made["status"].tolist() == [table.DONE] * 3 + [table.FAILED] * 3
    with raises_code("sweep.failed_jobs", given=3, says="point 4, seed 0: no collision today"):
        jobs.verdict(tmp_path / "verdict.txt")
    assert not done.exists() and not (tmp_path / "verdict.txt").exists()
    monkeypatch.setattr(wall, "collide", collide)
    again = Jobs(tmp_path / "sweep.yaml")
    (rest,) = again.missing
    again.run(rest, Path(again.files[0]))
    again.verdict(tmp_path / "verdict.txt")
    assert json.loads((tmp_path / "verdict.txt").read_text()) == {"runs": 6, "failed": 0}
    assert Jobs(tmp_path / "sweep.yaml").missing == []


def test_an_edit_of_a_sweep_that_was_done_is_a_new_job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A job's file must not stand for other runs, nor a page for another content of a gathered function."""
    monkeypatch.chdir(tmp_path)
    content = {**WALL, "gather": ["e_n", {"function": "mine.py:depth", "unit": "1"}]}
    function = tmp_path / "mine.py"
    function.write_text("def depth(answer):\n    return 2.0 * answer['e_n']\n")
    jobs = Jobs(write(tmp_path, content))
    jobs.run(jobs.missing[0], Path(jobs.files[0]))
    jobs.verdict(tmp_path / "verdict.txt")
    longer = Jobs(write(tmp_path, {**content, "axes": {**WALL["axes"], "friction": [0.1, 0.2, 0.3]}}))
    (file,) = longer.files
    assert not Path(file).exists()
    longer.run(longer.missing[0], Path(file))
    assert json.loads(Path(file).read_text()) == {"runs": 3, "with_results": 3}
    longer.verdict(tmp_path / "verdict.txt")
    before = longer.word
    function.write_text("def depth(answer):\n    return 3.0 * answer['e_n']\n")
    edited = Jobs(tmp_path / "sweep.yaml")
    assert edited.missing == [] and edited.word != before


def test_a_script_that_was_never_run_has_the_time_of_the_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """24 h by default, since a script that is stopped by the cluster begins again; later runs have that of stored ones."""
    monkeypatch.chdir(tmp_path)
    scripts.write(tmp_path)
    axes = {"liquid.percent": [1.0, 2.0]}
    jobs = Jobs(
        write(tmp_path, {"name": "mine", "base": {"script": "in.script"}, "axes": axes, "gather": ["ruptures"]})
    )
    job, other = jobs.missing
    assert (jobs.minutes(job, 1), jobs.minutes(job, 2)) == (1440, 2880)
    name = jobs.plan.runs[0].built.name
    jobs.plan.store.place(name).mkdir(parents=True)
    jobs.plan.store.note(name, 1200.0)
    assert jobs.minutes(other, 1) == 60


def test_a_job_of_a_changed_sweep_is_refused(tmp_path: Path) -> None:
    jobs = Jobs(write(tmp_path, WALL))
    with raises_code("sweep.stale_job"):
        jobs.run("1-0-0123456789abcdef", tmp_path / "done.json")
    before = jobs.word
    assert Jobs(write(tmp_path, {**WALL, "gather": ["e_n"]})).word != before
