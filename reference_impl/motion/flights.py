"""Integrate spheres in flight from one output to the next, to check forces outside the recorded windows.

A group of spheres connected by bridges, none of which forms, ruptures or meets a wall between two outputs, moves
under weight and bridges alone, and its motion follows from trajectory.parquet and the snapshot of bridges at the
first output. A sphere with a film cannot touch anything without an event. Integration is as in the engine: half a
kick, a step, forces, half a kick.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from itertools import pairwise

import numpy as np
import pandas as pd
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from reference_impl.motion import impulses
from reference_impl.motion.budget import VELOCITY
from reference_impl.motion.window import Setup
from reference_impl.replay import capillary, coverage, images, io, laws, script
from reference_impl.replay.arrays import Floats, cross, dot
from reference_impl.replay.bodies import bodies, pairs
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run, where

MOST_STEPS = 2000
"""Largest total number of integrated steps; intervals between outputs are chosen evenly over the run until it is reached."""
DRY = 1e-6
"""Film below which a sphere counts as dry, over r^3: it could touch another without a bridge."""
TERMS = ("weight", "capillary", "viscous_normal", "viscous_tangential")
STILL = dict.fromkeys(TERMS, 1.0)
ROUNDS = 100


@dataclass
class Flights:
    """Spheres (rows) with position, speed, spin at both outputs; bridges by the rows of their ends."""

    step: Floats
    id: Floats
    steps: Floats
    """Number of steps from one output to the other."""
    x: Floats
    v: Floats
    w: Floats
    x_end: Floats
    v_end: Floats
    w_end: Floats
    mass: Floats
    radius: Floats
    i: Floats
    j: Floats
    volume: Floats
    ti: Floats
    tj: Floats

    def of(self, rows: Floats) -> Flights:
        """Select some of the spheres with their free flights."""
        number, keep = np.cumsum(rows) - 1, rows[self.i]
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        bridges = {n: values[n][keep] for n in BRIDGES}
        ends = {n: number[bridges[n]] for n in "ij"}
        return Flights(**{**{n: v[rows] for n, v in values.items() if n not in BRIDGES}, **bridges, **ends})


BRIDGES = ("i", "j", "volume", "ti", "tj")


def _placed(count: int, at: Floats, values: Floats) -> Floats:
    """Return rows of some spheres among rows of all, which are nan for the others."""
    found = np.full((count, values.shape[1]), np.nan)
    found[at] = values
    return found


def judged(run: Run) -> bool:
    """Return whether the forces of bridges are always known: explicit, in closed form, and without mass of liquid."""
    known = {None, *capillary.LAWS, *laws.VISCOUS_NORMAL, *laws.VISCOUS_TANGENTIAL}
    laws_known = all(coverage.law(run, effect) in known for effect in TERMS[1:])
    explicit = not coverage.semi_implicit(run) and impulses.every(run) == 1
    # without wall films a collision with a wall causes no event
    films_on_walls = io.scene(run.folder)["effects"].get("wall_films", True)
    if script.of(run.folder):
        return False  # gravity and other forces of a script are unknown
    heavy = run.meta["effects"].get("liquid_weight") or run.meta["effects"].get("shedding")
    return bool(laws_known and explicit and films_on_walls and not heavy and where(run.folder, "trajectory").exists())


@dataclass
class Hangar:
    """Flights of the run, collected part by part."""

    run: Run
    setup: Setup
    outputs: Floats
    flights: list[Flights] = field(default_factory=list)
    last: dict[str, pd.DataFrame] = field(default_factory=dict)

    def __post_init__(self) -> None:
        ways = np.diff(self.outputs)
        count = int(MOST_STEPS // max(int(ways.max(initial=1)), 1))
        at: Floats = np.unique(((np.arange(count) + 0.5) / max(count, 1) * len(ways)).astype(int))
        broken = np.array(sorted(self.setup.broken), int)
        keep = [k for k in at if not ((broken >= self.outputs[k]) & (broken <= self.outputs[k + 1])).any()]
        self.starts = set(self.outputs[np.array(keep, int)].tolist())

    def add(self, part: Run) -> None:
        """Add a chunk of the logs, which ends with a step; the last output of the previous chunk is its start."""
        now = {n: part.table(n) for n in ("trajectory", "bridges", "films", "events")}
        both = {n: pd.concat([self.last[n], now[n]]) if n in self.last else now[n] for n in now}
        steps = np.unique(both["trajectory"]["step"].to_numpy())
        for one, two in pairwise(steps):
            if one in self.starts:
                self._add(both, int(one), int(two))
        last = steps[-1] if len(steps) else -1
        self.last = {n: rows[rows["step"] >= last] for n, rows in both.items()}

    def _add(self, logs: dict[str, pd.DataFrame], one: int, two: int) -> None:
        setup, fixed = self.setup, bodies(self.run)
        start, end = (logs["trajectory"][logs["trajectory"]["step"] == s].sort_values("id") for s in (one, two))
        stand, film = (logs[n][logs[n]["step"] == one] for n in ("bridges", "films"))
        # a bridge that forms at the first output acts only from the next step
        events = logs["events"][(logs["events"]["step"] >= one) & (logs["events"]["step"] <= two)]
        p, q = pairs(stand, fixed), pairs(events, fixed)
        place = np.full(len(fixed.radius), -1)
        place[setup.ids] = np.arange(len(setup.ids))
        bad = ~setup.free | ((setup.enters > one) & (setup.enters <= two)) | (setup.leaves <= two)
        bad[place[np.concatenate([q.i, q.sphere_j[~q.wall], p.i[p.wall]]).astype(int)]] = True
        bad[place[film["id"].to_numpy()]] |= film["film"].to_numpy() < DRY * fixed.radius[film["id"].to_numpy()] ** 3
        rows = np.flatnonzero(~p.wall)
        i, j = place[p.i[rows].astype(int)], place[p.sphere_j[rows].astype(int)]
        bad[i[stand["separation"].to_numpy()[rows] <= 0.0]] = True
        n = len(setup.ids)
        _, group = connected_components(coo_matrix((np.ones(len(i)), (i, j)), shape=(n, n)), directed=False)
        fly = ~np.isin(group, group[bad])
        columns = ("xyz", VELOCITY[:3], VELOCITY[3:])
        # a sphere that has left is in no output; it is not free
        there = [place[t["id"].to_numpy()] for t in (start, end)]
        (x, v, w), (x_end, v_end, w_end) = (
            [_placed(n, at, t[list(c)].to_numpy(float)) for c in columns]
            for at, t in zip(there, (start, end), strict=True)
        )
        whole = Flights(
            np.full(n, one), setup.ids, np.full(n, two - one), x, v, w, x_end, v_end, w_end, setup.mass, setup.radius, i, j,
            stand["volume"].to_numpy(float)[rows], p.ti[rows], p.tj[rows],
        )  # fmt: skip
        self.flights.append(whole.of(fly))

    def all(self) -> Flights | None:
        """Join the free flights of all intervals between outputs."""
        some = [f for f in self.flights if len(f.id)]
        if not some:
            return None
        before = np.cumsum([0, *(len(f.id) for f in some)])
        for f, n in zip(some, before, strict=False):
            f.i, f.j = f.i + n, f.j + n
        self.flights = []
        return Flights(*(np.concatenate([getattr(f, c.name) for f in some]) for c in fields(Flights)))

    def check(self) -> list[Quantity]:
        """Compare positions and speeds at the second output."""
        self.run.known["flights"] = flights = self.all()
        if flights is None:
            return []
        x, v, w, whole = fly(self.run, self.setup, flights)
        rows = pd.DataFrame({"step": flights.step, "i": flights.id})[whole].reset_index(drop=True)
        r, x_end = flights.radius[whole], x + images.of(self.run.folder).nearest(flights.x_end - x)
        speed = np.sqrt((flights.v_end[whole] ** 2).sum(axis=1))
        logged = np.concatenate([flights.v_end, flights.radius[:, None] * flights.w_end], axis=1)[whole]
        expected = np.concatenate([v, flights.radius[:, None] * w], axis=1)[whole]
        return [
            compare("flight_place", "radius", x_end[whole], x[whole], r, rows, LIMIT),
            compare("flight_velocity", "itself, or 1 cm/s", logged, expected, np.maximum(speed, 1e-2), rows, LIMIT),
        ]


LIMIT = 1e-8
"""Limit of deviations after some hundred steps near contact, in which rounding errors of a gap grow."""


def fly(
    run: Run, setup: Setup, f: Flights, factors: dict[str, float] | None = None
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return positions, speeds and spins at the second output, and the spheres of groups that never touched."""
    part, dt, box = {**STILL, **(factors or {})}, setup.step, images.of(run.folder)
    inertia = 0.4 * f.mass * f.radius**2
    touched = np.zeros(len(f.id), dtype=bool)
    entered = f.step >= setup.enters[np.searchsorted(setup.ids, f.id)]
    pull = entered[:, None] * setup.gravity

    def kicks(x: Floats, v: Floats, w: Floats) -> tuple[Floats, Floats]:
        force, torque, gap = forces(run, box, f, part, x, v, w)
        np.logical_or.at(touched, f.i, gap <= 0.0)
        force += part["weight"] * f.mass[:, None] * pull
        return 0.5 * dt * force / f.mass[:, None], 0.5 * dt * torque / inertia[:, None]

    kick, turn = np.zeros_like(f.x), np.zeros_like(f.x)
    for _ in range(ROUNDS):  # forces of the first output are evaluated at velocities of half a kick earlier
        before = kick, turn
        kick, turn = kicks(f.x, f.v - kick, f.w - turn)
        if max(np.abs(kick - before[0]).max(initial=0.0), np.abs(turn - before[1]).max(initial=0.0)) == 0.0:
            break
    x, v, w = f.x.copy(), f.v.copy(), f.w.copy()
    for n in range(int(f.steps.max(initial=0))):
        go = (n < f.steps)[:, None]
        v, w = v + go * kick, w + go * turn
        x = x + go * dt * v
        kick, turn = kicks(x, v, w)
        v, w = v + go * kick, w + go * turn
    group = connected_components(coo_matrix((np.ones(len(f.i)), (f.i, f.j)), shape=2 * (len(f.id),)), directed=False)[1]
    return x, v, w, ~np.isin(group, group[touched])


