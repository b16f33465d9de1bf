"""Single contacts in YADE against exact solutions, and against LIGGGHTS on the same scene.

Each run of YADE takes about a second, so one scene holds several collisions far from each other.
"""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

from pywet import config
from pywet.cases.screening import cases
from pywet.cases.small import bodies, small
from pywet.engines.liggghts import driver as liggghts
from pywet.engines.yade import driver as yade
from pywet.geometry.motion import engine_displacement
from pywet.geometry.solids import plate
from pywet.geometry.surface import make_surface
from pywet.scene import EngineScene, Rotation, Slide

CASES = config.load(Path(__file__).parents[2] / "config")
pytestmark = [
    pytest.mark.skipif(shutil.which("yade") is None, reason="YADE cannot be installed on this machine"),
    pytest.mark.skipif(shutil.which("liggghts") is None, reason="LIGGGHTS is not installed"),
]
DRY = small.DRY.model_copy(update={"rolling": False})
RADII = (2.5e-3, 4e-3)
E_PAIR, E_WALL, FRICTION, STIFFNESS = 0.8, 0.6, 0.35, 1e4
CLASSES = bodies.sphere_classes(*RADII, angle_rad=0.0, name="c{k}")
PAIRS = tuple(
    bodies.contact(a, b, STIFFNESS, friction=FRICTION, restitution=E_PAIR if b else E_WALL)
    for a, b in ((1, 0), (2, 0), (1, 1), (1, 2), (2, 2))
)
STEP = 2e-7
"""Some 700 steps in the shortest collision: the first order error of the leapfrog's damping is then below 1e-3."""


def scene_in(path: Path, spheres: list[small.Sphere], steps: int, **more: object) -> EngineScene:
    """A small dry scene; `more` as small.prepare takes it."""
    fields = {"effects": DRY, "time_step_s": STEP, "output_interval_s": steps * STEP / 20, **more}
    return small.prepare(path, CLASSES, spheres, PAIRS, steps=steps, **fields)


def last(path: Path) -> pd.DataFrame:
    """The last frame, by id."""
    table = pd.read_parquet(path / "trajectory.parquet")
    return table[table["step"] == table["step"].max()].set_index("id")


def rebound(mass: float, radii: float, restitution: float, speed: float) -> float:
    """Coefficient of restitution of spring and dashpot when YADE multiplies the speed in the damping by 1/(1 - overlap/radii)."""
    log_e = math.log(restitution)
    damping = -2.0 * log_e * math.sqrt(mass * STIFFNESS) / math.hypot(math.pi, log_e)

    def slope(_: float, y: np.ndarray) -> list[float]:
        return [y[1], -(STIFFNESS * y[0] + damping * y[1] / (1.0 - y[0] / radii)) / mass]

    def apart(_: float, y: np.ndarray) -> float:
        return float(y[0]) if y[1] < 0 else 1.0

    apart.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(
        slope, (0.0, 10 * math.sqrt(mass / STIFFNESS)), [0.0, speed], events=apart, rtol=1e-10, atol=1e-15
    )
    return float(-found.y[1, -1] / speed)


def test_restitution_of_every_pair_and_momentum(tmp_path: Path) -> None:
    """Five head-on collisions at once: exact with the speed YADE puts into its damping, the scene's to the overlap.

    2e-4: a step late at touch, of some 700. The scene's own coefficient is missed by 0.002 at overlaps of 2 % of the radius.
    """
    speed, gap, spheres = 0.5, 1e-4, []
    kinds = ((1, 1), (1, 2), (2, 2))
    for k, (a, b) in enumerate(kinds):
        z, y = 0.03, 0.02 * (k - 1)
        apart = RADII[a - 1] + RADII[b - 1] + gap
        spheres += [small.Sphere(a, (0.0, y, z), (speed, 0.0, 0.0)), small.Sphere(b, (apart, y, z), (-speed, 0.0, 0.0))]
    for k, r in enumerate(RADII, start=1):
        spheres.append(small.Sphere(k, (0.03, 0.02 * k, r + gap), (0.0, 0.0, -speed)))
    scene_in(tmp_path, spheres, 6000, walls=(small.floor(),))
    yade.run(tmp_path, progress=False)
    end = last(tmp_path)
    for k, (a, b) in enumerate(kinds):
        one, two = end.loc[2 * k + 1], end.loc[2 * k + 2]
        found = (two.vx - one.vx) / (2 * speed)
        masses = CLASSES[a - 1].mass_kg, CLASSES[b - 1].mass_kg
        mass = masses[0] * masses[1] / sum(masses)
        assert found == pytest.approx(rebound(mass, RADII[a - 1] + RADII[b - 1], E_PAIR, 2 * speed), abs=2e-4)
        assert found == pytest.approx(E_PAIR, abs=3e-3)
        before = CLASSES[a - 1].mass_kg - CLASSES[b - 1].mass_kg
        after = (CLASSES[a - 1].mass_kg * one.vx + CLASSES[b - 1].mass_kg * two.vx) / speed
        assert after == pytest.approx(before, abs=1e-12 * CLASSES[1].mass_kg)
    for k, r in enumerate(RADII):
        found = end.loc[7 + k].vz / speed
        assert found == pytest.approx(rebound(CLASSES[k].mass_kg, 2 * r, E_WALL, speed), abs=4e-4)
        assert found == pytest.approx(E_WALL, abs=3e-3)


