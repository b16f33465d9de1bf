"""The pairs of bodies of the force rows."""

from __future__ import annotations

import math

import numpy as np

from pywet.laws.contact import bridge_radius
from studies.pair import Floats, Pair

R, SIGMA, ETA, ANGLE, V_STAR = 2.5e-3, 0.07275, 1e-3, math.radians(15.0), 1e-2
"""Radius [m], surface tension [N/m], viscosity [Pa s], both contact angles, volume over r_eff³ (at a wall over r³)."""
SHARES = (0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
"""Gaps over the smallest rupture distance of all programs' laws."""
OVERLAPS = (-0.001, -0.01, -0.05)
"""Overlaps over the radius."""
RADII = {"equal": (R, R), "unequal": (R, 2.0 * R), "wall": (R, math.inf)}


def compared_gaps(pair: Pair) -> Floats:
    """Return the gaps at which all programs are compared [m]."""
    return np.array(SHARES) * min(pair.limit("paper"), pair.limit("exact"))


def drawn_gaps(pair: Pair) -> Floats:
    """Return the gaps at which the picture draws forces [m]."""
    far = 1.25 * pair.limit("paper")
    return np.concatenate([np.linspace(-0.05 * R, -0.001 * R, 6), np.linspace(1e-3 * far, far, 50)])


def pairs() -> list[Pair]:
    """Return the three pairs of the table."""
    volume = {key: V_STAR * bridge_radius(*radii) ** 3 for key, radii in RADII.items()}
    return [Pair(key, *radii, volume[key], (ANGLE, ANGLE), SIGMA) for key, radii in RADII.items()]
