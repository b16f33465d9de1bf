"""What `pywet run` and `run-scene` print at their end: ten lines at most, the answer, what was checked, the next command."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pandas as pd
import pytest
from PIL import Image
from typer.testing import CliRunner

import pywet
from pywet import config, scene_stages, stages
from pywet.cases.custom import results
from pywet.cases.screening import verdict
from pywet.cases.screening.results import class_titles
from pywet.cli import ending
from pywet.cli.app import app
from pywet.errors import PywetError
from pywet.products import screening_report
from pywet.report import screen_page
from pywet.runs.record import Status
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene
from pywet.util.files import read_table, write_json, write_table
from tests.cases.custom.conftest import beads
from tests.cases.screening import synthetic
from tests.error_codes import raises_code
from tests.products import made_up

ROOT = Path(__file__).parents[2]
NOT_CHECKED = ["forces: steps outside the windows", "scene: sizes", "results: versions", "VTK: no files"]
REPLAY = {
    "quantities": {
        "bridge_volume": {"scale": "itself", "count": 3, "largest": 2e-12, "median": 1e-16, "tolerance": 1e-9},
        "capillary": {"scale": "itself", "count": 40, "largest": 3e-13, "median": 1e-16, "tolerance": 1e-9},
    },
    "nothing_compared": [],
    "not_checked": NOT_CHECKED,
}
RETAINED = 0.75
"""Of the synthetic run with its liquid and of its spheres alone; its own numbers are asserted in tests/cases/screening."""


def finished(folder: Path, retained: float = RETAINED, dry: float = RETAINED, **replay: object) -> Path:
    """The synthetic case with results, a fraction retained, a replay and the configuration that it came from."""
    run = synthetic.make(folder)
    stages.results(run)
    write_json(run / "replay.json", {**REPLAY, **replay})
    summary = json.loads((run / "summary.json").read_text())
    write_json(run / "summary.json", {**summary, "fraction_retained_end": retained, "coarse_share": 0.5})
    table = read_table(run / "results" / "fraction_retained.parquet")
    table.loc[table.index[-1], "fraction_retained_spheres"] = dry
    write_table(table, run / "results" / "fraction_retained.parquet")
    Image.new("RGB", (8, 8)).save(run / "picture.png")  # as new as the results, so no picture is drawn
    write_json(run / "config.json", config.load(ROOT / "config").resolved(2, "smoke"))
    return run


def test_nothing_passed_has_no_sign(tmp_path: Path) -> None:
    """A share a little above one, by round-off: 0 %, not -0 %."""
    output_text = list(ending.lines([RunDir(finished(tmp_path / "case02", 1.0001, 1.0 + 1e-15))], None))
    assert "so 0 % of what can pass has passed" in output_text[1]


def test_what_has_passed_is_of_the_spheres(tmp_path: Path) -> None:
    """Y of 0.78 with the liquid that stays on walls, of the spheres 0.75: (1 − 0.75)/(1 − 0.5), where 44 % would be of both."""
    (line,) = ending._retained([RunDir(finished(tmp_path / "case02", 0.78, 0.75))])
    assert "0.78; share that cannot pass 0.500, so 50 % of what can pass has passed" in line


def test_ten_lines_of_a_case(tmp_path: Path) -> None:
    """(1 − 0.75)/(1 − 0.5) of what can pass has passed; two of four sentences on what was not checked, the others counted."""
    run = finished(tmp_path / "case02")
    output_text = list(ending.lines([RunDir(run)], run / "report.html"))
    assert len(output_text) == 10
    assert "0.75; share that cannot pass 0.500, so 50 % of what can pass has passed" in output_text[1]
    assert "4 bridges formed, 2 ruptured" in output_text[2]
    assert "checked: in part: 2 quantities in 43 values recomputed, largest deviation 2e-12" in output_text[3]
    assert output_text[4].strip() == f"not checked: {NOT_CHECKED[0]}" and "and 2 more not checked" in output_text[6]
    assert output_text[7].endswith("results/: fraction_retained.csv, liquid_by_holder.csv")
    assert (
        output_text[8] == f"report: {run / 'report.html'}"
        and output_text[9] == f"next: pywet plot {run} --out curves.pdf"
    )


def test_what_was_not_compared_at_all_comes_first(tmp_path: Path) -> None:
    """A kind of the scene without a single value is worse than a window: it heads the list."""
    run = finished(tmp_path / "case02", nothing_compared=["bridges: none formed or ruptured in the run"])
    output_text = list(ending.lines([RunDir(run)], None))
    assert output_text[3].startswith("checked: in part")
    assert output_text[4].strip() == "nothing compared: bridges: none formed or ruptured in the run"
    assert "and 3 more" in output_text[6]


def test_seeds_are_a_mean_with_its_interval(tmp_path: Path) -> None:
    """Student's t for three seeds is 4.303: 4.303 × 0.01/√3 = 0.025."""
    runs = [finished(tmp_path / f"case02{end}", y) for end, y in (("", 0.74), ("-8", 0.75), ("-9", 0.76))]
    output_text = list(ending.lines([RunDir(run) for run in runs], None))
    assert "fraction retained at the end 0.750 ± 0.025 (95 % interval of the mean over 3 seeds)" in output_text[1]
    assert output_text[-1] == f"next: pywet plot {' '.join(map(str, runs))} --out curves.pdf"