def test_sphere_on_the_edge_of_a_plate_is_in_contact_once(tmp_path: Path) -> None:
    """Facets would count the edge twice (twice the stiffness, another restitution); a convex solid counts it once."""
    r, speed = RADII[0], 0.5
    direction = np.array([math.sqrt(0.5), 0.0, math.sqrt(0.5)])
    at = np.array([0.02, 0.0, 0.0]) + (r + 1e-4) * direction
    spheres = [small.Sphere(1, tuple(at), tuple(-speed * direction))]
    scene_in(tmp_path, spheres, 6000, walls=(small.floor(half_side=0.02),))
    yade.run(tmp_path, progress=False)
    end = last(tmp_path).loc[1]
    # the direction to the edge is that of the flight, to the single precision of the edge's position
    assert np.array([end.vx, end.vz]) == pytest.approx(E_WALL * speed * direction[[0, 2]], rel=3e-3)


def test_sliding_then_rolling(tmp_path: Path) -> None:
    """A sphere set down sliding loses μg per second and ends rolling at 5/7 of its speed; a moving belt drags it along."""
    r, g, speed, step = RADII[0], 9.81, 0.1, 2e-5
    rest = r - CLASSES[0].mass_kg * g / STIFFNESS
    spheres = [small.Sphere(1, (0.0, 0.0, rest), (speed, 0.0, 0.0)), small.Sphere(1, (0.0, 0.2, rest), (0.0, 0.0, 0.0))]
    square = 0.05 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    belt = make_surface("belt", "slide", plate(square + np.array([0.0, 0.2]), -0.01, 0.0), "slides")
    scene_in(
        tmp_path,
        spheres,
        2500,
        walls=(small.floor(), belt),
        time_step_s=step,
        output_interval_s=50 * step,
        gravity=(0.0, 0.0, -g),
        box=0.3,
        slide=Slide(velocity_m_per_s=(speed, 0.0, 0.0), opens_at_s=0.0, travel_s=0.05),
    )
    yade.run(tmp_path, progress=False)
    table = pd.read_parquet(tmp_path / "trajectory.parquet").set_index(["id", "time"])
    stop = 2 * speed / (7 * FRICTION * g)
    sliding = table.loc[1]
    early = sliding[(sliding.index > 0.1 * stop) & (sliding.index < 0.9 * stop)]
    slope = np.polyfit(early.index, early["vx"], 1)[0]
    # the sphere starts in equilibrium with its contact spring, so |N| = mg to round-off
    assert slope == pytest.approx(-FRICTION * g, rel=1e-3)
    # the undamped shear spring oscillates about rolling; the mean is the exact value
    assert sliding["vx"].iloc[-20:].mean() == pytest.approx(5 / 7 * speed, rel=0.01)
    assert table.loc[2]["vx"].iloc[-20:].mean() == pytest.approx(2 / 7 * speed, rel=0.02)


def test_wall_that_strikes_a_sphere(tmp_path: Path) -> None:
    """A wall moving at v into a sphere at rest throws it off at (1 + e) v: the solids' velocity counts in the damping."""
    r, speed = RADII[0], 0.3
    square = 0.02 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    ram = make_surface("ram", "slide", plate(square, -0.01, 0.0), "slides")
    scene_in(
        tmp_path,
        [small.Sphere(1, (0.0, 0.0, r + 1e-4))],
        6000,
        walls=(ram,),
        slide=Slide(velocity_m_per_s=(0.0, 0.0, speed), opens_at_s=0.0, travel_s=1.0),
    )
    yade.run(tmp_path, progress=False)
    assert last(tmp_path).loc[1].vz == pytest.approx((1 + E_WALL) * speed, rel=2e-3)


