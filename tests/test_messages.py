"""Every error has a code; messages are rendered once, by code; all other tests assert codes and data.

`python -m tests.test_messages` writes tests/data/messages.yaml again, to be read before it is committed.
"""

from __future__ import annotations

import ast
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml

import pywet
from pywet import config, errors, scene_stages, shipped
from pywet.cli.app import app
from pywet.collisions.wall import wall
from pywet.config import Materials
from pywet.config.command_line import chosen
from pywet.errors import ConfigError, PywetError
from pywet.report import render
from tests import mistakes
from tests.error_codes import raises_code
from tests.import_graph import ROOT
from tests.reliability.test_bad_inputs import content
from tests.sweep import mistakes as of_sweeps
from tests.sweep.files import WALL, write

STORED = ROOT / "tests" / "data" / "messages.yaml"
ROWS = ROOT / "tests" / "reliability" / "rows"
OF_MACHINE = {"ranks", "packing.memory"}
"""Keys and codes whose limit is that of this machine."""
CODED = re.compile(r"[a-z]+\.[a-z_]+")
KINDS = {"NotComparable", *(n for n, k in vars(errors).items() if isinstance(k, type) and issubclass(k, PywetError))}
ELSEWHERE = {
    "digest.out": "tests/compare/test_compare.py",
    "lammps.refused": "tests/engines/test_lammps.py",
}  # fmt: skip
"""Code -> the test that provokes it and cannot assert it: it reads the messages of another process, or a page."""


def calls() -> Iterator[tuple[str, ast.Call]]:
    """Every call in the package, with its module."""
    for path in sorted((ROOT / "pywet").rglob("*.py")):
        yield from (
            (str(path.relative_to(ROOT)), node)
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.Call)
        )


def codes() -> dict[str, set[str]]:
    """Code -> the modules that give it."""
    found: dict[str, set[str]] = {}
    for module, call in calls():
        for given in (k.value for k in call.keywords if k.arg == "code"):
            if isinstance(given, ast.Constant) and isinstance(given.value, str):
                found.setdefault(given.value, set()).add(module)
    return found


def asserted() -> set[str]:
    """Codes that tests and rows name."""
    texts = [p.read_text() for p in (ROOT / "tests").rglob("*.py") if p.name not in ("test_messages.py", "mistakes.py")]
    rows = [p.read_text() for p in ROWS.glob("*.yaml")]
    return {*re.findall(r'"([a-z]+\.[a-z_]+)"', "".join(texts)), *re.findall(r"code: ([a-z]+\.[a-z_]+)", "".join(rows))}


def commanded(row: dict[str, Any], folder: Path) -> None:
    """Run the command of a row, with its files."""
    here = folder / "here"
    here.mkdir()
    shutil.copytree(ROOT / "config", folder / "config")
    for name, (old, new) in row.get("config", {}).items():
        path = folder / "config" / name
        path.write_text(path.read_text().replace(old, new, 1))
    for name, value in row.get("write", {}).items():
        (here / name).write_bytes(content(value))
    command(*(str(word).format(here=here, config=folder / "config") for word in row["run"]))


def of_rows() -> dict[str, Callable[[Path], Any]]:
    """The first row of each code that needs no run."""
    found: dict[str, Callable[[Path], Any]] = {}
    for path in sorted(ROWS.glob("*.yaml")):
        for row in yaml.safe_load(path.read_text()):
            if (
                "error" in row
                and "made" not in row
                and not OF_MACHINE & {row["error"].get("key"), row["error"]["code"]}
            ):
                found.setdefault(row["error"]["code"], partial(commanded, row))
    return found


def written(name: str, data: bytes, folder: Path) -> None:
    shutil.copytree(ROOT / "config", folder / "config")
    (folder / "config" / name).write_bytes(data)
    config.load(folder / "config")


def without_studies() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shipped, "open_studies", lambda: False)
        command("study", "stability")


def without_collisions(folder: Path) -> None:
    def refuse(_: object) -> None:
        raise PywetError("no collision today")

    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(wall, "collide", refuse)
        command("sweep", str(write(folder, WALL)), "--out", str(folder / "out"))


def walls_differ(materials: Materials) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            Materials, "contact", lambda _, sphere, partner: SimpleNamespace(numbers=partner, partner=partner)
        )
        materials.wall_contact("POM")


def command(*words: str) -> None:
    """Run `pywet` and raise what its border has put into words."""
    try:
        app([*words], standalone_mode=False)
    except SystemExit as end:
        raise end.__context__ or end from None


