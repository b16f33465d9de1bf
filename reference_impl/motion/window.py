"""Inputs for Newton's law from a run: bodies, dry contacts and walls (scene.json), motion in the windows (history/).

It only reads files; the only physics here are masses, dashpots and the motion of walls.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.faults import reading
from reference_impl.replay import retired, script
from reference_impl.replay.arrays import Floats, vectors
from reference_impl.replay.io import ReplayError, every, masses
from reference_impl.replay.io import scene as read_scene
from reference_impl.replay.plans import FOREIGN, created, engine, entered, plan

RECORDED = "recorded"
"""Motion of the walls of a script's run, as recorded in poses.parquet."""
TABLES = ("window_states", "window_pair_springs", "window_wall_springs")


@dataclass(frozen=True)
class Dry:
    """Parameters of the dry contacts by types of the two bodies, shape (types + 1, types + 1); type 0 is a wall.

    At an overlap d the normal spring is normal d^power, the tangential one tangential d^power [N/m], their
    dashpots damping and damping_side times d^(power/2). Linear: power 0. Hertz and Mindlin: power 1/2, and
    dashpots times sqrt(m_eff).
    """

    normal: Floats
    tangential: Floats
    friction: Floats
    rolling: Floats
    damping: Floats
    damping_side: Floats
    drag: Floats
    """Drag of friction without history, c = m_eff/(28 dt) [kg/s]."""
    power: float = 0.0

    def at(self, kinds: tuple[Floats, Floats], overlap: Floats, mass: Floats) -> tuple[Floats, ...]:
        """Return normal and tangential spring [N/m] and their dashpots [kg/s] at overlaps of bodies of an effective mass [kg]."""
        normal, side, damping, damping_side = (
            getattr(self, name)[kinds] for name in ("normal", "tangential", "damping", "damping_side")
        )
        if not self.power:
            return normal, side, damping, damping_side
        soft = np.maximum(overlap, 0.0) ** self.power
        slow = np.sqrt(soft * mass)
        return soft * normal, soft * side, slow * damping, slow * damping_side

    def steepest(self, weight: float) -> float:
        """Return the largest slope [N/m] of a normal force where it equals a weight [N]."""
        stiff = float(self.normal.max())
        depth = (weight / stiff) ** (1.0 / (1.0 + self.power))
        return (1.0 + self.power) * stiff * depth**self.power


@dataclass(frozen=True)
class Wall:
    """Motion of one mesh; its triangles are [first, last) of all triangles."""

    name: str
    first: int
    last: int
    motion: str
    way: dict[str, Any]
    """Parameters of its motion, see `way_of`; empty for a fixed wall."""
    analytic: bool = False
    """Whether every part is one convex body with one contact; otherwise every triangle has its own."""


@dataclass(frozen=True)
class Setup:
    """A run: `radius`, `mass`, `kind`, `free` over its spheres in order of `ids`; triangles at rest (t, 3, 3)."""

    folder: Path
    scene: dict[str, Any]
    ids: Floats
    kind: Floats
    radius: Floats
    mass: Floats
    free: Floats
    dry: Dry
    walls: tuple[Wall, ...]
    corners: Floats
    part: Floats
    enters: Floats
    """Step from which each sphere has weight."""
    leaves: Floats
    """Last step at which each sphere takes part, after which it has been retired."""
    broken: frozenset[int]
    """Steps after which the engine was set up again: the following forces differ from the recorded ones."""
    foreign: bool = False
    """Whether dry contacts follow a law specific to the engine, which is not recomputed."""
    created: Floats | None = None
    """Step at which the engine creates each sphere; until then nothing touches it. None: all at the start."""

    def touched(self, step: float, spheres: Floats) -> Floats:
        """Return which of some spheres, by index, may be in contact after a step."""
        return np.ones(len(spheres), dtype=bool) if self.created is None else step >= self.created[spheres]

    @property
    def step(self) -> float:
        """Return the time step [s]."""
        return float(self.scene["time_step_s"])

    @property
    def gravity(self) -> Floats:
        """Return the acceleration of gravity [m/s2]."""
        return np.array(self.scene["gravity_m_per_s2"], dtype=float)

    def pull(self, steps: Floats) -> Floats:
        """Return the acceleration by gravity [m/s2], shape (steps, spheres, 3); zero before entry and after retirement."""
        there = (steps[:, None] >= self.enters) & (steps[:, None] <= self.leaves)
        return np.asarray(there[:, :, None] * self.gravity)

    @property
    def memory(self) -> bool:
        """Return whether friction is a recorded spring with tangential history; otherwise it is a drag."""
        return not self.foreign and bool(self.scene["effects"].get("tangential_history", True))


