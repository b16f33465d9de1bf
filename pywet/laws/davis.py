"""Laws of Davis 2023 (finite-film lubrication, capillary suction) for bridges in the engine.

radius_j is infinite at a wall. The laws of the paper use the gap δ at which two films touch; a bridge of the engine has
its volume. The formation law here draws π a² h_i from each film h_i (a = r_red = r_i r_j/(r_i + r_j); wall: r_i), so that
a bridge of volume V has δ = V/(π a²) exactly, and every law computes δ from V. Consequently two equal spheres give 1/16
of their films to each bridge (the paper's films lose nothing), and the transfer law determines the share that each
receives back. The tangential laws of the engine do not receive the volume: `tangential` makes them for one stated δ.

The paper's solid contact is at h = h_min, the engine's at S = 0: h = max(S, 0) + S_min with S_min = 0.001 r_eff
corresponds to h_min, and δ + S_min to the paper's δ.
"""

from __future__ import annotations

import math

from pywet.laws import contact
from pywet.laws.force_law import ForceLaw, force_law, helper, register
from pywet.laws.viscous import lubricated_gap, reduced_radius

NOMINAL_FILM = 0.04
"""Film gap δ in units of r_red for which the registered tangential law is made: the paper's ĥ_a = 0.01 for equal spheres."""


@helper
def film_gap(volume: float, radius_i: float, radius_j: float) -> float:
    """Return δ = V/(π a²) [m] of a bridge drawn by `formation_sphere`."""
    a = reduced_radius(radius_i, radius_j)
    return volume / (math.pi * a * a)


thickness = helper(contact.film_thickness)