def test_an_objection_is_the_end_and_the_next_command_asks_again(tmp_path: Path) -> None:
    """The worst of several seeds is named, and everything is written before the command ends in its sentence."""
    row = {**REPLAY["quantities"]["capillary"], "largest": 0.1}  # type: ignore[index]
    runs = [finished(tmp_path / "case02"), finished(tmp_path / "case02-8", quantities={"capillary": row})]
    output_text = list(ending.lines([RunDir(run) for run in runs], None))
    assert any(line.startswith("checked: no (case02-8)") for line in output_text) and "pywet replay" in output_text[-1]
    with raises_code("cli.objections", says="case02-8: .*capillary"):
        ending.show(runs)
    assert all("capillary" in (run / "details.txt").read_text() for run in runs)


def test_the_refusal_of_a_replay_is_the_end_of_a_dry_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing else of a dry run disagrees: the refusal is stored, by either command, until a replay refuses it no more."""
    run, words = synthetic.make(tmp_path / "run", moist=False), "stage replay failed: .*trajectory.parquet is missing"
    stages.results(run)
    for module, name in (
        (scene_stages.building, "write"),
        (scene_stages.stages, "simulate"),
        (scene_stages.results, "write"),
    ):
        monkeypatch.setattr(module, name, lambda *_, **__: None)
    scene = pywet.Scene(**beads(), folder=tmp_path)
    trajectory = (run / "trajectory.parquet").read_bytes()
    for ask, refused, agrees in (
        (lambda: bool(scene_stages.finish(scene, run)), True, False),
        (lambda: CliRunner().invoke(app, ["replay", str(run)]).exit_code, 2, 0),
        (lambda: _refused(run), True, False),
    ):
        (run / "trajectory.parquet").unlink()
        assert ask() == refused
        (run / "trajectory.parquet").write_bytes(trajectory)  # what reads the run reads the status, not the table
        found = verdict.check_result(RunDir(run))
        assert found.word == "no" and re.search(words, found.sentence)
        assert ask() == agrees
        assert verdict.check_result(RunDir(run)).word != "no" and not (run / "status" / "replay.json").exists()
    (run / "trajectory.parquet").unlink()
    with raises_code("scene.objections", says=words):
        scene_stages.run(scene, run)
    (run / "trajectory.parquet").write_bytes(trajectory)
    with raises_code("cli.objections", says=words):
        ending.show([run])


def _refused(run: Path) -> bool:
    try:
        pywet.replay(run)
    except PywetError:
        return True
    return False


def test_the_report_of_a_run_has_its_links(tmp_path: Path) -> None:
    """From the run's own folder, on files that exist; its configuration is the one that was stored with it."""
    run = finished(tmp_path / "case02")
    done = CliRunner().invoke(app, ["report", str(run)])
    assert done.exit_code == 0, done.output
    text = (run / "report.html").read_text()
    assert 'href="results/fraction_retained.csv"' in text and "5/7/10" in text and "Scale smoke" in text


def test_the_report_of_a_run_needs_no_vtk_files(tmp_path: Path) -> None:
    """`pywet run` writes none: its page counts the case as done; a stage that failed is named, as by the workflow's verdict."""
    run = finished(tmp_path / "case02")
    shutil.rmtree(run / "status", ignore_errors=True)
    for stage in ("scene", "simulate", "results", "replay"):
        Status(stage, True, 1.0).write(run)
    assert CliRunner().invoke(app, ["report", str(run)]).exit_code == 0
    assert "was not run to the end" not in (run / "report.html").read_text()
    assert verdict.problems(run) == ["it was not run to the end: stage vtk is missing"]
    (run / "status" / "replay.json").unlink()
    assert CliRunner().invoke(app, ["report", str(run)]).exit_code == 0
    assert "stage replay is missing" in (run / "report.html").read_text()


def test_a_damaged_configuration_is_one_sentence(tmp_path: Path) -> None:
    run = finished(tmp_path / "case02")
    data = json.loads((run / "config.json").read_text())
    write_json(run / "config.json", {**data, "materials": {}})
    done = CliRunner(env={"COLUMNS": "500"}).invoke(app, ["report", str(run)])
    assert done.exit_code == 1 and "config.json" in done.output and "Traceback" not in done.output


