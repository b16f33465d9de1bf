"""Two calls on one folder in every order: at each file that the first one completes, others are made in other processes.

What simulates excludes all others to the end of its page; what reads or evaluates excludes what simulates. The first call ends
as if it had been alone, and a call that is refused has changed nothing.
"""

from __future__ import annotations

import importlib
import itertools
import json
import os
import shutil
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from pywet.cli.app import app
from tests.reliability.kills import assert_same, tables_of

pytestmark = pytest.mark.engine
ROOT = Path(__file__).parents[2]
SCENES = ROOT / "tests" / "data" / "inputs"
AT_WORK = "another run is active in"
Words = tuple[str, ...]
SIMULATES: dict[str, Words] = {
    "run": ("run", "2", "--config", "{config}", "--out", "{run}"),
    "run-scene A": ("run-scene", "{race_a}", "--out", "{run}"),
    "scene": ("scene", "bed", "--spheres", "6", "--seconds", "0.01", "--out", "{run}"),
}
READS: dict[str, Words] = {
    "replay": ("replay", "{run}"),
    "view": ("view", "{run}"),
    "view --movie": ("view", "{run}", "--movie"),
    "view --ovito": ("view", "{run}", "--ovito"),
    "report": ("report", "{run}"),
    "plot": ("plot", "{run}", "--out", "{out}/curves.svg"),
    "compare": ("compare", "{run}", "{run}", "--json", "{out}/compared.json"),
    "digest": ("digest", "{run}", "--out", "{out}/digest.json"),
    "app --to": ("app", "{run}", "--to", "{out}/app.html"),
}
OTHERS: dict[str, Words] = {
    "run of another case": ("run", "1", "--config", "{config}", "--out", "{run}"),
    "run of two seeds": ("run", "2", "--config", "{config}", "--out", "{run}", "--seeds", "2"),
    "run-scene B": ("run-scene", "{race_b}", "--out", "{run}"),
    "scene of another kind": ("scene", "pull", "--out", "{run}"),
    "init": ("init", "{run}"),
    "init --example": ("init", "{run}", "--example", "drum"),
    "timestep": ("timestep", "{run}"),
}
LOADED = [
    importlib.import_module(f"pywet.{name}")
    for name in (
        "stages",
        "cases.screening.cases",
        "cli.ending",
        "compare.command",
        "report.app",
        "report.bands",
        "report.scene_page",
    )
]
"""What the commands import, so that no process imports it again."""
FEW, MANY = 20, 1000
"""Calls during the first one, at most."""
FREE = ("timestep",)
"""Reads what no call changes once it is there."""


