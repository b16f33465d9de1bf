"""The sections `scene` and `results` of the replay: injected faults are named, sound scenes and runs raise no alarm."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml

from pywet import config
from pywet.cases.screening import cases
from reference_impl.replay import command, io
from reference_impl.replay.replay import replay, table
from reference_impl.scene import check as scene
from reference_impl.tables import check as results
from studies.subset import with_spheres
from tests.cases.screening import synthetic
from tests.reference_impl.injected_files import RESULTS, SCENE, edit, put, times

ROOT = Path(__file__).parents[2]
CONFIG = config.load(ROOT / "config")
OF_BUILT = {"scene_configuration", "scene_numbers", "scene_plan", "scene_walls", "scene_tables", "scene_start"}


@pytest.fixture
def copy(screened_dir: Path, tmp_path: Path) -> Path:
    """The sound run, to be spoiled."""
    return Path(shutil.copytree(screened_dir, tmp_path / "run"))


@pytest.mark.engine
@pytest.mark.parametrize("name", SCENE)
def test_fault_of_the_scene_is_named(copy: Path, name: str) -> None:
    fault = SCENE[name]
    fault.change(copy)
    found = scene.check(copy)
    assert fault.quantity in [q.name for q in found.quantities if not q.ok]
    assert [f["sentence"] for f in found.findings if fault.words in f["sentence"]], [
        f["sentence"] for f in found.findings
    ]


@pytest.mark.engine
@pytest.mark.parametrize("name", RESULTS)
def test_fault_of_the_results_is_named(copy: Path, name: str) -> None:
    fault = RESULTS[name]
    fault.change(copy)
    found = results.check(copy)
    assert [q.name for q in found.quantities if not q.ok] == [fault.quantity]
    assert [f["sentence"] for f in found.findings if fault.words in f["sentence"]], [
        f["sentence"] for f in found.findings
    ]


@pytest.mark.engine
def test_sound_run_agrees_and_says_what_was_compared(screened_dir: Path) -> None:
    found = json.loads((screened_dir / "replay.json").read_text())
    assert found["ok"] and found["scene"]["ok"] and found["results"]["ok"]
    assert found["scene"]["findings"] == found["results"]["findings"] == []
    assert found["quantities"]["scene_numbers"]["count"] > 100 and found["quantities"]["results_summary"]["count"] > 50
    # all is computed twice in double precision: what differs is round-off of sums over the spheres
    assert max(q["largest"] for name, q in found["quantities"].items() if name.startswith(("scene", "results"))) < 1e-12
    assert "scene: set by hand after the configuration: classes.count, duration_s, output" in found["not_checked"]


@pytest.mark.engine
def test_replay_counts_and_shows_the_sections(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A fault of either is a disagreement of the whole: verdict, table, findings, exit status."""
    SCENE["amplitude 0.1 % high"].change(copy)
    put("fraction_retained_end", 0.123, "summary.json")(copy)
    assert command.run([copy]) == 1
    output_text = capsys.readouterr()
    assert "fault: scene: vibration.amplitude_m.z is 0.0009009, expected 0.0009" in output_text.out
    assert "fault: results: summary.json: fraction_retained_end is 0.123" in output_text.out
    assert "scene: DISAGREES" in output_text.out and "results: DISAGREES" in output_text.out
    assert "scene_numbers" in output_text.err and "results_summary" in output_text.err
    assert json.loads((copy / "replay.json").read_text())["ok"] is False


@pytest.mark.engine
def test_without_configuration_or_results_nothing_is_reported_to_agree(copy: Path) -> None:
    (copy / "config.json").unlink()
    (copy / "summary.json").unlink()
    shutil.rmtree(copy / "results")
    found = replay(copy)
    assert found["ok"] and found["scene"]["ok"] is None and found["results"]["ok"] is None
    assert "scene: no configuration (config.json) in the run directory" in found["not_checked"]
    assert "results: there are none yet in the run directory" in found["not_checked"]
    assert not [name for name in found["quantities"] if name.startswith(("scene_", "results_"))]
    output_text = table(found)
    assert (
        "scene: not checked" in output_text
        and "scene: agrees" not in output_text
        and "results: agrees" not in output_text
    )


@pytest.mark.engine
@pytest.mark.parametrize(
    "file", ["config.json", "summary.json", "results/checks.json", "results/fraction_retained.parquet"]
)
def test_damaged_files_are_one_sentence(copy: Path, file: str) -> None:
    (copy / file).write_text('{"cut')
    with pytest.raises(io.ReplayError, match=r"(cannot be read|is not readable|not a readable).*expected"):
        scene.check(copy)
        results.check(copy)


def of_files(folder: Path, case: int, scale: str) -> dict[str, Any]:
    """Return the part of config.json that comes from config.yaml, materials.yaml, scales.yaml and cases.csv."""
    read = {name: yaml.safe_load((folder / f"{name}.yaml").read_text()) for name in ("config", "materials", "scales")}
    with open(folder / "cases.csv", newline="") as file:
        row = next(row for row in csv.DictReader(file) if int(row["case"]) == case)
    words = ("material", "source", "liquid")
    return {
        "case": {name: text if name in words else float(text) for name, text in row.items() if text},
        "scale": {"name": scale, **read["scales"]["scales"][scale]},
        "apparatus": read["scales"]["apparatus"],
        "materials": read["materials"],
        "settings": read["config"],
    }