def test_vibrating_wall_is_where_liggghts_has_it_and_trajectories_agree(tmp_path: Path) -> None:
    """The solids' own positions against the closed form of LIGGGHTS' mesh, and a bounce on the vibrating plate.

    The overlap is 2 % of the radius, which makes YADE's rebound 0.0006 lower: 2e-5 m after the 20 ms that follow. A wrong phase
    of one degree would change the wall's speed by 0.005 m/s, which is 1e-4 m.
    """
    square = 0.02 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    table = make_surface("table", "wires", plate(square, -0.01, 0.0), "vibrates")
    vibration, step = cases.vibration_of(CASES, CASES.case(1)), 2e-6
    spheres = [small.Sphere(2, (0.001, 0.002, RADII[1] + 1e-3), (0.05, 0.0, -0.2))]
    frames = {}
    for name, engine in (("yade", yade), ("liggghts", liggghts)):
        path = tmp_path / name
        scene = scene_in(
            path,
            spheres,
            20000,
            walls=(table,),
            vibration=vibration,
            time_step_s=step,
            output_interval_s=200 * step,
            gravity=(0.0, 0.0, -9.81),
        )
        engine.run(path, progress=False)
        frames[name] = pd.read_parquet(path / "trajectory.parquet").set_index("step")[["x", "y", "z"]]
    motion = pd.read_parquet(tmp_path / "yade" / "mesh_motion.parquet")
    exact = engine_displacement(vibration, motion["step"].to_numpy(), scene.time_step_s)
    # twenty thousand additions of velocity times step
    assert motion[["dx", "dy", "dz"]].to_numpy() == pytest.approx(exact, abs=1e-12)
    apart = (frames["yade"] - frames["liggghts"]).abs().max(axis=1)
    assert apart.loc[:400].max() < 1e-12  # free flight
    assert apart.max() < 3e-5


def test_oblique_collisions_with_spin_in_both_engines(tmp_path: Path) -> None:
    """Two spheres off centre, and one on the floor, spinning: velocities and spins after the contact agree.

    Overlaps are up to 1 % of the radius, by which YADE's damping differs: 0.002 of the speed. Spins times the radius likewise.
    """
    spin = (0.0, 60.0, -30.0)
    spheres = [
        small.Sphere(1, (0.0, 0.0, 0.03), (0.3, 0.0, 0.05), spin),
        small.Sphere(2, (0.0055, 0.003, 0.032), (-0.2, 0.0, 0.0), (50.0, 0.0, 0.0)),
        small.Sphere(1, (0.03, 0.0, RADII[0] + 1e-4), (0.2, 0.1, -0.3), spin),
    ]
    ends = {}
    for name, engine in (("yade", yade), ("liggghts", liggghts)):
        scene_in(tmp_path / name, spheres, 20000, walls=(small.floor(),))
        engine.run(tmp_path / name, progress=False)
        ends[name] = last(tmp_path / name)
    one, two = ends["yade"], ends["liggghts"]
    start = pd.DataFrame([s.velocity for s in spheres], columns=["vx", "vy", "vz"], index=two.index)
    assert ((two[["vx", "vy", "vz"]] - start).abs().max(axis=1) > 0.05).all()  # all three have collided
    assert one[["vx", "vy", "vz"]].to_numpy() == pytest.approx(two[["vx", "vy", "vz"]].to_numpy(), abs=1.5e-3)
    radii = two["type"].map(dict(enumerate(RADII, start=1))).to_numpy()[:, None]
    spins = [end[["wx", "wy", "wz"]].to_numpy() * radii for end in (one, two)]
    assert spins[0] == pytest.approx(spins[1], abs=1.5e-3)


def test_a_turning_drum_in_both_engines(tmp_path: Path) -> None:
    """A sphere on the mantle and one between the lids, both off the axis, are carried by friction: to 1e-4 of their way.

    Two turns a second: a wall's speed at the contact, not that of its middle, is what friction sees.
    """
    drum = bodies.drum_walls(0.03, 2.0 * RADII[0] - 2e-6, sides=16)
    turning = Rotation(origin_m=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), period_s=0.5)
    spheres = [small.Sphere(1, (0.002, RADII[0] + 0.0005 - 0.03, 0.0)), small.Sphere(1, (0.012, 0.005, 0.0))]
    ends, ways = {}, {}
    for name, engine in (("yade", yade), ("liggghts", liggghts)):
        path = tmp_path / name
        scene_in(path, spheres, 40_000, walls=drum, rotation=turning, time_step_s=2e-6, gravity=(0.0, -9.81, 0.0),
                 output_interval_s=2000 * 2e-6)  # fmt: skip
        engine.run(path, progress=False)
        of = pd.read_parquet(path / "trajectory.parquet").set_index(["step", "id"])[["x", "y", "z"]]
        ends[name], ways[name] = of, float(np.abs(of.xs(40_000) - of.xs(0)).max(axis=None))
        assert (pd.read_parquet(path / "mesh_motion.parquet")[["dx", "dy", "dz"]] == 0.0).all(axis=None)
    assert min(ways.values()) > 5e-3
    assert np.abs(ends["yade"] - ends["liggghts"]).max(axis=None) < 1e-4 * ways["yade"]
