"""Spheres that peg an aperture are those that stay in it for a period of the screen's motion; the number of apertures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import pyvista

from pywet import config as settings
from pywet.cases.custom import building
from pywet.cases.custom.description import Scene
from pywet.cases.screening import cases
from pywet.geometry.motion import engine_displacement, velocity
from pywet.products import apertures, screening_report, streams
from pywet.products.apertures import area, count, pegged, screen_of
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene, Vibration
from pywet.util.files import write_json, write_table
from reference_impl.replay import io
from reference_impl.tables import plant, screen_series, screen_wall
from tests.cases.custom.conftest import beads
from tests.cases.screening import synthetic
from tests.error_codes import raises_code

ROOT = Path(__file__).parents[2]
SHAKEN = Vibration(amplitude_m=(4e-4, 0.0, 9e-4), phase_rad=(0.2, 0.0, 0.0), frequency_Hz=400.0)
SLOWLY = SHAKEN.model_copy(update={"frequency_Hz": 60.0})
"""With a period of more than one and less than two outputs."""


def placed(folder: Path, at: list[float], share: float, scene: EngineScene) -> RunDir:
    """Put sphere 1 of a run at places along the screen, in its radii, with a share of the screen's velocity."""
    write_json(folder / "scene.json", scene.model_dump(mode="json"))
    run = RunDir(folder)
    moves, radius, start = scene.motions["wires"], scene.classes[run.timeline.types[0] - 1].radius_m, scene.screen_z_m
    table, motion, shift, speed = run.trajectory, run.mesh_motion, np.zeros((len(at), 3)), np.zeros((len(at), 3))
    if isinstance(moves, Vibration):
        shift = engine_displacement(moves, run.timeline.steps, scene.time_step_s)
        speed = share * velocity(moves, run.timeline.times)
    motion.loc[motion["mesh"] == "wires", ["dx", "dy", "dz"]] = shift
    place = shift + np.stack([radius * np.array(at), np.zeros(len(at)), np.full(len(at), start + 0.5 * radius)], axis=1)
    columns = ["x", "y", "z", "vx", "vy", "vz"]
    table = table.astype(dict.fromkeys(columns, float))
    table.loc[table["id"] == 1, columns] = np.hstack([place, speed])
    write_table(motion, folder / "mesh_motion.parquet")
    write_table(table, folder / "trajectory.parquet")
    return RunDir(folder)


@pytest.mark.parametrize(
    ("moves", "at", "share", "pegs"),
    [
        (SHAKEN, [0.0, 0.0, 0.0], 1.0, [True, True, True]),
        (SHAKEN, [0.0, 0.2, 0.4], 1.0, [True, True, True]),
        (SHAKEN, [0.0, 0.0, 1.0], 1.0, [True, True, False]),
        (SHAKEN, [1.0, 0.0, 0.2], 1.0, [False, True, True]),
        (SHAKEN, [0.0, 0.3, 0.6], 1.0, [False, False, False]),
        (SHAKEN, [0.0, 0.0, 0.0], 0.2, [False, False, False]),
        (SLOWLY, [0.0, 0.1, 0.2], 1.0, [True, True, True]),
        (SLOWLY, [0.0, 0.2, 0.4], 1.0, [False, False, False]),
        (SLOWLY, [0.0, 0.0, 1.0], 1.0, [False, False, False]),
    ],
    ids=["stays", "creeps", "leaves", "arrives", "travels", "is too slow for the screen",
         "stays for a period", "creeps in a period", "stays for less than a period"],
)  # fmt: skip
def test_a_sphere_pegs_while_it_stays(
    tmp_path: Path, moves: Vibration, at: list[float], share: float, pegs: list[bool]
) -> None:
    """A sphere over a vibrating screen; the reference counts alike."""
    folder = synthetic.make(tmp_path / "case02", moist=True)
    run = placed(folder, at, share, RunDir(folder).scene.model_copy(update={"vibration": moves}))
    assert 0.5 < (run.timeline.times[1] - run.timeline.times[0]) * SLOWLY.frequency_Hz < 1.0
    wall = screen_of(run)
    assert wall is not None
    found = pegged(run, wall)
    assert found[:, 0].tolist() == pegs
    times = run.timeline.times
    of = plant.Deck.read(folder, io.scene(folder), {})
    for first in range(len(times)):
        given = {"from_s": times[first], "to_s": times[-1]}
        assert screen_series.on_screen(of.series, given, 4)["pegged"] == found[first:].sum(axis=1).mean()


