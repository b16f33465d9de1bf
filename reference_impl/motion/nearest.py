"""Closest points of wall parts to spheres at any steps: for bridges, formations, the triangle that gets liquid, snapshots.

Rows of any steps are taken together; a triangle is looked at in full only where its bounds leave it a chance.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from reference_impl.motion import mesh, window
from reference_impl.motion.wall_motion import Motion
from reference_impl.replay.arrays import Floats, size
from reference_impl.replay.io import Run

CHUNK = 2_000_000
"""Pairs of a row and a triangle that are looked at together."""
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


class Parts:
    """All wall parts of a run."""

    def __init__(self, setup: window.Setup) -> None:
        self.setup, self.motion = setup, Motion(setup)
        part, corners = setup.part, setup.corners
        self.order = np.argsort(part, kind="stable")
        count = int(part.max(initial=-1)) + 1
        self.first = np.searchsorted(part[self.order], np.arange(count + 1))
        self.middle = corners.mean(axis=1)
        self.extent = np.sqrt(((corners - self.middle[:, None]) ** 2).sum(axis=2)).max(axis=1, initial=0.0)
        self.low, self.high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
        np.minimum.at(self.low, part, corners.min(axis=1, initial=np.inf))
        np.maximum.at(self.high, part, corners.max(axis=1, initial=-np.inf))
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
        self, step: Floats, x: Floats, part: Floats, values: Floats | None = None, which: Floats | None = None
    ) -> Closest:
        """Closest points of parts to points x, row by row; `values` of all triangles, of which row k takes those in which[k]."""
        which = np.zeros(len(x), np.int64) if which is None else which
        values = np.zeros((1, len(self.middle))) if values is None else values
        y, many = self.rest(step, x, part), self.first[part + 1] - self.first[part]
        distance, point, triangle = np.zeros(len(x)), np.zeros((len(x), 3)), np.zeros(len(x), np.int64)
        least = np.zeros(len(x))
        cuts = np.searchsorted(np.cumsum(many), np.arange(CHUNK, many.sum(), CHUNK))
        for rows in np.split(np.arange(len(x)), np.unique(cuts)):
            if len(rows):
                d, q, t, row = self._closest(y[rows], part[rows], many[rows])
                first = np.searchsorted(row, np.arange(len(rows)))
                distance[rows], triangle[rows] = np.minimum.reduceat(d, first), t[first]
                point[rows] = q[np.lexsort((d, row))[first]]
                least[rows] = np.minimum.reduceat(values[which[rows][row], t], first)
        return Closest(distance, self.rest(step, point, part, back=True), triangle, least)

    def _closest(self, y: Floats, part: Floats, many: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Distances, points and triangles that are closest, with the rows that they belong to: one of each row or more."""
        row, start = np.repeat(np.arange(len(y)), many), np.cumsum(many) - many
        t = self.order[np.repeat(self.first[part], many) + np.arange(len(row)) - np.repeat(start, many)]
        apart = size(y[row] - self.middle[t])
        # the middle belongs to the triangle, so nothing farther than it can be closest
        keep = apart - self.extent[t] <= np.minimum.reduceat(apart, start)[row] * (1.0 + 1e-12)
        row, t = row[keep], t[keep]
        q = mesh.closest_point(y[row], self.setup.corners[t])
        d = size(y[row] - q)
        first = np.searchsorted(row, np.arange(len(y)))
        near = d <= np.minimum.reduceat(d, first)[row] * (1.0 + SAME)
        return d[near], q[near], t[near], row[near]

    def to(self, step: Floats, x: Floats, triangle: Floats) -> tuple[Floats, Floats]:
        """Distance of points from triangles, and the closest point in the world."""
        part = self.setup.part[triangle]
        y = self.rest(step, x, part)
        q = mesh.closest_point(y, self.setup.corners[triangle])
        return size(y - q), self.rest(step, q, part, back=True)


def parts(run: Run) -> Parts:
    """Those of a run, made once."""
    if "parts" not in run.known:
        run.known["parts"] = Parts(window.read(run.folder))
    found: Parts = run.known["parts"]
    return found
