"""Spheres that peg an aperture are those that stay in it from one output to the next."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pywet.geometry.motion import engine_displacement, velocity
from pywet.products.apertures import pegged, screen_of
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene, Vibration
from pywet.util.files import write_json, write_table
from reference_impl.replay import io
from reference_impl.tables import plant, screen_series
from tests.cases.screening import synthetic

SHAKEN = Vibration(amplitude_m=(4e-4, 0.0, 9e-4), phase_rad=(0.2, 0.0, 0.0), frequency_Hz=50.0)


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
    ("at", "share", "pegs"),
    [
        ([0.0, 0.0, 0.0], 1.0, [True, True, True]),
        ([0.0, 0.2, 0.4], 1.0, [True, True, True]),
        ([0.0, 0.0, 1.0], 1.0, [True, True, False]),
        ([1.0, 0.0, 0.2], 1.0, [False, True, True]),
        ([0.0, 0.3, 0.6], 1.0, [False, False, False]),
        ([0.0, 0.0, 0.0], 0.2, [False, False, False]),
    ],
    ids=["stays", "creeps", "leaves", "arrives", "travels", "is too slow for the screen"],
)
def test_a_sphere_pegs_while_it_stays(tmp_path: Path, at: list[float], share: float, pegs: list[bool]) -> None:
    """A sphere over a vibrating screen; the reference counts alike."""
    folder = synthetic.make(tmp_path / "case02", moist=True)
    run = placed(folder, at, share, RunDir(folder).scene.model_copy(update={"vibration": SHAKEN}))
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
