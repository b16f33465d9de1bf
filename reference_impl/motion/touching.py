"""Contacts between spheres and with walls in every step of a window, from positions alone.

Candidates are found once per window (displacements within it are below a margin), then checked in every step.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from reference_impl.motion import mesh
from reference_impl.motion.nearest import closest_point
from reference_impl.motion.wall_motion import Motion
from reference_impl.motion.window import Setup, Wall, Window
from reference_impl.replay import images
from reference_impl.replay.arrays import Floats, dot
from reference_impl.replay.images import Images

CHUNK = 4_000_000


@dataclass(frozen=True)
class Touches:
    """Dry contacts, one row each: step k of the window, bodies a and b (a triangle if `wall`), geometry and motion.

    The normal n points from b to a; `apart` is the distance of the centres, or of centre and wall; `vb` is the
    partner's velocity.
    """

    k: Floats
    a: Floats
    b: Floats
    wall: Floats
    n: Floats
    apart: Floats
    vb: Floats
    face: Floats

    def __len__(self) -> int:
        return len(self.k)


def join(parts: list[Touches]) -> Touches:
    """Join all rows of several contact tables."""
    return Touches(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Touches)))


ABOUT_ONE_SIZE = 1.3
"""Largest ratio of ranges of bodies that are searched together: otherwise the largest range would determine all."""


def near_copies(x: Floats, reach: Floats, box: Images) -> tuple[Floats, Floats]:
    """Return pairs as `near_pairs`, between the nearest copies of both in a periodic box."""
    if not box.any:
        return near_pairs(x, reach)
    n, most = len(x), 2.0 * float(reach.max(initial=0.0))
    low, high = x.min(axis=0) - most, x.max(axis=0) + most
    copies = [x + shift for shift in box.others()]
    near = [np.flatnonzero(((c > low) & (c < high)).all(axis=1)) for c in copies]
    of = np.concatenate([np.arange(n), *near])
    a, b = near_pairs(np.concatenate([x, *(c[at] for c, at in zip(copies, near, strict=True))]), reach[of])
    one = (a < n) & (of[a] != of[b])  # a pair of two copies outside the box is counted elsewhere
    pairs = np.unique(np.stack([np.minimum(of[a], of[b]), np.maximum(of[a], of[b])], axis=1)[one], axis=0)
    return pairs[:, 0], pairs[:, 1]


def near_pairs(x: Floats, reach: Floats) -> tuple[Floats, Floats]:
    """Return pairs a < b with |x_a - x_b| < reach_a + reach_b."""
    sort = np.floor(np.log(reach / reach.min()) / np.log(ABOUT_ONE_SIZE)).astype(int)
    groups = [np.flatnonzero(sort == n) for n in np.unique(sort)]
    trees, most = [cKDTree(x[g]) for g in groups], [float(reach[g].max()) for g in groups]
    found = []
    for m, g in enumerate(groups):
        found.append(g[trees[m].query_pairs(2.0 * most[m], output_type="ndarray")])
        for n in range(m):
            near = trees[m].sparse_distance_matrix(trees[n], most[m] + most[n], output_type="ndarray")
            found.append(np.stack([g[near["i"]], groups[n][near["j"]]], axis=1))
    one, two = np.concatenate(found).T
    a, b = np.minimum(one, two), np.maximum(one, two)
    d = x[a] - x[b]
    close = dot(d, d) < (reach[a] + reach[b]) ** 2
    return a[close], b[close]


def near_triangles(y: Floats, reach: Floats, corners: Floats) -> tuple[Floats, Floats]:
    """Return pairs (sphere, triangle) whose bounds intersect."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    found, step = [], max(1, CHUNK // max(1, len(y)))
    for start in range(0, len(corners), step):
        at = slice(start, start + step)
        meet = np.ones((len(y), len(low[at])), dtype=bool)
        for m in range(3):
            meet &= (y[:, m, None] + reach[:, None] > low[None, at, m]) & (
                y[:, m, None] - reach[:, None] < high[None, at, m]
            )
        a, t = np.nonzero(meet)
        found.append((a, t + start))
    return np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found])


def travel(x: Floats, box: Images) -> float:
    """Return the largest displacement of any body since the start of the window [m]."""
    return float(np.sqrt((box.nearest(x - x[0]) ** 2).sum(axis=2)).max()) if len(x) else 0.0


