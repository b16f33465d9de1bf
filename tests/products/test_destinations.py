"""Shares of each size by outlet or tray, as `pywet plot` draws them for a deck of the user's own."""

from __future__ import annotations

import shutil
from pathlib import Path

import pandas as pd
import pytest

import pywet
from pywet.cases.custom import building
from pywet.products import destinations, screening_report
from pywet.report import bands
from pywet.runs.rundir import RunDir
from pywet.schema import TABLES
from pywet.util.files import read_json, read_table, write_json, write_table
from tests.products import made_up

SIZES = {"coarse": 8.0, "fine": 3.0}


def test_shares_by_outlet_are_the_partition_of_the_screen(tmp_path: Path) -> None:
    """T of the made-up run, 0, 1/4, 3/4, 1, is the share of the outlet overs."""
    run = made_up.make(tmp_path)
    by, (table,) = destinations.shares([RunDir(run)]) or ("", [pd.DataFrame()])
    assert by == "outlet" and table.columns.tolist() == ["overs", "unders"]
    curve = screening_report.analyse(run)[1]
    assert table.index.tolist() == pytest.approx(curve["diameter_mm"].tolist())
    assert table["overs"].tolist() == pytest.approx(curve["T"].tolist())
    (panel,) = bands.panels_of({"deck": [run]})
    assert panel.y == "share to the overs [-]" and panel.curves.keys() == {("deck", "overs")}  # unders are the rest
    assert bands.write(tmp_path / "f.svg", {"deck": [run]}).stat().st_size > 1000


def test_what_stays_in_a_batch_is_with_the_overs(tmp_path: Path) -> None:
    """Of a batch on one deck the shares are T of the screen too; its spheres that have not left are not left out."""
    run = made_up.make(tmp_path, steps=1000)
    scene = read_json(run / "scene.json")
    write_json(run / "scene.json", {**scene, "classes": [{**c, "insertion": None} for c in scene["classes"]]})
    curve = screening_report.analyse(run)[1]
    _, (table,) = destinations.shares([RunDir(run)]) or ("", [pd.DataFrame()])
    assert len(RunDir(run).table("history/retired")) < 3 * made_up.EACH
    assert table["overs"].tolist() == pytest.approx(curve["T"].tolist())
    low, high = destinations.intervals(RunDir(run), ["overs"])["overs"]
    assert low == pytest.approx(curve["T_low"]) and high == pytest.approx(curve["T_high"])


@pytest.fixture(scope="module")
def trays(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two trays below and a vessel around both that vibrates; of 10 coarse spheres 9 in the tray at the left, of 10 fine 2."""
    folder = tmp_path_factory.mktemp("trays")
    spheres = [
        pywet.Spheres(name=n, material="glass", diameter_mm=d, at_mm=[(30 * k - 135, y, 30) for k in range(10)])
        for (n, d), y in zip(SIZES.items(), (0, 20), strict=True)
    ]
    walls = [
        pywet.Wall(name="left pan", vessel=pywet.Vessel(inner_width_mm=60, height_mm=20, origin_mm=(-40, 0, 0))),
        pywet.Wall(name="tray_2", block=pywet.Block(low_mm=(5, -35, -10), high_mm=(70, 35, 10))),
        pywet.Wall(name="around", vessel=pywet.Vessel(inner_width_mm=400, height_mm=60, origin_mm=(0, 0, -20)),
                   vibrates=pywet.Vibrates(amplitude_mm=(0, 0, 0.5), frequency_Hz=50)),
    ]  # fmt: skip
    scene = pywet.Scene(name="trays", duration_s=0.02, materials={"glass": pywet.Material(density_kg_per_m3=2500)},
                        spheres=spheres, walls=walls)  # fmt: skip
    building.write(scene, folder)
    types = read_table(folder / "history" / "spheres.parquet").sort_values("id")["type"].tolist()
    last = RunDir(folder).scene.output_steps[-1]
    kind = {c.name: c.type for c in RunDir(folder).scene.classes}
    left = {kind["coarse"]: 9, kind["fine"]: 2}
    rows = []
    for i, t in enumerate(types, start=1):
        left[t] -= 1
        rows.append((last, last * 1e-5, i, t, -0.04 if left[t] >= 0 else 0.04, 0.0, 0.005, *([0.0] * 6)))
    write_table(pd.DataFrame(rows, columns=[*TABLES["trajectory"]]), folder / "trajectory.parquet")
    return folder


def test_shares_by_tray_count_the_spheres_in_it(trays: Path) -> None:
    """A vessel of any name and a block that is called a tray; one that moves is none."""
    by, (table,) = destinations.shares([RunDir(trays)]) or ("", [pd.DataFrame()])
    assert by == "tray" and table.index.tolist() == pytest.approx([3.0, 8.0])
    assert len(table.columns) == 2 and table["tray_2"].tolist() == pytest.approx([0.8, 0.1])
    assert table.sum(axis=1).tolist() == pytest.approx([1.0, 1.0])
    (panel,) = bands.panels_of({"deck": [trays]})
    assert panel.y == "partition by tray [-]"


def test_one_tray_with_all_in_it_is_no_partition(trays: Path, tmp_path: Path) -> None:
    shutil.copytree(trays, tmp_path, dirs_exist_ok=True)
    table = read_table(trays / "trajectory.parquet")
    write_table(table.assign(x=-0.04), tmp_path / "trajectory.parquet")
    assert destinations.shares([RunDir(tmp_path)]) is None
    _, tables = destinations.shares([RunDir(trays), RunDir(tmp_path)]) or ("", [])  # a seed of it is all the same
    assert [table["tray_2"].tolist() for table in tables] == [pytest.approx([0.8, 0.1]), [0.0, 0.0]]


def test_a_seed_without_overs_has_the_share_zero(tmp_path: Path) -> None:
    """T of 0, 1/4, 3/4, 1 in one run and of 0 in the other: half of it; a size that left one run nowhere has no mean."""
    runs = [made_up.make(tmp_path / "deck"), made_up.make(tmp_path / "deck-2", overs=(0, 0, 0, 0))]
    (panel,) = bands.panels_of({"deck": runs})
    sizes, mean, half = bands.mean_and_band(panel.curves["deck", "overs"])
    assert sizes.tolist() == pytest.approx([1.0, 2.0, 3.0, 4.0])
    assert half is not None and mean.tolist() == pytest.approx([0.0, 0.125, 0.375, 0.5])
    left = read_table(runs[1] / "history" / "retired.parquet")
    write_table(left[left["type"] != 2], runs[1] / "history" / "retired.parquet")
    (panel,) = bands.panels_of({"deck": runs})
    sizes, mean, _ = bands.mean_and_band(panel.curves["deck", "overs"])
    assert sizes.tolist() == pytest.approx([1.0, 3.0, 4.0]) and mean.tolist() == pytest.approx([0.0, 0.375, 0.5])
