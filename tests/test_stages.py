"""Stages of a case: what a failure leaves behind and what comes after it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from pywet import config, run_folder, stages
from pywet.cases.screening import cases, verdict
from pywet.config.entries import NonNegativeEntry
from pywet.errors import PywetError
from pywet.runs import record
from pywet.runs.rundir import RunDir
from tests.cases.screening import synthetic
from tests.import_graph import ROOT

GOOD_REPLAY = {
    "quantities": {
        "bridge_volume": {"scale": "itself", "count": 3, "largest": 2e-12, "median": 1e-16, "tolerance": 1e-9}
    }
}


def _fail() -> None:
    raise PywetError("the engine was given nonsense", code="engine.stopped")


def _finish(run_dir: Path, fail_at: str | None = None) -> None:
    """Every stage, with real results and all else pretended."""
    with run_folder.hold(run_dir):
        for stage in stages.NEEDS:
            real = (lambda: stages.results(run_dir)) if stage == "results" else (lambda: None)
            stages.attempt(run_dir, stage, _fail if stage == fail_at else real)


def test_seeds_of_a_case_have_one_fingerprint_without_the_seed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cases with the seeds 8 and 9 differ in their fingerprints and not in the second one; another viscosity is another case."""
    monkeypatch.setattr(cases, "build", lambda *given: given[-1]())
    usual = config.load(ROOT / "config")
    materials = usual.materials
    liquid = materials.liquid.model_copy(update={"viscosity_Pa_s": NonNegativeEntry(value=0.002, source="assumption")})
    other = replace(usual, materials=materials.model_copy(update={"liquid": liquid}))
    for name, of in (("a", usual.with_seed(8)), ("b", usual.with_seed(9)), ("c", other.with_seed(10))):
        (tmp_path / name).mkdir()
        stages.build(of, 2, "smoke", tmp_path / name)
    a, b, c = (tmp_path / name for name in "abc")
    assert len({record.left_identity(run) for run in (a, b, c)}) == len((a, b, c))
    assert record.alike(a, b) and not record.alike(a, c)


def test_a_failed_stage_keeps_its_reason_and_the_next_pass_it_on(tmp_path: Path) -> None:
    _finish(tmp_path, fail_at="simulate")
    last = stages.Status.read(tmp_path, "vtk")
    assert (last.ok, last.failed_at, last.code) == (False, "simulate", "engine.stopped")
    assert verdict.problems(tmp_path) == ["stage simulate failed: the engine was given nonsense"]


def test_a_failed_replay_does_not_take_the_results_along(tmp_path: Path) -> None:
    run = synthetic.make(tmp_path / "case02")
    _finish(run, fail_at="replay")
    assert stages.Status.read(run, "results").ok
    assert record.outcome(run).failed_at == "replay"


def test_a_fault_of_the_program_is_a_reason_too(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    status = stages.attempt(tmp_path, "scene", lambda: 1 / 0)
    assert status.reason == "fault in the program, ZeroDivisionError: division by zero (traceback in the log)"
    assert "Traceback" in caplog.text


def test_a_case_cut_off_names_the_missing_stage(tmp_path: Path) -> None:
    stages.attempt(tmp_path, "scene", lambda: None)
    assert verdict.problems(tmp_path) == ["it was not run to the end: stage simulate is missing"]


def test_judging_forgets_failed_stages_so_that_they_are_tried_again(tmp_path: Path) -> None:
    good, bad = tmp_path / "case01", tmp_path / "case05"
    _finish(synthetic.make(good, moist=False))
    _finish(bad, fail_at="simulate")
    assert stages.judge([good, bad]) == ["case05: stage simulate failed: the engine was given nonsense"]
    assert not (bad / "status" / "simulate.json").exists()
    assert (bad / "status" / "scene.json").exists()
    assert (good / "status" / "simulate.json").exists()


@pytest.mark.parametrize("left", ["", "{", "[]", '{"stage": "vtk"}'])
def test_a_status_file_cut_off_is_a_failed_stage(tmp_path: Path, left: str) -> None:
    """As a power cut leaves it: a sentence, and forgotten."""
    run = synthetic.make(tmp_path / "case01", moist=False)
    _finish(run)
    (run / "status" / "vtk.json").write_text(left)
    assert "vtk.json" in stages.judge([run])[0]
    assert not (run / "status" / "vtk.json").exists()


def test_a_moist_run_is_believed_only_with_a_good_replay_and_ledger(tmp_path: Path) -> None:
    run = synthetic.make(tmp_path / "case02")
    _finish(run)
    assert verdict.objections(RunDir(run)) == ["the run was not replayed"]
    (run / "replay.json").write_text(json.dumps(GOOD_REPLAY))
    assert verdict.objections(RunDir(run)) == []
    bad = {"quantities": {"bridge_volume": {**GOOD_REPLAY["quantities"]["bridge_volume"], "largest": 3e-9}}}
    (run / "replay.json").write_text(json.dumps(bad))
    assert verdict.objections(RunDir(run)) == [
        "the replay disagrees on bridge_volume: 3e-09 relative, allowed is 1e-09"
    ]
    summary = json.loads((run / "summary.json").read_text())
    (run / "summary.json").write_text(json.dumps({**summary, "ledger_error": 1e-11}))
    assert (
        verdict.objections(RunDir(run))[0]
        == "the liquid ledger is off by 1e-11 of the initial liquid, allowed is 1e-12"
    )


def test_summary_counts_speed_events_and_ledger(tmp_path: Path) -> None:
    run = synthetic.make(tmp_path / "case02")
    stages.results(run)
    summary = json.loads((run / "summary.json").read_text())
    # 200 steps of 3 spheres in 2 s.
    assert summary["particle_steps_per_s"] == 300.0
    assert summary["events"] == {"formations": 4, "ruptures": 2, "standing_bridges": 2}
    assert summary["spheres"] == {"POM 8 mm": 1, "POM 4 mm": 2}
    assert summary["ledger_error"] <= 1e-15
    energy = summary["energy_J"]
    assert (energy["kinetic"], energy["gravity"], energy["contact"]) == (2e-6, 5e-6, -3e-6)
    assert abs(energy["unaccounted"]) < 1e-18
    assert summary["versions"]["liggghts"] == "3.8.0"


def test_summary_of_a_dry_run_knows_gravity_and_the_rest(tmp_path: Path) -> None:
    run = synthetic.make(tmp_path / "case01", moist=False)
    stages.results(run)
    energy = json.loads((run / "summary.json").read_text())["energy_J"]
    assert energy["contact_and_wall_motion"] == pytest.approx(-energy["gravity"], rel=1e-12)  # velocities are unchanged
    assert energy["gravity"] != 0.0 and energy["unaccounted"] is None


def test_what_is_printed_goes_to_the_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with stages.logged(tmp_path / "logs" / "stage.log"):
        print("one line")
    assert (tmp_path / "logs" / "stage.log").read_text() == "one line\n"
    assert capsys.readouterr().out == ""
