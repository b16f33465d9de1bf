"""Walls for YADE: every closed surface cut into convex solids.

YADE treats facets individually: a sphere on the edge that two of them share, flat or convex, has contacts with both
(measured: twice the stiffness and damping). Most contacts with a wire of six sides are on edges. A convex polyhedron
is one body with one contact, as in LIGGGHTS for a closed mesh. Wires, plates and boxes are already convex; tubes and
bins are cut into the pieces between opposite faces, which fit together at the mitres without gaps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from pywet.errors import PywetError
from pywet.geometry.surface import Floats, Surface, enclosed

SAME = 1e-6
"""Relative tolerance of volumes, and in metres over the size of the solid of distances: STL files are in single precision."""


@dataclass(frozen=True)
class Face:
    """A flat patch of a closed surface: all its triangles in one plane."""

    normal: Floats
    points: Floats
    area: float

    @property
    def convex(self) -> bool:
        """Return whether the patch fills the convex hull of its corners."""
        return abs(_flat_area(self.points, self.normal) - self.area) < 1e-3 * self.area

    @property
    def centre(self) -> Floats:
        """Return the mean of the distinct corners (3,) [m]."""
        return np.asarray(np.unique(np.round(self.points, 9), axis=0).mean(axis=0))


def convex_pieces(surface: Surface) -> list[Floats]:
    """Corner points (n, 3) [m] of convex solids that together fill the closed surface.

    PywetError if they do not: this method does not support solids other than convex parts between parallel faces.
    """
    pieces: list[Floats] = []
    count, body = surface.components()
    for component in (surface.corners[body == k] for k in range(count)):
        solids = _pieces(component)
        filled, wanted = sum(float(ConvexHull(p).volume) for p in solids), enclosed(component)
        if abs(filled - wanted) > 1e3 * SAME * wanted:
            raise PywetError(
                f"the wall {surface.name} cannot be cut into convex solids ({filled:.3g} m3 of {wanted:.3g} m3 found); the "
                "engine yade takes wires, plates, boxes, straight tubes and bins: run this scene in LIGGGHTS",
                code="yade.wall", key=f"walls.{surface.name}",
            )  # fmt: skip
        pieces += solids
    return pieces


def _pieces(corners: Floats) -> list[Floats]:
    """Return a convex solid as it is, another one cut between opposite faces."""
    points = np.unique(corners.reshape(-1, 3), axis=0)
    if abs(ConvexHull(points).volume - enclosed(corners)) < 1e2 * SAME * enclosed(corners):
        return [points]
    faces = [f for f in _faces(corners) if f.convex]
    solids: dict[tuple[int, int], Floats] = {}
    for k in range(len(faces)):
        m = _behind(faces, k)
        if m is not None:
            solids[(min(k, m), max(k, m))] = np.unique(np.concatenate([faces[k].points, faces[m].points]), axis=0)
    return list(solids.values())


def _behind(faces: list[Face], k: int) -> int | None:
    """Return the nearest face with the opposite orientation within the solid behind face k."""
    best: int | None = None
    distance = math.inf
    for m, other in enumerate(faces):
        if m == k or other.normal @ faces[k].normal > -0.999:
            continue
        between = other.centre - faces[k].centre
        away = float(between @ faces[k].normal)
        sideways = float(np.linalg.norm(between - away * faces[k].normal))
        if away < 0 and -away + sideways < distance:
            best, distance = m, -away + sideways
    return best


def _faces(corners: Floats) -> list[Face]:
    """Join coplanar triangles to faces."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(cross, axis=1)
    normal = cross / (2.0 * area[:, None])
    offset = np.einsum("ij,ij->i", normal, corners[:, 0])
    plane = np.column_stack([np.round(normal, 4), np.round(offset, 7)]) + 0.0
    _, label = np.unique(plane, axis=0, return_inverse=True)
    label = np.asarray(label).reshape(-1)
    return [
        Face(normal[label == k][0], corners[label == k].reshape(-1, 3), float(area[label == k].sum()))
        for k in range(label.max() + 1)
    ]


def _flat_area(points: Floats, normal: Floats) -> float:
    """Area of the convex hull of points in a plane."""
    along = np.linalg.svd(normal[None, :])[2][1:]
    return float(ConvexHull(points @ along.T).volume)
