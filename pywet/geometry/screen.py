"""The screen: straight horizontal wires in both directions in the plane z = 0, as in Elskamp's simulations (5.1).

Woven wires are approximated by horizontal bars; crossing bars intersect each other. Every wire is a closed solid and
one part; its ends are inside the side wall, so that no sphere can pass around it.
"""

from __future__ import annotations

import numpy as np
import scipy

from pywet.geometry.solids import wire
from pywet.geometry.surface import SAME_POINT_M, Floats, Surface, make_surface

SMALLEST_WIRE_ANGLE_DEG = 1.02
"""Smallest angle [deg] of a wire's triangles: twice what the engine requires."""
MOST_STEPS_MORE = 12
"""Largest number of attempts to divide the wires along y so that no node lies on a wire along x."""


def wire_positions(pitch: float, radius: float, half_width: float) -> Floats:
    """Return the centre lines of parallel wires [m]: symmetric, `pitch` apart, all that extend into the tower.

    A width that is a multiple of the pitch gives whole apertures only, with the outermost wires half inside the wall. With
    any other width the openings at the wall are smaller than an aperture, never larger.
    """
    count = round(2.0 * half_width / pitch)
    reach = int(half_width // pitch) + 2
    position = (np.arange(-reach, reach + 1 + count % 2) - 0.5 * (count % 2)) * pitch
    inside = np.abs(position) < half_width + radius * (1 - 1e-6)
    return np.asarray(position[inside], dtype=np.float64)


def chord(outline: Floats, offset: float, axis: int) -> tuple[float, float] | None:
    """Return both ends of the chord of a convex outline (n, 2) at `offset` from the axis and parallel to x (axis 0) or y (1)."""
    along, across = outline[:, axis], outline[:, 1 - axis] - offset
    next_along, next_across = np.roll(along, -1), np.roll(across, -1)
    cut = (across < 0) != (next_across < 0)
    if cut.sum() != 2:
        return None
    share = across[cut] / (across[cut] - next_across[cut])
    ends = along[cut] + share * (next_along[cut] - along[cut])
    return float(ends.min()), float(ends.max())


def build_wires(aperture: float, diameter: float, sides: int, inner_apothem: float, mid_wall: Floats) -> Surface:
    """Return all wires as one vibrating surface; `mid_wall` (n, 2) is the outline in the middle of the side wall.

    Crossing wires must not share a node, because the engine would treat them as one body. If they would, the
    wires along y are divided into one more step.
    """
    radius = 0.5 * diameter
    for more in range(MOST_STEPS_MORE):
        wires = []
        for axis in (0, 1):
            for offset in wire_positions(aperture + diameter, radius, inner_apothem):
                ends = chord(mid_wall, float(offset), axis)
                if ends is None:
                    continue
                start, end = np.zeros(3), np.zeros(3)
                start[axis], end[axis] = ends
                start[1 - axis] = end[1 - axis] = offset
                wires.append(wire(start, end, radius, sides, SMALLEST_WIRE_ANGLE_DEG, more * axis))
        if not _meet(wires):
            break
    return make_surface("wires", "wires", [(corners, radius) for corners in wires], "vibrates")


def _meet(wires: list[Floats]) -> bool:
    """Return whether nodes of two wires are so close that they would be merged."""
    nodes = [np.unique(corners.reshape(-1, 3), axis=0) for corners in wires]
    owner = np.repeat(np.arange(len(nodes)), [len(n) for n in nodes])
    close = scipy.spatial.cKDTree(np.concatenate(nodes)).query_pairs(2.0 * SAME_POINT_M, output_type="ndarray")
    return bool((owner[close[:, 0]] != owner[close[:, 1]]).any())
