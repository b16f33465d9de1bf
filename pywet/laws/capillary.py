"""Capillary forces of a liquid bridge from its neck; magnitudes, attraction positive. Sphere-wall: radius_j is infinite.

Fits and boundary methods are in `capillary_fits.py`, the exact force in `young_laplace.py`.
"""

from __future__ import annotations

import math

from pywet.laws import contact
from pywet.laws.force_law import force_law, helper

effective_radius, bridge_radius = helper(contact.effective_radius), helper(contact.bridge_radius)


@helper
def _neck_and_ring(
    separation: float, volume: float, ri: float, rj: float, ti: float, tj: float, tension: float, small_gap: bool
) -> float:
    """Return the force of the neck, in full or in its limit for a small gap, and of the ring at the contact line (Rabinovich)."""
    s, r = max(separation, 0.0), bridge_radius(ri, rj)
    spread, share = (1.0, 1.0) if math.isinf(rj) else (2.0, 0.5)  # share: 1/spread, since products are fast
    limit = 2.0 * share * math.pi * tension * r * (math.cos(ti) + math.cos(tj))
    q = volume / (math.pi * r)
    if q <= 0.0:
        return limit if s == 0.0 else 0.0
    d = q / (s + math.sqrt(s * s + spread * q))
    phi = math.sqrt(2.0 * d / r)
    neck = limit / (1.0 + (s * share * math.sqrt(spread / q) if small_gap else s * share / d))
    return neck + 2.0 * math.pi * tension * r * math.sin(phi) * math.sin(phi + 0.5 * (ti + tj))


@helper
def _as_printed(separation: float, volume: float, ri: float, rj: float, ti: float, tj: float, tension: float) -> float:
    """Return the force as printed, for both kinds of partner."""
    s, r, wall = max(separation, 0.0), bridge_radius(ri, rj), math.isinf(rj)
    theta = 0.5 * (ti + tj)
    cosines = math.cos(ti) + math.cos(tj)
    q = max(volume, 0.0) / (math.pi * r)
    d = math.sqrt(s * s + q) if wall else q / max(s + math.sqrt(s * s + 2.0 * q), 1e-300)
    length = math.sqrt(q) if wall else 2.0 * d
    weaker = 1.0 if s == 0.0 else 1.0 + s / length if length > 0.0 else math.inf
    neck = (2.0 if wall else 1.0) * math.pi * tension * r * cosines / weaker
    return neck + 2.0 * math.pi * tension * r * math.sin(theta) * math.sin(theta + math.sqrt(2.0 * d / r))


