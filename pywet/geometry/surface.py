"""A closed triangulated surface whose triangles are grouped into parts, and the checks every wall must pass.

Coordinates are rounded to single precision when a surface is made, because binary STL, which the engine reads, has no
more digits: walls in Python and in the engine are then identical. `solids` builds shapes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from pywet.errors import PywetError
from pywet.geometry.slivers import SMALLEST_ANGLE_DEG, angles_deg, divided
from pywet.scene import Reservoir

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Motion = Literal["fixed", "vibrates", "slides", "turns"]

SAME_POINT_M = 2e-8
"""Distance per coordinate below which points are merged; LIGGGHTS uses 1e-8 m (`EPSILON_PRECISION`, multi_node_mesh.h)."""
LARGE_HALF_WIDTH_M = 0.005
"""Smaller half side from which on a flat part is a large wall: the largest sphere's radius (Elskamp 2.2.1)."""


LARGEST_M = 100.0
"""Largest size [m] of a wall: the resolution of single precision, in which the engine reads it, is then 8 um."""


@dataclass(frozen=True)
class Surface:
    """One wall mesh: `vertices` (n, 3) [m], `triangles` (m, 3), `part` (m,) and the half width of each part [m].

    Parts are numbered 0, 1, … in the order of the triangles; a half width None means a large wall.
    """

    name: str
    reservoir: Reservoir
    vertices: Floats
    triangles: Ints
    part: Ints
    part_half_width: tuple[float | None, ...]
    motion: Motion = "fixed"

    @property
    def corners(self) -> Floats:
        """Return the corner points of every triangle, shape (m, 3, 3) [m]."""
        return self.vertices[self.triangles]

    @property
    def area(self) -> Floats:
        """Return the area of every triangle, shape (m,) [m2]."""
        return np.asarray(0.5 * np.linalg.norm(self._cross(), axis=1), dtype=np.float64)

    @property
    def normals(self) -> Floats:
        """Return the outward unit normal of every triangle, shape (m, 3)."""
        cross = self._cross()
        return np.asarray(cross / np.linalg.norm(cross, axis=1)[:, None], dtype=np.float64)

    @property
    def angles_deg(self) -> Floats:
        """Return the three angles of every triangle, shape (m, 3) [deg]."""
        return angles_deg(self.corners)

    def components(self) -> tuple[int, Ints]:
        """Return the number of bodies not joined by a vertex, and the body of every triangle, shape (m,)."""
        first, second = self.triangles.ravel(), np.roll(self.triangles, -1, axis=1).ravel()
        n = len(self.vertices)
        links = scipy.sparse.coo_array((np.ones(len(first)), (first, second)), shape=(n, n))
        count, label = scipy.sparse.csgraph.connected_components(links, directed=False)
        return int(count), np.asarray(label, dtype=np.int64)[self.triangles[:, 0]]

    def _cross(self) -> Floats:
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return np.cross(b - a, c - a)


def enclosed(corners: Floats) -> float:
    """Return the volume within closed triangles (m, 3, 3) [m3]: the sum of signed tetrahedra to a point among them.

    Positive when the normals point outward; overlapping wires count twice.
    """
    a, b, c = np.moveaxis(corners - corners.reshape(-1, 3).mean(axis=0), 1, 0)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def inside(point: Floats, corners: Floats) -> bool:
    """Return whether a point lies within triangles: their solid angles about it add up to more than half a sphere."""
    if not len(corners):
        return False
    a, b, c = np.moveaxis(corners - point, 1, 0)
    x, y, z = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    of = np.einsum("ij,ij->i", a, np.cross(b, c))
    dots = [np.einsum("ij,ij->i", p, q) for p, q in ((a, b), (b, c), (c, a))]
    below = x * y * z + dots[0] * z + dots[1] * x + dots[2] * y
    return abs(float(np.arctan2(of, below).sum()) * 2.0) > 2.0 * np.pi


