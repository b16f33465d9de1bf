"""Closest points of wall parts to spheres at any steps: for bridges, formations, the triangle that receives liquid, snapshots.

Rows of any steps are processed together; the distance of a triangle is computed only if its bounds permit it to be
the closest.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from reference_impl.compiled import compiled
from reference_impl.motion import window
from reference_impl.motion.wall_motion import Motion
from reference_impl.replay import images
from reference_impl.replay.arrays import Floats, size
from reference_impl.replay.io import Run

SAME = 1e-9
"""Relative difference of distances below which two triangles count as equally near, as next to an edge."""


class Closest(NamedTuple):
    """Distance, closest point and triangle (the first of equally near ones) of a wall part for each row."""

    distance: Floats
    point: Floats
    triangle: Floats


class Near(NamedTuple):
    """Distance and closest triangle of a wall part for each row, and the smallest of given values over equally near triangles."""

    distance: Floats
    triangle: Floats
    least: Floats


class Parts:
    """All wall parts of a run."""

    def __init__(self, setup: window.Setup, box: images.Images | None = None) -> None:
        self.setup, self.motion = setup, Motion(setup)
        part, corners = setup.part, setup.corners
        self.order = np.argsort(part, kind="stable")
        count = int(part.max(initial=-1)) + 1
        self.first = np.searchsorted(part[self.order], np.arange(count + 1))
        self.bounds = np.stack([corners.min(axis=1, initial=np.inf), corners.max(axis=1, initial=-np.inf)], axis=1)
        self.low, self.high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
        np.minimum.at(self.low, part, self.bounds[:, 0])
        np.maximum.at(self.high, part, self.bounds[:, 1])
        self._shape = (self.first, self.order, corners, self.bounds)
        self.others = box.others() if box else []
        self.wall = np.zeros(count, np.int64)
        for n, wall in enumerate(setup.walls):
            self.wall[part[wall.first : wall.last]] = n

    def __len__(self) -> int:
        return len(self.wall)

    def rest(self, step: Floats, x: Floats, part: Floats, back: bool = False) -> Floats:
        """Transform points from the world to the rest frame of a part's mesh; `back`: the inverse."""
        y = x.copy()
        move = self.motion.to_world if back else self.motion.to_rest
        for wall, now, rows in self._moving(step, part):
            y[rows] = move(wall, now, x[rows])
        return y

    def velocity(self, step: Floats, x: Floats, part: Floats) -> Floats:
        """Return the velocities of points of parts [m/s]."""
        v = np.zeros_like(x)
        for wall, now, rows in self._moving(step, part):
            v[rows] = self.motion.velocity(wall, now, x[rows])
        return v

    def _moving(self, step: Floats, part: Floats) -> Iterator[tuple[window.Wall, int, Floats]]:
        """Yield the rows whose parts move: those of one wall and step at a time."""
        wall = self.wall[part]
        for n, w in enumerate(self.setup.walls):
            rows = (
                np.flatnonzero(wall == n)
                if w.motion in ("vibrates", "slides", "turns", window.RECORDED)
                else np.zeros(0, int)
            )
            rows = rows[np.argsort(step[rows], kind="stable")]
            for at in np.split(rows, np.flatnonzero(np.diff(step[rows])) + 1) if len(rows) else []:
                yield w, int(step[at[0]]), at

    def within(self, step: int, x: Floats, reach: Floats, values: Floats) -> tuple[Floats, Floats, Near]:
        """Return pairs of a sphere (its row) and a part that are nearer than `reach` plus the largest of the part's values."""
        most = np.full(len(self), -np.inf)
        np.maximum.at(most, self.setup.part, values)
        found = []
        for n, w in enumerate(self.setup.walls):
            parts = np.flatnonzero(self.wall == n)
            for shift in ([0.0], *self.others):
                y = self.motion.to_rest(w, step, x + shift)
                found.append(_within(y, reach, parts, most, self.low, self.high, self._shape, values))
        whole, real = (np.concatenate([np.zeros((0, n)), *(f[k] for f in found)]) for k, n in ((0, 3), (1, 2)))
        if self.others:  # the nearest of several periodic copies of a part
            order = np.lexsort((real[:, 0], whole[:, 1], whole[:, 0]))
            whole, real = whole[order], real[order]
            first = np.append(True, (np.diff(whole[:, :2], axis=0) != 0).any(axis=1))[: len(whole)]
            whole, real = whole[first], real[first]
        a, part, triangle = whole.astype(np.int64).T
        return a, part, Near(real[:, 0], triangle, real[:, 1])

    def closest(self, step: Floats, x: Floats, part: Floats) -> Closest:
        """Return the closest points of parts to points x, row by row."""
        y, count = self.rest(step, x, part), len(x)
        distance, point, triangle = np.zeros(count), np.zeros((count, 3)), np.zeros(count, np.int64)
        _closest(y, part, self._shape, distance, point, triangle)
        found = Closest(distance, self.rest(step, point, part, back=True), triangle)
        for shift in self.others:
            self._copy(step, x, part, shift, found)
        return found

    def _copy(self, step: Floats, x: Floats, part: Floats, shift: Floats, found: Closest) -> None:
        """Replace the closest points found by those of a copy of the parts, displaced by `shift`, where the copy is nearer."""
        y = self.rest(step, x + shift, part)
        off = size(np.maximum(np.maximum(self.low[part] - y, y - self.high[part]), 0.0))
        rows = np.flatnonzero(off < found.distance)
        distance, point, triangle = np.zeros(len(rows)), np.zeros((len(rows), 3)), np.zeros(len(rows), np.int64)
        _closest(y[rows], part[rows], self._shape, distance, point, triangle)
        nearer = distance < found.distance[rows]
        at, point = rows[nearer], self.rest(step[rows], point, part[rows], back=True)
        found.distance[at], found.point[at], found.triangle[at] = (
            distance[nearer],
            point[nearer] - shift,
            triangle[nearer],
        )

    def goes_on(self, step: Floats, x: Floats, part: Floats, foot: Floats, near: Floats, least: Floats) -> Floats:
        """Return whether parts continue at their points `foot` towards x.

        One of their triangles within `near` of the foot must have its closest point to x farther than `least`
        from it.
        """
        y, q = self.rest(step, x, part), self.rest(step, foot, part)
        found = np.zeros(len(part), dtype=bool)
        for row, n in enumerate(part):
            corners = self.setup.corners[self.order[self.first[n] : self.first[n + 1]]]
            at = size(q[row] - closest_point(np.broadcast_to(q[row], (len(corners), 3)), corners)) <= near[row]
            to = closest_point(np.broadcast_to(y[row], (int(at.sum()), 3)), corners[at])
            found[row] = (size(q[row] - to) > least[row]).any()
        return found

    def to(self, step: Floats, x: Floats, triangle: Floats) -> tuple[Floats, Floats]:
        """Return the distance of points from triangles, and the closest point in world coordinates."""
        part = self.setup.part[triangle]
        y = self.rest(step, x, part)
        q = closest_point(y, self.setup.corners[triangle])
        distance, point = size(y - q), self.rest(step, q, part, back=True)
        for shift in self.others:
            y = self.rest(step, x + shift, part)
            q = closest_point(y, self.setup.corners[triangle])
            other, nearer = size(y - q), size(y - q) < distance
            point = np.where(nearer[:, None], self.rest(step, q, part, back=True) - shift, point)
            distance = np.where(nearer, other, distance)
        return distance, point