def test_on_a_screen_at_rest_those_that_stay_peg(tmp_path: Path) -> None:
    folder = synthetic.make(tmp_path / "case02", moist=True)
    scene = RunDir(folder).scene
    walls = tuple(w.model_copy(update={"motion": "fixed"}) for w in scene.walls)
    run = placed(
        folder, [0.0, 0.0, 1.0], 0.0, scene.model_copy(update={"walls": walls, "vibration": None, "slide": None})
    )
    wall = screen_of(run)
    assert wall is not None and pegged(run, wall)[:, 0].tolist() == [True, True, False]


def counted(folder: Path) -> tuple[float, int]:
    """Area [m2] and apertures of the screen of a run directory; the reference agrees."""
    run = RunDir(folder)
    wall, scene = screen_of(run), io.scene(folder)
    assert wall is not None
    found, mine = (area(run, wall), count(run, wall)), screen_wall.of(scene, 1)
    assert mine is not None
    assert screen_wall.area(folder, mine) == pytest.approx(found[0], rel=1e-12)
    assert screen_wall.count(folder, scene, mine, 1) == found[1]
    return found


@pytest.mark.parametrize(
    ("case", "scale", "within_m2", "cells"),
    [(2, "smoke", 0.05**2, 25), (2, "full", math.pi * 0.1**2, 314), (8, "smoke", 0.0504**2, 49)],
)
def test_area_and_apertures_of_a_case_are_those_inside_its_side_wall(
    tmp_path: Path, case: int, scale: str, within_m2: float, cells: int
) -> None:
    """Wires reach into the side wall: a square of 5 by 5 cells of 10 mm, or of 7 by 7 of 7.2 mm; a circle of 200 mm."""
    cases.build(settings.load(ROOT / "config"), case, scale, tmp_path)
    found = counted(tmp_path)
    assert found == (pytest.approx(within_m2, rel=1e-9), cells)


@pytest.mark.parametrize(
    ("deck", "openings"),
    [
        ({"width_mm": 40, "aperture_mm": 5, "wire_mm": 2}, 6 * 9),
        ({"width_mm": 12, "aperture_mm": 5, "wire_mm": 2}, 2 * 9),
        ({"width_mm": 40, "aperture_mm": 5, "wire_mm": 2, "mesh": "slotted"}, 6),
        ({"width_mm": 28, "aperture_mm": 5, "wire_mm": 2, "periodic": True}, 4 * 9),
        ({"width_mm": 33, "aperture_mm": 4, "wire_mm": 1}, 7 * 13),
        ({"width_mm": 24.5, "aperture_mm": 4, "wire_mm": 1}, 4 * 13),
    ],
    ids=["square", "one wire along", "slotted", "periodic", "wide sides", "narrow sides"],
)
def test_openings_at_the_sides_of_a_deck_are_apertures(tmp_path: Path, deck: dict[str, Any], openings: int) -> None:
    """By hand: n wires across the deck leave n + 1 openings; those at the sides count if wider than half an aperture.

    The first wire along begins at the back, the last opening before the end has no wire behind it.
    """
    given = {"length_mm": 70, "side_mm": 20, "stroke": {"amplitude_mm": 2, "frequency_Hz": 20}, **deck}
    box = {"low_mm": (5, -4, 4), "high_mm": (40, 4, 20)}
    one = {"name": "beads", "material": "glass", "diameter_mm": 3, "count": 4, "box": box}
    building.write(Scene(**beads(deck=given, spheres=[one])), tmp_path)
    assert counted(tmp_path)[1] == openings


