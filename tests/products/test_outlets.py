"""Outlets of custom scenes: who leaves where and when, with which liquid; resumed and parallel runs; what the replay finds."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import pyvista

import pywet
from pywet.cases.custom import building
from pywet.engines import schedule
from pywet.engines.liggghts import driver
from pywet.engines.liggghts.checkpoint import saved as saved_name
from pywet.products import outlets
from pywet.report import browser, ovito, render, scene_page, sketch, vtk, vtkhdf
from pywet.runs.rundir import RunDir
from pywet.runs.tables import ledger_error
from reference_impl.replay import outlets as replay_outlets
from reference_impl.shown import ovito as ovito_read
from reference_impl.shown import vtk as vtk_read
from reference_impl.shown import vtkhdf as vtkhdf_read
from tests.cases.custom.conftest import beads
from tests.cases.custom.test_repeating import strip
from tests.engines.liggghts.test_restart import killed, same_bits
from tests.error_codes import raises_code

OUTLETS = [
    {"name": "edge", "low_mm": (-4, None, None), "high_mm": (-1, None, 3)}, {"name": "under", "high_mm": (None, None, -20)},
]  # fmt: skip
"""Some beads are taken off the plate's end, wet with it and with others; what falls there is in both and booked to the first."""


def scene(**changes: Any) -> pywet.Scene:
    """Moist beads that enter one after the other and slide off a plate."""
    entry = {
        "name": "beads", "material": "glass", "diameter_mm": 3, "count": 40, "velocity_m_per_s": (0, 0, -0.3),
        "box": {"low_mm": (-8, -8, 20), "high_mm": (8, 8, 26)}, "insertion": {"from_s": 0.0, "for_s": 0.15},
    }  # fmt: skip
    given = {
        "duration_s": 0.3,
        "spheres": [entry],
        "liquid": {"percent": 3.0},
        "walls": [{"name": "slope", "block": {"low_mm": (-10, -20, -4), "high_mm": (-1, 20, 0)}}],
        "outlets": OUTLETS,
        "gravity_m_per_s2": (2.0, 0.0, -9.6),
        "results": {"interval_s": 0.01, "windows": 2},
        "time_step": {"time_step_s": 2e-5},
    }
    return pywet.Scene(**beads(**{**given, **changes}))


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> pywet.Run:
    """The scene, run and replayed: `pywet.run` raises where a check, the ledger or the replay objects."""
    return pywet.run(scene(), tmp_path_factory.mktemp("outlets") / "run")


def gone(folder: Path) -> pd.DataFrame:
    return pd.read_parquet(folder / "history" / "retired.parquet")


@pytest.mark.engine
def test_every_sphere_leaves_where_it_first_is_in_an_outlet(run: pywet.Run) -> None:
    """At the first step looked at, an output every 0.02 s outside the windows, booked to the first outlet that holds it."""
    left, places = gone(run.path).set_index("id"), run.trajectory
    every = 2 * run.scene.output_every
    windows = schedule.windows(run.scene)
    steps = [s for s in range(every, run.scene.steps, every) if not any(a <= s < b for a, b in windows)]
    edge = places["x"].between(-0.004, -0.001) & (places["z"] < 0.003)
    held = places.assign(outlet=np.where(edge, 1, 2))[places["step"].isin(steps) & (edge | (places["z"] < -0.020))]
    due = held.drop_duplicates("id").set_index("id")
    assert len(due) > 30 and set(left["outlet"]) == {1, 2}
    assert left["step"].to_dict() == due["step"].to_dict()
    assert left["outlet"].to_dict() == due["outlet"].to_dict()
    counts = places.groupby("step").size()
    assert counts.to_dict() == {step: 40 - int((left["step"] < step).sum()) for step in counts.index}


