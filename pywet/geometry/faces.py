"""Divide a surface at its folds into faces with half widths.

Each face is one part, with which a sphere has at most one bridge. A curved face, whose facets meet at small angles,
is one part.
"""

from __future__ import annotations

import numpy as np
import scipy

from pywet.geometry.surface import LARGE_HALF_WIDTH_M, Floats, Ints

FEATURE_ANGLE_DEG = 30.0
"""Angle between the normals of two neighbouring facets above which a face ends at their common edge."""
BODIES_DEG = 180.0
"""Feature angle for which each body is one part, such as a wire."""
FLAT = 1.0 - 1e-5
"""Cosine of the angle between normals above which facets are coplanar, as in the engine."""
ROUNDING_DEG = 1e-3
"""Rotation of a facet's normal [deg] due to single precision of its corners."""


def faces(corners: Floats, feature_angle_deg: float = FEATURE_ANGLE_DEG) -> list[tuple[Floats, float | None]]:
    """Return triangles (m, 3, 3) [m] and half width (None: a large wall) of each face, in the order of its first triangle."""
    face = face_of(corners, feature_angle_deg)
    each = [corners[face == k] for k in range(int(face.max(initial=-1)) + 1)]
    return [(triangles, half_width(triangles)) for triangles in each]


def face_of(corners: Floats, feature_angle_deg: float = FEATURE_ANGLE_DEG) -> Ints:
    """Return the face of each triangle, numbered in the order of their first triangles."""
    points, index = np.unique(corners.reshape(-1, 3).astype(np.float32), axis=0, return_inverse=True)
    triangles = index.reshape(-1, 3)
    normal = _normals(corners)
    first, second = _neighbours(triangles, len(points))
    fold = np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", normal[first], normal[second]), -1.0, 1.0)))
    joined = fold <= feature_angle_deg + ROUNDING_DEG
    n = len(corners)
    links = scipy.sparse.coo_array((np.ones(joined.sum()), (first[joined], second[joined])), shape=(n, n))
    label = scipy.sparse.csgraph.connected_components(links, directed=False)[1]
    _, start, place = np.unique(label, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(start))[place], dtype=np.int64)


def half_width(corners: Floats) -> float | None:
    """Return half the width of a flat face [m]; None for a curved or a large one (from 5 mm on).

    The width of a rim, around a hole, is its area over half the length of its borders; that of another face its
    smallest extent along or across one of its border's edges.
    """
    normal = _normals(corners)
    largest = normal[int(np.argmax(_area(corners)))]
    if (normal @ largest < FLAT).any():
        return None
    points, index = np.unique(corners.reshape(-1, 3).astype(np.float32), axis=0, return_inverse=True)
    triangles = index.reshape(-1, 3)
    edges = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    pairs, count = np.unique(edges, axis=0, return_counts=True)
    border = points[pairs[count == 1]].astype(np.float64)
    if not len(border):  # for instance a wall thinner than single precision resolves, which is rejected as a surface
        return None
    along = border[:, 1] - border[:, 0]
    length = np.linalg.norm(along, axis=1)
    if len(points) - len(pairs) + len(triangles) <= 0:  # Euler characteristic: 1 for a face without a hole
        half = float(_area(corners).sum() / length.sum())
    else:
        across = np.cross(largest, along / length[:, None])
        half = 0.5 * float(np.ptp(points.astype(np.float64) @ across.T, axis=0).min())
    return None if half >= LARGE_HALF_WIDTH_M - 1e-8 else round(half, 9)


def _neighbours(triangles: Ints, points: int) -> tuple[Ints, Ints]:
    """Return the triangles on both sides of each edge."""
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    face = np.repeat(np.arange(len(triangles)), 3)
    there, back = start * points + end, end * points + start
    order = np.argsort(there)
    at = np.minimum(np.searchsorted(there[order], back), len(there) - 1)
    found = there[order][at] == back
    return face[found], face[order][at][found]


def _normals(corners: Floats) -> Floats:
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(cross / np.maximum(np.linalg.norm(cross, axis=1), 1e-300)[:, None])


def _area(corners: Floats) -> Floats:
    return np.asarray(
        0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    )
