"""docs/own-scene.md: its snippets run as they are printed, its tables are those of the source."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import pandas as pd
import pytest

from pywet.own_scene.building import Building
from pywet.own_scene.commands import read_scene
from pywet.own_scene.walls import MOTIONS, SHAPES
from pywet.scene import Holder
from pywet.schema import CODES, HOLDERS, TABLES, meanings

PAGE = (Path(__file__).parents[2] / "docs" / "own-scene.md").read_text()


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found
    return found.group(1)


@pytest.mark.engine
def test_the_python_of_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It runs in an empty folder; what it prints are units and meanings, and the liquid that was put in: 1 % of 30 beads."""
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(compile(block("python"), "page", "exec"), names)
    assert "m/s S at the event" in capsys.readouterr().out
    mass = 30 * 2500 * 3.14159265 / 6 * 0.003**3
    liquid: pd.DataFrame = names["run"].liquid
    assert liquid["total_m3"].to_numpy() == pytest.approx(0.01 * mass / 1000, rel=1e-6)
    assert (tmp_path / "cup" / "picture.png").exists() and (tmp_path / "cup" / "vtk" / "walls.pvd").exists()


def test_the_yaml_of_the_page(tmp_path: Path) -> None:
    """One gram of 5 mm POM is 11 spheres; the fine have their own film."""
    (tmp_path / "scene.yaml").write_text(block("yaml"))
    made = Building(read_scene(tmp_path / "scene.yaml"))
    assert [c.count for c in made.classes] == [11, 10]
    assert made.thickness[1] == pytest.approx(20e-6)
    assert made.scene().vibration is not None


def test_every_holder_is_explained() -> None:
    assert set(HOLDERS) == set(get_args(Holder))


def test_codes_and_keys_are_those_of_the_source() -> None:
    for name, rows in CODES.items():
        for code, text in rows.items():
            assert f"| {name} | {code} | {text} |" in PAGE
    assert all(f"`{key}`" in PAGE for key in (*SHAPES, *MOTIONS))


@pytest.mark.parametrize("table", ["trajectory", *(t for t in TABLES if meanings(t) and t != "trajectory")])
def test_every_column_of_a_log_has_a_unit_and_a_meaning(table: str) -> None:
    assert set(meanings(table)) == set(TABLES[table])
    assert all(unit and text for unit, text in meanings(table).values())