def forces(
    run: Run, box: images.Images, f: Flights, part: dict[str, float], x: Floats, v: Floats, w: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return forces and torques of the bridges on all spheres, and the gaps."""
    ri, rj, wall = f.radius[f.i], f.radius[f.j], np.zeros(len(f.i), dtype=bool)
    d = box.nearest(x[f.i] - x[f.j])
    apart = np.sqrt(dot(d, d))
    n, gap, eta, sigma = d / apart[:, None], apart - ri - rj, run.meta["viscosity"], run.meta["surface_tension"]
    relative = v[f.i] - v[f.j]
    vn = dot(relative, n)
    along, side = np.zeros(len(gap)), np.zeros_like(d)
    if (name := coverage.law(run, "capillary")) is not None:
        along -= part["capillary"] * capillary.LAWS[name](gap, f.volume, ri, rj, wall, f.ti, f.tj, sigma)
    if (name := coverage.law(run, "viscous_normal")) is not None:
        along += part["viscous_normal"] * laws.VISCOUS_NORMAL[name](gap, f.volume, ri, rj, wall, vn, eta)
    if (name := coverage.law(run, "viscous_tangential")) is not None:
        slide, roll = laws.VISCOUS_TANGENTIAL[name](gap, ri, rj, wall, eta)
        turn = cross(ri[:, None] * w[f.i] + rj[:, None] * w[f.j], n)
        side = roll[:, None] * turn - slide[:, None] * (relative - vn[:, None] * n)
        side *= part["viscous_tangential"]
    force, torque = np.zeros_like(x), np.zeros_like(x)
    arm = cross(n, side)
    for who, push, spin in (
        (f.i, along[:, None] * n + side, -ri[:, None] * arm),
        (f.j, -along[:, None] * n - side, -rj[:, None] * arm),
    ):
        np.add.at(force, who, push)
        np.add.at(torque, who, spin)
    return force, torque, gap
