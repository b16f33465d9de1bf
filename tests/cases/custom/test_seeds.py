"""A custom scene with several seeds: every number of its page that differs between seeds has mean and interval."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pandas as pd
import pytest
import yaml
from typer.testing import CliRunner

import pywet
from pywet import scene_stages, stages
from pywet.cases.custom import seeds
from pywet.cases.screening import verdict
from pywet.cli.app import app
from pywet.cli.ending import lines
from pywet.errors import PywetError
from pywet.report import scene_page as page
from pywet.runs import record
from pywet.runs.rundir import RunDir
from pywet.runs.spread import with_interval
from tests.cases.custom.conftest import beads
from tests.cases.screening import synthetic

SEEDS = 3


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run of a small scene with three seeds, by the command; its output in out.txt."""
    path = tmp_path_factory.mktemp("seeds")
    box = {"low_mm": [-5, -5, 0.2], "high_mm": [5, 5, 14]}
    entry = {"name": "beads", "material": "glass", "diameter_mm": 3, "count": 8, "box": box}
    scene = beads(
        spheres=[entry], liquid={"percent": 1.0}, walls=[CUP], duration_s=0.03, seed=4, results={"interval_s": 0.006}
    )
    (path / "scene.yaml").write_text(yaml.safe_dump(scene))
    done = CliRunner().invoke(app, ["run-scene", str(path / "scene.yaml"), "--out", str(path / "run"), "--seeds", "3"])
    (path / "out.txt").write_text(done.output)
    assert done.exit_code == 0, done.output
    return path / "run"


CUP = {"name": "cup", "vessel": {"inner_width_mm": 12, "height_mm": 20}}


@pytest.mark.engine
def test_the_page_combines_the_seeds(folder: Path) -> None:
    """Liquid of every reservoir, bridges, energies, ledger and overlaps are mean ± half width of the three runs."""
    runs = [pywet.load(folder.with_name(name)) for name in ("run", "run-5", "run-6")]
    text = (folder / "report.html").read_text()
    assert [run.path.name for run in seeds.of_scene(folder)] == ["run", "run-5", "run-6"]
    ends = [run.liquid.iloc[-1] for run in runs]
    for column in ("spheres_beads_m3", "wall_cup_m3"):
        values = [1e9 * float(end[column]) for end in ends]
        shares = [100.0 * float(end[column] / end["initial_m3"]) for end in ends]
        assert len(set(values)) == SEEDS  # each seed has a different packing
        name = column.removesuffix("_m3").replace("_", " ")
        assert f">{name}</td><td>{with_interval(values, 4)}</td><td>{with_interval(shares, 3)} %</td>" in text
    formed, active = (
        seeds.over([run.summary["events"][key] for run in runs], 9) for key in ("formations", "standing_bridges")
    )
    assert f">{formed}<" in text and f"bridges formed, {active} stand" in text
    for key, value in runs[0].summary["energy_J"].items():
        if value is not None:
            several = seeds.over([run.summary["energy_J"][key] for run in runs])
            assert f">{key}</td><td>{several}</td>" in text
    overlap = with_interval([100.0 * run.contact_statistics["largest_overlap"].max() for run in runs], 2)
    assert f"Spheres overlap by {overlap} % of the smaller radius" in text
    assert "3 seeds (run, run-5, run-6): numbers are their mean ± 95 % confidence interval" in text


