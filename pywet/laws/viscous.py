"""Viscous forces of a liquid bridge, normal and tangential. Sphere-wall: radius_j is infinite and r_red = r_i."""

from __future__ import annotations

import math

from pywet.laws import contact
from pywet.laws.force_law import force_law, helper

reduced_radius = helper(contact.reduced_radius)
S_MIN = contact.S_MIN


@helper
def lubricated_gap(separation: float, radius_i: float, radius_j: float) -> float:
    """Return max(S, 0) + S_min with S_min = 0.001 r_eff [m] (Elskamp & Kruggel-Emden 2018, after 29; r_eff = r_i at a wall)."""
    if math.isinf(radius_j):
        return max(separation, 0.0) + S_MIN * radius_i
    return max(separation, 0.0) + 2.0 * S_MIN * radius_i * radius_j / (radius_i + radius_j)


@helper
def _slide(separation: float, radius_i: float, radius_j: float, viscosity: float) -> float:
    """Return 6π η r ((8/15) ln(r/S) + 0.9588), at least 0, r = r_red, S → max(S, 0) + S_min."""
    r = reduced_radius(radius_i, radius_j)
    log = math.log(r / lubricated_gap(separation, radius_i, radius_j))
    return max(6.0 * math.pi * viscosity * r * (8.0 / 15.0 * log + 0.9588), 0.0)  # a drag never pushes


@force_law("viscous_normal")
def pitois(
    separation: float, volume: float, radius_i: float, radius_j: float, normal_velocity: float, viscosity: float
) -> float:
    """Normal viscous force of Pitois et al. (2000): lubrication in a bridge of finite volume.

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
    normal_velocity : float or array
        Relative velocity v_n = (v_i − v_j)·n [m/s], n from j to i.
    viscosity : float or array
        Dynamic viscosity η [Pa s].

    Returns
    -------
    float or array
        Component along n of the force on i [N].

    Notes
    -----
    F = −(6π η r² v_n/S)(1 − 1/√(1 + V/(π r S²)))², r = r_red = r_i r_j/(r_i + r_j) (wall: r_i), S → max(S, 0) + S_min.

    Valid for gaps small against the radius and low capillary Reynolds number. S ≤ 0: the value at S_min.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (26).

    Examples
    --------
    >>> f"{pitois(0.0, 1e-9, 1e-3, 1e-3, 0.1, 1e-3):.5e}"
    '-4.70058e-04'
    """
    r = reduced_radius(radius_i, radius_j)
    s = lubricated_gap(separation, radius_i, radius_j)
    a = volume / (math.pi * r * s * s)
    root = math.sqrt(1.0 + a)
    finite = a / (root * (root + 1.0))  # 1 − 1/√(1 + a) without cancellation
    return -6.0 * math.pi * viscosity * r * r * normal_velocity / s * finite * finite


@force_law("viscous_normal")
def adams_perchard(
    separation: float, volume: float, radius_i: float, radius_j: float, normal_velocity: float, viscosity: float
) -> float:
    """Normal viscous force of Adams & Perchard (1985): lubrication with unlimited liquid.

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    volume : float or array
        Volume of the bridge [m³]; not used.
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    normal_velocity : float or array
        Relative velocity v_n = (v_i − v_j)·n [m/s], n from j to i.
    viscosity : float or array
        Dynamic viscosity η [Pa s].

    Returns
    -------
    float or array
        Component along n of the force on i [N].

    Notes
    -----
    F = −6π η r² v_n/S, r = r_red = r_i r_j/(r_i + r_j) (wall: r_i), S → max(S, 0) + S_min.

    Valid for gaps small against the radius, and against the wetted radius. S ≤ 0: the value at S_min.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (25).

    Examples
    --------
    >>> f"{adams_perchard(0.0, 1e-9, 1e-3, 1e-3, 0.1, 1e-3):.5e}"
    '-4.71239e-04'
    """
    r = reduced_radius(radius_i, radius_j)
    return -6.0 * math.pi * viscosity * r * r * normal_velocity / lubricated_gap(separation, radius_i, radius_j)