@dataclass(frozen=True)
class Window:
    """Motion of all spheres in consecutive steps: arrays (steps, spheres, 3); force and torque are the engine's sums."""

    steps: Floats
    x: Floats
    v: Floats
    w: Floats
    force: Floats
    torque: Floats
    v_half: Floats
    """Velocity in the forces of the step, half a step before its end."""
    w_half: Floats
    w_margin: Floats
    """Uncertainty of `w_half` [rad/s] due to rounding and negligible components; shape (steps, spheres)."""
    mass: Floats
    """Mass of the moving spheres [kg], shape (steps, spheres)."""
    liquid: Floats
    """Mass of the liquid on them [kg], whether or not it is part of `mass`; the same shape."""


def recorded(run_dir: Path) -> bool:
    """Return whether the run recorded its motion in windows."""
    return (Path(run_dir) / "history" / "window_states.parquet").exists()


def read(run_dir: Path) -> Setup:
    """Read the inputs for a replay of the motion from a run, except the motion itself."""
    with reading(f"{run_dir}: scene.json with history/", "the scene of a run and its tables: run the case again"):
        return _read(Path(run_dir))


def _read(folder: Path) -> Setup:
    scene = read_scene(folder)
    recorded = script.of(folder) is not None
    spheres = every(folder / "history" / "spheres.parquet").sort_values("id")
    kind = spheres["type"].to_numpy()
    mass_of, radius_of = masses(scene), {c["type"]: c["radius_m"] for c in scene["classes"]}
    mass, radius = (np.array([of[t] for t in kind]) for of in (mass_of, radius_of))
    ids = spheres["id"].to_numpy()
    walls, corners, part = _walls(folder, scene, recorded)
    foreign = engine(folder) in FOREIGN
    return Setup(
        folder, scene, ids, kind, radius, mass, ~np.isin(ids, list(driven(folder))),
        dry_contacts(scene, mass_of), walls, corners, part, entered(scene, spheres),
        retired.leaves(folder, ids), frozenset() if foreign else _broken(scene), foreign,
        created(scene, spheres, plan(folder).steps),
    )  # fmt: skip


def dashpot(stiffness: float, restitution: float, mass: float, step: float) -> float:
    """Return the normal damping [kg/s]: gamma0 = -2 ln e sqrt(m k)/sqrt(pi^2 + ln^2 e) (E after 4), over 1 + gamma0 dt/(4 m).

    The second factor compensates for the engine's velocities, which are half a step old (docs/engine.md).
    """
    log = np.log(restitution)
    gamma = -2.0 * log * np.sqrt(mass * stiffness) / np.sqrt(np.pi**2 + log**2)
    return float(gamma / (1.0 + gamma * step / (4.0 * mass)))


def dry_contacts(scene: dict[str, Any], mass: dict[int, float]) -> Dry:
    """Return matrices over pairs of types; 0 is a wall."""
    n, hertz = len(mass) + 1, scene.get("hertz")
    found = {f.name: np.zeros((n, n)) for f in fields(Dry) if f.name != "power"}
    for pair in scene["pairs"]:
        a, b = pair["a"], pair["b"]
        m = mass[a] if b == 0 else mass[a] * mass[b] / (mass[a] + mass[b])
        row = {
            "friction": pair["friction"],
            "rolling": pair["rolling_friction_m"] if scene["effects"].get("rolling", True) else 0.0,
            "drag": m / (28.0 * scene["time_step_s"]),
            **(_linear(pair, m, scene["time_step_s"]) if hertz is None else hertz_mindlin(scene, pair)),
        }
        for name, value in row.items():
            found[name][a, b] = found[name][b, a] = value
    return Dry(**found, power=0.0 if hertz is None else 0.5)


def _linear(pair: dict[str, Any], mass: float, step: float) -> dict[str, float]:
    k = pair["normal_stiffness_N_per_m"]
    return {
        "normal": k,
        "tangential": pair["tangential_stiffness_N_per_m"],
        "damping": dashpot(k, pair["restitution"], mass, step),
    }


