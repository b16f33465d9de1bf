"""Closed solids with few triangles: corner points of extruded sections, tubes, plates and bins, part by part.

A part is the array of its triangles' corner points, shape (m, 3, 3) [m], with outward normals. Cross-sections are
regular polygons described by their apothem (distance from the axis to a face); a square is the one with four sides.
Nothing here is specific to sieves.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from pywet.geometry.surface import Floats, flat_half_width

WAVE = 6
"""Number of straight pieces of a woven wire from one crossing to the next."""
Part = tuple[Floats, float | None]


def polygon(apothem: float, sides: int) -> Floats:
    """Return the corners (sides, 2) [m], counter-clockwise, of a regular polygon whose first face has its normal along +x."""
    angle = 2.0 * math.pi * (np.arange(sides) - 0.5) / sides
    return apothem / math.cos(math.pi / sides) * np.column_stack([np.cos(angle), np.sin(angle)])


def square(half_side: float) -> Floats:
    """Return the corners of a square about the origin, shape (4, 2) [m]."""
    return half_side * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def fan(loop: Floats) -> Floats:
    """Return the triangles of a convex polygon (n, 3), counter-clockwise seen from outside: shape (n - 2, 3, 3)."""
    return np.stack([np.stack([loop[0], loop[k], loop[k + 1]]) for k in range(1, len(loop) - 1)])


def band(first: Floats, second: Floats, smooth: bool = False) -> list[Floats]:
    """Return quadrilaterals between two closed loops (n, 3): one piece per side, or all in one if `smooth`.

    Normals point outward when `first` runs counter-clockwise around an upward axis and `second` is above it.
    """
    pieces = []
    for k in range(len(first)):
        m = (k + 1) % len(first)
        pieces.append(np.stack([[first[k], first[m], second[m]], [first[k], second[m], second[k]]]))
    return [np.concatenate(pieces)] if smooth else pieces


def flip(corners: Floats) -> Floats:
    """Reverse the orientation of triangles."""
    return corners[:, ::-1]


def lift(loop: Floats, z: float | Floats) -> Floats:
    """Put plane corners (n, 2) at height(s) z [m]."""
    return np.column_stack([loop, np.broadcast_to(z, len(loop))])


def _sides(low: Floats, high: Floats, smooth: bool, outward: bool) -> list[Part]:
    """Return the side faces of an extruded section; a smooth (curved) wall is one large part, a flat face one part each."""
    parts: list[Part] = []
    for corners in band(low, high, smooth):
        if smooth:
            half = None
        else:
            edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
            half = flat_half_width(float(edges.min()))
        parts.append((corners if outward else flip(corners), half))
    return parts


def _ring(inner: Floats, outer: Floats, up: bool) -> Part:
    """Return the annular face between two loops at one height: a rim, whose half width is half the wall's thickness."""
    corners = np.concatenate(band(outer, inner))
    thickness = float(np.linalg.norm(inner[0] + inner[1] - outer[0] - outer[1]) / 2.0)
    return (corners if up else flip(corners)), flat_half_width(thickness)


def tube(apothem: float, thickness: float, sides: int, z_low: float, z_high: float) -> list[Part]:
    """Return an open tube of regular cross-section: inner and outer faces and the two rims."""
    smooth = sides > 4
    inner, outer = polygon(apothem, sides), polygon(apothem + thickness, sides)
    inside = _sides(lift(inner, z_low), lift(inner, z_high), smooth, outward=False)
    outside = _sides(lift(outer, z_low), lift(outer, z_high), smooth, outward=True)
    top = _ring(lift(inner, z_high), lift(outer, z_high), up=True)
    bottom = _ring(lift(inner, z_low), lift(outer, z_low), up=False)
    return [*inside, *outside, top, bottom]


def bin_solid(apothem: float, thickness: float, sides: int, z_floor: float, z_rim: float) -> list[Part]:
    """Return an open-topped vessel as one solid; the floor's upper face is at `z_floor`, `thickness` thick like the walls."""
    smooth = sides > 4
    inner, outer = polygon(apothem, sides), polygon(apothem + thickness, sides)
    inside = _sides(lift(inner, z_floor), lift(inner, z_rim), smooth, outward=False)
    outside = _sides(lift(outer, z_floor - thickness), lift(outer, z_rim), smooth, outward=True)
    rim = _ring(lift(inner, z_rim), lift(outer, z_rim), up=True)
    floor: Part = (fan(lift(inner, z_floor)), flat_half_width(2.0 * apothem))
    underside: Part = (flip(fan(lift(outer, z_floor - thickness))), flat_half_width(2.0 * apothem))
    return [floor, *inside, *outside, rim, underside]