@pytest.mark.engine
def test_the_liquid_is_booked_to_the_outlets(run: pywet.Run) -> None:
    """Spheres, walls and outlets hold what was put in, at every output to 1e-12 of it."""
    liquid, left = run.liquid, gone(run.path)
    for k, name in enumerate(("edge", "under"), start=1):
        want = [left["film"][(left["outlet"] == k) & (left["step"] <= step)].sum() for step in liquid["step"]]
        assert liquid[f"outlet_{name}_m3"].to_numpy() == pytest.approx(want, rel=1e-14) and want[-1] > 0
    held = liquid[[c for c in liquid if c.startswith(("spheres_", "wall_", "outlet_"))]].sum(axis=1)
    assert np.abs(held - liquid["initial_m3"]).max() < 1e-12 * liquid["initial_m3"].iloc[-1]
    assert liquid["wall_slope_m3"].iloc[-1] > 0 and ledger_error(run.ledger) < 1e-12
    assert (run.events["kind"] == 2).any()  # a bridge ended because a sphere left
    rows = run.replay["quantities"]
    assert all(rows[f"retired_{name}"]["count"] == len(left) for name in ("who", "place", "speed", "film"))


@pytest.mark.engine
def test_explicit_drag_is_replayed_where_spheres_leave(tmp_path: Path) -> None:
    """Flights between outputs are recomputed then; those that have left are in no output."""
    explicit = {"time_step_s": 2e-6, "viscous_integration": "explicit"}
    few = scene().spheres[0].model_copy(update={"count": 6})
    made = scene(spheres=[few.model_dump(exclude_unset=True)], duration_s=0.25, time_step=explicit)
    assert len(gone(pywet.run(made, tmp_path / "run").path)) > 2


def test_the_page_lists_all_liquid_that_was_put_in(run: pywet.Run) -> None:
    """In each row of the ledger on the page the reservoirs, with what left with spheres, add up to the last column."""
    table, _ = re.findall("<table>(.*?)</table>", scene_page._ledger((run,)), re.DOTALL)
    head, *rows = [re.findall("<t[hd][^>]*>(.*?)</t[hd]>", row) for row in table.split("</tr>") if "<t" in row]
    assert head[-2:] == ["with spheres that left", "put in"] and len(rows) == 3
    for _, *held, put_in in [[float(cell) for cell in row] for row in rows]:
        assert sum(held) == pytest.approx(put_in, rel=1e-4)
    assert float(rows[-1][-2]) > 0


@pytest.mark.slow
@pytest.mark.engine
def test_killed_and_on_two_ranks(run: pywet.Run, tmp_path: Path) -> None:
    """A killed run goes on to the same bits; two ranks take out the same spheres at the same steps with the same liquid."""
    one, two = tmp_path / "killed", tmp_path / "ranks"
    for folder in (one, two):
        building.write(scene(), folder)
    last = killed(one, after=5000)
    assert saved_name("state", last) and driver.run(one, progress=False).resumed_at_step >= 5000
    shutil.copytree(run.path, tmp_path / "whole", ignore=lambda folder, names: [n for n in names if n == "results"])
    same_bits(tmp_path / "whole", one)
    driver.run(two, 2, progress=False)
    order = ["step", "id"]
    here, there = (gone(f).sort_values(order, ignore_index=True) for f in (run.path, two))
    pd.testing.assert_frame_equal(here, there, rtol=1e-6, atol=1e-9)
    assert ledger_error(RunDir(two).ledger) < 1e-12