def of_pairs(setup: Setup, window: Window) -> Touches:
    """Find pairs of spheres that overlap."""
    box = images.of_scene(setup.scene)
    reach = setup.radius + travel(window.x, box) * 1.01
    a, b = near_copies(window.x[0], reach, box)
    here = setup.touched(window.steps[0], a) & setup.touched(window.steps[0], b)
    a, b = a[here], b[here]
    touch = setup.radius[a] + setup.radius[b]
    rows = []
    for k, x in enumerate(window.x):
        d = box.nearest(x[a] - x[b])
        square = (d**2).sum(axis=1)
        at = np.flatnonzero(square < touch**2)
        apart = np.sqrt(square[at])
        rows.append(
            Touches(
                np.full(len(at), k), a[at], b[at], np.zeros(len(at), dtype=bool), d[at] / apart[:, None], apart,
                window.v_half[k][b[at]], np.zeros(len(at), dtype=bool),
            )
        )  # fmt: skip
    return join(rows)


def of_walls(setup: Setup, window: Window, motion: Motion, shapes: dict[str, mesh.Topology]) -> list[Touches]:
    """Return spheres that overlap walls, one table per mesh: triangles by the engine's rules, analytic wires by closest point."""
    found, box = [], images.of_scene(setup.scene)
    for wall in setup.walls:
        shape = shapes[wall.name]
        rest = np.stack([motion.to_rest(wall, int(s), x) for s, x in zip(window.steps, window.x, strict=True)])
        a, t = near_triangles(rest[0], setup.radius + travel(rest, box) * 1.01, shape.corners)
        here = setup.touched(window.steps[0], a)
        a, t = a[here], t[here]
        one_step = _analytic_wire_step if wall.analytic else _wall_step
        rows = []
        for k, step in enumerate(window.steps.tolist()):
            # at the periodic copy that was found near
            y = rest[0] + box.nearest(rest[k] - rest[0]) if box.any else rest[k]
            at, b, apart, point, face = one_step(setup, wall, shape, y, a, t)
            place = motion.to_world(wall, step, point) + (rest[k] - y)[at]
            some = np.ones(len(at), dtype=bool)
            n, vb = (window.x[k][at] - place) / apart[:, None], motion.velocity(wall, step, place)
            rows.append(Touches(np.full(len(at), k), at, b, some, n, apart, vb, face))
        found.append(join(rows))
    return found


def _wall_step(setup: Setup, wall: Wall, shape: mesh.Topology, y: Floats, a: Floats, t: Floats) -> tuple[Floats, ...]:
    """Select touching pairs of spheres and triangles: sphere, triangle, distance, point at rest, whether on the face."""
    apart, point, kind = mesh.resolve(shape, t, y[a])
    at = np.flatnonzero(apart - setup.radius[a] <= 0.0)
    return a[at], t[at] % (wall.last - wall.first) + wall.first, apart[at], point[at], kind[at] == mesh.FACE


def _analytic_wire_step(
    setup: Setup, wall: Wall, shape: mesh.Topology, y: Floats, a: Floats, t: Floats
) -> tuple[Floats, ...]:
    """Find contacts with analytic wires, each part being one body with the closest of its triangles."""
    part = setup.part[wall.first + t]
    point = closest_point(y[a], shape.corners[t])
    apart = np.sqrt(((y[a] - point) ** 2).sum(axis=1))
    order = np.lexsort((apart, part, a))
    first = np.ones(len(order), dtype=bool)
    first[1:] = (np.diff(a[order]) != 0) | (np.diff(part[order]) != 0)
    at = order[first]
    at = at[apart[at] <= setup.radius[a[at]]]
    parts = setup.part[wall.first : wall.last]
    b = wall.first + np.searchsorted(parts, part[at])  # parts are numbered in the order of the triangles
    return a[at], b, apart[at], point[at], np.zeros(len(at), dtype=bool)


class Springs:
    """The engine's logged springs, found by step and the two bodies."""

    def __init__(self, table: pd.DataFrame, bodies: int) -> None:
        self._bodies = bodies
        key = self._key(table["step"].to_numpy(), table["a"].to_numpy(), table["b"].to_numpy())
        order = np.argsort(key, kind="stable")
        self._keys = key[order]
        self._values = table[["sx", "sy", "sz"]].to_numpy(float)[order]

    def _key(self, step: Floats, a: Floats, b: Floats) -> Floats:
        return (np.asarray(step, dtype=np.int64) * self._bodies + a) * self._bodies + b

    def of(self, step: Floats, a: Floats, b: Floats) -> tuple[Floats, Floats]:
        """Return springs (n, 3), zero if none is logged, and whether one is."""
        if not len(self._keys):
            return np.zeros((len(a), 3)), np.zeros(len(a), dtype=bool)
        key = self._key(step, a, b)
        at = np.minimum(np.searchsorted(self._keys, key), len(self._keys) - 1)
        there = self._keys[at] == key
        return np.where(there[:, None], self._values[at], 0.0), there
