"""What is done again after a change: all that depends on it, and nothing else. Jobs planned by `snakemake -n`, edit by edit."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pywet import config, run_folder, stages
from pywet.cases.screening import identity
from pywet.runs import record
from pywet.util import sources

ROOT = Path(__file__).parent.parent
CASES = "cases=[2,10,11]"
"""POM moist (and its comparison run with preset exact), glass dry and moist."""
POM, GLASS = {"case02", "case02_exact"}, {"case10", "case11"}
MOIST = {"case02", "case02_exact", "case11"}
CUSTOM_LAW = """from pywet.laws.force_law import force_law


@force_law
def later(speed: float, viscosity: float, surface_tension: float) -> float:
    return 1.1


@force_law
def reach(volume: float, radius_i: float, radius_j: float, contact_angle_i: float, contact_angle_j: float) -> float:
    return 1.1 * volume ** (1.0 / 3.0)
"""
SECOND = """def reach(volume, radius_i, radius_j, contact_angle_i, contact_angle_j):
    return 1.1 * volume ** (1 / 3)
"""
NAMED = """preset: paper
  dynamic_rupture: own.py:later
  rupture: own.py:reach
  reference:
    rupture: second.py:reach"""


def snakemake(folder: Path, *arguments: str, code: Path = ROOT) -> str:
    """What Snakemake prints in a folder; `code`: folder of modules that it finds first."""
    environment = {**os.environ, "PYTHONPATH": f"{code}:{ROOT}", "XDG_CACHE_HOME": str(folder / "cache")}
    command = [sys.executable, "-m", "snakemake", "--cores", "1", *arguments]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def custom_law(folder: Path) -> None:
    for place in (folder, folder / "config"):
        (place / "own.py").write_text(CUSTOM_LAW.replace("1.1", "1.2"))


def edit(file: str, old: str, new: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        path = folder / "config" / file
        text = path.read_text()
        assert text.count(old) >= 1, (file, old)
        path.write_text(text.replace(old, new, 1))

    return change


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which everything is done, by scripts that only leave what they are asked for."""
    folder = tmp_path_factory.mktemp("done")
    shutil.copy(ROOT / "Snakefile", folder)
    for name in ("config", "workflow", "liggghts_inputs"):
        shutil.copytree(ROOT / name, folder / name)
    for place in (folder, folder / "config"):
        (place / "own.py").write_text(CUSTOM_LAW)
    (folder / "config" / "second.py").write_text(SECOND)
    edit("config.yaml", "preset: paper", NAMED)(folder)
    for script in (folder / "workflow" / "scripts").glob("*.py"):
        script.write_text("from pathlib import Path\nfor made in snakemake.output:\n    Path(made).write_text('{}')\n")
    assert "The report is in results/smoke/report_cases2-10-11.html" in snakemake(folder, "--config", CASES)
    return folder


def planned(folder: Path, *arguments: str) -> tuple[set[str], set[str]]:
    """Cases whose scene is built again, and what else is made of all cases together."""
    text = snakemake(folder, "-n", "--config", *(arguments or (CASES,)))
    cases = set(re.findall(r"output: results/\w+/(\w+)/status/scene.json", text))
    assert cases == set(re.findall(r"output: results/\w+/(\w+)/status/simulate.json", text))
    return cases, set(re.findall(r"^rule (report|verdict):", text, flags=re.MULTILINE))


EDITS: dict[str, tuple[Callable[[Path], None], set[str]]] = {
    "nothing": (lambda folder: None, set()),
    "a comment": (edit("config.yaml", "# What to run", "# Now: what to run"), set()),
    "glass density": (edit("materials.yaml", "value: 2535.1", "value: 2540.0"), GLASS),
    "glass friction": (edit("materials.yaml", "friction: {value: 0.1966", "friction: {value: 0.2"), GLASS),
    "POM restitution": (edit("materials.yaml", "restitution: {value: 0.8038", "restitution: {value: 0.8"), POM),
    "surface tension": (edit("materials.yaml", "value: 0.07275", "value: 0.072"), MOIST),
    "viscosity": (edit("materials.yaml", "viscosity_Pa_s: {value: 1.0e-3", "viscosity_Pa_s: {value: 2.0e-3"), MOIST),
    "a moist case's liquid": (edit("cases.csv", "2,POM,5,7,10,8,1,5,", "2,POM,5,7,10,8,1,6,"), {"case02", "case02_exact"}),
    "a case not asked for": (edit("cases.csv", "3,POM,5,7,10,8,1,10,", "3,POM,5,7,10,8,1,9,"), set()),
    "another scale's time": (edit("scales.yaml", "duration_s: {value: 5.0", "duration_s: {value: 6.0"), set()),
    "this scale's time": (edit("scales.yaml", "duration_s: {value: 1.6", "duration_s: {value: 1.7"), POM | GLASS),
    "side wall": (edit("scales.yaml", "side_wall_height_mm: {value: 40", "side_wall_height_mm: {value: 41"), POM | GLASS),
    "a reason": (edit("scales.yaml", "five apertures of 8 mm", "five wide apertures of 8 mm"), set()),
    "seed": (edit("config.yaml", "seed: 10007", "seed: 10008"), POM | GLASS),
    "an own law's code": (custom_law, MOIST - {"case02_exact"}),
    "a law": (edit("config.yaml", "preset: paper", "preset: paper\n  capillary: willett_simple"), MOIST - {"case02_exact"}),
}  # fmt: skip
REPORT_TOO = {"a case not asked for", "another scale's time", "a reason"}
"""Edits after which no case is run again, but the report shows other words."""


