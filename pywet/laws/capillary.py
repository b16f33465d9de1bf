"""Capillary forces of a liquid bridge; magnitudes, attraction positive. Sphere-wall: radius_j is infinite."""

from __future__ import annotations

import math

from pywet.laws.force_law import force_law


@force_law
def rabinovich(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """Capillary force of Rabinovich et al. (2005), sphere-sphere and sphere-wall.

    Spheres, r = r_eff = 2 r_i r_j/(r_i + r_j) (harmonic mean), S > 0:
        F = π σ r (cos θ_i + cos θ_j)/(1 + S/(2d)) + 2π σ r sin φ sin(φ + θ_m),  φ = √(2d/r),
        d = (V/(π r))/(S + √(S² + 2V/(π r))).
    Wall, r = r_i:
        F = 2π σ r (cos θ_i + cos θ_w)/(1 + S/d) + 2π σ r sin φ sin(φ + θ_m),  φ = √(2d/r),
        d = (V/(π r))/(S + √(S² + V/(π r))).

    Arguments: separation S [m], volume V [m3], radii [m] (radius_j = inf: wall), contact angles [rad],
    surface_tension σ [N/m]. Returns F [N].
    Valid for small bridges (V* up to about 0.1) and contact angles below 90°. S ≤ 0: the limit S → 0.
    Source: Elskamp & Kruggel-Emden 2018 (14)-(16) with sin φ in place of sin θ_m in the second term, and the full first term
    at a wall (their (15) prints its small-gap limit).

    >>> f"{rabinovich(0.0, 0.0, 1e-3, 1e-3, 0.0, 0.0, 0.07):.6e}"
    '4.398230e-04'
    """
    s = max(separation, 0.0)
    theta = 0.5 * (contact_angle_i + contact_angle_j)
    cosines = math.cos(contact_angle_i) + math.cos(contact_angle_j)
    if math.isinf(radius_j):
        r, factor, spread, gap = radius_i, 2.0, 1.0, s
    else:
        r, factor, spread, gap = 2.0 * radius_i * radius_j / (radius_i + radius_j), 1.0, 2.0, 0.5 * s
    q = volume / (math.pi * r)
    if q <= 0.0:
        return factor * math.pi * surface_tension * r * cosines if s == 0.0 else 0.0
    d = q / (s + math.sqrt(s * s + spread * q))
    phi = math.sqrt(2.0 * d / r)
    neck = factor * math.pi * surface_tension * r * cosines / (1.0 + gap / d)
    return neck + 2.0 * math.pi * surface_tension * r * math.sin(phi) * math.sin(phi + theta)
