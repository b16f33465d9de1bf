"""Forces of the bridges in the windows from the trajectories: which bridges act is taken from the contact log, nothing else.

Positions, speeds and spins are those of the trajectory, closest points on walls and their motion are the reference's own. A law
that cannot be recomputed (the exact bridge is solved for a sample only) is taken as logged, as in forces.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from reference_impl.motion import impulses, mesh
from reference_impl.motion.dry import dot, size
from reference_impl.motion.touching import travel
from reference_impl.motion.wall_motion import Motion
from reference_impl.motion.window import Setup, Window
from reference_impl.replay import capillary, coverage, laws
from reference_impl.replay.bodies import bodies
from reference_impl.replay.compare import Floats
from reference_impl.replay.forces import angles
from reference_impl.replay.implicit import relative_kick
from reference_impl.replay.io import Run, vectors

DEFAULT = {"capillary": "rabinovich", "viscous_normal": "pitois", "viscous_tangential": "goldman"}
"""Laws by which an effect that is off is judged for what it would have done."""


@dataclass(frozen=True)
class Bridges:
    """Bridges of a window, one row each, forces on a; `triangle` is the own closest one, `point` the closest point."""

    table: pd.DataFrame
    k: Floats
    a: Floats
    b: Floats
    wall: Floats
    n: Floats
    gap: Floats
    point: Floats
    vb: Floats
    relative: Floats
    slip: Floats
    capillary: Floats
    normal: Floats
    tangential: Floats
    weight: Floats
    acting: dict[str, bool]

    def force(self) -> Floats:
        """Whole force on a."""
        zero = np.zeros(len(self.k))
        pull = self.capillary if self.acting["capillary"] else zero
        drag = self.normal if self.acting["viscous_normal"] else zero
        side = self.tangential if self.acting["viscous_tangential"] else np.zeros((len(self.k), 3))
        return np.asarray((drag - pull)[:, None] * self.n + side)

    def torques(self, setup: Setup) -> tuple[Floats, Floats]:
        """Torques on a and on b (zero at a wall)."""
        turn = np.cross(self.n, self.tangential) * self.acting["viscous_tangential"]
        rb = np.where(self.wall, 0.0, setup.radius[np.where(self.wall, 0, self.b)])
        return -setup.radius[self.a][:, None] * turn, -rb[:, None] * turn


def of_window(run: Run, setup: Setup, window: Window, motion: Motion) -> Bridges:
    """All bridges of one window."""
    log = run.rows("contacts", int(window.steps[0]), int(window.steps[-1]))
    table = log[log["step"].isin(window.steps)].reset_index(drop=True)
    wall = (table["partner_kind"] != laws.SPHERE).to_numpy()
    k = np.searchsorted(window.steps, table["step"].to_numpy())
    a = np.searchsorted(setup.ids, table["i"].to_numpy())
    b = np.where(wall, table["j"].to_numpy(), np.searchsorted(setup.ids, table["j"].to_numpy()))
    other = np.where(wall, 0, b)
    point, vb = window.x[k, other], window.v_half[k, other]
    if wall.any():
        at = np.flatnonzero(wall)
        point[at], vb[at] = closest_on_parts(setup, window, motion, k[at], a[at], b[at])
    d = window.x[k, a] - point
    apart = size(d)
    n = d / apart[:, None]
    rb = np.where(wall, 0.0, setup.radius[other])
    gap = apart - setup.radius[a] - rb
    relative = window.v_half[k, a] - vb
    spin = setup.radius[a][:, None] * window.w_half[k, a] + rb[:, None] * window.w_half[k, other]
    pull, normal, side, acting = _terms(run, table, wall, gap, n, relative, spin)
    slip = relative - dot(relative, n)[:, None] * n - np.cross(spin, n)
    weight = impulses.weights(run, table)
    return Bridges(table, k, a, b, wall, n, gap, point, vb, relative, slip, pull, normal, side, weight, acting)


def _terms(
    run: Run, table: pd.DataFrame, wall: Floats, gap: Floats, n: Floats, relative: Floats, spin: Floats
) -> tuple[Floats, Floats, Floats, dict[str, bool]]:
    """Capillary pull, normal drag along n, tangential drag; of an effect that is off, what its usual law would give."""
    ri, rj, ti, tj = angles(table, bodies(run))
    volume, eta, sigma = table["volume"].to_numpy(float), run.meta["viscosity"], run.meta["surface_tension"]
    name = {effect: coverage.law(run, effect) for effect in DEFAULT}
    acting = {effect: law is not None for effect, law in name.items()}
    use = {effect: law or DEFAULT[effect] for effect, law in name.items()}
    push, spin_push = vectors(table, "push"), vectors(table, "spin_push")
    pull = table["capillary"].to_numpy(float)
    if use["capillary"] in capillary.LAWS:
        pull = capillary.LAWS[use["capillary"]](gap, volume, ri, rj, wall, ti, tj, sigma)
    normal, side = table["viscous_normal"].to_numpy(float), vectors(table, "viscous_tangential")
    kick = relative_kick(run, table)
    if use["viscous_normal"] in laws.VISCOUS_NORMAL:
        law = laws.VISCOUS_NORMAL[use["viscous_normal"]]
        drag = -law(gap, volume, ri, rj, wall, np.ones(len(gap)), eta)
        normal = -drag * (dot(relative, n) + dot(push, n)) / (1.0 + drag * kick)
    if use["viscous_tangential"] in laws.VISCOUS_TANGENTIAL:
        slide, roll = laws.VISCOUS_TANGENTIAL[use["viscous_tangential"]](gap, ri, rj, wall, eta)
        moved = relative + push
        sideways, turn = moved - dot(moved, n)[:, None] * n, np.cross(spin + spin_push, n)
        side = (roll[:, None] * turn - slide[:, None] * sideways) / (1.0 + (slide + 2.5 * roll) * kick)[:, None]
    return pull, normal, side, acting


def closest_on_parts(
    setup: Setup, window: Window, motion: Motion, k: Floats, a: Floats, part: Floats
) -> tuple[Floats, Floats]:
    """Closest points of wall parts to spheres, and their velocities: all triangles of a part once, then those that can matter."""
    point, velocity = np.zeros((len(k), 3)), np.zeros((len(k), 3))
    for wall in setup.walls:
        own = np.arange(wall.first, wall.last)
        rows = np.flatnonzero(np.isin(part, setup.part[own]))
        if not len(rows):
            continue
        rest = np.stack([motion.to_rest(wall, int(s), x) for s, x in zip(window.steps, window.x, strict=True)])
        one, triangle = _near(setup, rest, a[rows], part[rows], own, 2.0 * travel(rest) * 1.01)
        # every row of the log against the few triangles of its pair of sphere and part
        row = np.repeat(np.arange(len(rows)), np.diff(one)[_group(a[rows], part[rows])])
        first = one[_group(a[rows], part[rows])]
        count = np.diff(one)[_group(a[rows], part[rows])]
        at = np.repeat(first, count) + np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
        y = rest[k[rows][row], a[rows][row]]
        q = mesh.closest_point(y, setup.corners[triangle[at]])
        distance = size(y - q)
        order = np.lexsort((distance, row))
        best = order[np.searchsorted(row[order], np.arange(len(rows)))]
        for step in np.unique(k[rows]):
            these = np.flatnonzero(k[rows] == step)
            place = motion.to_world(wall, int(window.steps[step]), q[best[these]])
            point[rows[these]] = place
            velocity[rows[these]] = motion.velocity(wall, int(window.steps[step]), place)
    return point, velocity


def _group(a: Floats, part: Floats) -> Floats:
    """Number of each row's pair of sphere and part."""
    _, number = np.unique(np.stack([a, part], axis=1), axis=0, return_inverse=True)
    return np.asarray(number.ravel())


def _near(setup: Setup, rest: Floats, a: Floats, part: Floats, own: Floats, margin: float) -> tuple[Floats, Floats]:
    """For each pair of sphere and part the triangles that can be closest in the window: offsets and triangles."""
    pairs = np.unique(np.stack([a, part], axis=1), axis=0)
    order = own[np.argsort(setup.part[own], kind="stable")]
    sorted_part = setup.part[order]
    low, high = np.searchsorted(sorted_part, pairs[:, 1], "left"), np.searchsorted(sorted_part, pairs[:, 1], "right")
    count = high - low
    row = np.repeat(np.arange(len(pairs)), count)
    triangle = order[np.repeat(low, count) + np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)]
    y = rest[0][pairs[row, 0]]
    distance = size(y - mesh.closest_point(y, setup.corners[triangle]))
    least = np.minimum.reduceat(distance, np.cumsum(count) - count)
    keep = distance <= least[row] + margin
    return np.concatenate([[0], np.cumsum(np.bincount(row[keep], minlength=len(pairs)))]), triangle[keep]