@pytest.mark.parametrize("number", CONFIG.cases)
def test_no_false_alarm_on_the_scenes_of_the_cases(number: int, tmp_path: Path) -> None:
    """Compared with the resolved copy, and with the four files of config/ read by the reference itself."""
    cases.build(CONFIG, number, "smoke", tmp_path)
    for read in (None, of_files(ROOT / "config", number, "smoke")):
        found = scene.check(tmp_path, read)
        assert {q.name for q in found.quantities} == OF_BUILT and not found.findings, found.findings[:3]


@pytest.mark.parametrize(("number", "scale"), [(7, "full"), (11, "full"), (17, "reduced")])
def test_no_false_alarm_at_other_scales(number: int, scale: str, tmp_path: Path) -> None:
    """A round sieve with analytic wires and other contact stiffness."""
    cases.build(CONFIG.with_preset("exact").with_seed(5), number, scale, tmp_path)
    assert not scene.check(tmp_path).findings


def test_no_false_alarm_on_a_scene_for_the_other_engine(tmp_path: Path) -> None:
    """Its rolling resistance is off, and an own seed counts."""
    cases.build(CONFIG.without_rolling().with_seed(7), 4, "smoke", tmp_path)
    assert not scene.check(tmp_path).findings


EFFECTS = [
    {"capillary": False, "viscous_normal": False},
    {"wall_films": False, "sharing_by_size": False, "rolling": False},
    {"bridges": False},
    {"gravity": False, "tangential_history": False, "liquid_weight": True},
    {"decide": "tolerance"},
    {"shedding": True, "dynamic_rupture": False},
]


@pytest.mark.parametrize("switches", EFFECTS, ids=lambda s: ",".join(s))
def test_no_false_alarm_where_effects_are_switched(switches: dict[str, object], tmp_path: Path) -> None:
    """Switches by hand change laws, gravity and the time step; what their numbers decide is said not to be checked."""
    from dataclasses import replace

    effects = CONFIG.settings.effects.model_copy(update=switches)
    step = CONFIG.settings.time_step.model_copy(update={"bridges_every": 2})
    turned = replace(CONFIG, settings=CONFIG.settings.model_copy(update={"effects": effects, "time_step": step}))
    cases.build(turned, 12, "smoke", tmp_path)
    found = scene.check(tmp_path)
    assert not found.findings
    assert ("decide" in switches) == any("decided by their numbers" in s for s in found.not_checked)
    times("liquid.viscosity_Pa_s", 1.001)(tmp_path)
    assert scene.check(tmp_path).findings


def test_fields_set_by_hand_are_named_and_others_still_held(tmp_path: Path) -> None:
    """As studies do: fewer spheres, another duration. A fault in what was not touched is found."""
    built = cases.build(CONFIG, 2, "smoke", tmp_path)
    spheres = pd.read_parquet(tmp_path / built.spheres_file)
    with_spheres(built, tmp_path, spheres.iloc[::20], duration_s=0.5)
    found = scene.check(tmp_path)
    assert (
        not found.findings
        and "scene: set by hand after the configuration: classes.count, duration_s" in found.not_checked
    )
    times("classes.small.radius_m", 1.001)(tmp_path)
    edit("scene.json", lambda s: s.update(duration_s=0.7))(tmp_path)
    assert {f["what"] for f in scene.check(tmp_path).findings} >= {"classes.small.radius_m"}
    assert "duration_s" not in {f["what"] for f in scene.check(tmp_path).findings}


@pytest.mark.parametrize("moist", [True, False])
def test_results_added_up_by_hand_agree(tmp_path: Path, moist: bool) -> None:
    """The synthetic run of three spheres, whose numbers tests/cases/screening add up on paper."""
    from pywet import stages

    folder = synthetic.make(tmp_path / "run", moist=moist)
    stages.results(folder)
    found = results.check(folder)
    wrong = {f["what"] for f in found.findings}
    # in the synthetic event log more bridges form than are active
    assert wrong <= {"summary.json: events.standing_bridges"}
    assert {q.name for q in found.quantities} == {
        f"results_{n}"
        for n in (
            "fraction_retained",
            "liquid_by_holder",
            "checks",
            "summary",
            "screen",
            "screen_series",
            "partition",
            "grade_efficiency",
            "flowsheet",
        )
    }


@pytest.mark.engine
def test_dry_run_agrees_and_its_faults_are_named(dry_dir: Path, tmp_path: Path) -> None:
    """Without liquid, on the stock program: configuration, deck and curves are compared all the same."""
    found = replay(dry_dir)
    assert found["ok"] and found["scene"]["ok"] and found["results"]["ok"]
    copy = Path(shutil.copytree(dry_dir, tmp_path / "run"))
    RESULTS["classes exchanged"].change(copy)
    SCENE["restitution 0.1 % low"].change(copy)
    output_text = [f["sentence"] for f in (*scene.check(copy).findings, *results.check(copy).findings)]
    assert any("pairs.3-0.restitution" in s for s in output_text) and any(
        "near_mesh should hold" in s for s in output_text
    )


@pytest.mark.engine
def test_dry_run_without_recorded_motion_has_its_sections(dry_dir: Path, tmp_path: Path) -> None:
    """Nothing to replay but them; they are replayed, and a fault of theirs is a disagreement."""
    copy = Path(shutil.copytree(dry_dir, tmp_path / "run"))
    put("output.window_trajectories", False)(copy)
    for path in (copy / "history").glob("window_*.parquet"):
        path.unlink()
    found = command.outcome(copy)
    assert found["status"] == "in part" and set(found["quantities"]) >= OF_BUILT - {
        "scene_plan"
    }  # built without a plan
    put("mass_kg", 1.0, "summary.json")(copy)
    assert command.outcome(copy)["status"] == "disagrees"
