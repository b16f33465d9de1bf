"""What the files of a run say is checked before the plugin takes it for array indices."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from pywet.engines.liggghts.border import check_start, check_tables
from pywet.engines.liggghts.inputs import transfer_tables
from pywet.engines.liggghts.worker import corner_points
from pywet.scene import EngineScene
from pywet.util.files import read_table
from tests.cases.screening import synthetic
from tests.error_codes import raises_code


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    run = synthetic.make(tmp_path_factory.mktemp("run") / "case02")
    scene = EngineScene.read(run / "scene.json")
    spheres = read_table(run / "history" / "spheres.parquet")
    nodes = corner_points(read_table(run / "history" / "triangles.parquet"))
    return {"scene": scene, "spheres": spheres, "transfer": transfer_tables(scene), "nodes": nodes}


def test_the_tables_of_a_run_pass(whole: dict[str, Any]) -> None:
    check_tables(**whole)


@pytest.mark.parametrize(
    "wrong, says",
    [
        (lambda t: t.assign(id=-t.id), "repeated, missing or below 1; expected 1 to "),
        (lambda t: t.assign(id=0 * t.id + 1), "repeated, missing or below 1"),
        (lambda t: t.assign(id=t.id + 1), "repeated, missing or below 1"),
        (lambda t: t.assign(id=t.id * 2**31), "repeated, missing or below 1"),
        (lambda t: pd.concat([t, t]), "repeated, missing or below 1"),
        (lambda t: t.assign(type=0), "has types that scene.json does not"),
        (lambda t: t.assign(type=99), "has types that scene.json does not"),
        (lambda t: t.assign(film=-1e-12), "has films that are no volumes"),
        (lambda t: t.assign(film=np.nan), "has films that are no volumes"),
    ],
)
def test_spheres_that_are_not_the_scenes_are_refused(whole: dict[str, Any], wrong: Any, says: str) -> None:
    with raises_code("run.history", key="spheres") as refused:
        check_tables(**{**whole, "spheres": wrong(whole["spheres"])})
    assert says in str(refused.value)


@pytest.mark.parametrize("wrong", [lambda t: t.iloc[:1], lambda t: t.assign(type=3 - t.type)])
def test_other_spheres_than_the_engines_are_refused(whole: dict[str, Any], wrong: Any) -> None:
    """The engine has those of the file that the scene starts from."""
    there = whole["spheres"]
    check_start(there, there.iloc[::-1])
    with raises_code("run.history", key="spheres"):
        check_start(wrong(there), there)


@pytest.mark.parametrize(
    "wrong, says",
    [
        (lambda t: t.assign(type_i=t.type_i - 1), "has "),
        (lambda t: t[t.type_i > 1], "tables of pairs; expected those of the "),
        (lambda t: t.assign(part_class=7), "tables of pairs"),
        (lambda t: t.assign(transfer_i=1.5), "has shares that are none; expected 0 to 1"),
        (lambda t: t.groupby(["partner_kind", "type_i", "type_j", "part_class"]).head(1), "less than two nodes"),
    ],
)
def test_transfer_tables_of_other_pairs_are_refused(whole: dict[str, Any], wrong: Any, says: str) -> None:
    with raises_code("run.history", key="transfer") as refused:
        check_tables(**{**whole, "transfer": wrong(whole["transfer"])})
    assert says in str(refused.value)


def test_walls_without_triangles_are_refused(whole: dict[str, Any]) -> None:
    name = whole["scene"].walls[0].name
    nodes = {key: value for key, value in whole["nodes"].items() if key != name}
    with raises_code("run.history", key="triangles"):
        check_tables(**{**whole, "nodes": nodes})