def test_a_deck_ends_with_what_its_screen_did(tmp_path: Path) -> None:
    """A line for each number, of at most 80 columns; a size class by the name that the user gave it, not by its column."""
    run = made_up.make(tmp_path / "deck")
    screening_report.write(run)
    titles = {"spheres_ore_5_4_mm": "spheres ore 5.4 mm"}
    scene = made_up.scene()
    named = scene.model_copy(update={"classes": (scene.classes[0].model_copy(update={"name": "ore 5.4 mm"}),)})
    assert class_titles(named) == titles
    whole = named.model_copy(update={"classes": (*named.classes, *scene.classes[1:])})
    write_json(run / "scene.json", whole.model_dump(mode="json"))
    summary = {"spheres": {"ore 5.4 mm": 160}, "steps": 2000, "wall_s": 1.0, "ledger_error": 0.0, "particle_steps_per_s": 1.0,
               "initial_liquid_m3": 1e-9, "events": None, "effects": {"bridges": True}, "checks": [], "versions": {},
               "liquid_end_m3": {"spheres_ore_5_4_mm": 4e-10, "outlet_overs": 6e-10, "total": 1e-9}}  # fmt: skip
    write_json(run / "summary.json", summary)
    output_text = [*ending._screen([RunDir(run)]), *ending._liquid([RunDir(run)])]
    assert output_text[0].startswith("cut size d50 ") and " 2.5 mm (" in output_text[0], output_text
    assert [line.split()[0] for line in output_text[:6]] == [
        name.split()[0] for name in screen_page.five(screening_report.write(run))
    ]
    assert all(len(line) <= 80 for line in output_text)
    assert "60 % outlet overs, 40 % spheres inside" in output_text[-1]
    assert (
        ending._next([RunDir(run)], "yes") == f"pywet screen {run}"
        and ending._next([RunDir(run)], "no") == f"pywet replay {run}"
    )


def test_deep_overlaps_are_reported_at_the_end(tmp_path: Path) -> None:
    """13 % of the radius, where 5 % is soft, and a stiffness that lowers it to that; nothing of 4 %, nor without the table.

    An impact of energy m v²/2 = k δ²/2 needs (13/5)² = 6.76 times the stiffness, and √6.76 = 2.6 times the steps.
    """
    folder = finished(tmp_path / "run")
    assert not list(ending._deep([RunDir(folder)]))
    table = folder / "results" / "contact_statistics.parquet"
    scene = EngineScene.read(folder / "scene.json")
    pairs = tuple(p.model_copy(update={"normal_stiffness_N_per_m": 1000.0}) for p in scene.pairs)
    write_json(folder / "scene.json", scene.model_copy(update={"pairs": pairs}).model_dump(mode="json"))
    into_walls = {"contacts": [{"between": ["ore", "walls"], "stiffness_N_per_m": 1000.0}]}
    for column, of, where, description in (
        ("largest_overlap", "the smaller radius", "materials", {}),
        ("largest_wall_overlap", "the radius at a wall", "materials", {"contacts": [{"stiffness_N_per_m": None}]}),
        ("largest_wall_overlap", "the radius at a wall", "materials and contacts", into_walls),
    ):
        write_json(folder / "description.json", description)
        sentence = (
            f"deep overlaps: up to 13 % of {of}, soft above 5 %: raise stiffness_N_per_m in {where} from 1000 to about "
            "6800; the run takes 2.6 times as many steps"
        )
        for deepest, lines in ((0.04, []), (0.13, [sentence])):
            columns = {**dict.fromkeys(("step", "time_s", *results.STATISTICS), 0), "largest_overlap": 0.03}
            write_table(pd.DataFrame([columns, {**columns, column: deepest}]), table)
            assert [line for line in ending.lines([RunDir(folder)], None) if line.startswith("deep")] == lines


def test_springs_are_those_of_the_deepest_overlap(tmp_path: Path) -> None:
    """Walls that are softer than the spheres: their stiffness is named if the walls' overlap is the larger one."""
    folder = finished(tmp_path / "run")
    scene = EngineScene.read(folder / "scene.json")
    pairs = tuple(p.model_copy(update={"normal_stiffness_N_per_m": 4000.0 if p.b else 1000.0}) for p in scene.pairs)
    write_json(folder / "scene.json", scene.model_copy(update={"pairs": pairs}).model_dump(mode="json"))
    for spheres, walls, words in ((0.1, 0.08, "from 4000 to about 16000"), (0.1, 0.2, "from 1000 to about 16000")):
        columns = {**dict.fromkeys(("step", "time_s", *results.STATISTICS), 0), "largest_overlap": spheres}
        table = pd.DataFrame([{**columns, "largest_wall_overlap": walls}])
        write_table(table, folder / "results" / "contact_statistics.parquet")
        (line,) = ending._deep([RunDir(folder)])
        assert words in line
