"""Shapes of the tower around the screen: its cross-section and the impact plate."""

from __future__ import annotations

import math

import numpy as np

from pywet.geometry.solids import Part, plate
from pywet.geometry.surface import Floats


def impact_plate(mid_wall: Floats, low_edge_x: float, angle: float, thickness: float, z_top: float) -> list[Part]:
    """Return a slab that falls from the wall at -x, where its upper face is at `z_top`, to its low edge at x = `low_edge_x`."""
    outline = clip(mid_wall, low_edge_x)
    z = z_top - math.tan(angle) * (outline[:, 0] - mid_wall[:, 0].min())
    return plate(outline, z - thickness, z)


def clip(outline: Floats, x: float) -> Floats:
    """Return the part of a convex outline (n, 2), counter-clockwise, left of x [m]; corners very near the cut are omitted."""
    width = float(np.ptp(outline[:, 0]))
    left = outline[outline[:, 0] < x - 0.03 * width]
    after = np.roll(outline, -1, axis=0)
    cut = (outline[:, 0] < x) != (after[:, 0] < x)
    share = (x - outline[cut, 0]) / (after[cut, 0] - outline[cut, 0])
    points = np.concatenate([left, outline[cut] + share[:, None] * (after[cut] - outline[cut])])
    centre = points.mean(axis=0)
    order = np.argsort(np.arctan2(points[:, 1] - centre[1], points[:, 0] - centre[0]))
    return points[order]


def equal_area_apothem(shape: str, width: float, sides: int) -> tuple[float, int]:
    """Return apothem [m] and number of sides of the inner cross-section; a cylinder's polygon has the circle's area."""
    if shape == "square":
        return 0.5 * width, 4
    return 0.5 * width * math.sqrt(math.pi / (sides * math.tan(math.pi / sides))), sides
