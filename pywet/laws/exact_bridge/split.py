"""Position at which a bridge ruptures, and the liquid that remains on either side; compiled, lengths in any one unit."""

from __future__ import annotations

import math

import numpy as np

from pywet.laws.exact_bridge.meridian import (
    CURVATURE,
    LENGTH,
    PHI_I,
    PHI_J,
    Case,
    Floats,
    contact,
    integrals,
    jit,
    slope,
    square,
    start,
)

LOOKS = 64
"""Number of sections of the meridian compared to find the narrowest."""


@jit
def neck_position(y: Floats, c: Case) -> float:
    """Return the arc length of the narrowest section; that of the narrower contact line if there is no minimum between."""
    h, t = y[CURVATURE], y[LENGTH]
    w0, w1, w2, _ = start(y, c)
    # a meridian that meets a body beyond its equator first widens, then narrows
    at = np.argmin(np.array([square(k * t / LOOKS, h, w0, w1, w2) for k in range(LOOKS + 1)]))
    low, high = max(at - 1, 0) * t / LOOKS, min(at + 1, LOOKS) * t / LOOKS
    if slope(low, h, w1, w2) < 0.0 and slope(high, h, w1, w2) > 0.0:
        for _ in range(100):
            middle = 0.5 * (low + high)
            if slope(middle, h, w1, w2) < 0.0:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)
    return at * t / LOOKS


@jit
def cap_part(angle: float, radius: float, theta: float, depth: float) -> float:
    """Return the volume of a body between its contact plane and a plane `depth` further into the bridge."""
    if math.isinf(radius) or depth <= 0.0:
        return 0.0
    _, _, _, height, cap = contact(angle, radius, theta)
    left = height - depth
    return cap if left <= 0.0 else cap - math.pi / 3.0 * left * left * (3.0 * radius - left)


@jit
def parts(y: Floats, c: Case) -> tuple[float, float]:
    """Return the liquid on either side of the plane through the narrowest section, without the bodies."""
    h, t = y[CURVATURE], y[LENGTH]
    w0, w1, w2, f = start(y, c)
    length, whole = integrals(t, h, w0, w1, w2, f)
    z, left = integrals(neck_position(y, c), h, w0, w1, w2, f)
    cap_i, cap_j = contact(y[PHI_I], c.ri, c.ti)[4], contact(y[PHI_J], c.rj, c.tj)[4]
    body_i = cap_part(y[PHI_I], c.ri, c.ti, z)
    body_j = cap_part(y[PHI_J], c.rj, c.tj, length - z)
    volume_i = left - body_i - (cap_j - body_j)
    return volume_i, whole - cap_i - cap_j - volume_i