def hertz_mindlin(scene: dict[str, Any], pair: dict[str, Any]) -> dict[str, float]:
    """Return Hertz's normal force 4/3 E* sqrt(R d) d and Mindlin's no-slip spring 8 G* sqrt(R d), as coefficients of sqrt(d).

    Each dashpot is 2 sqrt(5/6) beta sqrt(S m), S being 2 E* sqrt(R d) or the tangential spring, beta = -ln e/sqrt(pi^2 + ln^2 e);
    here without sqrt(m) and sqrt(d).
    """
    a, b, radius = pair["a"], pair["b"], {c["type"]: c["radius_m"] for c in scene["classes"]}
    r = radius[a] if b == 0 else radius[a] * radius[b] / (radius[a] + radius[b])
    one = scene["hertz"]["spheres"][a - 1]
    two = scene["hertz"]["spheres"][b - 1] if b else scene["hertz"]["walls"]
    bulk = shear = 0.0
    for body in (one, two):
        modulus, nu = body["youngs_modulus_Pa"], body["poissons_ratio"]
        bulk += (1.0 - nu * nu) / modulus
        shear += 2.0 * (2.0 - nu) * (1.0 + nu) / modulus
    normal, side = np.sqrt(r) / bulk, np.sqrt(r) / shear
    log = np.log(pair["restitution"])
    lost = -2.0 * np.sqrt(5.0 / 6.0) * log / np.sqrt(np.pi**2 + log**2)
    return {
        "normal": 4.0 / 3.0 * normal,
        "tangential": 8.0 * side,
        "damping": lost * np.sqrt(2.0 * normal),
        "damping_side": lost * np.sqrt(8.0 * side),
    }


def _walls(folder: Path, scene: dict[str, Any], recorded: bool) -> tuple[tuple[Wall, ...], Floats, Floats]:
    path = folder / "history" / "triangles.parquet"
    if not path.exists():
        return (), np.zeros((0, 3, 3)), np.zeros(0, dtype=int)
    table = every(path).sort_values("triangle")
    corners = np.stack([vectors(table, f"v{k}") for k in range(3)], axis=1)
    far = 10.0 * float(np.abs([scene["box_low_m"], scene["box_high_m"]]).max())
    if not (np.abs(corners) <= far).all():  # round-off grows with the coordinates
        raise ReplayError(f"{path} has corners beyond {far:.3g} m, ten times the scene's box: run the case again")
    walls, names = [], table["mesh"].to_numpy()
    for wall in scene["walls"]:
        at = np.flatnonzero(names == wall["name"])
        way, analytic_wires = way_of(scene, wall), wall.get("analytic_wires", False)
        motion = RECORDED if recorded else wall["motion"]
        walls.append(Wall(wall["name"], int(at[0]), int(at[-1]) + 1, motion, way, analytic_wires))
    return tuple(walls), corners, table["part"].to_numpy()


def driven(folder: Path) -> set[int]:
    """Return the spheres whose motion the deck, or YADE's task, prescribes."""
    task = folder / "engine" / "task.json"
    if task.exists():
        return set(json.loads(task.read_text())["driven"])
    decks = [deck for name in ("setup.liggghts", "in.lammps") if (deck := folder / "engine" / name).exists()]
    found = re.search(r"^group driven id (.*)$", decks[0].read_text(errors="replace"), re.MULTILINE) if decks else None
    return {int(word) for word in found.group(1).split()} if found else set()


def _broken(scene: dict[str, Any]) -> frozenset[int]:
    """Return the ends of the run's stages (walls that move out)."""
    return frozenset(step for window in slide_steps(scene).values() for step in window) - {0}


def way_of(scene: dict[str, Any], wall: dict[str, Any]) -> dict[str, Any]:
    """Return the motion of a wall: its own, or the scene's for its kind; empty for a fixed wall."""
    shared = {"vibrates": "vibration", "slides": "slide", "turns": "rotation"}.get(wall["motion"])
    return dict(wall.get("motion_parameters") or (shared and scene.get(shared)) or {})


def slide_steps(scene: dict[str, Any]) -> dict[str, tuple[int, int]]:
    """Find the steps at which each sliding wall starts and stops."""
    step, found = scene["time_step_s"], {}
    total = round(scene["duration_s"] / step)
    for wall in scene["walls"]:
        way = way_of(scene, wall)
        if wall["motion"] == "slides" and way:
            opens = min(total, round(way["opens_at_s"] / step))
            found[wall["name"]] = opens, min(total, opens + round(way["travel_s"] / step))
    return found