@compiled
def closest_on(p: Any, t: Any, best: Any) -> float:
    """Return the squared distance of a point from a triangle t (3, 3); `best` becomes its closest point.

    This is the foot in the plane if inside, otherwise the closest on the three edges.
    """
    ux, uy, uz = t[1, 0] - t[0, 0], t[1, 1] - t[0, 1], t[1, 2] - t[0, 2]
    vx, vy, vz = t[2, 0] - t[0, 0], t[2, 1] - t[0, 1], t[2, 2] - t[0, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    lift = ((p[0] - t[0, 0]) * nx + (p[1] - t[0, 1]) * ny + (p[2] - t[0, 2]) * nz) / (nx * nx + ny * ny + nz * nz)
    fx, fy, fz = p[0] - lift * nx, p[1] - lift * ny, p[2] - lift * nz
    inside, least = True, np.inf
    for k in range(3):
        u, v = t[k], t[(k + 1) % 3]
        ex, ey, ez = v[0] - u[0], v[1] - u[1], v[2] - u[2]
        dx, dy, dz = fx - u[0], fy - u[1], fz - u[2]
        turn = (ey * dz - ez * dy) * nx + (ez * dx - ex * dz) * ny + (ex * dy - ey * dx) * nz
        inside = inside and turn >= 0.0
        share = ((p[0] - u[0]) * ex + (p[1] - u[1]) * ey + (p[2] - u[2]) * ez) / (ex * ex + ey * ey + ez * ez)
        share = min(max(share, 0.0), 1.0)
        qx, qy, qz = u[0] + share * ex, u[1] + share * ey, u[2] + share * ez
        d = (p[0] - qx) ** 2 + (p[1] - qy) ** 2 + (p[2] - qz) ** 2
        if d < least:
            least, best[0], best[1], best[2] = d, qx, qy, qz
    if inside:
        best[0], best[1], best[2] = fx, fy, fz
        least = (p[0] - fx) ** 2 + (p[1] - fy) ** 2 + (p[2] - fz) ** 2
    return least


@compiled
def _closest_points(p: Any, t: Any, found: Any) -> None:
    for n in range(len(p)):
        closest_on(p[n], t[n], found[n])


def closest_point(p: Floats, t: Floats) -> Floats:
    """Return the closest points of triangles t (n, 3, 3) to points p (n, 3)."""
    found = np.empty((len(p), 3))
    _closest_points(p, t, found)
    return found


@compiled
def _to_bounds(y: Any, low: Any, high: Any) -> float:
    """Return the squared distance of a point from a box."""
    square = 0.0
    for axis in range(3):
        off = max(low[axis] - y[axis], y[axis] - high[axis], 0.0)
        square += off * off
    return square


@compiled
def _look(y: Any, part: int, shape: Any, best: float, apart: Any, q: Any, point: Any) -> float:
    """Return the smallest distance of a part from a point y in the rest frame of its mesh, if below `best`.

    `apart` becomes the distance of each of the part's triangles that can be the closest, `point` that of the
    closest one.
    """
    first, order, corners, bounds = shape
    for k in range(first[part], first[part + 1]):
        t, apart[k] = order[k], np.inf
        if _to_bounds(y, bounds[t, 0], bounds[t, 1]) > (best * (1.0 + 2.0 * SAME)) ** 2:
            continue
        apart[k] = np.sqrt(closest_on(y, corners[t], q))
        if apart[k] < best:
            best, point[:] = apart[k], q
    return best


@compiled
def _closest(y: Any, part: Any, shape: Any, distance: Any, point: Any, triangle: Any) -> None:
    """Find the closest point and triangle of a wall part for each point."""
    first, order = shape[0], shape[1]
    apart, q = np.empty(len(order)), np.empty(3)
    for n in range(len(y)):
        distance[n] = _look(y[n], part[n], shape, np.inf, apart, q, point[n])
        for k in range(first[part[n]], first[part[n] + 1]):
            if apart[k] <= distance[n] * (1.0 + SAME):
                triangle[n] = order[k]
                break


@compiled
def _within(
    y: Any, reach: Any, parts: Any, more: Any, low: Any, high: Any, shape: Any, values: Any
) -> tuple[Any, Any]:  # fmt: skip
    """Return numbers of sphere, part and triangle, distance and smallest value, of all pairs that are near."""
    first, order = shape[0], shape[1]
    apart, q, point = np.empty(len(order)), np.empty(3), np.empty(3)
    whole, real, count = np.empty((len(y), 3), np.int64), np.empty((len(y), 2)), 0
    lowest, highest, most = np.full(3, np.inf), np.full(3, -np.inf), -np.inf
    for p in parts:
        lowest, highest, most = np.minimum(lowest, low[p]), np.maximum(highest, high[p]), max(most, more[p])
    for n in range(len(y)):
        if _to_bounds(y[n], lowest, highest) >= (reach[n] + most) ** 2:
            continue
        for p in parts:
            far = reach[n] + more[p]
            if _to_bounds(y[n], low[p], high[p]) >= far * far:
                continue
            best = _look(y[n], p, shape, far, apart, q, point)
            if best >= far:
                continue
            if count == len(whole):
                whole, real = np.concatenate((whole, whole)), np.concatenate((real, real))
            whole[count, 2], real[count, 1] = -1, np.inf
            for k in range(first[p], first[p + 1]):
                if apart[k] <= best * (1.0 + SAME):
                    whole[count, 2] = order[k] if whole[count, 2] < 0 else whole[count, 2]
                    real[count, 1] = min(real[count, 1], values[order[k]])
            whole[count, 0], whole[count, 1], real[count, 0] = n, p, best
            count += 1
    return whole[:count], real[:count]


def parts(run: Run) -> Parts:
    """Return the wall parts of a run, made at the first call."""
    if "parts" not in run.known:
        run.known["parts"] = Parts(window.read(run.folder), images.of(run.folder))
    found: Parts = run.known["parts"]
    return found
