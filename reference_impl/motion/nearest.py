"""Closest points of wall parts to spheres at any steps: for bridges, formations, the triangle that gets liquid, snapshots.

Rows of any steps are taken together; a triangle is looked at in full only where its bounds leave it a chance.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numba import njit

from reference_impl.motion import mesh, window
from reference_impl.motion.wall_motion import Motion
from reference_impl.replay.arrays import Floats, size
from reference_impl.replay.io import Run

SAME = 1e-9
"""Part of the distance within which two triangles are as near: beside an edge either may be the one that is meant."""


@dataclass(frozen=True)
class Closest:
    """Of each row: how far the part is; the closest point in the world; its triangle, of several as near the first."""

    distance: Floats
    point: Floats
    triangle: Floats
    least: Floats
    """The least of given values over the triangles that are as near."""

    def of(self, rows: Floats) -> Closest:
        """Some of them."""
        return Closest(*(getattr(self, f.name)[rows] for f in fields(self)))


class Parts:
    """All wall parts of a run."""

    def __init__(self, setup: window.Setup) -> None:
        self.setup, self.motion = setup, Motion(setup)
        part, corners = setup.part, setup.corners
        self.order = np.argsort(part, kind="stable")
        count = int(part.max(initial=-1)) + 1
        self.first = np.searchsorted(part[self.order], np.arange(count + 1))
        self.bounds = np.stack([corners.min(axis=1, initial=np.inf), corners.max(axis=1, initial=-np.inf)], axis=1)
        self.low, self.high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
        np.minimum.at(self.low, part, self.bounds[:, 0])
        np.maximum.at(self.high, part, self.bounds[:, 1])
        self.wall = np.zeros(count, np.int64)
        for n, wall in enumerate(setup.walls):
            self.wall[part[wall.first : wall.last]] = n

    def __len__(self) -> int:
        return len(self.wall)

    def rest(self, step: Floats, x: Floats, part: Floats, back: bool = False) -> Floats:
        """Points in the world as the mesh of a part sees them at rest; `back`: the way back."""
        y = x.copy()
        move = self.motion.to_world if back else self.motion.to_rest
        for wall, now, rows in self._moving(step, part):
            y[rows] = move(wall, now, x[rows])
        return y

    def velocity(self, step: Floats, x: Floats, part: Floats) -> Floats:
        """Velocities of points of parts [m/s]."""
        v = np.zeros_like(x)
        for wall, now, rows in self._moving(step, part):
            v[rows] = self.motion.velocity(wall, now, x[rows])
        return v

    def _moving(self, step: Floats, part: Floats) -> Iterator[tuple[window.Wall, int, Floats]]:
        """The rows whose parts move: those of one wall and step at a time."""
        wall = self.wall[part]
        for n, w in enumerate(self.setup.walls):
            rows = np.flatnonzero(wall == n) if w.motion in ("vibrates", "slides", "turns") else np.zeros(0, int)
            rows = rows[np.argsort(step[rows], kind="stable")]
            for at in np.split(rows, np.flatnonzero(np.diff(step[rows])) + 1) if len(rows) else []:
                yield w, int(step[at[0]]), at

    def near(self, step: int, x: Floats, reach: Floats, more: Floats) -> tuple[Floats, Floats]:
        """Pairs of a sphere (its row) and a part whose bounds are nearer than `reach` of the one and `more` of the other."""
        found = []
        for n, w in enumerate(self.setup.walls):
            parts = np.flatnonzero(self.wall == n)
            if not len(parts):
                continue
            y = self.motion.to_rest(w, step, x)[:, None]
            d = np.maximum(np.maximum(self.low[parts] - y, y - self.high[parts]), 0.0)
            a, p = np.nonzero((d**2).sum(axis=2) < (reach[:, None] + more[parts]) ** 2)
            found.append((a, parts[p]))
        none = np.zeros(0, np.int64)
        return (np.concatenate([none, *(f[0] for f in found)]), np.concatenate([none, *(f[1] for f in found)]))

    def closest(
        self, step: Floats, x: Floats, part: Floats, values: Floats | None = None, which: Floats | None = None,
        reach: Floats | None = None,
    ) -> Closest:  # fmt: skip
        """Closest points of parts to points x, row by row; `values` of all triangles, of which row k takes those in which[k].

        What is farther than `reach` is not looked for: triangle -1.
        """
        which = np.zeros(len(x), np.int64) if which is None else which
        values = np.zeros((1, len(self.bounds))) if values is None else values
        y, distance = self.rest(step, x, part), np.full(len(x), np.inf) if reach is None else reach * (1.0 + SAME)
        point, triangle, least = np.full((len(x), 3), np.nan), np.zeros(len(x), np.int64), np.zeros(len(x))
        shape, scratch = (
            (self.first, self.order, self.setup.corners, self.bounds),
            (np.zeros(len(self.bounds)), np.zeros(3)),
        )
        _closest(y, part, shape, values, which, scratch, (distance, point, triangle, least))
        return Closest(distance, self.rest(step, point, part, back=True), triangle, least)

    def to(self, step: Floats, x: Floats, triangle: Floats) -> tuple[Floats, Floats]:
        """Distance of points from triangles, and the closest point in the world."""
        part = self.setup.part[triangle]
        y = self.rest(step, x, part)
        q = mesh.closest_point(y, self.setup.corners[triangle])
        return size(y - q), self.rest(step, q, part, back=True)


@njit(cache=True, error_model="numpy")
def _closest(y: Any, part: Any, shape: Any, values: Any, which: Any, scratch: Any, found: Any) -> None:
    """Row by row, points y as the meshes at rest see them."""
    first, order, corners, bounds = shape
    apart, q = scratch
    distance, point, triangle, least = found
    for n in range(len(y)):
        best, start, end = distance[n], first[part[n]], first[part[n] + 1]
        for k in range(start, end):
            t, to_bounds = order[k], 0.0
            for axis in range(3):
                off = max(bounds[t, 0, axis] - y[n, axis], y[n, axis] - bounds[t, 1, axis], 0.0)
                to_bounds += off * off
            apart[k] = np.inf
            if to_bounds > (best * (1.0 + 2.0 * SAME)) ** 2:
                continue
            apart[k] = np.sqrt(mesh.closest_on(y[n], corners[t], q))
            if apart[k] < best:
                best = apart[k]
                point[n, 0], point[n, 1], point[n, 2] = q[0], q[1], q[2]
        distance[n], triangle[n], least[n] = best, -1, np.inf
        for k in range(start, end):
            if apart[k] <= best * (1.0 + SAME):
                triangle[n] = order[k] if triangle[n] < 0 else triangle[n]
                least[n] = min(least[n], values[which[n], order[k]])


def parts(run: Run) -> Parts:
    """Those of a run, made once."""
    if "parts" not in run.known:
        run.known["parts"] = Parts(window.read(run.folder))
    found: Parts = run.known["parts"]
    return found