@force_law("viscous_tangential", "goldman")
def goldman_translation(separation: float, radius_i: float, radius_j: float, viscosity: float) -> float:
    """Coefficient c_t of the tangential viscous force −c_t v_t (Goldman, Cox & Brenner 1967).

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    viscosity : float or array
        Dynamic viscosity η [Pa s].

    Returns
    -------
    float or array
        Coefficient c_t of slip [kg/s].

    Notes
    -----
    c_t = 6π η r ((8/15) ln(r/S) + 0.9588), r = r_red (wall: r_i), S → max(S, 0) + S_min.

    Valid for S below about r; S ≤ 0: the value at S_min; 0 from S = 6.04 r, where the series becomes negative.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (28), (29).

    Examples
    --------
    >>> f"{goldman_translation(0.0, 1e-3, 1e-3, 1e-3):.5e}"
    '4.02745e-05'
    """
    return _slide(separation, radius_i, radius_j, viscosity)


@force_law("viscous_tangential", "goldman")
def goldman_rotation(separation: float, radius_i: float, radius_j: float, viscosity: float) -> float:
    """Coefficient c_r of the tangential viscous force −c_r v_rot of the spins (Goldman, Cox & Brenner 1967).

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    viscosity : float or array
        Dynamic viscosity η [Pa s].

    Returns
    -------
    float or array
        Coefficient c_r of spin [kg/s].

    Notes
    -----
    S < 0.1 r:  c_r = 6π η r ((2/15) ln(r/S) − 0.2526);  beyond:  c_r = 6π η r (1/8)(r/(S + r))⁴(1 − 3r/(8(S + r))),
    r = r_red (wall: r_i), S → max(S, 0) + S_min; v_rot = −(r_i ω_i + r_j ω_j) × n with n from j to i.

    The two branches do not meet exactly (0.0544 against 0.0563 at S = 0.1 r). S ≤ 0: the value at S_min.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (28), (29).

    Examples
    --------
    >>> f"{goldman_rotation(0.0, 1e-3, 1e-3, 1e-3):.5e}"
    '5.42881e-06'
    """
    r = reduced_radius(radius_i, radius_j)
    s = lubricated_gap(separation, radius_i, radius_j)
    if s < 0.1 * r:
        return 6.0 * math.pi * viscosity * r * (2.0 / 15.0 * math.log(r / s) - 0.2526)
    q = r / (s + r)
    return 6.0 * math.pi * viscosity * r * 0.125 * q**4 * (1.0 - 0.375 * q)


@force_law("viscous_tangential", "lian")
def lian_translation(separation: float, radius_i: float, radius_j: float, viscosity: float) -> float:
    """Coefficient c_t of the tangential viscous force −c_t (v_t + v_rot) of Lian et al. (1998).

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    viscosity : float or array
        Dynamic viscosity η [Pa s].

    Returns
    -------
    float or array
        Coefficient c_t of slip [kg/s].

    Notes
    -----
    c_t = 6π η r ((8/15) ln(r/S) + 0.9588), r = r_red (wall: r_i), S → max(S, 0) + S_min.

    Valid for S below about r; S ≤ 0: the value at S_min; 0 from S = 6.04 r, where the series becomes negative.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (27).

    Examples
    --------
    >>> f"{lian_translation(0.0, 1e-3, 1e-3, 1e-3):.5e}"
    '4.02745e-05'
    """
    return _slide(separation, radius_i, radius_j, viscosity)


@force_law("viscous_tangential", "lian")
def lian_rotation(separation: float, radius_i: float, radius_j: float, viscosity: float) -> float:
    """Coefficient c_r of the tangential viscous force −c_r v_rot of the spins (Lian et al. 1998): that of translation.

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    viscosity : float or array
        Dynamic viscosity η [Pa s].

    Returns
    -------
    float or array
        Coefficient c_r of spin [kg/s].

    Notes
    -----
    c_r = 6π η r ((8/15) ln(r/S) + 0.9588), r = r_red (wall: r_i), S → max(S, 0) + S_min;
    v_rot = −(r_i ω_i + r_j ω_j) × n with n from j to i. Up to eight times `goldman_rotation`.

    S ≤ 0: the value at S_min; 0 from S = 6.04 r, where the series becomes negative.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (27).

    Examples
    --------
    >>> f"{lian_rotation(0.0, 1e-3, 1e-3, 1e-3):.5e}"
    '4.02745e-05'
    """
    return _slide(separation, radius_i, radius_j, viscosity)