def plate(outline: Floats, z_low: Floats | float, z_high: Floats | float) -> list[Part]:
    """Return a slab over a convex outline (n, 2), counter-clockwise; the heights may vary linearly over it (inclined plate)."""
    low, high = lift(outline, z_low), lift(outline, z_high)
    width = float(np.ptp(outline, axis=0).min())
    top: Part = (fan(high), flat_half_width(width))
    bottom: Part = (flip(fan(low)), flat_half_width(width))
    edges = np.concatenate(band(low, high))
    return [top, bottom, (edges, flat_half_width(float((high - low)[:, 2].min())))]


def wire(
    start: Floats, end: Floats, radius: float, sides: int, smallest_angle_deg: float, steps_more: int = 0
) -> Floats:
    """Triangles of a straight horizontal wire from `start` to `end` (3,) [m]: a polygonal bar inscribed in the cylinder.

    Two opposite edges point horizontally sideways, so that the free distance between parallel wires is exact. The
    length is divided into equal steps; nodes are on every other step of an edge, alternating from edge to edge,
    which halves the triangles that a plain grid would need for the same smallest angle. `sides` must be even.
    `steps_more` is added to the smallest number of steps that satisfies the smallest angle.
    """
    axis = (end - start) / np.linalg.norm(end - start)
    across = np.cross([0.0, 0.0, 1.0], axis)
    angle = 2.0 * math.pi * np.arange(sides) / sides
    rim = radius * (np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * np.array([0.0, 0.0, 1.0]))
    length = float(np.linalg.norm(end - start))
    longest = 2.0 * radius * math.sin(math.pi / sides) / math.tan(math.radians(smallest_angle_deg))
    steps = max(1, math.ceil(length / longest)) + steps_more
    nodes = [sorted({0, *range(odd, steps, 2), steps}) for odd in (2, 1)]

    def point(edge: int, step: int) -> Floats:
        return np.asarray(start + (end - start) * (step / steps) + rim[edge % sides], dtype=np.float64)

    triangles = []
    for edge in range(sides):
        for a, b, c in _zip(nodes[edge % 2], nodes[(edge + 1) % 2]):
            triangles.append([point(edge + side, step) for side, step in (a, b, c)])
    caps = [flip(fan(start + rim)), fan(end + rim)]
    return np.concatenate([flip(np.array(triangles)), *caps])


def woven(start: Floats, end: Floats, radius: float, sides: int, pitch: float, crimp: float, first: float) -> Floats:
    """Return the triangles of a wire that waves up and down by `crimp`, with the same polygonal sections as `wire`.

    The wave is a cosine of period 2 pitch whose crest is at the distance `first` from the start.
    """
    length = float(np.linalg.norm(end - start))
    axis = (end - start) / length
    across = np.cross([0.0, 0.0, 1.0], axis)
    angle = 2.0 * math.pi * np.arange(sides) / sides
    rim = radius * (np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * np.array([0.0, 0.0, 1.0]))
    step = pitch / WAVE
    nodes = first + step * np.arange(
        math.ceil((0.25 * step - first) / step), math.floor((length - first) / step - 0.25) + 1
    )
    way = np.concatenate([[0.0], nodes, [length]])
    rise = crimp * np.cos(math.pi * (way - first) / pitch)[:, None] * np.array([0.0, 0.0, 1.0])
    loops = start + way[:, None, None] * axis + rim + rise[:, None]
    sleeves = [np.concatenate(band(a, b)) for a, b in pairwise(loops)]
    return np.concatenate([*sleeves, flip(fan(loops[0])), fan(loops[-1])])


def _zip(first: list[int], second: list[int]) -> list[tuple[tuple[int, int], ...]]:
    """Return the triangles between chains of nodes on neighbouring edges, shorter diagonal first; a node is (0 or 1, step)."""
    i = j = 0
    triangles: list[tuple[tuple[int, int], ...]] = []
    while i < len(first) - 1 or j < len(second) - 1:
        if j == len(second) - 1:
            along_first = True
        elif i == len(first) - 1:
            along_first = False
        else:
            along_first = abs(first[i + 1] - second[j]) <= abs(second[j + 1] - first[i])
        if along_first:
            triangles.append(((0, first[i]), (0, first[i + 1]), (1, second[j])))
            i += 1
        else:
            triangles.append(((0, first[i]), (1, second[j + 1]), (1, second[j])))
            j += 1
    return triangles