@pytest.fixture(scope="module")
def given(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The configuration with a short moist case, and two scenes of which one is the other, edited."""
    folder = tmp_path_factory.mktemp("given")
    text = (shutil.copytree(ROOT / "config", folder / "config") / "scales.yaml").read_text()
    for name, before, after in (("duration_s", 1.6, 0.03), ("slide_opens_at_s", 0.2, 0.02)):
        assert f"{name}: {{value: {before}," in text
        text = text.replace(f"{name}: {{value: {before},", f"{name}: {{value: {after},", 1)
    (folder / "config" / "scales.yaml").write_text(text)
    for name in ("race_a", "race_b"):
        scene = (SCENES / f"{name}.yaml").read_text()
        scene = scene.replace("duration_s: 1.6", "duration_s: 0.02").replace("count: 120", "count: 12")
        (folder / f"{name}.yaml").write_text(scene)
    (folder / "out").mkdir()
    return {"config": f"{folder}/config", "out": f"{folder}/out"} | {
        n: f"{folder}/{n}.yaml" for n in ("race_a", "race_b")
    }


def call(words: Words, named: dict[str, str]) -> dict[str, Any]:
    """Exit code and all that a command printed, in its order."""
    done = CliRunner(env={"COLUMNS": "400", "NO_COLOR": "1"}).invoke(app, [word.format(**named) for word in words])
    fault = done.exception is not None and not isinstance(done.exception, SystemExit)
    return {
        "code": 99 if fault else done.exit_code,
        "said": done.output + (repr(done.exception) if fault else ""),
    }


def forked(work: Callable[[], Any], answer: Path) -> Any:
    """Return the result of a function in a separate process."""
    child = os.fork()
    if child == 0:
        try:
            answer.write_text(json.dumps(work()))
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    return json.loads(answer.read_text())


def content(run: Path) -> dict[str, bytes]:
    """All that a second call could change: the engine of the first writes on in engine.partial."""
    paths = (
        p for p in run.rglob("*") if p.is_file() and "engine.partial" not in p.parts and not p.name.endswith(".lock")
    )
    return {str(path): path.read_bytes() for path in sorted(paths)}


def interrupted(
    first: Words, others: Mapping[str, Words], named: dict[str, str], folder: Path, most: int, files: int
) -> list[Any]:
    """The first call, and at `most` of the `files` that it completes another in turn: (name, answer, whether it changed).

    Without others, how many files it completes in the place of their answers.
    """
    seen: list[Any] = []
    busy, count, ask = False, 0, itertools.cycle(others.items())

    def hook(event: str, given: tuple[Any, ...]) -> None:
        nonlocal busy, count
        if busy or event != "os.rename" or not str(given[1]).startswith((named["run"], named["out"])):
            return
        count += 1
        if not others or count * most // files == (count - 1) * most // files:
            return
        busy = True
        name, words = next(ask)
        before = content(Path(named["run"]))
        answer = forked(lambda: call(words, named), folder / "second.json")
        seen.append((name, answer, content(Path(named["run"])) != before))
        busy = False

    def work() -> list[Any]:
        sys.addaudithook(hook)
        return [("first", call(first, named), False), *(seen if others else [count])]

    return list(forked(work, folder / "first.json"))


@pytest.mark.parametrize(
    ("first", "most"),
    [("run-scene A", FEW), *(pytest.param(first, MANY, marks=pytest.mark.slow) for first in SIMULATES)],
)
def test_a_call_that_simulates_is_alone(given: dict[str, str], tmp_path: Path, first: str, most: int) -> None:
    """From its first file to its page; its tables are those of a run without others, and no folder was moved aside."""
    named, alone = ({**given, "run": str(tmp_path / name)} for name in ("run", "alone"))
    (_, answer, _), files = interrupted(SIMULATES[first], {}, alone, tmp_path, 0, 0)
    assert answer["code"] == 0, answer
    calls = SIMULATES | READS | OTHERS
    mine, *others = interrupted(SIMULATES[first], calls, named, tmp_path, min(most, files), files)
    assert mine[1]["code"] == 0, mine
    assert {name for name, _, _ in others} == set(calls)
    for name, answer, changed in others:
        assert not changed and answer["code"] in (0, 1, 2), (name, answer)
        expected = "lies in the run directory" if name.startswith("init") else AT_WORK
        assert name in FREE or (answer["code"] and expected in answer["said"]), (name, answer)
    print(f"{first}: {len(others)} calls of {len(calls)} kinds at {files} files")
    assert_same(tables_of(tmp_path / "alone"), tables_of(tmp_path / "run"))
    assert {p.name for p in tmp_path.iterdir()} == {"run", "alone", "first.json", "second.json"}
    assert {p.name for p in (tmp_path / "run").iterdir()} == {p.name for p in (tmp_path / "alone").iterdir()}


@pytest.mark.parametrize(
    ("first", "most"), [("view", 10), *(pytest.param(first, MANY, marks=pytest.mark.slow) for first in READS)]
)
def test_calls_that_read_go_side_by_side(given: dict[str, str], finished: Path, first: str, most: int) -> None:
    """With all that read or evaluate, but for two that draw one time series; what simulates waits until they have ended."""
    named, folder = given | {"run": str(finished)}, finished.parent
    before = tables_of(finished)
    (_, answer, _), files = interrupted(READS[first], {}, named, folder, 0, 0)
    assert answer["code"] == 0 and files, answer
    mine, *others = interrupted(READS[first], SIMULATES | OTHERS | READS, named, folder, min(most, files), files)
    assert mine[1]["code"] == 0, mine
    for name, answer, changed in others:
        assert answer["code"] in (0, 1), (name, answer)
        if name in READS | {"timestep": ()}:
            drawn = first == "view" == name and AT_WORK in answer["said"]
            assert answer["code"] == 0 or drawn, (name, answer)
            continue
        expected = "lies in the run directory" if name.startswith("init") else AT_WORK
        assert answer["code"] == 1 and expected in answer["said"] and not changed, (name, answer)
    print(f"{first}: {len(others)} calls at {files} files")
    assert_same(before, tables_of(finished))


@pytest.fixture(scope="module")
def finished(given: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished moist run with one bridge or more."""
    run = tmp_path_factory.mktemp("finished") / "run"
    assert (
        forked(lambda: call(SIMULATES["run-scene A"], given | {"run": str(run)}), run.parent / "made.json")["code"] == 0
    )
    return run
