"""Liquid drawn into a bridge when two films touch (Shi & McCarthy 2008, and the wall forms of Elskamp & Kruggel-Emden)."""

from __future__ import annotations

import math

from pywet.laws.force_law import force_law


@force_law("formation", "shi_mccarthy")
def formation_sphere(film_volume_i: float, radius_i: float, radius_j: float) -> float:
    """Volume drawn from sphere i by sphere j, or by a large wall (radius_j infinite).

    Parameters
    ----------
    film_volume_i : float or array
        Liquid L of the film on sphere i [m³].
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.

    Returns
    -------
    float or array
        Volume V_i drawn from the film on sphere i [m³].

    Notes
    -----
    V_i = (L_i/2)(1 − √(1 − r_j²/(r_i + r_j)²)); large wall: as for an equal sphere, (L_i/2)(1 − √0.75).

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (8), (9).

    Examples
    --------
    >>> f"{formation_sphere(1.0, 1e-3, 1e-3):.7f}"
    '0.0669873'
    """
    cap = 0.25 if math.isinf(radius_j) else (radius_j / (radius_i + radius_j)) ** 2
    return 0.5 * film_volume_i * cap / (1.0 + math.sqrt(1.0 - cap))


@force_law("formation", "shi_mccarthy")
def formation_sphere_wire(film_volume_i: float, radius_i: float, half_width: float) -> float:
    """Volume drawn from sphere i by a small wall (a wire of radius r_w < r_i): V_i = L_i r_w/(6 r_i).

    Parameters
    ----------
    film_volume_i : float or array
        Liquid L of the film on sphere i [m³].
    radius_i : float or array
        Radius of sphere i [m].
    half_width : float or array
        Half width r_w of the wire [m].

    Returns
    -------
    float or array
        Volume V_i drawn from the film on sphere i [m³].

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (12).

    Examples
    --------
    >>> f"{formation_sphere_wire(6.0, 2e-3, 1e-3):.6f}"
    '0.500000'
    """
    return film_volume_i * half_width / (6.0 * radius_i)


@force_law("formation", "shi_mccarthy")
def formation_wall(film_thickness: float, radius_i: float) -> float:
    """Volume drawn from a large wall's film: V_w = W_lf (π/4) r_i².

    Parameters
    ----------
    film_thickness : float or array
        Thickness W of the film on the wall [m].
    radius_i : float or array
        Radius of sphere i [m].

    Returns
    -------
    float or array
        Volume V_w drawn from the film on the wall [m³].

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (10).

    Examples
    --------
    >>> f"{formation_wall(1.0, 2.0):.6f}"
    '3.141593'
    """
    return film_thickness * 0.25 * math.pi * radius_i * radius_i


@force_law("formation", "shi_mccarthy")
def formation_wire(film_thickness: float, radius_i: float, half_width: float) -> float:
    """Volume drawn from a wire's film: V_w = W_lf 2 r_i r_w.

    Parameters
    ----------
    film_thickness : float or array
        Thickness W of the film on the wall [m].
    radius_i : float or array
        Radius of sphere i [m].
    half_width : float or array
        Half width r_w of the wire [m].

    Returns
    -------
    float or array
        Volume V_w drawn from the film on the wall [m³].

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (13).

    Examples
    --------
    >>> f"{formation_wire(1.0, 2.0, 0.5):.6f}"
    '2.000000'
    """
    return film_thickness * 2.0 * radius_i * half_width