@force_law("capillary")
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

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    volume : float or array
        Volume V of the bridge [m³].
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    contact_angle_i : float or array
        Contact angle on body i [rad].
    contact_angle_j : float or array
        Contact angle on body j [rad].
    surface_tension : float or array
        Surface tension σ [N/m].

    Returns
    -------
    float or array
        Attraction F [N].

    Notes
    -----
    Spheres, r = r_eff = 2 r_i r_j/(r_i + r_j) (harmonic mean), S > 0:
        F = π σ r (cos θ_i + cos θ_j)/(1 + S/(2d)) + 2π σ r sin φ sin(φ + θ_m),  φ = √(2d/r),
        d = (V/(π r))/(S + √(S² + 2V/(π r))).
    Wall, r = r_i:
        F = 2π σ r (cos θ_i + cos θ_w)/(1 + S/d) + 2π σ r sin φ sin(φ + θ_m),  φ = √(2d/r),
        d = (V/(π r))/(S + √(S² + V/(π r))).

    Valid for little liquid and contact angles below 90°. Spheres at touch, above the exact force at 0° and 20°: 10 and 18 % at
    V* = 0.00125, 24 and 38 % at 0.0125, 56 and 81 % at 0.1. S ≤ 0: the limit S → 0.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (14)-(16) with sin φ in place of sin θ_m in the second term, and the full first term at
    a wall (their (15) prints its small-gap limit).

    Examples
    --------
    >>> f"{rabinovich(0.0, 0.0, 1e-3, 1e-3, 0.0, 0.0, 0.07):.6e}"
    '4.398230e-04'
    """
    return _neck_and_ring(
        separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension, False
    )


@force_law("capillary")
def rabinovich_small_gap(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """`rabinovich` with the small-gap limit of its first term, which the paper prints at walls.

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    volume : float or array
        Volume V of the bridge [m³].
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    contact_angle_i : float or array
        Contact angle on body i [rad].
    contact_angle_j : float or array
        Contact angle on body j [rad].
    surface_tension : float or array
        Surface tension σ [N/m].

    Returns
    -------
    float or array
        Attraction F [N].

    Notes
    -----
    Wall, r = r_i:  F = 2π σ r (cos θ_i + cos θ_w)/(1 + S √(π r/V)) + 2π σ r sin φ sin(φ + θ_m);
    spheres, r = r_eff:  F = π σ r (cos θ_i + cos θ_j)/(1 + S √(π r/(2V))) + 2π σ r sin φ sin(φ + θ_m); φ of `rabinovich`.

    Valid for S well below √(V/(π r)); near rupture it is up to 17 times too strong. S ≤ 0: the limit S → 0.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (15), second term corrected.

    Examples
    --------
    >>> f"{rabinovich_small_gap(1e-4, 1e-10, 1e-3, math.inf, 0.3, 0.3, 0.07):.5e}"
    '6.71890e-04'
    """
    return _neck_and_ring(
        separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension, True
    )


@force_law("capillary")
def rabinovich_as_printed(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """The capillary force as Elskamp & Kruggel-Emden print it, for comparison with `rabinovich`.

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    volume : float or array
        Volume V of the bridge [m³].
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    contact_angle_i : float or array
        Contact angle on body i [rad].
    contact_angle_j : float or array
        Contact angle on body j [rad].
    surface_tension : float or array
        Surface tension σ [N/m].

    Returns
    -------
    float or array
        Attraction F [N].

    Notes
    -----
    Second term 2π σ r sin θ_m sin(θ_m + φ) (here sin θ_m means sin φ: it vanishes for perfect wetting, and does not
    vanish with the volume otherwise); at a wall the first term is 2π σ r (cos θ_i + cos θ_w)/(1 + S √(π r/V)) and
    φ = √((2S/r) √(1 + V/(π r S²))) lacks the −1.

    S ≤ 0: the limit S → 0.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (14), (15), (16), (18).

    Examples
    --------
    >>> f"{rabinovich_as_printed(1e-4, 1e-10, 1e-3, 1e-3, 0.3, 0.3, 0.07):.5e}"
    '3.50482e-04'
    """
    return _as_printed(separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension)


@force_law("capillary")
def rabinovich_spheres_as_printed(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """`rabinovich_as_printed` between spheres, `rabinovich` at walls.

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    volume : float or array
        Volume V of the bridge [m³].
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    contact_angle_i : float or array
        Contact angle on body i [rad].
    contact_angle_j : float or array
        Contact angle on body j [rad].
    surface_tension : float or array
        Surface tension σ [N/m].

    Returns
    -------
    float or array
        Attraction F [N].

    Notes
    -----
    Spheres, r = r_eff:  F = π σ r (cos θ_i + cos θ_j)/(1 + S/(2d)) + 2π σ r sin θ_m sin(θ_m + φ), d and φ of `rabinovich`.

    S ≤ 0: the limit S → 0.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (14) as printed; (15) corrected, since as printed it contradicts their Fig. 5a.

    Examples
    --------
    >>> f"{rabinovich_spheres_as_printed(1e-4, 1e-10, 1e-3, 1e-3, 0.3, 0.3, 0.07):.5e}"
    '3.50482e-04'
    """
    if math.isinf(radius_j):
        return _neck_and_ring(
            separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension, False
        )
    return _as_printed(separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension)


@force_law("capillary")
def rabinovich_walls_as_printed(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """`rabinovich_as_printed` at walls, `rabinovich` between spheres.

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    volume : float or array
        Volume V of the bridge [m³].
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    contact_angle_i : float or array
        Contact angle on body i [rad].
    contact_angle_j : float or array
        Contact angle on body j [rad].
    surface_tension : float or array
        Surface tension σ [N/m].

    Returns
    -------
    float or array
        Attraction F [N].

    Notes
    -----
    Wall, r = r_i:  F = 2π σ r (cos θ_i + cos θ_w)/(1 + S √(π r/V)) + 2π σ r sin θ_m sin(θ_m + φ),
    φ = √((2S/r) √(1 + V/(π r S²))).

    S ≤ 0: the limit S → 0.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (15), (18) as printed; (14) corrected.

    Examples
    --------
    >>> f"{rabinovich_walls_as_printed(1e-4, 1e-10, 1e-3, math.inf, 0.3, 0.3, 0.07):.5e}"
    '6.43449e-04'
    """
    if math.isinf(radius_j):
        return _as_printed(separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension)
    return _neck_and_ring(
        separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension, False
    )


@force_law("capillary")
def lambert(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """Capillary force of Lambert et al. (2008): the first term of `rabinovich` alone.

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    volume : float or array
        Volume V of the bridge [m³].
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    contact_angle_i : float or array
        Contact angle on body i [rad].
    contact_angle_j : float or array
        Contact angle on body j [rad].
    surface_tension : float or array
        Surface tension σ [N/m].

    Returns
    -------
    float or array
        Attraction F [N].

    Notes
    -----
    F = π σ r (cos θ_i + cos θ_j)/(1 + S/(2d)), d = (V/(π r))/(S + √(S² + 2V/(π r))), r = r_eff (harmonic mean; 2 r_i at a wall).

    Exact for V → 0 at S of the order of √(V/r); too strong at touch by about φ, too weak near rupture. S ≤ 0: the limit
    S → 0.

    References
    ----------
    Lambert et al. 2008 (65); Elskamp & Kruggel-Emden 2018 (14), first term.

    Examples
    --------
    >>> f"{lambert(0.0, 1e-10, 1e-3, 1e-3, 0.0, 0.0, 0.07):.6e}"
    '4.398230e-04'
    """
    s = max(separation, 0.0)
    r = effective_radius(radius_i, radius_j)
    limit = math.pi * surface_tension * r * (math.cos(contact_angle_i) + math.cos(contact_angle_j))
    if s == 0.0:
        return limit
    q = volume / (math.pi * r)
    if q <= 0.0:
        return 0.0
    d = q / (s + math.sqrt(s * s + 2.0 * q))
    return limit / (1.0 + 0.5 * s / d)
