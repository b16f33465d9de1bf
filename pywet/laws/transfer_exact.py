"""Shares of the liquid of a rupturing bridge from the exact profile at its limit of stability, as a table over V*.

The profile is divided at the neck. This is the counterpart of `transfer.py` with the same arguments. A wire counts as
a sphere of its radius.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from pywet.errors import PywetError
from pywet.laws.contact import effective_radius
from pywet.laws.exact_bridge import rupture
from pywet.laws.transfer import SMALLEST, V_STAR_GRID, Floats, check_numbers
from pywet.schema import LARGE_WALL, SPHERE


def exact_table(
    radius_i: float, size_j: float, theta_i: float, theta_j: float, kind: int, v_star: Floats = V_STAR_GRID
) -> Floats:
    """Transfer ratio T_i = V_i/(V_i + V_j) over V*, shape of `v_star`; V* = V/r³ with r the harmonic mean, for walls r_i.

    `kind` 0: `size_j` is the other sphere's radius; 1: a large wall (`size_j` is not used); 2: a wire of radius `size_j`.
    V* = 0 takes the value at 1e-5; volumes too large for the bodies (thin wires) take the last solved value. Equal bodies
    share equally: where the bridge breaks by losing its symmetry, either may win.
    Source: the exact solution, `pywet.laws.exact_bridge`.

    >>> float(exact_table(2e-3, 2e-3, 0.5, 0.5, 0)[7])
    0.5
    """
    check_numbers(kind, radius_i, size_j, v_star)
    return _exact(radius_i, size_j, theta_i, theta_j, kind, tuple(float(v) for v in v_star)).copy()


@cache
def _exact(
    radius_i: float, size_j: float, theta_i: float, theta_j: float, kind: int, v_star: tuple[float, ...]
) -> Floats:
    radius_j = math.inf if kind == LARGE_WALL else size_j
    if (radius_i, theta_i) == (radius_j, theta_j):
        return np.full(len(v_star), 0.5)
    r = effective_radius(radius_i, size_j) if kind == SPHERE else radius_i
    if kind == SPHERE and (radius_i, theta_i) < (radius_j, theta_j):  # so that T_i(i, j) + T_j(j, i) = 1 exactly
        return 1.0 - _exact(radius_j, radius_i, theta_j, theta_i, kind, v_star)
    ratios: list[float] = []
    for reduced in v_star:
        try:
            ratios.append(rupture(max(reduced, SMALLEST) * r**3, radius_i, radius_j, theta_i, theta_j).transfer_ratio)
        except PywetError:
            if not ratios:
                raise
            ratios.append(ratios[-1])
    return np.array(ratios)