@force_law("capillary", "davis")
def capillary(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """Capillary suction of Davis & Sitison (2020): constant 8π a σ while the films overlap.

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
    F = 8π a σ for S < δ, 0 beyond; a = r_red = r_i r_j/(r_i + r_j) (wall: r_i), δ = V/(π a²). Contact angles are not used.

    Valid for wetting films thin against the radius. S ≤ 0: the same. It is twice the exact limit 4π a σ of little
    liquid with contact angle 0.

    References
    ----------
    Davis 2023 (3).

    Examples
    --------
    >>> f"{capillary(0.0, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07):.6e}"
    '8.796459e-04'
    """
    if separation >= film_gap(volume, radius_i, radius_j):
        return 0.0
    return 8.0 * math.pi * reduced_radius(radius_i, radius_j) * surface_tension


@force_law("viscous_normal", "davis")
def normal(
    separation: float, volume: float, radius_i: float, radius_j: float, normal_velocity: float, viscosity: float
) -> float:
    """Normal lubrication of a film of finite extent (Davis & Sitison 2020).

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
    F = −6π η a² v_n [1 − h/(2δ' − h)]²/h for h < δ', 0 beyond; h = max(S, 0) + S_min, δ' = V/(π a²) + S_min,
    a = r_red = r_i r_j/(r_i + r_j) (wall: r_i), S_min = 0.001 r_eff (wall: 0.001 r_i).

    Valid for films thin against the radius. S ≤ 0: the value at S_min.

    References
    ----------
    Davis 2023 (3).

    Examples
    --------
    >>> f"{normal(1e-6, 1e-11, 1e-3, 1e-3, 0.1, 0.05):.6e}"
    '-1.000309e-02'
    """
    h = lubricated_gap(separation, radius_i, radius_j)
    film = film_gap(volume, radius_i, radius_j) + lubricated_gap(0.0, radius_i, radius_j)
    if h >= film:
        return 0.0
    a = reduced_radius(radius_i, radius_j)
    finite = 1.0 - h / (2.0 * film - h)
    return -6.0 * math.pi * viscosity * a * a * normal_velocity * finite * finite / h


def tangential(film_over_a: float) -> tuple[ForceLaw, ForceLaw]:
    """Make the tangential law for films that touch at δ = film_over_a · r_red.

    Parameters
    ----------
    film_over_a : float
        Sum δ of the film thicknesses over r_red [-].

    Returns
    -------
    tuple of ForceLaw
        Coefficients of translation and of spin [kg/s], which are equal.

    Notes
    -----
    c = 2π η a ln[(2δ' − h)/h] for h < δ', 0 beyond; h = max(S, 0) + S_min, δ' = δ + S_min, a = r_red (wall: r_i).
    The force on i is −c v_t − c v_rot with v_rot = −(r_i ω_i + r_j ω_j) × n, so −c times the slip.

    References
    ----------
    Davis 2023 (4).

    Examples
    --------
    >>> f"{tangential(0.02)[0](1e-6, 1e-3, 1e-3, 0.05):.6e}"
    '3.616892e-04'
    """

    def translation(separation: float, radius_i: float, radius_j: float, viscosity: float) -> float:
        a = reduced_radius(radius_i, radius_j)
        h = lubricated_gap(separation, radius_i, radius_j)
        film = film_over_a * a + lubricated_gap(0.0, radius_i, radius_j)
        if h >= film:
            return 0.0
        return 2.0 * math.pi * viscosity * a * math.log((2.0 * film - h) / h)

    law = force_law(translation)
    return law, law


@force_law("rupture", "davis")
def rupture(volume: float, radius_i: float, radius_j: float, contact_angle_i: float, contact_angle_j: float) -> float:
    """Distance at which the films part, δ = V/(π a²), a = r_red = r_i r_j/(r_i + r_j) (wall: r_i).

    Parameters
    ----------
    volume : float or array
        Volume V of the bridge [m³].
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    contact_angle_i : float or array
        Contact angle on body i [rad]; not used.
    contact_angle_j : float or array
        Contact angle on body j [rad]; not used.

    Returns
    -------
    float or array
        Sum δ of the film thicknesses [m].

    References
    ----------
    Davis 2023, after (33).

    Examples
    --------
    >>> f"{rupture(3.0e-12, 1e-3, 1e-3, 0.0, 0.0):.6e}"
    '3.819719e-06'
    """
    return film_gap(volume, radius_i, radius_j)


@force_law("formation", "davis")
def formation_sphere(film_volume_i: float, radius_i: float, radius_j: float) -> float:
    """Volume drawn from sphere i: V_i = π a² h_i, a = r_red (large wall: r_i), so that V = π a² δ with δ = h_i + h_j.

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
    Film thickness h_i = (3L_i/(4π) + r_i³)^(1/3) − r_i. The draw is a matter of bookkeeping (see the module), close to
    the 0.067 L_i of Shi & McCarthy for equal spheres.

    Examples
    --------
    >>> f"{formation_sphere(1.2566e-10, 1e-3, 1e-3):.6e}"
    '7.776498e-12'
    """
    a = reduced_radius(radius_i, radius_j)
    return math.pi * a * a * thickness(film_volume_i, radius_i)


@force_law("formation", "davis")
def formation_sphere_wire(film_volume_i: float, radius_i: float, half_width: float) -> float:
    """Volume drawn from sphere i by a wire: as by a large wall, π r_i² h_i (a wire's force laws are those of a wall).

    Parameters
    ----------
    film_volume_i : float or array
        Liquid L of the film on sphere i [m³].
    radius_i : float or array
        Radius of sphere i [m].
    half_width : float or array
        Half width r_w of the wire [m]; not used.

    Returns
    -------
    float or array
        Volume V_i drawn from the film on sphere i [m³].

    Examples
    --------
    >>> f"{formation_sphere_wire(1.2566e-10, 1e-3, 1e-3):.6e}"
    '3.110599e-11'
    """
    return math.pi * radius_i * radius_i * thickness(film_volume_i, radius_i)


@force_law("formation", "davis")
def formation_wall(film_thickness: float, radius_i: float) -> float:
    """Volume drawn from a large wall's film W: V_w = π r_i² W.

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

    Examples
    --------
    >>> f"{formation_wall(1e-5, 1e-3):.6e}"
    '3.141593e-11'
    """
    return math.pi * radius_i * radius_i * film_thickness


@force_law("formation", "davis")
def formation_wire(film_thickness: float, radius_i: float, half_width: float) -> float:
    """Volume drawn from a wire's film W: V_w = π r_i² W.

    Parameters
    ----------
    film_thickness : float or array
        Thickness W of the film on the wall [m].
    radius_i : float or array
        Radius of sphere i [m].
    half_width : float or array
        Half width r_w of the wire [m]; not used.

    Returns
    -------
    float or array
        Volume V_w drawn from the film on the wall [m³].

    Examples
    --------
    >>> f"{formation_wire(1e-5, 1e-3, 5e-4):.6e}"
    '3.141593e-11'
    """
    return math.pi * radius_i * radius_i * film_thickness


TANGENTIAL = tangential(NOMINAL_FILM)
"""Registered pair of tangential coefficients, for δ = NOMINAL_FILM · r_red."""
TANGENTIAL[0].__doc__ = """Coefficient of the tangential lubrication of a film of finite extent, for δ = 0.04 r_red.

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
        Coefficient c [kg/s] of slip and of spin; 0 where the films do not touch.

    Notes
    -----
    `tangential` makes the law for another δ.

    References
    ----------
    Davis 2023 (4).

    Examples
    --------
    >>> f"{translation(1e-6, 1e-3, 1e-3, 0.05):.6e}"
    '4.705685e-04'
    """
register("viscous_tangential", "davis", *TANGENTIAL)
