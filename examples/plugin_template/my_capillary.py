"""A capillary law of your own: copy this folder, rename the law, put your formula in.

The function below is Python when you call it and machine code when LIGGGHTS calls it: only floats, `math` and other functions
decorated with @helper may be used.
"""

from __future__ import annotations

import math

from pywet.laws.force_law import force_law


@force_law
def my_capillary(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """Capillary force by the parabolic (Derjaguin) approximation: exact for little liquid.

    F = π σ r (cos θ_i + cos θ_j)(1 − S/√(S² + 2V/(π r))), r = r_eff = 2 r_i r_j/(r_i + r_j) (harmonic mean; 2 r_i at a wall).

    Arguments: separation S [m], volume V [m3], radii [m] (radius_j = inf: wall), contact angles [rad],
    surface_tension σ [N/m]. Returns the attraction F ≥ 0 [N].
    Valid for V much smaller than r³. S ≤ 0: the limit S → 0.
    Source: pressure σ (cos θ_i + cos θ_j)/gap on a disc wetted up to where the gap of two parabolas is filled.

    >>> f"{my_capillary(1e-5, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07):.5e}"
    '3.85127e-04'
    """
    r = 2.0 * radius_i if math.isinf(radius_j) else 2.0 * radius_i * radius_j / (radius_i + radius_j)
    s = max(separation, 0.0)
    limit = math.pi * surface_tension * r * (math.cos(contact_angle_i) + math.cos(contact_angle_j))
    if volume <= 0.0:
        return limit if s == 0.0 else 0.0
    return limit * (1.0 - s / math.sqrt(s * s + 2.0 * volume / (math.pi * r)))
