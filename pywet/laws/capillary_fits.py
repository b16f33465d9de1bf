"""Capillary forces of a liquid bridge: fits to the exact solution, and the boundary method. Attraction positive.

At a wall (radius_j infinite) all of them are taken in the limit r_j → ∞ of the harmonic mean, r_eff = 2 r_i. `pywet
study laws` measures the accuracy of each.
"""

from __future__ import annotations

import math

from pywet.laws.capillary import effective_radius
from pywet.laws.force_law import force_law, helper


@helper
def _willett_exponent(half_gap: float, v_star: float, t: float) -> float:
    """Return f1 − f2 exp(f3 ln S* + f4 ln² S*) with Willett's coefficients, V* limited to the range of the fit."""
    x = math.log(min(max(v_star, 1e-3), 0.1))
    t2 = t * t
    f1 = (
        (-0.44507 + 0.050832 * t - 1.1466 * t2)
        + (-0.1119 - 0.000411 * t - 0.1490 * t2) * x
        + (-0.012101 - 0.0036456 * t - 0.01255 * t2) * x * x
        + (-0.0005 - 0.0003505 * t - 0.00029076 * t2) * x**3
    )
    if half_gap <= 0.0:
        return f1
    f2 = (
        (1.9222 - 0.57473 * t - 1.2918 * t2)
        + (-0.0668 - 0.1201 * t - 0.22574 * t2) * x
        + (-0.0013375 - 0.0068988 * t - 0.01137 * t2) * x * x
    )
    f3 = (
        (1.268 - 0.01396 * t - 0.23566 * t2)
        + (0.198 + 0.092 * t - 0.06418 * t2) * x
        + (0.02232 + 0.02238 * t - 0.009853 * t2) * x * x
        + (0.0008585 + 0.001318 * t - 0.00053 * t2) * x**3
    )
    f4 = (
        (-0.010703 + 0.073776 * t - 0.34742 * t2)
        + (0.03345 + 0.04543 * t - 0.09056 * t2) * x
        + (0.0018574 + 0.004456 * t - 0.006257 * t2) * x * x
    )
    s = math.log(half_gap)
    return f1 - f2 * math.exp(f3 * s + f4 * s * s)


