"""Detect a closed surface that intersects itself: edges that pass through facets of which they are no part."""

from __future__ import annotations

import numpy as np

from pywet.geometry.surface import Floats, Ints

MOST = 20_000
"""Largest number of triangles of a surface that is checked; for more, pairs would take minutes."""
BLOCK = 256
"""Number of triangles whose pairs are in memory at once."""
MARGIN = 1e-6
"""Share of an edge's length and of a facet's sides by which an intersection must be inside both, to exclude touching."""


def crossing(points: Floats, triangles: Ints) -> Floats | None:
    """Return a point (3,) at which an edge passes through a facet; None if there is none, or for more than `MOST` triangles."""
    if len(triangles) > MOST:
        return None
    corners = points[triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    for start in range(0, len(triangles), BLOCK):
        block = slice(start, start + BLOCK)
        near = ((low[block, None] <= high) & (high[block, None] >= low)).all(axis=2)
        first, second = np.nonzero(near)
        first += start
        apart = ~(triangles[first][:, :, None] == triangles[second][:, None, :]).any(axis=(1, 2))
        at = _through(corners[first[apart]], corners[second[apart]])
        if at is not None:
            return at
    return None


def _through(edges: Floats, facets: Floats) -> Floats | None:
    """Return the first point where an edge of one triangle passes through the other of its pair (Moeller and Trumbore 1997)."""
    a, one, two = facets[:, 0], facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0]
    for k in range(3):
        start, way = edges[:, k], edges[:, (k + 1) % 3] - edges[:, k]
        across = np.cross(way, two)
        of = np.einsum("ij,ij->i", one, across)
        slanted = np.abs(of) > 1e-9 * np.prod([np.linalg.norm(v, axis=1) for v in (one, two, way)], axis=0)
        inverse = 1.0 / np.where(slanted, of, 1.0)
        u = inverse * np.einsum("ij,ij->i", start - a, across)
        beside = np.cross(start - a, one)
        v, t = (inverse * np.einsum("ij,ij->i", w, beside) for w in (way, two))
        inside = slanted & (np.minimum.reduce([u, v, t, 1.0 - t, 1.0 - u - v]) > MARGIN)
        if inside.any():
            hit = int(np.argmax(inside))
            return np.asarray(start[hit] + t[hit] * way[hit])
    return None
