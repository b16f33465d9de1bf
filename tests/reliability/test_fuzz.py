"""Every reader on inputs that nobody would write: fine, or one printable sentence (`PywetError`); never another exception.

Each target gets a handful of inputs in `make test`, the same at every call, and all together ten thousand among the slow tests:
`pytest -m slow tests/reliability/test_fuzz.py`.
"""

from __future__ import annotations

import copy
import json
import shutil
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from pywet import config, stages
from pywet.cases.screening import cases, results
from pywet.cases.small import bridge_query
from pywet.cli import ending, showing
from pywet.cli.app import app
from pywet.collisions.spheres import command as spheres
from pywet.collisions.spheres import simulate
from pywet.collisions.wall import sweep
from pywet.compare import digest, quantities
from pywet.errors import PywetError
from pywet.planning import audit, time_steps
from pywet.report import collect, report, report_numbers, vtk
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene
from pywet.util.files import parse_json, write_json
from tests.cases.screening import synthetic
from tests.report.test_report import REPLAY

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
FEW, MANY = 12, 1000
"""Inputs to each target."""

NUMBERS = (
    st.sampled_from([0, -1, 1, 2, 90, 0.5, 1e-3, 1e30, 1e-30, 1e308, -1e308, 5e-324, 10**300, 10**400]) | st.floats()
)
WORDS = st.sampled_from(
    ["", "x", "1e-3", "0,07275", "$\\frac{1}{0$", "[/x]", "\x1b[31m", "\ud800", "../../x", "a\nb", "n" * 300]
)
LEAVES = st.none() | st.booleans() | NUMBERS | WORDS | st.integers() | st.text(max_size=5)
VALUES = st.recursive(
    LEAVES, lambda v: st.lists(v, max_size=3) | st.dictionaries(st.text(max_size=4), v, max_size=3), max_leaves=4
)
HOW = st.sampled_from(["set", "set", "set", "drop", "add"])
FRACTION = st.floats(0, 1, exclude_max=True)


def places(value: Any) -> Iterator[tuple[Any, Any]]:
    """Every (container, key) inside nested dicts and lists."""
    for key in value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield value, key
        yield from places(value[key])


def changed(document: Any, where: float, how: str, new: Any) -> Any:
    """A copy with the value at one of its places replaced, dropped, or joined by another key."""
    document = copy.deepcopy(document)
    found = list(places(document))
    inside, key = found[int(where * len(found))]
    if how == "set":
        inside[key] = new
    elif how == "drop":
        del inside[key]
    elif isinstance(inside, dict):
        inside[str(new)[:50]] = new
    else:
        inside.append(new)
    return document


def broken(data: bytes, where: float, how: str, bit: int) -> bytes:
    """Bytes with one bit flipped, cut off, or followed by some that do not belong there."""
    at = int(where * len(data))
    if how == "set" and data:
        return data[:at] + bytes([data[at] ^ (1 << bit)]) + data[at + 1 :]
    return data[:at] if how == "drop" else data + b"\0" * bit


CHANGE = st.tuples(FRACTION, HOW, VALUES)
BREAK = st.tuples(FRACTION, HOW, st.integers(0, 7))


@dataclass
class Bench:
    """A folder, a whole run directory in it, and the configuration."""

    folder: Path
    good: Path
    config: config.Config

    def fresh(self) -> Path:
        """A copy of the good run directory."""
        run = self.folder / "run" / "case02"
        shutil.rmtree(run, ignore_errors=True)
        return Path(shutil.copytree(self.good, run))

    def put(self, text: str | bytes) -> Path:
        """A file with this content."""
        path = self.folder / "given.json"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path


def sentence(*calls: Callable[[], Any]) -> None:
    """Each call returns, or is refused in one printable line."""
    for call in calls:
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                call()
        except PywetError as error:
            assert 10 < len(str(error)) < 5000


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    folder = tmp_path_factory.mktemp("fuzz")
    good, case = synthetic.make(folder / "good" / "case02"), 2
    loaded = config.load(ROOT / "config")
    write_json(good / "plan.json", cases.ingredients(loaded, case, "smoke").plan.as_dict())
    entry = {"acting": True, "impulse_share": 0.1, "liquid_share": 0.1, "mean_stretch": 0.1}
    names = {row["effect"] for row in json.loads((good / "plan.json").read_text())["rows"]}
    forces = {*names, "weight", "contact_normal", "contact_tangential"}
    write_json(good / "contributions.json", {"effects": dict.fromkeys(sorted(forces), entry)})
    write_json(good / "replay.json", {"ok": True, **REPLAY})
    write_json(good / "scene_result.json", {"work_J": 1e-6})
    audit.write(good)
    for stage in stages.NEEDS:
        stages.attempt(good, stage, lambda stage=stage: stages.results(good) if stage == "results" else None)
    numbers = digest.numbers_in(good)
    facts = quantities.facts(quantities.read_run(good).scene)
    digest.save(digest.make("case02", "", [numbers], facts), folder / "digest.json")
    return Bench(folder, good, loaded)


