"""Contacts with faces, made by the plugin, are those of the mesh walls of the engine, to the last bit: edges, corners, beds.

Beds between moving walls are in test_contacts.py, kills and resumptions in test_restart.py.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import bodies, small
from pywet.geometry.solids import bin_solid
from pywet.geometry.surface import Surface, make_surface
from pywet.scene import Contacts, EngineScene, Output, Rotation, Slide, Vibration
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of
from tests.engines.liggghts.test_contacts import PAIRS
from tests.engines.liggghts.test_restart import same_bits
from tests.engines.liggghts.test_wires import one_wire

pytestmark = pytest.mark.engine
R, STEP = 2.5e-3, 1e-5
WAYS: tuple[Contacts, Contacts] = ("stock", "planes")
SHAKEN = Vibration(amplitude_m=(2e-4, 1e-4, 3e-4), phase_rad=(0.5, 0.1, 0.3), frequency_Hz=50.0)


def cup(sides: int, motion: str) -> Surface:
    """A bin of flat or curved sides with its floor at z = 0: concave and convex edges, corners, a rim."""
    return make_surface("cup", "wall", bin_solid(0.02, 0.004, sides, 0.0, 0.03), motion)  # type: ignore[arg-type]


def thrown(count: int, seed: int) -> list[small.Sphere]:
    """Spheres apart from each other over and about the cup, thrown at its faces, edges and corners with spins."""
    random = np.random.default_rng(seed)
    cells = np.stack(np.meshgrid(*[np.arange(-7, 8)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    places = 2.4 * R * cells + [0.0, 0.0, 0.015] + random.uniform(-0.1, 0.1, (len(cells), 3)) * R
    near = np.maximum(np.abs(places[:, :2]).max(axis=1) - 0.024, np.abs(places[:, 2] - 0.013) - 0.017)
    hollow = (np.abs(places[:, :2]).max(axis=1) < 0.02 - 1.2 * R) & (places[:, 2] > 1.2 * R)
    places = random.permutation(places[(near > 1.2 * R) | hollow])[:count]
    targets = random.uniform([-0.022, -0.022, 0.0], [0.022, 0.022, 0.03], (count, 3))
    targets[::2, 2] = random.choice([-0.002, 0.03], len(targets[::2]))
    targets[::3, 0] = random.choice([-0.022, 0.022], len(targets[::3]))
    speeds, spins = (targets - places) * random.uniform(50.0, 100.0, (count, 1)), random.normal(0.0, 100.0, (count, 3))
    rows = zip(*(v.tolist() for v in (places, speeds, spins)), strict=True)
    return [small.Sphere(1 + n % 2, tuple(x), tuple(v), tuple(w)) for n, (x, v, w) in enumerate(rows)]


def same(one: Path, two: Path) -> None:
    """Every table has the same rows and bits; springs, which each lists as it comes to them, in the order of spheres."""
    for folder in (one, two):
        path = folder / "history" / "window_wall_springs.parquet"
        if path.exists():
            table = pd.read_parquet(path).sort_values(["step", "i", "mesh", "triangle"])
            table.to_parquet(path, index=False)
    same_bits(one, two)


def both(folder: Path, spheres: list[small.Sphere], walls: list[Surface], steps: int, **more: Any) -> EngineScene:
    """The run with the engine's walls and with the plugin's; the wire far off loads the plugin."""
    fields = {"effects": small.DRY, "window_trajectories": True, "output_interval_s": steps * STEP, **more}
    far = one_wire(8).vertices + np.array([0.0, 0.0, 0.09])
    wire = make_surface("wires", "wires", [(far[one_wire(8).triangles], 2e-3)])
    for way in WAYS:
        scene = small.prepare(
            folder / way, spheres_of(R, 2e-3), spheres, PAIRS, walls=[*walls, wire], analytic_wires=["wires"], steps=steps,
            time_step_s=STEP, contacts=way, **fields,
        )  # fmt: skip
        small.run(folder / way, spheres)
    return scene


@pytest.mark.parametrize(
    ("sides", "motion", "effect"),
    [(4, "vibrates", None), (12, "turns", None), (4, "slides", "tangential_history"), (12, "fixed", "rolling")],
)
def test_paths_over_edges_and_corners(tmp_path: Path, sides: int, motion: str, effect: str | None) -> None:
    """120 spheres meet faces, edges and corners of a cup that moves: forces, torques and springs of each of 600 steps."""
    ways = {
        "vibration": SHAKEN,
        "rotation": Rotation(origin_m=(0.0, 0.0, 0.015), axis=(0.0, 1.0, 0.0), period_s=0.05),
        "slide": Slide(velocity_m_per_s=(0.3, 0.1, 0.0), opens_at_s=100 * STEP, travel_s=200 * STEP),
    }
    effects = small.DRY.model_copy(update={effect: False} if effect else {})
    both(tmp_path, thrown(120, 11), [cup(sides, motion)], 600, effects=effects, **ways)
    same(tmp_path / "stock", tmp_path / "planes")
    states = beds.table(tmp_path / "planes", "history/window_states")
    assert (states[["fx", "fy", "fz"]].abs().max(axis=1) > 1.0).sum() > 1000  # N
    if effect != "tangential_history":
        springs = beds.table(tmp_path / "planes", "history/window_wall_springs")
        met = springs.groupby("i")["triangle"].nunique()
        assert len(met) >= 40 and (met >= 2).sum() >= 4  # spheres at the wall, and those on several triangles


def test_bed_in_a_cup(tmp_path: Path) -> None:
    """Free spheres settle and slide in a shaken cup over 2,000 steps with checkpoints: places, speeds, spins, springs."""
    random = np.random.default_rng(5)
    cells = np.stack(np.meshgrid(*[np.arange(-3, 4)] * 2, np.arange(5), indexing="ij"), axis=-1).reshape(-1, 3)
    places = 2.1 * R * cells + [0.0, 0.0, 1.3 * R] + random.uniform(-1e-4, 1e-4, (len(cells), 3))
    spheres = [
        small.Sphere(1 + k % 2, tuple(x), tuple(random.normal(0.0, 0.2, 3).tolist()))
        for k, x in enumerate(places.tolist())
    ]
    inside = [s for s in spheres if max(abs(s.position[0]), abs(s.position[1])) < 0.02 - 1.05 * R]
    output = Output(
        interval_s=500 * STEP, contact_windows=2, contact_window_steps=100, checkpoints=3, window_trajectories=True
    )
    both(
        tmp_path, inside, [cup(4, "vibrates")], 2000, gravity=(0.0, 0.0, -9.81), vibration=SHAKEN, output=output
    )  # fmt: skip
    same(tmp_path / "stock", tmp_path / "planes")
    result = replay(tmp_path / "planes")
    assert result["ok"], result["notes"]
    assert result["newton"]["at_walls"] > 300
    assert result["quantities"]["newton_force"]["largest"] < 1e-9


def test_work_of_moving_walls(tmp_path: Path) -> None:
    """Works of a moist bed between moving walls: a sum over contacts in place of one over triangles, to 1e-9 of the largest."""
    spheres = beds.bed((5, 5, 4))
    for way in WAYS:
        scene = beds.prepare(tmp_path / way, spheres, 1000)
        (tmp_path / way / "scene.json").write_text(scene.model_copy(update={"contacts": way}).model_dump_json())
        small.run(tmp_path / way, spheres)
    one, two = (beds.table(tmp_path / way, "history/energy") for way in WAYS)
    turnover = one["wall_motion"].abs().max()
    assert turnover > 1e-6
    assert (one - two).abs().max().max() < 1e-9 * turnover


@pytest.mark.slow
def test_drum(tmp_path: Path) -> None:
    """A moist drum: curved wall and two ends that turn."""
    walls = list(bodies.drum_walls(0.02, 0.03))
    spheres = [
        small.Sphere(1, (x, y, z)) for x in (-6e-3, 0.0, 6e-3) for y in (-6e-3, 0.0, 6e-3) for z in (-8e-3, -2e-3)
    ]
    for way in WAYS:
        small.prepare(
            tmp_path / way, spheres_of(R), spheres, contacts(1, stiffness=1e4), walls=walls, liquid=WATER, effects=small.PAPER,
            steps=3000, time_step_s=STEP, gravity=(0.0, -9.81, 0.0), contacts=way,
            output=Output(interval_s=500 * STEP, contact_windows=2, window_trajectories=True, energy=False),
            rotation=Rotation(origin_m=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), period_s=1.0),
        )  # fmt: skip
        small.run(tmp_path / way, spheres)
    same(tmp_path / "stock", tmp_path / "planes")
    assert replay(tmp_path / "planes")["ok"]