def triggers() -> dict[str, Callable[[Path], Any]]:
    """Code -> what raises it, in a folder."""
    loaded, cases = config.load(ROOT / "config"), (ROOT / "config" / "cases.csv").read_bytes()
    header = cases.partition(b"\n")[0] + b"\n"
    return of_rows() | mistakes.mistakes() | of_sweeps.mistakes() | {
        "config.not_yaml": lambda folder: written("config.yaml", b"scale: smoke\n- smoke\n", folder),
        "config.not_text": lambda folder: written("config.yaml", b"scale: \xff", folder),
        "config.not_keys": lambda folder: written("config.yaml", b"[1, 2]", folder),
        "config.not_csv": lambda folder: written("cases.csv", header + b'1,"' + b"x" * 200_000, folder),
        "config.no_case": lambda folder: written("cases.csv", header, folder),
        "config.no_contact": lambda _: loaded.materials.contact("POM", "lead"),
        "cli.sweep_failed": without_collisions,
        "config.walls_differ": lambda _: walls_differ(loaded.materials),
        "cli.no_studies": lambda _: without_studies(),
        "config.reference": lambda folder: written("cases.csv", cases.replace(b"2,POM,5,7", b"2,POM,4,7"), folder),
        "config.unknown_preset": lambda _: loaded.with_preset("papers"),
        "config.unknown_material": lambda _: loaded.materials.sphere("lead"),
        "config.unknown_liquid": lambda _: loaded.materials.liquid_named("mercury"),
        "config.unknown_size": lambda _: loaded.materials.size("POM", 4.0),
        "config.not_on_command_line": lambda _: chosen(loaded.settings, {**loaded.settings.model_dump(), "retire": True}),
        "scene.frozen": lambda _: setattr(pywet.Scene.model_construct(name="bed"), "seed", 3),
        "scene.no_folder": lambda _: scene_stages.finish(pywet.Scene.model_construct(), ""),
        "init.unknown_example": lambda folder: shipped.begin(folder, "mill"),
        "init.there": lambda folder: [(folder / "Snakefile").touch(), shipped.begin(folder)],
        "cli.no_case": lambda _: command("plan", "--accuracy", "2%", "--config", str(ROOT / "config")),
        "cli.plan_options": lambda _: command("plan", "2", "--write", "x", "--config", str(ROOT / "config")),
        "cli.bridge_engine": lambda _: command("bridge", str(ROOT / "examples" / "bridge.json"), "--engine", "yade"),
        "cli.sweep_words": lambda _: command("sweep", "a.yaml", "b.yaml"),
        "cli.plot_words": lambda _: command("sweep", "plot", "a.yaml"),
        "cli.unused_option": lambda _: command("kinetics", "run", "--from", "2"),
        "cli.no_run": lambda folder: command("report", str(folder)),
    }  # fmt: skip


def rendered() -> dict[str, str]:
    """Code -> its message, with DIR for the folder and ROOT for the checkout."""
    found = {}
    for code, trigger in sorted(triggers().items()):
        with tempfile.TemporaryDirectory() as name:
            try:
                trigger(Path(name))
                found[code] = "nothing was raised"
            except PywetError as error:
                assert error.code == code, (code, error.code, str(error))
                found[code] = str(error).replace(name, "DIR").replace(str(ROOT), "ROOT")
    return found


def test_every_error_has_a_distinct_code() -> None:
    """It is written where the error is made, passed on (`code=code`), or that of another error (`**error.data`)."""
    without = [
        f"{module}:{call.lineno}" for module, call in calls()
        if ast.unparse(call.func).rpartition(".")[2] in KINDS and not {"code", None} & {k.arg for k in call.keywords}
    ]  # fmt: skip
    assert without == []
    found = codes()
    assert [code for code in found if not CODED.fullmatch(code)] == []
    assert {code: modules for code, modules in found.items() if len(modules) > 1} == {}
    assert len(found) > 300


def test_each_message_is_as_stored() -> None:
    """A sentence is improved by a change of tests/data/messages.yaml alone."""
    assert rendered() == yaml.safe_load(STORED.read_text())


def test_every_code_is_rendered_once_or_asserted() -> None:
    assert set(codes()) - set(yaml.safe_load(STORED.read_text())) - asserted() == set(ELSEWHERE)
    assert all((ROOT / test).exists() for test in ELSEWHERE.values())


def test_an_error_carries_its_data_to_another_of_its_kind() -> None:
    first = ConfigError("a", file="f.yaml", key="k", code="config.value", given=3, expected=4)
    assert ConfigError("b", **first.data).data == first.data == {
        "code": "config.value", "key": "k", "given": 3, "expected": 4, "where": "f.yaml"
    }  # fmt: skip


def test_an_error_of_a_child_process_keeps_its_code_and_data() -> None:
    with raises_code("program.arguments", given=[]):
        list(render.in_child("pywet.report.closeup"))


@pytest.mark.parametrize(
    ("kind", "code"), [("FileError", "file"), ("LawError", "law"), ("StoppedRun", "engine.stopped")]
)
def test_a_kind_has_a_code_where_none_was_given(kind: str, code: str) -> None:
    assert getattr(errors, kind)("a sentence").code == code


if __name__ == "__main__":
    STORED.write_text(yaml.safe_dump(rendered(), allow_unicode=True, width=1000))
