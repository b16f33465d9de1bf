"""Every message once: what a user reads of each mistake, by its code; all other tests assert codes and data.

`python -m tests.test_messages` writes tests/data/messages.yaml again, to be read before it is committed.
"""

from __future__ import annotations

import ast
import re
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

import pywet
from pywet import config, errors, scene_stages, shipped
from pywet.cli.app import app
from pywet.config.command_line import chosen
from pywet.errors import ConfigError, PywetError
from tests.import_graph import ROOT

STORED = ROOT / "tests" / "data" / "messages.yaml"
ROWS = ROOT / "tests" / "reliability" / "rows"
MIGRATED = ("config", "cli", "cases/custom", "scene_stages.py", "shipped.py", "errors.py")
"""Where every mistake has a code of its own."""
CODED = re.compile(r"[a-z]+\.[a-z_]+")
ELSEWHERE = {
    "cli.objections": "tests/cli/test_ending.py", "cli.stage_failed": "tests/cli/test_cli.py",
    "cli.no_page": "tests/test_docs.py", "cli.sweep_failed": "tests/sweep",
    "scene.overlap": "tests/cases/custom/test_building.py",
    "scene.in_wall": "tests/cases/custom/test_building.py", "scene.box": "tests/cases/custom/test_vast.py",
    "scene.narrow_region": "tests/reliability/rows/scenes.yaml", "scene.long_feed": "tests/reliability/rows/scenes.yaml",
    "scene.crowded_feed": "tests/cases/custom/test_feeding.py", "scene.stl_unit": "tests/cases/custom/test_parts.py",
    "scene.far_away": "tests/cases/custom/test_parts.py", "scene.objections": "tests/cases/custom",
    "program.argument": "tests/reliability/bad_calls.py", "program.arguments": "tests/reliability/bad_calls.py",
    "config.residual": "tests/test_config.py", "config.no_mass": "tests/test_config.py",
    "config.walls_differ": "tests/test_config.py",


}  # fmt: skip
"""Code -> the test that reads its sentence, which takes a run, a scene or a file that is no text."""


def codes() -> dict[str, list[str]]:
    """Code -> the places that raise it, in the modules whose mistakes all have one."""
    found: dict[str, list[str]] = {}
    for path in (
        p
        for part in MIGRATED
        for p in sorted((ROOT / "pywet").glob(f"{part}" if part[-3:] == ".py" else f"{part}/*.py"))
    ):
        for node in (n for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.Raise)):
            call = node.exc
            if isinstance(call, ast.Call) and ast.unparse(call.func) in ("PywetError", "ConfigError"):
                given = {k.arg: k.value for k in call.keywords}
                code = given.get("code")
                passed_on = None in given  # `**error.data`: that of another error
                name = "" if passed_on else code.value if isinstance(code, ast.Constant) else "none"
                found.setdefault(name, []).append(f"{path.relative_to(ROOT)}:{node.lineno}")
    found.pop("", None)
    return found


def configured(change: dict[str, list[str]], folder: Path) -> None:
    shutil.copytree(ROOT / "config", folder / "config")
    for name, (old, new) in change.items():
        path = folder / "config" / name
        path.write_text(path.read_text().replace(old, new, 1))
    config.load(folder / "config")


def of_rows() -> dict[str, Callable[[Path], Any]]:
    """The first row of each code that a changed configuration has."""
    found: dict[str, Callable[[Path], Any]] = {}
    for name in ("config", "values"):
        for row in yaml.safe_load((ROWS / f"{name}.yaml").read_text()):
            if "error" in row and row["error"]["key"] != "ranks":  # whose limit is that of the machine
                found.setdefault(row["error"]["code"], lambda folder, row=row: configured(row["config"], folder))
    return found


def written(name: str, data: bytes, folder: Path) -> None:
    shutil.copytree(ROOT / "config", folder / "config")
    (folder / "config" / name).write_bytes(data)
    config.load(folder / "config")


def without_studies() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shipped, "open_studies", lambda: False)
        command("study", "stability")


def command(*words: str) -> None:
    """Run `pywet` and raise what its border has put into words."""
    try:
        app([*words], standalone_mode=False)
    except SystemExit as end:
        raise end.__context__ or end from None


def triggers() -> dict[str, Callable[[Path], Any]]:
    """Code -> what raises it, in a folder."""
    loaded, header = (
        config.load(ROOT / "config"),
        (ROOT / "config" / "cases.csv").read_bytes().partition(b"\n")[0] + b"\n",
    )
    return of_rows() | {
        "config.not_yaml": lambda folder: configured({"config.yaml": ["scale: smoke", "- smoke"]}, folder),
        "config.not_text": lambda folder: written("config.yaml", b"scale: \xff", folder),
        "config.not_keys": lambda folder: written("config.yaml", b"[1, 2]", folder),
        "config.not_csv": lambda folder: written("cases.csv", header + b'1,"' + b"x" * 200_000, folder),
        "config.no_case": lambda folder: written("cases.csv", header, folder),
        "config.no_contact": lambda _: loaded.materials.contact("POM", "lead"),
        "cli.no_studies": lambda _: without_studies(),
        "config.reference": lambda folder: configured({"cases.csv": ["2,POM,5,7", "2,POM,4,7"]}, folder),
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
        "cli.bridge_engine": lambda _: command("bridge", str(ROOT / "examples" / "bridge.json"), "--engine", "yade"),
        "cli.sweep_words": lambda _: command("sweep", "a.yaml", "b.yaml"),
        "cli.plot_words": lambda _: command("sweep", "plot", "a.yaml"),
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


def test_every_mistake_has_a_distinct_code() -> None:
    found = codes()
    assert "none" not in found, found["none"]
    assert all(CODED.fullmatch(code) for code in found)
    assert {code: places for code, places in found.items() if len(places) > 1} == {}
    assert len(found) > 40


def test_each_message_is_as_stored() -> None:
    """A sentence is improved by a change of tests/data/messages.yaml alone."""
    assert rendered() == yaml.safe_load(STORED.read_text())


def test_every_code_is_rendered_once_or_named_with_its_test() -> None:
    stored = set(yaml.safe_load(STORED.read_text()))
    assert set(codes()) - stored == set(ELSEWHERE)
    assert all((ROOT / test).exists() for test in ELSEWHERE.values() if test != "tests/sweep")


def test_an_error_carries_its_data_to_another_of_its_kind() -> None:
    first = ConfigError("a", file="f.yaml", key="k", code="config.value", given=3, expected=4)
    assert ConfigError("b", **first.data).data == first.data == {
        "code": "config.value", "key": "k", "given": 3, "expected": 4, "where": "f.yaml"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "code"), [("FileError", "file"), ("LawError", "law"), ("StoppedRun", "engine.stopped")]
)
def test_a_kind_has_a_code_where_none_was_given(kind: str, code: str) -> None:
    assert getattr(errors, kind)("a sentence").code == code


if __name__ == "__main__":
    STORED.write_text(yaml.safe_dump(rendered(), allow_unicode=True, width=1000))