def text(bench: Bench, given: bytes | str) -> None:
    """Any bytes and any text as JSON."""
    sentence(lambda: parse_json(given, "given", "fix it"))


def query(bench: Bench, given: tuple[str, tuple[float, str, Any]]) -> None:
    """Descriptions of bridges and collisions with one value changed."""
    name, change = given
    document = json.loads((EXAMPLES / name).read_text())
    file = bench.put(json.dumps(changed(document, *change)))
    if name.startswith("bridge"):
        sentence(lambda: json.dumps(bridge_query.answer(bridge_query.read(file)), allow_nan=False))
    elif name.startswith("wall"):
        sentence(lambda: json.dumps(sweep.records(sweep.table(sweep.read(file), threads=1)), allow_nan=False))
    else:
        sentence(lambda: json.dumps(spheres.describe(spheres.run(spheres.read(file))), allow_nan=False))


def scene(bench: Bench, given: tuple[float, str, Any]) -> None:
    """scene.json with one value changed: the advisor, results, pictures."""
    run = bench.fresh()
    document = json.loads((run / "scene.json").read_text())
    (run / "scene.json").write_text(json.dumps(changed(document, *given)))
    sentence(lambda: time_steps.advise(EngineScene.read(run / "scene.json")).lines, lambda: read_all(run))


JSON_FILES = (
    "scene",
    "summary",
    "replay",
    "plan",
    "contributions",
    "audit",
    "scene_result",
    "engine/run",
    "status/results",
)


def json_file(bench: Bench, given: tuple[str, tuple[float, str, Any]]) -> None:
    """A JSON file of a run with one value changed, to everything that reads it."""
    name, change = given
    run = bench.fresh()
    path = run / f"{name}.json"
    path.write_text(json.dumps(changed(json.loads(path.read_text()), *change)))
    sentence(*readers(bench, run))


def broken_file(bench: Bench, given: tuple[float, tuple[float, str, int]]) -> None:
    """Any file of a run with a bit flipped, cut or lengthened, to everything that reads it."""
    which, damage = given
    run = bench.fresh()
    files = sorted(p for p in run.rglob("*") if p.is_file() and p.suffix != ".csv")
    path = files[int(which * len(files))]
    path.write_bytes(broken(path.read_bytes(), *damage))
    sentence(*readers(bench, run))


COLUMN = st.tuples(
    FRACTION, FRACTION, FRACTION, st.sampled_from(["value", "one", "drop", "rows", "twice", "empty"]), LEAVES
)


def table(bench: Bench, given: tuple[float, float, float, str, Any]) -> None:
    """A table of a run with other values in a column, without it, or with other rows."""
    which, column, row, how, new = given
    run = bench.fresh()
    files = sorted(run.rglob("*.parquet"))
    path = files[int(which * len(files))]
    frame = pd.read_parquet(path)
    name = frame.columns[int(column * len(frame.columns))]
    keep = int(row * len(frame))
    try:
        if how == "value":
            frame[name] = [new] * len(frame)
        elif how == "one" and len(frame):
            frame[name] = [new if k == keep else v for k, v in enumerate(frame[name])]
    except UnicodeEncodeError:  # pandas rejects half a surrogate pair
        return
    frame = {"drop": frame.drop(columns=name), "rows": frame.iloc[:keep], "twice": pd.concat([frame, frame]),
             "empty": frame.iloc[:0]}.get(how, frame)  # fmt: skip
    try:
        frame.to_parquet(path)
    except Exception:  # values that pandas cannot write are not an input
        return
    sentence(*readers(bench, run))


def read_all(run_dir: Path) -> None:
    """Results and what is drawn of a run."""
    run = RunDir(run_dir)
    results.summarise(run, results.Results.of(run))
    for step in run.timeline.steps[:1]:
        for kind in vtk.KINDS.values():
            kind(run, int(step))


def read_report(bench: Bench, run: Path) -> None:
    """The numbers of the report on a run and what its page shows."""
    found = [collect.collect_run(run, bench.config.case(2))]
    report.context("smoke", found, report_numbers.collected(found, bench.config, "smoke"), None)


