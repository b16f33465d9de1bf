"""Divide triangles that are too sharp for the engine without changing the surface: edges flipped within a plane, or split."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SMALLEST_ANGLE_DEG = 0.5
"""Smallest angle [deg] of a triangle, below which LIGGGHTS warns.

It stops below 0.2562 deg, arccos(1 - `EPSILON_CURVATURE`) in its surface_mesh.h.
"""
FLAT_M = 2e-8
"""Distance [m] from a plane below which corners count as coplanar: rounding to single precision in a scene of 0.3 m."""
SHORTEST_M = 2e-6
"""Shortest edge of a triangle that is divided, so that no corners come so close that the engine merges them."""
MOST_ROUNDS = 60
"""Largest number of rounds, each of which halves the longest sharp triangles; 2^60 exceeds any mesh."""
MOST_TRIANGLES = 20_000
"""Largest number of triangles made: more would take minutes, and no realistic wall needs them."""
Edge = tuple[int, int]


def angles_deg(corners: Floats) -> Floats:
    """Return the three angles of triangles (m, 3, 3), shape (m, 3) [deg]."""
    forward = np.roll(corners, -1, axis=1) - corners
    backward = np.roll(corners, 1, axis=1) - corners
    across = np.linalg.norm(np.cross(forward, backward), axis=2)
    along = np.einsum("ijk,ijk->ij", forward, backward)
    return np.asarray(np.degrees(np.arctan2(across, along)), dtype=np.float64)


def divided(points: Floats, triangles: Ints, face: Ints) -> tuple[Floats, Ints, Ints]:
    """Divide a surface so that, if possible, no triangle is sharper than the engine allows.

    The result is points, triangles and `face` (m,) of the same surface. Coplanar triangles of one face exchange
    their common edge if that makes them less sharp; then edges of triangles that are still too sharp are halved,
    in both triangles of an edge, so that the surface remains closed. A corner of a face that is itself sharper
    than the limit is unchanged, and so is the whole surface if too many triangles would result.
    """
    least = angles_deg(points[triangles]).min(axis=1)
    if (SMALLEST_ANGLE_DEG / np.maximum(least[least < SMALLEST_ANGLE_DEG], 1e-30)).sum() > MOST_TRIANGLES:
        return points, triangles, face
    mesh = _Mesh(points, triangles, face)
    for _ in range(MOST_ROUNDS):
        mesh.flip()
        sharp = mesh.sharp()
        if not sharp or len(mesh.triangles) > MOST_TRIANGLES or not mesh.split(sharp):
            break
    order = np.argsort(mesh.face, kind="stable")
    return np.array(mesh.points), np.array(mesh.triangles, dtype=np.int64)[order], np.array(mesh.face)[order]


class _Mesh:
    """Triangles with their edges as lists, which suffice because only meshes with slivers are processed here."""

    def __init__(self, points: Floats, triangles: Ints, face: Ints) -> None:
        self.points = [p for p in np.asarray(points, dtype=np.float64)]
        self.triangles = [tuple(t) for t in np.asarray(triangles).tolist()]
        self.face = np.asarray(face).tolist()
        self.of_edge: dict[Edge, set[int]] = defaultdict(set)
        for k, t in enumerate(self.triangles):
            for edge in _edges(t):
                self.of_edge[edge].add(k)
        self.touched = set(self.sharp())

    def sharp(self) -> list[int]:
        """List the triangles whose smallest angle is below the limit of the engine."""
        if not self.triangles:
            return []
        least = angles_deg(np.array(self.points)[np.array(self.triangles)]).min(axis=1)
        return np.flatnonzero(least < SMALLEST_ANGLE_DEG).tolist()

    def flip(self) -> None:
        """Exchange common edges of two coplanar triangles as long as their smallest angle grows."""
        waiting = [edge for k in self.touched for edge in _edges(self.triangles[k])]
        self.touched.clear()
        for _ in range(20 * len(waiting) + 100):
            if not waiting:
                return
            edge = waiting.pop()
            waiting += self._flip(edge)

    def _flip(self, edge: Edge) -> list[Edge]:
        """Return the edges around a pair of triangles whose common edge was exchanged; none if it was not."""
        pair = sorted(self.of_edge.get(edge, ()))
        if len(pair) != 2 or self.face[pair[0]] != self.face[pair[1]]:
            return []
        first, second = (self.triangles[k] for k in pair)
        a = next(p for p in first if p not in edge)
        b = next(p for p in second if p not in edge)
        here = first.index(a)
        start, end = first[(here + 1) % 3], first[(here + 2) % 3]
        new = (a, start, b), (a, b, end)
        if a == b or _pair(a, b) in self.of_edge or not self._in_plane(first, b):
            return []
        before, after = self._corners([first, second]), self._corners(new)
        normal = np.cross(before[0, 1] - before[0, 0], before[0, 2] - before[0, 0])
        turned = np.cross(after[:, 1] - after[:, 0], after[:, 2] - after[:, 0]) @ normal
        if (turned <= 0.0).any() or angles_deg(after).min() <= 1.000001 * angles_deg(before).min():
            return []
        for k, t in zip(pair, new, strict=True):
            self._replace(k, t)
        return [e for t in new for e in _edges(t)]

    def split(self, sharp: list[int]) -> bool:
        """Halve an edge of each sharp triangle; return False if none can be halved."""
        chosen = {self._longest(k) for k in sharp} - {None}
        for edge in sorted(e for e in chosen if e is not None):
            middle = len(self.points)
            half = 0.5 * (self.points[edge[0]] + self.points[edge[1]])
            self.points.append(half.astype(np.float32).astype(np.float64))
            for k in sorted(self.of_edge.pop(edge)):
                t = self.triangles[k]
                at = next(n for n in range(3) if _pair(t[n], t[(n + 1) % 3]) == edge)
                p, q, r = t[at], t[(at + 1) % 3], t[(at + 2) % 3]
                self._replace(k, (p, middle, r))
                self.triangles.append((middle, q, r))
                self.face.append(self.face[k])
                self._enter(len(self.triangles) - 1)
                self.touched |= {k, len(self.triangles) - 1}
        return bool(chosen)

    def _longest(self, k: int) -> Edge | None:
        """Return the longest edge at which a face ends if it is at least half as long as the longest; else the longest."""
        edges = sorted(_edges(self.triangles[k]), key=lambda e: -self._length(e))
        ends = [e for e in edges if len({self.face[n] for n in self.of_edge[e]}) > 1 or not self._inside(e)]
        long = [e for e in ends if self._length(e) > 0.5 * self._length(edges[0])]
        edge = (long or edges)[0]
        return edge if self._length(edges[-1]) > SHORTEST_M else None

    def _inside(self, edge: Edge) -> bool:
        """Return whether the two triangles of an edge are coplanar."""
        pair = sorted(self.of_edge[edge])
        return len(pair) == 2 and self._in_plane(
            self.triangles[pair[0]], next(p for p in self.triangles[pair[1]] if p not in edge)
        )

    def _in_plane(self, triangle: tuple[int, ...], point: int) -> bool:
        a, b, c = self._corners([triangle])[0]
        normal = np.cross(b - a, c - a)
        size = float(np.linalg.norm(normal))
        # the plane of a sliver is only as accurate as its corners: three roundings at its height
        height = size / max(float(np.linalg.norm(p)) for p in (b - a, c - b, a - c))
        away = abs(float((self.points[point] - a) @ normal)) / size if size else np.inf
        lever = float(np.linalg.norm(self.points[point] - a)) / height if height else np.inf
        return away <= FLAT_M * (1.0 + min(lever, 50.0))

    def _corners(self, triangles: object) -> Floats:
        return np.array([[self.points[p] for p in t] for t in triangles])  # type: ignore[attr-defined]

    def _length(self, edge: Edge) -> float:
        return float(np.linalg.norm(self.points[edge[0]] - self.points[edge[1]]))

    def _replace(self, k: int, triangle: tuple[int, ...]) -> None:
        for edge in _edges(self.triangles[k]):
            if edge in self.of_edge:
                self.of_edge[edge].discard(k)
                if not self.of_edge[edge]:
                    del self.of_edge[edge]
        self.triangles[k] = triangle
        self._enter(k)

    def _enter(self, k: int) -> None:
        for edge in _edges(self.triangles[k]):
            self.of_edge[edge].add(k)


def _pair(a: int, b: int) -> Edge:
    return (a, b) if a < b else (b, a)


def _edges(triangle: tuple[int, ...]) -> tuple[Edge, Edge, Edge]:
    a, b, c = triangle
    return _pair(a, b), _pair(b, c), _pair(c, a)