@pytest.mark.parametrize(("mesh", "each"), [("slotted", 3.0 / 70.0), ("square", 1.0), ("punched_round", 1.0)])
def test_a_sphere_blocks_its_diameter_of_a_slot(tmp_path: Path, mesh: str, each: float) -> None:
    """12 spheres of 3 mm in six slots of 70 mm block 8.6 % of their length, where they are twice as many as the slots.

    Of other meshes one blocks one aperture. The reference finds the same.
    """
    deck = {"length_mm": 70, "width_mm": 40, "side_mm": 20, "aperture_mm": 5, "wire_mm": 2, "mesh": mesh,
            "stroke": {"amplitude_mm": 2, "frequency_Hz": 20}}  # fmt: skip
    box = {"low_mm": (5, -4, 4), "high_mm": (40, 4, 20)}
    one = {"name": "beads", "material": "glass", "diameter_mm": 3, "count": 4, "box": box}
    building.write(Scene(**beads(deck=deck, spheres=[one])), tmp_path)
    run = RunDir(tmp_path)
    series = pd.DataFrame(
        {"time_s": [0.1 * k for k in range(9)], "pegged_1": [6.0] * 5 + [18.0] * 4, "screen_liquid_m3": 0.0}
    )
    given = {"from_s": 0.05, "to_s": 0.85}
    flow = streams.Streams(pd.DataFrame(), True, given["from_s"], given["to_s"], True)
    found, (_, number) = screening_report._of_screen(run, flow, series), counted(tmp_path)
    assert found["apertures"] == number and found["pegged"] == 12.0
    assert found["pegged_share"] == pytest.approx(12.0 * each / number, rel=1e-6)  # corners have single precision
    assert found["pegged_share_half_width"] == pytest.approx(found["pegged_half_width"] * each / number, rel=1e-6)
    wall = screen_wall.of(io.scene(tmp_path), 1)
    assert wall is not None
    slot = screen_wall.slots(tmp_path, wall, 1)
    mine = screen_series.on_screen(series, given, number, {"pegged_1": 3e-3 / slot} if slot else None)
    assert mine == {key: pytest.approx(found[key], rel=1e-9) for key in mine}