@force_law("capillary")
def willett(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """Capillary force of Willett et al. (2000), the full fit to their exact solutions.

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
    F = 2π r σ exp(f1 − f2 exp(f3 ln S* + f4 ln² S*)), S* = (S/2)/√(V/r), f1 to f4 polynomials of ln V* and θ_m, V* = V/r³,
    r = r_eff (harmonic mean; 2 r_i at a wall), θ_m the mean contact angle.

    Valid for 1e-3 ≤ V* ≤ 0.1 and θ ≤ 40°; outside that V* the polynomials keep their value at the end of the range. S ≤
    0: 2π r σ exp f1.

    References
    ----------
    Willett et al. 2000, appendix; Elskamp & Kruggel-Emden 2018 (19), (20).

    Examples
    --------
    >>> f"{willett(0.0, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07):.5e}"
    '3.83301e-04'
    """
    r = effective_radius(radius_i, radius_j)
    if volume <= 0.0:
        return 0.0
    half_gap = 0.5 * max(separation, 0.0) / math.sqrt(volume / r)
    theta = 0.5 * (contact_angle_i + contact_angle_j)
    return 2.0 * math.pi * r * surface_tension * math.exp(_willett_exponent(half_gap, volume / r**3, theta))


@helper
def _willett_simple(
    separation: float, volume: float, ri: float, rj: float, ti: float, tj: float, tension: float
) -> float:
    r, s = effective_radius(ri, rj), max(separation, 0.0)
    limit = math.pi * r * tension * (math.cos(ti) + math.cos(tj))
    if volume <= 0.0:
        return limit if s == 0.0 else 0.0
    half_gap = 0.5 * s / math.sqrt(volume / r)
    return limit / (1.0 + 2.1 * half_gap + 10.0 * half_gap * half_gap)


@force_law("capillary")
def willett_simple(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """Simplified capillary force of Willett et al. (2000).

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
    F = π r σ (cos θ_i + cos θ_j)/(1 + 2.1 S* + 10 S*²), S* = (S/2)/√(V/r), r = r_eff (harmonic mean; 2 r_i at a wall).

    Valid for V* below about 0.01 and small θ. S ≤ 0: the limit S → 0.

    References
    ----------
    Willett et al. 2000 (12); Elskamp & Kruggel-Emden 2018 (21) with π in place of 2π.

    Examples
    --------
    >>> f"{willett_simple(1e-4, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07):.5e}"
    '9.66644e-05'
    """
    return _willett_simple(separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension)


@force_law("capillary")
def willett_simple_as_printed(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """`willett_simple` with the factor 2π that Elskamp & Kruggel-Emden print: twice the force.

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
    F = 2π r σ (cos θ_i + cos θ_j)/(1 + 2.1 S* + 10 S*²), S* = (S/2)/√(V/r), r = r_eff (harmonic mean; 2 r_i at a wall).

    S ≤ 0: the limit S → 0.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (21).

    Examples
    --------
    >>> f"{willett_simple_as_printed(1e-4, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07):.5e}"
    '1.93329e-04'
    """
    return 2.0 * _willett_simple(
        separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension
    )


@helper
def _weigert(separation: float, volume: float, ri: float, rj: float, ti: float, tj: float, printed: bool) -> float:
    """Return F/σ of Weigert & Ripperger; `printed`: with the whole of S in the meridian's height and sin θ_m for sin φ."""
    if volume <= 0.0:
        return 0.0
    r, theta, separation = effective_radius(ri, rj), 0.5 * (ti + tj), max(separation, 0.0)
    sine4 = volume / (0.12 * (2.0 * r) ** 3 * (1.0 + 3.0 * separation / r) * (1.0 + 1.1 * math.sin(theta)))
    phi = math.asin(min(sine4, 1.0) ** 0.25)
    opening = math.cos(phi + theta)
    sine = math.sin(phi + theta)
    height = r * (1.0 - math.cos(phi)) + (1.0 if printed else 0.5) * separation
    # R1 = height/opening; R1 (sin − 1) = −height opening/(1 + sin), finite where the meridian turns from hollow to full
    second = r * math.sin(phi) - height * opening / (1.0 + sine)
    pressure = opening / height - 1.0 / second
    line = math.sin(theta) if printed else math.sin(phi)
    return math.pi * r * r * pressure * math.sin(phi) ** 2 + 2.0 * math.pi * r * line * sine


@force_law("capillary")
def weigert(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """Capillary force of Weigert & Ripperger (1999), the boundary method.

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
    F = (π/4)(2r)² p sin²φ + 2π σ r sin φ sin(θ_m + φ), p = σ(1/R1 − 1/R2), R1 = (r(1 − cos φ) + S/2)/cos(φ + θ_m),
    R2 = r sin φ + R1 (sin(φ + θ_m) − 1), sin⁴φ = V/(0.12 (2r)³ (1 + 6S/(2r))(1 + 1.1 sin θ_m)), r = r_eff (2 r_i at a wall).

    Made for spheres near contact; poor at larger gaps. sin⁴φ is limited to 1. S ≤ 0: S = 0.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (22)-(24), corrected.

    Examples
    --------
    >>> f"{weigert(0.0, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07):.5e}"
    '3.71106e-04'
    """
    force = _weigert(separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, False)
    return surface_tension * force


@force_law("capillary")
def weigert_as_printed(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """`weigert` with the misprints of Elskamp & Kruggel-Emden that can be evaluated.

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
    S in place of S/2 in (24), and sin θ_m in place of sin φ in the second term of (22). The other misprints of (23), (24), a
    square for a cube and a product for a sum, are not lengths and cannot be evaluated; they are mended here too.

    S ≤ 0: S = 0.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (22)-(24).

    Examples
    --------
    >>> f"{weigert_as_printed(0.0, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07):.5e}"
    '3.26217e-04'
    """
    force = _weigert(separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, True)
    return surface_tension * force


@force_law("capillary")
def soulie(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """Capillary force of Soulié et al. (2006), a fit for unequal spheres.

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
    F = π σ √(r_i r_j) (c + exp(a S/R + b)), R the larger radius, v = V/R³, a = −1.1 v^(−0.53),
    b = (−0.148 ln v − 0.96) θ² − 0.0082 ln v + 0.48, c = 0.0018 ln v + 0.078; never below 0.

    Fitted to small volumes; no limit for r_j → ∞, at a wall √(r_i r_j) and R are taken as 2 r_i. S ≤ 0: S = 0.

    References
    ----------
    Soulié et al. 2006 (4)-(7).

    Examples
    --------
    >>> f"{soulie(0.0, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07):.5e}"
    '3.84401e-04'
    """
    if volume <= 0.0:
        return 0.0
    if math.isinf(radius_j):
        mean = larger = 2.0 * radius_i
    else:
        mean, larger = math.sqrt(radius_i * radius_j), max(radius_i, radius_j)
    theta = 0.5 * (contact_angle_i + contact_angle_j)
    v = volume / larger**3
    x = math.log(v)
    b = (-0.148 * x - 0.96) * theta * theta - 0.0082 * x + 0.48
    decay = math.exp(-1.1 * v ** (-0.53) * max(separation, 0.0) / larger + b)
    return max(math.pi * surface_tension * mean * (0.0018 * x + 0.078 + decay), 0.0)


@force_law("capillary")
def bagheri(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """Capillary force of Bagheri, Roy & Pöschel (2024), a fit to exact solutions over a wide range.

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
    F = r σ f (1 + a s)/(1 + t b a s + t b s²), s = S/S_rup, S_rup = r (1 + θ/2)(V*^(1/3) + 0.1 V*^(2/3)),
    f = 2π (1 − 0.3823 V*^0.2586)(1 − (0.4158 V*^0.2835 + 0.6474) sin^m θ), m = 2.267 − 0.2087 V*^0.3113,
    a = 0.6717 V*^0.1995 − 0.3319 V*^0.4974, b = 13.84 V*^−0.3909 − 12.11 V*^−0.3945,
    t = (−0.007815 ln²V* − 0.2105 ln V* − 1.426) θ³ + (0.6669 V*^−0.01391 − 1.78 V*^0.8351) θ + 1, r = r_eff (2 r_i at a wall).

    Made for equal spheres. S ≤ 0: S = 0.

    References
    ----------
    Bagheri et al. 2024 (24)-(30); coefficients as in the open code of the same group, checked against the exact
    solution in the law comparison.

    Examples
    --------
    >>> f"{bagheri(0.0, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07):.5e}"
    '3.88716e-04'
    """
    if volume <= 0.0:
        return 0.0
    r = effective_radius(radius_i, radius_j)
    theta = 0.5 * (contact_angle_i + contact_angle_j)
    v = volume / r**3
    x = math.log(v)
    power = 2.267 - 0.2087 * v**0.3113
    wetting = 1.0 - (0.4158 * v**0.2835 + 0.6474) * math.sin(theta) ** power
    touch = 2.0 * math.pi * (1.0 - 0.3823 * v**0.2586) * wetting
    s = max(separation, 0.0) / (r * (1.0 + 0.5 * theta) * (v ** (1.0 / 3.0) + 0.1 * v ** (2.0 / 3.0)))
    a = 0.6717 * v**0.1995 - 0.3319 * v**0.4974
    b = 13.84 * v**-0.3909 - 12.11 * v**-0.3945
    t = (-0.007815 * x * x - 0.2105 * x - 1.426) * theta**3 + (0.6669 * v**-0.01391 - 1.78 * v**0.8351) * theta + 1.0
    return r * surface_tension * touch * (1.0 + a * s) / (1.0 + t * b * (a * s + s * s))