def make_surface(
    name: str,
    reservoir: Reservoir,
    parts: Sequence[tuple[Floats, float | None]],
    motion: Motion = "fixed",
) -> Surface:
    """Join parts, each the corner points of its triangles (m, 3, 3) [m] with its half width, into a checked surface.

    Triangles too sharp for the engine are divided.
    """
    corners = np.concatenate([c for c, _ in parts]).astype(np.float32).astype(np.float64)
    across = float(np.ptp(corners.reshape(-1, 3), axis=0).max()) if corners.size else 0.0
    if across > LARGEST_M:
        raise PywetError(
            f"surface {name} is {across:.4g} m large, expected at most {LARGEST_M:g} m: are its lengths in another unit?",
            code="surface.large", key=name, given=across, expected=LARGEST_M,
        )  # fmt: skip
    vertices, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    triangles = index.reshape(-1, 3).astype(np.int64)
    part = np.repeat(np.arange(len(parts)), [len(c) for c, _ in parts]).astype(np.int64)
    if len(triangles) and np.isfinite(vertices).all() and angles_deg(corners).min() < SMALLEST_ANGLE_DEG:
        _check_edges(name, vertices, triangles)  # an open surface has no inside
        vertices, triangles, part = divided(vertices, triangles, part)
    surface = Surface(
        name=name,
        reservoir=reservoir,
        vertices=vertices,
        triangles=triangles,
        part=part,
        part_half_width=tuple(h for _, h in parts),
        motion=motion,
    )
    check_surface(surface)
    return surface


def flat_half_width(shorter_side: float) -> float | None:
    """Return the half width of a flat part from the shorter of its sides [m]; None (a large wall) from 5 mm on."""
    half = 0.5 * shorter_side
    return None if half >= LARGE_HALF_WIDTH_M else round(half, 9)


def check_surface(surface: Surface) -> None:
    """Raise `PywetError` unless the surface is closed, oriented outward, free of slivers, its parts in order."""
    _check_parts(surface)
    _check_shape(surface)
    _check_edges(surface.name, surface.vertices, surface.triangles)
    count, body = surface.components()
    for k in range(count):
        of_body, others = surface.corners[body == k], surface.corners[body != k]
        volume = enclosed(of_body)
        cavity = volume < 0 and inside(of_body[0].mean(axis=0), others)  # its normals point inward
        if volume <= 0 and not cavity:
            raise PywetError(
                f"surface {surface.name}: its triangles enclose {volume:.3g} m3, expected a positive volume; "
                "reverse the triangles so that normals point outward",
                code="surface.inward", key=surface.name, given=volume,
            )  # fmt: skip


def _check_parts(surface: Surface) -> None:
    steps = np.diff(surface.part, prepend=0)
    parts = len(surface.part_half_width)
    if len(surface.triangles) == 0 or len(surface.part) != len(surface.triangles):
        raise PywetError(
            f"surface {surface.name}: {len(surface.triangles)} triangles with {len(surface.part)} part numbers, "
            "expected one part number for each of at least four triangles",
            code="surface.parts", key=surface.name,
        )  # fmt: skip
    if surface.part[0] != 0 or not np.isin(steps, (0, 1)).all() or surface.part[-1] != parts - 1:
        raise PywetError(
            f"surface {surface.name}: parts must be numbered 0 to {parts - 1} in the order of the triangles, "
            "one half width each; sort the triangles by part",
            code="surface.part_order", key=surface.name,
        )  # fmt: skip


def _check_shape(surface: Surface) -> None:
    if not np.isfinite(surface.vertices).all():
        raise PywetError(
            f"surface {surface.name}: a vertex is not finite; fix the mesh", code="surface.not_finite", key=surface.name
        )
    close = scipy.spatial.cKDTree(surface.vertices).query_pairs(SAME_POINT_M)
    if close:
        raise PywetError(
            f"surface {surface.name}: {len(close)} pairs of vertices are closer than {SAME_POINT_M:g} m; merge them",
            code="surface.close_vertices", key=surface.name, given=len(close),
        )  # fmt: skip
    smallest = surface.angles_deg.min(axis=1)
    if not smallest.min() >= SMALLEST_ANGLE_DEG:
        at = ", ".join(f"{x:.4g}" for x in 1e3 * surface.corners[int(np.argmin(smallest))].mean(axis=0))
        raise PywetError(
            f"surface {surface.name}: its smallest triangle angle is {smallest.min():.2g} deg at {at} mm, expected at least "
            f"{SMALLEST_ANGLE_DEG:g} deg, which the engine needs and dividing could not give: make the wall thicker there",
            code="surface.sharp", key=surface.name, given=float(smallest.min()), expected=SMALLEST_ANGLE_DEG,
        )  # fmt: skip


def _check_edges(name: str, vertices: Floats, triangles: Ints) -> None:
    """Check that every directed edge occurs once, and once in the opposite direction."""
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    n = len(vertices)
    forward, there = np.unique(start * n + end, return_counts=True)
    backward = np.unique(end * n + start)
    open_edges = len(np.setxor1d(forward, backward))
    if open_edges or (there > 1).any():
        raise PywetError(
            f"surface {name}: it is not closed and oriented ({open_edges} open or turned edges, "
            f"{int((there > 1).sum())} used twice in one direction); fix the mesh so that it bounds a solid",
            code="surface.open", key=name, given=open_edges,
        )  # fmt: skip