STRIP = [
    {
        "name": name, "material": "glass", "diameter_mm": size, "count": count, "velocity_m_per_s": (0, 0, -0.4),
        "box": {"low_mm": (2, -14, 8), "high_mm": (24, 14, 20)}, "insertion": {"for_s": 0.12},
    }
    for name, size, count in (("fine", 3, 50), ("coarse", 6, 8))
]  # fmt: skip
"""Spheres that enter a periodic strip of a deck."""


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("kind", ["outlets", "strip"])
def test_killed_twice(tmp_path: Path, kind: str) -> None:
    """A continuous run with outlets, and a periodic strip of a deck: the same tables to the last bit after two kills; spheres and
    bridges crossed the periodic face, and spheres left before and after each kill."""
    what = scene() if kind == "outlets" else strip(spheres=STRIP, liquid={"percent": 3}, duration_s=0.24)
    for name in ("whole", "killed"):
        building.write(what, tmp_path / name)
    driver.run(tmp_path / "whole", progress=False)
    run = RunDir(tmp_path / "whole")
    every, left = schedule.checkpoint_every(run.scene), gone(run.path)["step"]
    kills = [every * (run.scene.steps * k // 3 // every) for k in (1, 2)]
    for step in kills:
        assert step <= killed(tmp_path / "killed", after=step) < run.scene.steps
    assert driver.run(tmp_path / "killed", progress=False).resumed_at_step >= kills[1]
    same_bits(tmp_path / "whole", tmp_path / "killed")
    assert ledger_error(run.ledger) < 1e-12 and (left > kills[1]).any()
    if kind == "strip":
        width = run.scene.box_high_m[1] - run.scene.box_low_m[1]
        way = run.trajectory.sort_values(["id", "step"]).groupby("id")["y"].diff()
        assert (way.abs() > 0.8 * width).any()
        bridges = run.table("history/bridges").query("partner_kind == 0")
        assert (np.abs(bridges["xj_y"]) > 0.5 * width).any()


@pytest.mark.engine
def test_an_outlet_around_an_insertion_takes_what_has_entered(tmp_path: Path) -> None:
    """Beads wait and come through the outlet; those whose step has not come are left alone, all others are taken out below."""
    mouth = [{"name": "above", "low_mm": (None, None, 27)}, {"name": "mouth", "high_mm": (None, None, 19)}]
    run = pywet.run(scene(outlets=mouth, duration_s=0.16), tmp_path)
    kinds, left = run._run.spheres.sort_values("id"), gone(tmp_path)
    enters = dict(zip(kinds["id"], run.scene.enters(kinds["type"].tolist()), strict=True))
    waited = left["step"] - left["id"].map(enters)
    assert len(left) > 10 and (waited >= 0).all()


def falling(**changes: Any) -> pywet.Scene:
    """Three beads that fall into an outlet, one after the other."""
    falls = [{"name": "beads", "material": "glass", "diameter_mm": 3, "at_mm": [(0, 0, 0), (0, 0, 10), (5, 0, 20)]}]
    outlets = [{"name": "below", "high_mm": (None, None, -10)}]
    given = {"spheres": falls, "walls": [], "outlets": outlets, "duration_s": 0.15, "gravity_m_per_s2": (0, 0, -9.81)}
    return scene(**given, **changes)


@pytest.mark.engine
@pytest.mark.parametrize("liquid", [None, {"percent": 3.0}])
def test_a_time_at_which_nobody_is_left_is_drawn(tmp_path: Path, liquid: dict[str, float] | None) -> None:
    """Files for ParaView and OVITO agree with the logs at every output; the picture shows a time with spheres."""
    pywet.run(falling(liquid=liquid), tmp_path)
    run = RunDir(tmp_path)
    empty, last = int(run.timeline.steps[-1]), int(run.trajectory["step"].max())
    assert empty > last >= render.telling_step(run) > 0
    for drawn, read in ((vtk, vtk_read), (vtkhdf, vtkhdf_read), (ovito, ovito_read)):
        drawn.write(tmp_path)
        assert read.disagreement(tmp_path) is None
    assert len(pyvista.read(tmp_path / "vtk" / f"particles_{empty:09d}.vtu").points) == 0
    assert render.write(tmp_path, tmp_path / "picture.png", empty) in ("vtk", "matplotlib")
    sketch.draw(run, empty, tmp_path / "sketch.png")
    assert browser.packed(run)


@pytest.mark.engine
def test_dry_spheres_fall_into_an_outlet_until_nobody_is_left(tmp_path: Path) -> None:
    """Without walls or liquid all leave; whoever is left out of outputs afterwards is not missing."""
    found = pywet.run(falling(liquid=None), tmp_path)
    left = gone(tmp_path).sort_values("id")
    looked = 0.02 * np.arange(1, 8)
    want = [looked[0.5 * 9.81 * looked**2 > 0.010 + z][0] for z in (0.0, 0.010, 0.020)]
    assert left["time"].to_numpy() == pytest.approx(want, abs=1e-9) and (left["film"] == 0).all()
    assert found.trajectory["step"].max() < found.scene.output_steps[-1]  # no spheres are left at the end
    assert found.contact_statistics["largest_speed_m_per_s"].iloc[-1] == 0.0


@pytest.mark.engine
@pytest.mark.parametrize(("along", "speed"), [(4.1, 0.1), (-4.1, 0.3), (0.0, 0.2)])
def test_the_height_at_an_end_is_that_of_the_path_under_inclined_gravity(
    tmp_path: Path, along: float, speed: float
) -> None:
    """Spheres in flight cross x = 0 after 2 ms at 0.5 and -1.5 mm, and are seen 38 ms later, both 13 mm lower."""
    g, v, before = np.array([along, 0.0, -8.9]), np.array([speed, 0.0, -0.2]), 0.002
    entries = [
        {
            "name": name, "material": "glass", "diameter_mm": 1,
            "at_mm": [tuple(1e3 * (np.array([0.0, y, z]) - v * before + 0.5 * g * before**2))],
            "velocity_m_per_s": tuple(v - g * before),
        }
        for name, y, z in (("above", -0.01, 5e-4), ("below", 0.01, -1.5e-3))
    ]  # fmt: skip
    outlets = [
        {"name": "over", "low_mm": (0, None, None), "crossing_above_mm": -1},
        {"name": "under", "high_mm": (None, None, -5)},
    ]
    found = pywet.run(
        scene(
            spheres=entries, walls=[], outlets=outlets, liquid=None, duration_s=0.08, gravity_m_per_s2=tuple(g),
            results={"interval_s": 0.04, "windows": 0},
        ),
        tmp_path,
    )  # fmt: skip
    left = gone(tmp_path).sort_values("id")
    assert left["time"].to_numpy() == pytest.approx([0.04, 0.04]) and left["outlet"].to_list() == [1, 2]
    assert found.replay["quantities"]["retired_who"]["ok"]


def test_the_reference_finds_crossings_of_a_moving_end() -> None:
    """Of flights past a plane that swings by 3 mm: the height above the moving one at the crossing, or later above its highest
    place; flights that crossed before the last two checks are left out."""
    way = {"amplitude_m": [3e-3, 0.0, 4e-3], "phase_rad": [0.7, 0.0, -0.9], "frequency_Hz": 16.0}
    g, open_, least, longest = np.array([2.0, 0.0, -9.0]), np.inf, -1e-3, 0.04
    edges = [[0.0, -open_, -open_]], [[open_] * 3]
    regions = replay_outlets.Regions(
        *map(np.array, edges), np.array([least]), g, longest, np.zeros(0), pd.Series(dtype=float), 1e-5, [way]
    )
    random = np.random.default_rng(2)
    zero = np.zeros(400)
    x = np.stack([random.uniform(4e-3, 0.02, 400), zero, random.uniform(-0.02, 0.005, 400)], axis=1)
    v = np.stack([random.uniform(0.6, 1.0, 400), zero, random.uniform(-0.6, 0.3, 400)], axis=1)
    steps = 10_000 + 37 * np.arange(400)

    def swung(axis: int, t: Any) -> Any:
        a, p = way["amplitude_m"][axis], way["phase_rad"][axis]  # type: ignore[index]
        return a * (np.sin(2.0 * np.pi * 16.0 * t + p) - np.sin(p))

    found, number = regions.clearance(0, steps, x, v, 0.0), 0
    for at, speed, now, mine in zip(x, v, 1e-5 * steps, found, strict=True):

        def path(axis: int, b: Any) -> Any:
            return at[axis] - b * speed[axis] + 0.5 * b**2 * g[axis]  # noqa: B023

        b = np.linspace(0.0, longest, 40_001)
        before = np.flatnonzero(path(0, b) < swung(0, now - b))
        if not len(before) or before[0] == 0:
            continue
        last, number = b[before[0]], number + 1
        later = b[: before[0]]
        want = max(
            path(2, last) - least - swung(2, now - last), (path(2, later) - least).max() - 4e-3 * (1.0 + np.sin(0.9))
        )
        assert mine == pytest.approx(want, abs=3e-6)
    assert number > 200


def other_outlet(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(outlet=3 - table["outlet"])


def too_high(table: pd.DataFrame) -> pd.DataFrame:
    table.loc[table.index[table["outlet"] == 2][0], "x_z"] = -0.019
    return table


FAULTS = {
    "another outlet": (other_outlet, "retired_who"),
    "not in the outlet": (too_high, "retired_who"),
    "film off": (lambda t: t.assign(film=1.001 * t["film"]), "retired_film"),
}


@pytest.mark.engine
@pytest.mark.parametrize("name", FAULTS)
def test_injected_faults_are_found(run: pywet.Run, tmp_path: Path, name: str) -> None:
    change, quantity = FAULTS[name]
    copy = Path(shutil.copytree(run.path, tmp_path / "copy"))
    change(gone(copy)).to_parquet(copy / "history" / "retired.parquet", index=False)
    found = pywet.replay(copy) or {}
    assert not found["ok"] and not found["quantities"][quantity]["ok"]


@pytest.mark.parametrize(
    ("changes", "code", "says"),
    [
        ({"outlets": [{"name": "all"}]}, "config.inconsistent", "every sphere leaves at once"),
        ({"outlets": [{"name": "a", "low_mm": (1, None, None), "high_mm": (0, None, None)}]},
         "config.inconsistent", "less than that of high_mm"),
        ({"outlets": [{"name": "a", "high_mm": (0, None, None), "crossing_above_mm": 1}]},
         "config.inconsistent", "outlet a: a smallest x in low_mm with crossing_above_mm"),
        ({"outlets": [OUTLETS[0], OUTLETS[0]]}, "config.inconsistent", "outlets of different names"),
        ({"outlets": [{"name": "a", "low_mm": (0, None, None), "moves_with": "slope"}]},
         "config.inconsistent", "moves_with only with crossing_above_mm"),
        ({"outlets": [{"name": "a", "low_mm": (0, None, None), "crossing_above_mm": 1, "moves_with": "slope"}]},
         "config.inconsistent", "outlet a: moves_with to name a wall that vibrates .none., not slope"),
        ({"outlets": [{"name": "mouth", "low_mm": (None, None, 10)}]},
         "scene.in_outlet", "40 of 40 spheres start or enter in outlet mouth"),
        ({"results": {"checkpoints": 0}}, "config.inconsistent", "results.checkpoints of at least 1"),
        (
            {"outlets": [{"name": "thin", "low_mm": (None, None, -25), "high_mm": (None, None, -20)}]},
            "scene.thin_outlet",
            "",
        ),
        ({"results": {"interval_s": 0.01, "windows": 2, "window_steps": 3000}}, "scene.outlet_windows", "at 0.06 and 0.08 s"),
        ({"results": {"interval_s": 0.01, "windows": 1000, "window_steps": 20}}, "scene.outlet_windows", "at 0.02 and 0.04 s"),
    ],
)  # fmt: skip
def test_outlets_that_cannot_be_are_refused(changes: dict[str, Any], code: str, says: str) -> None:
    with raises_code(code, says=says):
        building.Building(scene(**changes)).scene()


def test_a_window_may_skip_one_check() -> None:
    """Of 1000 steps, as many as are between two checks."""
    made = building.Building(scene(results={"interval_s": 0.01, "windows": 3, "window_steps": 1000})).scene()
    every, windows = schedule.checkpoint_every(made), schedule.windows(made)
    checks = [s for s in range(0, made.steps + 1, every) if not any(first <= s < last for first, last in windows)]
    assert every == 1000 and np.diff(checks).max() == schedule.SKIPPED * every


def test_the_box_holds_who_passes_an_outlet() -> None:
    """2 windows of 0.02 s at the planned speed and half of g t^2 below the border; open sides as far."""
    made = building.Building(scene())
    low, high = made.box
    way = made.speed * 0.04 + 0.5 * np.array([2.0, 0.0, 9.6]) * 0.04**2
    assert low[2] == pytest.approx(-0.020 - way[2])
    assert low[1] == pytest.approx(made.extent[0][1] - way[1]) and high[1] == pytest.approx(made.extent[1][1] + way[1])
    tilted = building.Building(scene(origin_mm=(0, 0, 5)))
    assert tilted.outlets[0].high_m == pytest.approx((-0.001, None, -0.002))


def test_spheres_reach_further_into_an_outlet_that_is_looked_at_rarely() -> None:
    """At 1 m/s without gravity: two intervals of 0.02 s, or of the outputs where they are longer."""
    ways = [outlets.reach(1.0, (0.0, 0.0, 0.0), s)[2] for s in (None, 0.01, 0.5)]
    assert ways == pytest.approx([0.04, 0.04, 1.0])
