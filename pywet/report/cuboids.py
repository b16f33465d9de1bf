"""Liquid bridges drawn as in Elskamp & Kruggel-Emden (2018), Fig.

11: cuboids whose visible volume is the bridge's. The visible part of a cuboid with square section is outside both
spheres. Its side follows from that volume, its length d_lb = d_i + d_j + S from the depth at which its edges meet the
spheres. A wall is a plane.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize.elementwise import find_root

from pywet.runs.rundir import Bools, Floats

NODES, WEIGHTS = (np.polynomial.legendre.leggauss(8)[k] for k in (0, 1))
PAIR = np.triu_indices(8)
SQUARE = ((NODES[PAIR[0]] + 1.0) ** 2 + (NODES[PAIR[1]] + 1.0) ** 2) / 16.0
"""Squared distance from the axis, over the squared side, of points in a quarter of the square; mirrored ones are listed once."""
WEIGHT = WEIGHTS[PAIR[0]] * WEIGHTS[PAIR[1]] * np.where(PAIR[0] == PAIR[1], 0.25, 0.5)
TOLERANCE = 1e-9
"""Relative error of a side."""


def visible(side: Floats, gap: Floats, ri: Floats, rj: Floats) -> Floats:
    """Return the volume [m3] of square bars of a side [m] on the line of centres, between spheres; rj may be infinite."""
    square = side[:, None] ** 2 * SQUARE
    return np.asarray(side**2 * (np.maximum(gap[:, None] + depth(square, ri) + depth(square, rj), 0.0) @ WEIGHT))


def depth(square: Floats, radius: Floats) -> Floats:
    """Return the depth of a sphere's surface at a distance from the axis, given squared; 0 for an infinite radius."""
    r = radius.reshape(-1, *(1,) * (square.ndim - 1))
    inside = np.minimum(square, r**2)
    with np.errstate(invalid="ignore"):
        return np.where(np.isfinite(r), inside / (r + np.sqrt(r**2 - inside)), 0.0)


def sides(volume: Floats, gap: Floats, ri: Floats, rj: Floats) -> Floats:
    """Return the side [m] of the square whose visible volume is the bridge's, limited by the smaller sphere."""
    most = np.sqrt(2.0) * np.minimum(ri, rj)
    narrower = visible(most, gap, ri, rj) > volume
    side, known = most.copy(), [of[narrower] for of in (volume, gap, ri, rj)]
    found = find_root(
        lambda s, v, *of: visible(s, *of) - v,
        (np.zeros_like(known[0]), most[narrower]),
        args=tuple(known),
        tolerances={"xrtol": TOLERANCE, "xatol": 0.0, "frtol": 0.0, "fatol": 0.0},
    )
    side[narrower] = found.x
    return side


def corners(
    first: Floats, second: Floats, at_wall: Bools, volume: Floats, gap: Floats, ri: Floats, rj: Floats
) -> Floats:
    """Return corners (n, 8, 3) of the cuboids between centres `first` and `second` (walls: closest point), four at each end."""
    along = second - first
    along /= np.maximum(np.linalg.norm(along, axis=1), 1e-300)[:, None]
    side = sides(volume, gap, ri, rj)
    into = [depth(side**2 / 2.0, r) for r in (ri, rj)]
    start = ri - into[0]
    end = ri + gap + np.where(at_wall, 0.0, into[1])
    least = np.eye(3)[np.abs(along).argmin(axis=1)]
    u = np.cross(along, least)
    u *= (side / np.linalg.norm(u, axis=1) / 2.0)[:, None]
    v = np.cross(along, u)
    square = np.stack([-u - v, u - v, u + v, v - u], axis=1)
    ends = [first + d[:, None] * along for d in (start, np.maximum(end, start))]
    return np.concatenate([at[:, None, :] + square for at in ends], axis=1)