@pytest.mark.engine
def test_few_curves_of_liquid_add_up(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One curve for the reservoirs that have none of their own; at the end it is all the liquid."""
    monkeypatch.setattr(page, "LARGEST", 0)
    runs = [pywet.load(folder)]
    (data,) = re.findall(r'<script type="application/json">(.*?)</script>', page._liquid(runs))
    curves = {line["label"]: line["y"] for line in json.loads(data)}
    assert list(curves) == ["2 others"]  # bridges on spheres and on the cup
    assert curves["2 others"][-1] == pytest.approx(1e9 * runs[0].liquid["total_m3"].iloc[-1], rel=1e-12)


@pytest.mark.engine
def test_the_replay_of_the_page_is_that_of_all_seeds(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Values add up; one seed that disagrees makes the page say no, with the name of its run."""
    runs = seeds.of_scene(folder)
    volume = next(row for row in seeds.agreement(runs) if row.quantity == "volume")
    assert volume.count == sum(run.replay["quantities"]["volume"]["count"] for run in runs)
    assert seeds.worst(runs).word == "in part"  # only windows are replayed step by step
    path = folder.with_name("run-5") / "replay.json"
    whole = path.read_text()
    changed = json.loads(whole)
    changed["ok"], changed["quantities"]["volume"]["largest"] = False, 0.1
    path.write_text(json.dumps(changed))
    try:
        found = seeds.worst(seeds.of_scene(folder))
    finally:
        path.write_text(whole)
    assert found.word == "no" and "run-5: " in found.sentence


@pytest.mark.engine
def test_another_scene_in_a_folder_of_that_name_is_no_seed(folder: Path, tmp_path: Path) -> None:
    """A run whose description differs in more than the seed, or one that is not finished, is left out."""
    for name in ("run", "run-5", "run-6"):
        (tmp_path / name).mkdir()
        for file in ("description.json", "scene.json", "summary.json"):
            (tmp_path / name / file).write_bytes((folder.with_name(name) / file).read_bytes())
    other: dict[str, Any] = json.loads((tmp_path / "run-5" / "description.json").read_text())
    other["liquid"]["percent"] = 2.0
    (tmp_path / "run-5" / "description.json").write_text(json.dumps(other))
    (tmp_path / "run-6" / "summary.json").unlink()
    assert [run.path.name for run in seeds.of_scene(tmp_path / "run")] == ["run"]


def test_a_seed_of_another_file_is_not_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """The file of a wall changes after the seeds 1 and 2: descriptions are the same, fingerprints without the seed are not."""
    scene = pywet.Scene(**beads(walls=[{"name": "cup", "stl": "cup.stl", "stl_unit": "m"}]), folder=tmp_path)

    def ended(made: pywet.Scene, where: Path, _: object, begin: Callable[[], object]) -> None:
        begin()
        (where / "description.json").write_text(json.dumps({"name": made.name, "seed": made.seed}))
        (where / "scene.json").write_text(synthetic.scene().model_copy(update={"seed": made.seed}).model_dump_json())
        (where / "summary.json").write_text("{}")
        raise PywetError("it ends here")

    monkeypatch.setattr(scene_stages.building, "write", ended)
    for name, seed, text in (("run", 1, "one"), ("run-2", 2, "one"), ("run-3", 3, "another")):
        (tmp_path / "cup.stl").write_text(text)
        with pytest.raises(PywetError, match="it ends here"):
            scene_stages.finish(scene.with_(seed=seed), tmp_path / name)
    assert len({record.left_identity(tmp_path / name) for name in ("run", "run-2", "run-3")}) == SEEDS
    assert [run.path.name for run in seeds.of_scene(tmp_path / "run")] == ["run", "run-2"]
    assert f"{tmp_path / 'run-3'} was run with another configuration, file" in caplog.text
    record.leave_identity(tmp_path / "run-3", "of a version without the second fingerprint")
    assert [run.path.name for run in seeds.of_scene(tmp_path / "run")] == ["run", "run-2", "run-3"]


@pytest.fixture
def scenes(tmp_path: Path) -> list[Path]:
    """Three dry seeds of a scene: `run` was replayed in part, `run-2` was not replayed, `run-3` has not ended."""
    runs = [synthetic.make(tmp_path / name, moist=False) for name in ("run", "run-2", "run-3")]
    for seed, run in enumerate(runs, start=1):
        (run / "description.json").write_text(json.dumps({"name": "scene", "seed": seed}))
        (run / "scene.json").write_text(
            synthetic.scene(moist=False).model_copy(update={"seed": seed}).model_dump_json()
        )
    for run in runs[:2]:
        stages.results(run)
    force = {"scale": "itself", "count": 3, "largest": 1e-13, "median": 1e-16, "tolerance": 1e-9}
    (runs[0] / "replay.json").write_text(json.dumps({"quantities": {"force": force}, "not_checked": ["energies"]}))
    return runs


def test_a_seed_that_has_not_ended_is_named(scenes: list[Path]) -> None:
    """The page of the two others says no and which it is; a folder of another scene is none of its seeds."""
    runs = seeds.of_scene(scenes[0])
    assert [run.path for run in runs] == scenes[:2]
    found = seeds.worst(runs)
    assert (found.word, found.grade) == ("no", "bad") and "run-3: not run to the end" in found.sentence
    (scenes[2] / "description.json").write_text(json.dumps({"name": "another", "seed": 3}))
    assert seeds.worst(runs).word == "–"


def test_nothing_replayed_is_worse_than_in_part(scenes: list[Path]) -> None:
    """So it heads the page and the summary of the command; the section on the replay names the seed."""
    shutil.rmtree(scenes[2])
    runs = seeds.of_scene(scenes[0])
    assert [verdict.check_result(RunDir(run.path)).word for run in runs] == ["in part", "–"]
    assert seeds.worst(runs).word == "–" and "run-2: Its checks agree" in seeds.worst(runs).sentence
    assert "checked: nothing (run-2): nothing of it could" in "\n".join(lines([RunDir(run.path) for run in runs], None))
    text = page._replay(runs)
    assert "1 quantities in 3 values were recomputed" in text and "Nothing of run-2 was replayed." in text
    assert "Nothing of this run could be replayed" in page._replay(runs[1:])


def test_the_ledger_of_seeds_has_times_that_all_have() -> None:
    """Runs with `until` of 21 and 10 outputs: rows at the outputs 0, 5 and 9; films hold 1 and 3 mm³ times the output."""

    def run(rows: int, factor: float) -> Any:
        names = ("films", "bridges", "walls", "left", "retired")
        ledger = pd.DataFrame({"step": [100 * k for k in range(rows)], "time": [0.5 * k for k in range(rows)]})
        ledger = ledger.assign(**dict.fromkeys(names, 0.0), initial=1e-7)
        ledger["films"] = [1e-9 * factor * k for k in range(rows)]
        return SimpleNamespace(summary={"energy_J": {"kinetic": 0.0}, "events": {}}, ledger=ledger)

    text = page._ledger([run(21, 1.0), run(10, 3.0)])
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row)[:2] for row in re.findall(r"<tr>(.*?)</tr>", text, re.DOTALL)]
    assert [row for row in rows if row][:3] == [
        ["0", "0"],
        ["2.5", with_interval([5.0, 15.0], 5)],
        ["4.5", with_interval([9.0, 27.0], 5)],
    ]


@pytest.mark.engine
def test_each_seed_counts_once(folder: Path, tmp_path: Path) -> None:
    """A run that was made again with the seed of run-5 is not a second run of that seed."""
    for name, of in (("run", "run-5"), ("run-5", "run-5"), ("run-6", "run-6"), ("run-7", "run-6")):
        (tmp_path / name).mkdir()
        for file in ("description.json", "scene.json", "summary.json"):
            (tmp_path / name / file).write_bytes((folder.with_name(of) / file).read_bytes())
    assert [run.path.name for run in seeds.of_scene(tmp_path / "run")] == ["run", "run-6"]


@pytest.mark.engine
def test_the_end_of_the_command_names_the_seeds(folder: Path) -> None:
    """Its lines hold the number of seeds and intervals, and the page is of all of them."""
    printed = (folder.parent / "out.txt").read_text()
    assert ", 3 seeds" in printed and re.search(r"liquid at the end: [\d.]+ ± [\d.]+ % spheres beads", printed)
    assert page.of_run(folder) == folder / "report.html"