def readers(bench: Bench, run: Path) -> list[Callable[[], Any]]:
    """Everything that reads a run directory, but the replay, which has its own tests."""
    return [
        lambda: read_all(run),
        lambda: stages.judge([run]),
        lambda: list(ending.lines([RunDir(run)], None)),
        lambda: ending.details(RunDir(run), showing.out),
        lambda: read_report(bench, run),
        lambda: quantities.read_run(run),
        lambda: digest.check(digest.load(bench.folder / "digest.json"), run),
    ]


def stored_digest(bench: Bench, given: tuple[float, str, Any]) -> None:
    """A digest with one value changed."""
    document = json.loads((bench.folder / "digest.json").read_text())
    file = bench.put(json.dumps(changed(document, *given)))
    sentence(lambda: digest.check(digest.load(file), bench.good))


def configuration(bench: Bench, given: tuple[str, tuple[float, str, Any]]) -> None:
    """A file of the configuration with one value changed, up to the effect plan."""
    name, change = given
    folder = bench.folder / "config"
    shutil.copytree(ROOT / "config", folder, dirs_exist_ok=True)
    document = yaml.safe_load((folder / name).read_text())
    (folder / name).write_text(yaml.safe_dump(changed(document, *change)), errors="surrogatepass")
    sentence(lambda: cases.ingredients(config.load(folder), 2, "smoke").plan.lines)


OPTIONS = (
    ("plan", "CASE"), ("plan", "2", "--accuracy"), ("plan", "2", "--scale"), ("run", "2", "--ranks"), ("run", "2", "--seed"),
    ("view", "none", "--step"), ("scene", "bed", "--spheres"), ("scene", "pull", "--speed"), ("scene", "drum", "--rpm"),
    ("scene", "bed", "--seconds"), ("scene", "bed", "--moisture"), ("scene", "bed", "--viscosity"), ("scene", "bed", "--seed"),
    ("study", "effects", "--size"), ("study", "effects", "--seeds"), ("study", "stability", "--cases"),
)  # fmt: skip
"""Commands with their last argument left open."""


def option(bench: Bench, given: tuple[tuple[str, ...], Any]) -> None:
    """Values that no option of a command can have: exit code 1 or 2, and what was given is said."""
    (*before, last), value = given
    assume(
        (last, value) != ("CASE", "--")
    )  # the end of the options: no case is given, and that of the defaults is taken
    arguments = [*before, value] if last == "CASE" else [*before, f"{last}={value}"]
    result = CliRunner(env={"COLUMNS": "300", "NO_COLOR": "1"}).invoke(app, arguments)
    assert isinstance(result.exception, SystemExit) and result.exit_code in (1, 2), (arguments, result.exception)
    assert "Traceback" not in result.output and result.stderr.strip()


SENSELESS = st.sampled_from(
    ["nan", "inf", "-inf", "x", "", "-1e300", "1e999", "0x10", "1,5", "--", "\x00", "-20", "[/x]", "٣x"]
)
TARGETS: dict[str, tuple[Callable[[Bench, Any], None], st.SearchStrategy[Any]]] = {
    "text": (text, st.binary(max_size=60) | st.text(max_size=60) | VALUES.map(json.dumps)),
    "query": (query, st.tuples(st.sampled_from(["bridge.json", "bridge_wall.json", "wall_wet.json", "wall_oblique_dry.json",
                                                "three_equal_spheres.json", "four_spheres.json"]), CHANGE)),
    "scene": (scene, CHANGE),
    "json_file": (json_file, st.tuples(st.sampled_from(JSON_FILES), CHANGE)),
    "broken_file": (broken_file, st.tuples(FRACTION, BREAK)),
    "table": (table, COLUMN),
    "digest": (stored_digest, CHANGE),
    "configuration": (configuration, st.tuples(st.sampled_from(["config.yaml", "materials.yaml", "scales.yaml"]), CHANGE)),
    "option": (option, st.tuples(st.sampled_from(OPTIONS), SENSELESS)),
    "option_text": (option, st.tuples(st.sampled_from(OPTIONS), st.text("abcxyz,;$", min_size=1, max_size=8))),
}  # fmt: skip


@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=[pytest.mark.slow, pytest.mark.timeout(7200)])])
@pytest.mark.parametrize("target", TARGETS)
def test_any_input_is_fine_or_refused_in_a_sentence(
    target: str, count: int, bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(simulate, "MOST_STEPS", 2000)  # sufficient to detect a crash
    monkeypatch.setattr(report, "_figures", lambda found: {})  # seconds each
    check, strategy = TARGETS[target]

    def tried(given: Any) -> None:
        check(bench, given)

    quiet = settings(
        max_examples=count, deadline=None, database=None, derandomize=True, suppress_health_check=list(HealthCheck)
    )
    quiet(given(strategy)(tried))()


def test_the_slow_run_is_as_long_as_promised() -> None:
    assert MANY * len(TARGETS) >= 10_000