def windows(setup: Setup, carried: Callable[[Floats], Floats] | None = None) -> list[Window]:
    """Return the recorded windows, ranges of consecutive steps; `carried`: liquid on the spheres [m3], shape (steps, spheres)."""
    table = every(setup.folder / "history" / "window_states.parquet").sort_values(["step", "id"])
    steps = np.unique(table["step"].to_numpy())
    there = steps[:, None] <= setup.leaves
    if not np.array_equal(table["id"].to_numpy(), np.broadcast_to(setup.ids, there.shape)[there]):
        raise ReplayError(
            f"{setup.folder}/history/window_states.parquet holds {len(table)} rows for {len(steps)} steps of {len(setup.ids)} "
            "spheres; expected every sphere that is not retired in every step: run the case again"
        )
    cuts = np.flatnonzero(np.diff(steps) > 1) + 1
    whole = {name: np.zeros((*there.shape, 3)) for name in ("x", "v", "w", "f", "t")}
    whole["x"][:] = retired.nowhere(len(setup.ids))
    for name, values in whole.items():
        values[there] = vectors_of(table, name)
    return [
        _window(setup, steps[at], {k: v[at] for k, v in whole.items()}, carried)
        for at in np.split(np.arange(len(steps)), cuts)
    ]


def vectors_of(table: pd.DataFrame, name: str) -> Floats:
    """Return three columns as (n, 3); the position has columns x, y, z."""
    names = ["x", "y", "z"] if name == "x" else [f"{name}{axis}" for axis in "xyz"]
    return table[names].to_numpy(dtype=np.float64)


def _window(
    setup: Setup, steps: Floats, s: dict[str, Floats], carried: Callable[[Floats], Floats] | None
) -> Window:  # fmt: skip
    """Make a window, with half-step speeds from those at the end of the step, after the second half of the kick."""
    liquid, mass = np.zeros((len(steps), len(setup.ids))), np.tile(setup.mass, (len(steps), 1))
    if carried is not None and setup.scene["liquid"]:
        liquid = carried(steps) * setup.scene["liquid"]["density_kg_per_m3"]
        mass = mass + liquid * bool(setup.scene["effects"].get("liquid_weight"))
    acted = (steps > 0)[:, None, None] * setup.free[None, :, None]
    kick = acted * (0.5 * setup.step / mass)[:, :, None]
    turn = acted * (0.5 * setup.step / (0.4 * mass * setup.radius**2))[:, :, None]
    spun = turn * s["t"]
    w_half, largest = s["w"] - spun, np.abs(spun).max(axis=2)
    # about ten roundings of the kick and one of the sum
    margin = np.finfo(float).eps * (8.0 * largest + np.abs(s["w"]).max(axis=2))
    # round-off must not become a spin: rolling resistance depends on its direction only
    lost = (np.abs(w_half) < STILL * largest[:, :, None]) & (w_half != 0.0)
    w_half[lost] = 0.0
    margin += STILL * largest * np.sqrt(lost.sum(axis=2))
    return Window(steps, s["x"], s["v"], s["w"], s["f"], s["t"], s["v"] - kick * s["f"], w_half, margin, mass, liquid)


STILL = 1e-13
"""Share of the spin of half a kick below which a component counts as zero."""


def springs(setup: Setup, name: str) -> pd.DataFrame:
    """Return logged springs on a: `step`, `a`, `b` (index of the sphere in `ids`; for walls of the triangle), vector."""
    path = setup.folder / "history" / f"window_{name}.parquet"
    if not path.exists():
        return pd.DataFrame({k: np.zeros(0) for k in ("step", "a", "b", "sx", "sy", "sz")}).astype(
            {"step": int, "a": int, "b": int}
        )
    table = every(path)
    a = np.searchsorted(setup.ids, table["i"].to_numpy())
    if name == "wall_springs":
        first = np.array([w.first for w in setup.walls])
        b = first[table["mesh"].to_numpy()] + table["triangle"].to_numpy()
        sign = np.ones(len(table))
    else:
        other = np.searchsorted(setup.ids, table["j"].to_numpy())
        sign = np.where(a < other, 1.0, -1.0)  # the sign of the spring depends on the order of the spheres
        a, b = np.minimum(a, other), np.maximum(a, other)
    found = pd.DataFrame({"step": table["step"], "a": a, "b": b})
    for axis in "xyz":
        found[f"s{axis}"] = sign * table[f"s{axis}"].to_numpy()
    return found