def test_a_sphere_in_the_mouth_of_a_thick_plate_pegs_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Plate of 5 mm with holes of 5 mm: the centre of a sphere of 5.2 mm in a hole is 0.71 mm above it, of one on the land 2.6;
    of one that hangs out below it can be as far under it."""
    deck = {"length_mm": 30, "width_mm": 20, "side_mm": 20, "aperture_mm": 5, "wire_mm": 5, "mesh": "punched_round",
            "stroke": {"amplitude_mm": 2, "frequency_Hz": 20}}  # fmt: skip
    box = {"low_mm": (5, -4, 4), "high_mm": (25, 4, 20)}
    one = {"name": "beads", "material": "glass", "diameter_mm": 5.2, "count": 2, "box": box}
    building.write(Scene(**beads(deck=deck, spheres=[one])), tmp_path)
    run, reference = RunDir(tmp_path), io.scene(tmp_path)
    wall, radius = screen_of(run), 2.6e-3
    assert wall is not None
    monkeypatch.setattr(apertures, "_radius", lambda run: np.full(4, radius))
    in_hole = math.sqrt(radius**2 - 2.5e-3**2)
    place = np.zeros((1, 4, 3))
    place[0, :, 2] = in_hole, 0.999 * radius, -5e-3 - 0.999 * radius, -5e-3 - 1.001 * radius
    assert apertures._caught(run, wall, place, np.zeros_like(place)).tolist() == [[True, False, True, False]]
    mine = screen_wall.of(reference, 1)
    assert mine is not None and screen_wall.faces(tmp_path, mine) == pytest.approx((-5e-3, 0.0), abs=1e-9)


def _plate(folder: Path, name: str, tilt_deg: float = 0.0, rim_mm: float = 0.0) -> dict[str, Any]:
    """Write a plate of 100 by 40 by 2 mm, inclined or with a rim at its end, and return it as the wall of a scene."""
    parts = pyvista.Box((0, 100, -20, 20, -2, 0)).triangulate()
    if rim_mm:
        parts = parts + pyvista.Box((101, 103, -20, 20, -2, rim_mm)).triangulate()
    parts.rotate_y(tilt_deg).extract_surface().triangulate().save(folder / f"{name}.stl")
    return {"name": "screen", "stl": f"{name}.stl"}


BARS = {"diameter_mm": 2, "pitch_mm": 7, "count": 5, "length_mm": 100, "axis": "x"}
SCREENS = {
    "plate": (lambda folder: _plate(folder, "plate"), True),
    "nearly level": (lambda folder: _plate(folder, "nearly", 1.5), True),
    "inclined": (lambda folder: _plate(folder, "inclined", 15.0), False),
    "with a rim": (lambda folder: _plate(folder, "rim", 0.0, 30.0), False),
    "block": (lambda _: {"name": "screen", "block": {"low_mm": (0, -20, -30), "high_mm": (100, 20, 0)}}, True),
    "bars": (lambda _: {"name": "deck", "bars": BARS}, True),
    "woven": (lambda _: {"name": "screen", "bars": {**BARS, "crimp_mm": 1.0}}, True),
}  # fmt: skip


@pytest.mark.parametrize("name", SCREENS)
def test_pegging_is_undefined_of_a_screen_that_is_not_level(tmp_path: Path, name: str) -> None:
    """A plate of 100 mm rises by 2.6 mm at 1.5 deg and by 26 mm at 15 deg, that with a rim by 30 mm; it may by 2 mm of thickness
    and a radius of 1.5 mm. A block of 30 mm is thick. The reference finds the same."""
    wall_of, level = SCREENS[name]
    one = {"name": "beads", "material": "glass", "diameter_mm": 3, "at_mm": [(50, 0, 60)]}
    building.write(Scene(**beads(walls=[wall_of(tmp_path)], spheres=[one], folder=tmp_path)), tmp_path / "run")
    run, scene = RunDir(tmp_path / "run"), io.scene(tmp_path / "run")
    wall, mine = screen_of(run), screen_wall.of(scene, 1)
    assert wall is not None and mine is not None
    why = apertures.not_level(run, wall)
    assert (why is None) == level == screen_wall.level(tmp_path / "run", scene, mine)
    if level:
        return
    assert why is not None and "not horizontal" in why
    series = pd.DataFrame({"time_s": [0.1 * k for k in range(9)], "screen_liquid_m3": 0.0})
    flow = streams.Streams(pd.DataFrame(), True, 0.05, 0.85, True)
    found = screening_report._of_screen(run, flow, series)
    assert found["pegged_undefined"] == why and [found[key] for key in screening_report.PEGGED] == [None] * 4
    asked = screen_series.on_screen(series, {"from_s": 0.05, "to_s": 0.85}, found["apertures"])
    assert asked == {key: found[key] for key in asked} and {*screening_report.PEGGED} <= {*asked}


def test_outputs_of_a_deck_are_frequent_enough_for_its_outlets() -> None:
    """Spheres leave at outputs; in 0.1 s one that rolls off the end falls 50 mm, past the product it belongs to."""
    deck = {
        "length_mm": 30,
        "width_mm": 20,
        "aperture_mm": 4,
        "wire_mm": 1,
        "stroke": {"amplitude_mm": 2, "frequency_Hz": 20},
    }
    with raises_code("config.inconsistent", says="results.interval_s of at most 0.02 with a deck"):
        Scene(**beads(deck=deck, results={"interval_s": 0.1}))


@pytest.mark.parametrize("count", [2, 7, 60])
@pytest.mark.parametrize("pitch", [7.2e-3, 10.0e-3, 0.71e-3])
def test_the_pitch_of_wires_in_single_precision(pitch: float, count: int) -> None:
    """To a nanometre in both programs, as positions in a file of a surface have up to 4 nm."""
    at = ((np.arange(count) - 0.5 * (count - 1)) * pitch).astype(np.float32).astype(float)
    low, high = np.c_[0.0 * at - 1.0, at - 1e-4, 0.0 * at], np.c_[0.0 * at + 1.0, at + 1e-4, 0.0 * at]
    assert apertures._pitch(low, high) == pytest.approx(pitch, abs=1e-9)
    assert screen_wall.cell_of([*at]) == apertures._pitch(low, high)
