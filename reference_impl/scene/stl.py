"""Binary STL files read and measured: bodies, extruded sections, tubes, plates; independent of the configuration."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy  # its parts are loaded where they are used

from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import ReplayError

RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
LENGTH_ERROR = 2e-8
"""Error of a length of the tower by single precision [m]: two coordinates below 0.25 m."""


def read(path: Path) -> Floats:
    """Return the corners of all triangles in file order, shape (m, 3, 3) [m]."""
    try:
        data = path.read_bytes()
        count = int(np.frombuffer(data, "<u4", 1, 80)[0])
        return np.frombuffer(data, RECORD, count, 84)["corners"].astype(np.float64)
    except (OSError, ValueError, IndexError) as error:
        raise ReplayError(
            f"{path} cannot be read as binary STL ({error}); expected a wall of the scene: build it again"
        ) from error


def nodes(corners: Floats) -> tuple[Floats, Floats]:
    """Return the distinct nodes (n, 3), and the node numbers of every triangle (m, 3)."""
    points, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return points, index.reshape(-1, 3)


def bodies(corners: Floats) -> Floats:
    """Return the body of every triangle: triangles connected by nodes."""
    points, index = nodes(corners)
    ends = index[:, [0, 1, 2]].ravel(), index[:, [1, 2, 0]].ravel()
    links = scipy.sparse.coo_array((np.ones(index.size), ends), shape=(len(points), len(points)))
    return np.asarray(scipy.sparse.csgraph.connected_components(links, directed=False)[1])[index[:, 0]]


@dataclass(frozen=True)
class Wire:
    """A straight horizontal bar: along x (0) or y (1), position of its axis, its section and ends [m]."""

    along: int
    at: float
    width: float
    height: float
    middle: float
    """Height of the bar's axis."""
    sides: int
    ends: tuple[float, float]


def wires(corners: Floats) -> list[Wire]:
    """Measure every body of a screen as a bar."""
    body, found = bodies(corners), []
    for k in range(int(body.max()) + 1):
        points = nodes(corners[body == k])[0]
        low, high = points.min(axis=0), points.max(axis=0)
        along = int(np.argmax((high - low)[:2]))
        across = 1 - along
        cap = points[points[:, along] == low[along]]
        found.append(
            Wire(
                along=along, at=float(0.5 * (low + high)[across]), width=float((high - low)[across]),
                height=float((high - low)[2]), middle=float(0.5 * (low + high)[2]), sides=len(cap),
                ends=(float(low[along]), float(high[along])),
            )
        )  # fmt: skip
    return found


@dataclass(frozen=True)
class Tube:
    """An upright tube or bin of regular cross-section: distances from the axis to its inner and outer faces [m]."""

    inner: float
    outer: float
    sides: int
    low: float
    high: float
    floor: float
    """Height of the lowest node of the inner face."""


def tube(corners: Floats) -> Tube:
    """Measure a tube at its nodes, which are on two circles about the axis."""
    points = nodes(corners)[0]
    radius = np.hypot(points[:, 0], points[:, 1])
    inside = radius < 0.5 * (radius.min() + radius.max())
    angle = np.round(np.arctan2(points[inside, 1], points[inside, 0]), 4)
    sides = len(np.unique(angle))
    flat = np.cos(np.pi / sides)
    return Tube(
        inner=float(flat * radius[inside].mean()), outer=float(flat * radius[~inside].mean()), sides=sides,
        low=float(points[:, 2].min()), high=float(points[:, 2].max()), floor=float(points[inside, 2].min()),
    )  # fmt: skip


@dataclass(frozen=True)
class Plate:
    """A slab: its position in plan, its heights, thickness and the inclination of its upper face about y [rad]."""

    low: Floats
    high: Floats
    thickness: float
    angle: float


def plate(corners: Floats) -> Plate:
    """Measure a plate at its nodes; the thickness is the vertical one at each node of the outline."""
    points, _ = nodes(corners)
    stacked, normal = _stacked(points), _normals(corners)
    top = normal[np.argmax(normal[:, 2])]
    return Plate(
        points.min(axis=0), points.max(axis=0), float((stacked[:, 1, 2] - stacked[:, 0, 2]).mean()),
        float(np.arctan2(np.hypot(top[0], top[1]) * np.sign(top[0] or 1.0), top[2])),
    )  # fmt: skip


def _stacked(points: Floats) -> Floats:
    """Return the nodes of an outline, which are above each other, in pairs (n, 2, 3)."""
    return points[np.lexsort((points[:, 2], points[:, 1], points[:, 0]))].reshape(-1, 2, 3)


def _normals(corners: Floats) -> Floats:
    """Compute the normal of every triangle, with twice its area as length."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def area(corners: Floats) -> Floats:
    """Return the area of every triangle [m2]."""
    return np.asarray(0.5 * np.sqrt((_normals(corners) ** 2).sum(axis=1)))


LARGE = 0.005
"""Half width [m] from which a part is a large wall (Elskamp 2.2.1: the largest sphere's radius)."""


def half_width(corners: Floats, upright: bool) -> float | None:
    """Return half the shorter side [m] of a flat face, a rim, or the edge of a slab (`upright` its height); None: large.

    A rim of width w is between two outlines of total length P, so that its area is w P/2.
    """
    points, index = nodes(corners)
    edges = np.concatenate([index[:, [0, 1]], index[:, [1, 2]], index[:, [2, 0]]])
    pairs, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    border = pairs[count == 1]
    normal = _normals(corners)
    normal = normal / np.sqrt((normal**2).sum(axis=1))[:, None]
    ring = len(points) - len(pairs) + len(index) == 0  # Euler characteristic: 1 for a face without a hole
    if (normal @ normal[0] < 1.0 - 1e-6).any():
        if not upright:
            return None
        height = np.abs(np.diff(_stacked(points)[:, :, 2], axis=1))
        half = 0.5 * float(height.min())
    elif ring:
        length = np.sqrt(((points[border[:, 0]] - points[border[:, 1]]) ** 2).sum(axis=1)).sum()
        half = float(area(corners).sum() / length)
    else:
        extent = np.sort(np.ptp(points, axis=0))
        half = 0.5 * float(extent[1])
    return None if half >= LARGE - LENGTH_ERROR else half