@pytest.fixture
def edited(done: Path, tmp_path: Path) -> Iterator[Path]:
    """Return the folder for a test that changes it; the changes are undone afterwards."""
    shutil.copytree(done / "config", tmp_path / "config")
    shutil.copy(done / "own.py", tmp_path)
    yield done
    shutil.copytree(tmp_path / "config", done / "config", dirs_exist_ok=True)
    shutil.copy(tmp_path / "own.py", done)


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_redoes_what_depends_on_it(edited: Path, name: str) -> None:
    change, expected = EDITS[name]
    change(edited)
    cases, together = planned(edited)
    assert cases == expected
    assert together == ({"report", "verdict"} if expected or name in REPORT_TOO else set())


def test_a_second_function_asks_for_evaluations_alone(edited: Path) -> None:
    """Nothing is simulated again; the comparison run with a preset has no custom laws."""
    (edited / "config" / "second.py").write_text(SECOND.replace("1 / 3", "1.0 / 3"))
    text = snakemake(edited, "-n", "--config", CASES)
    assert set(re.findall(r"output: results/\w+/(\w+)/status/results.json", text)) == {"case02", "case10", "case11"}
    assert set(re.findall(r"^rule (\w+):", text, flags=re.MULTILINE)) >= {"evaluate", "report"}
    assert not re.search("^rule (scene|simulate):", text, flags=re.MULTILINE)


def test_changed_code_of_evaluation_asks_for_evaluations_alone(edited: Path, tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text("from pywet.util import sources\nsources.EVALUATION = ('products',)\n")
    text = snakemake(edited, "-n", "--config", CASES, code=tmp_path)
    assert set(re.findall(r"output: results/\w+/(\w+)/status/results.json", text)) == POM | GLASS
    assert not re.search("^rule (scene|simulate):", text, flags=re.MULTILINE)


def test_some_cases_leave_the_report_of_all_as_it_is(edited: Path) -> None:
    """A part of the cases has a report of its own name, and runs nothing again."""
    text = snakemake(edited, "-n", "--config", "cases=11", "both_presets=false")
    assert "results/smoke/report_cases11.html" in text and not re.search(
        "^rule (scene|simulate):", text, flags=re.MULTILINE
    )


def test_another_folder_of_the_configuration_has_separate_results(edited: Path) -> None:
    shutil.copytree(edited / "config", edited / "mine", dirs_exist_ok=True)
    text = snakemake(edited, "-n", "--config", "config_dir=mine", "cases=[2,10]", "both_presets=false")
    made = set(re.findall(r"output: results/(\w+/\w+)/case\w+/status/simulate.json", text))
    assert made == {"mine/smoke"} and len(re.findall("^rule simulate:", text, flags=re.MULTILINE)) == 2


def test_changed_code_repeats_evaluations_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a finished run: results and replay for the program's code, the replay for a user's reference implementation, or none."""
    run, law, heard, done = tmp_path / "run", tmp_path / "law.py", list[str](), list[Path]()
    monkeypatch.setattr(stages, "same_run", lambda *_: True)
    monkeypatch.setattr(stages, "replay", done.append)
    laws = SimpleNamespace(reference={"rupture": f"{law}:reach"})
    configured: Any = SimpleNamespace(settings=SimpleNamespace(laws=laws))
    monkeypatch.setattr(stages, "results", done.append)
    run_folder.claim(run)
    for stage in ("scene", "simulate", "results", "replay"):
        record.attempt(run, stage, lambda: None)
    for text, code, evaluations, lines in (
        ("first", "one", 2, 2), ("first", "one", 2, 3), ("second", "one", 3, 5), ("second", "two", 5, 7), ("second", "two", 5, 8)
    ):  # fmt: skip
        law.write_text(text)
        monkeypatch.setattr(sources, "digest_of_evaluation", lambda code=code: code)
        assert stages.carry_out(configured, 2, "smoke", run, say=heard.append) is None
        assert (len(done), len(heard)) == (evaluations, lines)


def test_a_folder_that_holds_this_very_run_is_known(tmp_path: Path) -> None:
    """Finished stages and the same word; another seed, engine or an unfinished stage is another run."""
    configured = config.load(ROOT / "config")
    word = identity.identity(configured, 10, "smoke")
    assert not stages.same_run(configured, 10, "smoke", tmp_path)
    there = ["trajectory", "mesh_motion", "history/spheres", "results/fraction_retained", "results/liquid_by_holder"]
    for name in (*(f"{name}.parquet" for name in there), "engine/run.json", "summary.json"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    for stage in ("scene", "simulate", "results", "replay"):
        stages.Status(stage, True, 1.0).write(tmp_path)
    assert not stages.same_run(configured, 10, "smoke", tmp_path)
    record.leave_identity(tmp_path, f"liggghts {word}")
    assert stages.same_run(configured, 10, "smoke", tmp_path)
    assert not stages.same_run(configured.with_seed(3), 10, "smoke", tmp_path)
    assert not stages.same_run(configured, 10, "smoke", tmp_path, engine="yade")
    assert not stages.same_run(configured, 13, "smoke", tmp_path)
    stages.Status("replay", False, 1.0, "replay", "no table").write(tmp_path)
    assert not stages.same_run(configured, 10, "smoke", tmp_path)
