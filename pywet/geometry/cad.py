"""Read STL files written by CAD programs: unambiguous faults are repaired and reported, others refused with their position."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy

from pywet.errors import PywetError
from pywet.geometry.stl import corners_in
from pywet.geometry.surface import SAME_POINT_M, Floats, Ints, enclosed, inside

EXPORT_ROUNDING_M = 1e-6
"""Distance below which vertices of an open surface are merged, since exports round them."""
APART_M = 2e-6
"""Distance by which a body is withdrawn from an edge or corner that it shares with another one."""
FARTHEST_M = 1e6
"""Largest plausible coordinate; larger ones indicate a damaged file."""


def read_cad(
    path: Path, unit_m: float, origin_m: Floats | None = None, shell_m: float | None = None
) -> tuple[Floats, list[str]]:
    """Return corners (m, 3, 3) [m] of closed bodies with outward normals, and a list of repairs.

    `origin_m` is subtracted in double precision. An open shell becomes a wall of the thickness `shell_m`, half on either side.
    Raises `PywetError` if the enclosed volume is ambiguous.
    """
    corners, changes = corners_in(path)
    corners = corners * unit_m - (np.zeros(3) if origin_m is None else origin_m)
    if not len(corners) or not np.abs(corners).max() <= FARTHEST_M:  # also false for NaN
        raise PywetError(
            f"{path} holds {len(corners)} triangles, expected at least four with corners at most {FARTHEST_M:g} m from the "
            "origin; export it again",
            code="stl.far", where=path,
        )  # fmt: skip
    mesh = _Mesh(path, corners, changes)
    mesh.weld(SAME_POINT_M)
    if len(mesh.open_edges()):
        mesh.weld(EXPORT_ROUNDING_M)
    mesh.clean()
    mesh.orient()
    if len(mesh.open_edges()):
        if shell_m is None:
            raise PywetError(mesh.not_closed(), code="stl.not_closed", where=path)
        mesh.thicken(shell_m)
    elif shell_m is not None:
        raise PywetError(
            f"{path} is closed, so that shell_thickness_mm has no effect; expected an open shell, or no shell_thickness_mm",
            code="stl.closed", where=path,
        )  # fmt: skip
    mesh.outward()
    mesh.part_bodies()
    return mesh.points[mesh.triangles], changes


class _Mesh:
    """Points and triangles of a file under repair."""

    def __init__(self, path: Path, corners: Floats, changes: list[str]) -> None:
        self.path, self.changes = path, changes
        self.points, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
        self.triangles: Ints = index.reshape(-1, 3).astype(np.int64)

    def weld(self, tolerance: float) -> None:
        """Merge points nearer than a tolerance, at their mean."""
        pairs = scipy.spatial.cKDTree(self.points).query_pairs(tolerance, output_type="ndarray")
        if not len(pairs):
            return
        n = len(self.points)
        links = scipy.sparse.coo_array((np.ones(len(pairs)), pairs.T), shape=(n, n))
        groups, label = scipy.sparse.csgraph.connected_components(links, directed=False)
        mean = np.stack([np.bincount(label, self.points[:, k]) for k in range(3)], axis=1) / np.bincount(label)[:, None]
        self.points, self.triangles = mean, label[self.triangles].astype(np.int64)
        self.changes.append(f"joined {n - groups} vertices nearer than {1e6 * tolerance:.3g} um to another")

    def clean(self) -> None:
        """Remove facets of zero area, repeated ones and pairs of opposite facets within touching solids."""
        self._divide_neighbours()
        self._keep(self._area() > 0.0, "facets without area")
        ordered = np.sort(self.triangles, axis=1)
        _, first, group, count = np.unique(ordered, axis=0, return_index=True, return_inverse=True, return_counts=True)
        if (count > 1).any():
            turn = self._parity(ordered)
            net = np.abs(np.bincount(group.ravel(), turn))
            keep = np.zeros(len(ordered), dtype=bool)
            keep[first] = (net > 0) | (count == 1)
            back = int(((net == 0) & (count > 1)).sum())
            if back:
                self.changes.append(f"removed {back} pairs of facets back to back, where solids touch")
            doubled = len(ordered) - int(keep.sum()) - 2 * back
            if doubled:
                self.changes.append(f"removed {doubled} repeated facets")
            self.triangles = self.triangles[keep]

    def _divide_neighbours(self) -> None:
        """Divide facets at a corner of a facet without area on their edge, if removing that facet opened the surface."""
        flat, count = set(np.flatnonzero(self._area() == 0.0).tolist()), 0
        while done := {face for face in flat if self._divide_neighbour(face, flat)}:
            flat, count = flat - done, count + len(done)
        if count:
            self.changes.append(f"divided {count} facets at the corner of a facet without area")

    def _divide_neighbour(self, face: int, flat: set[int]) -> bool:
        """Divide the neighbour at the longest edge of a facet, which becomes its other part; False if there is none."""
        corners = self.points[self.triangles[face]]
        longest = int(np.argmax(np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)))
        a, b, middle = np.roll(self.triangles[face], -longest).tolist()
        of_a, of_b, of_middle = ((self.triangles == point).any(axis=1) for point in (a, b, middle))
        others = np.setdiff1d(np.flatnonzero(of_a & of_b), [face])
        closes = min((of_a & of_middle).sum(), (of_b & of_middle).sum()) > 1
        if len({a, b, middle}) < 3 or not closes or len(others) != 1 or int(others[0]) in flat:
            return False
        whole = self.triangles[others[0]].copy()
        self.triangles[face] = np.where(whole == a, middle, whole)
        self.triangles[others[0]] = np.where(whole == b, middle, whole)
        return True

    def orient(self) -> None:
        """Reverse facets whose neighbours in a body all have the opposite orientation."""
        edges, face = self._edges()
        ordered = np.sort(edges, axis=1)
        order = np.lexsort((face, ordered[:, 1], ordered[:, 0]))
        edges, ordered, face = edges[order], ordered[order], face[order]
        _, start, count = np.unique(ordered, axis=0, return_index=True, return_counts=True)
        pair = start[count == 2]
        a, b = face[pair], face[pair + 1]
        same = edges[pair, 0] == edges[pair + 1, 0]  # both have the same orientation: one is reversed
        n = len(self.triangles)
        # each facet occurs twice, as it is and reversed: facets that can be combined form one component
        rows, cols = np.concatenate([a, a + n]), np.concatenate([b + n * same, b + n * ~same])
        links = scipy.sparse.coo_array((np.ones(len(rows)), (rows, cols)), shape=(2 * n, 2 * n))
        _, label = scipy.sparse.csgraph.connected_components(links, directed=False)
        if (label[:n] == label[n:]).any():
            at = self._at(self.points[self.triangles[int(np.argmax(label[:n] == label[n:]))]].mean(axis=0))
            raise PywetError(
                f"{self.path} does not separate inside from outside, such as at {at}; expected the surface of a solid",
                code="stl.not_solid", where=self.path,
            )  # fmt: skip
        body = np.unique(np.minimum(label[:n], label[n:]), return_inverse=True)[1]
        turned = label[:n] > label[n:]
        share = np.bincount(body, turned) / np.bincount(body)
        self._turn(turned ^ (share > 0.5)[body], "facets that looked the other way than their neighbours")

    def outward(self) -> None:
        """Reverse bodies that enclose a negative volume and are no cavity of another one."""
        label = self._bodies()
        corners = self.points[self.triangles]
        wrong = np.zeros(len(label), dtype=bool)
        for k in range(int(label.max()) + 1):
            of_body = label == k
            if enclosed(corners[of_body]) < 0.0 and not inside(corners[of_body][0].mean(axis=0), corners[~of_body]):
                wrong |= of_body
        self._turn(wrong, "facets of a solid that was inside out")

    def part_bodies(self) -> None:
        """Withdraw bodies from points that they share, since the engine would treat them as one."""
        label = self._bodies()
        pairs = np.unique(np.stack([self.triangles.ravel(), np.repeat(label, 3)], axis=1), axis=0)
        shared = np.flatnonzero(np.bincount(pairs[:, 0], minlength=len(self.points)) > 1)
        for point in shared:
            for body in pairs[pairs[:, 0] == point, 1][1:]:
                of_body = np.flatnonzero(label == body)
                middle = self.points[np.unique(self.triangles[of_body])].mean(axis=0)
                away = middle - self.points[point]
                self.points = np.vstack([self.points, self.points[point] + APART_M * away / np.linalg.norm(away)])
                rows = self.triangles[of_body]
                self.triangles[of_body] = np.where(rows == point, len(self.points) - 1, rows)
        if len(shared):
            self.changes.append(f"drew bodies {1e6 * APART_M:g} um apart at {len(shared)} vertices that they share")

    def thicken(self, thickness: float) -> None:
        """Make a shell a wall of this thickness, half on either side; its free edges become rims."""
        edges, _ = self._edges()
        if np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)[1].max() > 2:
            raise PywetError(
                f"{self.path} is a shell in which more than two facets meet in an edge; expected one sheet per file",
                code="stl.shell", where=self.path,
            )  # fmt: skip
        corners = self.points[self.triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        away = np.zeros_like(self.points)
        for point in np.unique(self.triangles):  # at half the thickness from every facet around a point
            around = np.unique(normal[(self.triangles == point).any(axis=1)].round(6), axis=0)
            away[point] = 0.5 * thickness * np.linalg.lstsq(around, np.ones(len(around)), rcond=0.05)[0]
        n, free = len(self.points), self._free(edges)
        a, b = free.T
        rims = np.concatenate([np.stack([b, a, a + n], axis=1), np.stack([b, a + n, b + n], axis=1)])
        self.points = np.concatenate([self.points + away, self.points - away])
        self.triangles = np.concatenate([self.triangles, self.triangles[:, ::-1] + n, rims])
        self.changes.append(f"made its open shell a wall of {1e3 * thickness:g} mm, half on either side")

    def open_edges(self) -> Ints:
        """Return the edges (n, 2) that are not used equally often in both directions."""
        return self._free(self._edges()[0])

    def not_closed(self) -> str:
        """Find two positions at which a surface is open."""
        edges = self.open_edges()
        middle = self.points[edges].mean(axis=1)
        places = " and ".join(self._at(p) for p in middle[[0, -1]][: len(edges)])
        return (
            f"{self.path} is an open shell: not closed at {len(edges)} edges, such as at {places}; expected a closed solid, "
            "or its thickness, shell_thickness_mm of the wall"
        )

    def _free(self, edges: Ints) -> Ints:
        n = len(self.points)
        key, back = edges[:, 0] * n + edges[:, 1], edges[:, 1] * n + edges[:, 0]
        lone = ~np.isin(key, back)
        return edges[lone]

    def _edges(self) -> tuple[Ints, Ints]:
        edges = np.stack([self.triangles, np.roll(self.triangles, -1, axis=1)], axis=2).reshape(-1, 2)
        return edges, np.repeat(np.arange(len(self.triangles)), 3)

    def _bodies(self) -> Ints:
        """Return the body of every triangle: triangles connected by edges that two of them share."""
        edges, face = self._edges()
        ordered = np.sort(edges, axis=1)
        order = np.lexsort((ordered[:, 1], ordered[:, 0]))
        _, start, count = np.unique(ordered[order], axis=0, return_index=True, return_counts=True)
        pair = start[count == 2]
        a, b = face[order][pair], face[order][pair + 1]
        n = len(self.triangles)
        links = scipy.sparse.coo_array((np.ones(len(a)), (a, b)), shape=(n, n))
        return np.asarray(scipy.sparse.csgraph.connected_components(links, directed=False)[1], dtype=np.int64)

    def _keep(self, keep: np.ndarray, what: str) -> None:
        if not keep.all():
            self.changes.append(f"removed {int((~keep).sum())} {what}")
            self.triangles = self.triangles[keep]

    def _turn(self, which: np.ndarray, what: str) -> None:
        if which.any():
            self.changes.append(f"turned {int(which.sum())} {what}")
            self.triangles[which] = self.triangles[which][:, ::-1]

    def _area(self) -> Floats:
        a, b, c = np.moveaxis(self.points[self.triangles], 1, 0)
        long = np.maximum.reduce(
            [np.linalg.norm(b - a, axis=1), np.linalg.norm(c - b, axis=1), np.linalg.norm(a - c, axis=1)]
        )
        height = np.linalg.norm(np.cross(b - a, c - a), axis=1) / np.where(long > 0.0, long, 1.0)
        return np.where(height > SAME_POINT_M, height, 0.0)

    def _parity(self, ordered: Ints) -> Floats:
        """Return 1 for facets that run through their sorted corners in order, otherwise -1."""
        first = np.argmax(self.triangles == ordered[:, :1], axis=1)
        following = np.take_along_axis(self.triangles, ((first + 1) % 3)[:, None], axis=1)[:, 0]
        return np.where(following == ordered[:, 1], 1.0, -1.0)

    @staticmethod
    def _at(point: Floats) -> str:
        return "(" + ", ".join(f"{1e3 * x:.4g}" for x in point) + ") mm"
