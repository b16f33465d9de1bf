"""The forces of Buck et al.

(2018) in the engine's form: functions of gap and volume of one bridge. Equation numbers are those of the paper. Since
the engine stores neither the layer's thickness nor the phase of a collision, the gap is measured from the solid wall,
the half-filling angle φ follows from the bridge's volume (that of the toroid at touch), and the forces act from
formation to rupture, except in contact (phase II of the paper has none). Differences are listed in
docs/wall_collision.md.
"""

from __future__ import annotations

import math

from pywet.laws import contact
from pywet.laws.force_law import force_law, helper
from pywet.laws.toroid import attraction, radii
from pywet.laws.toroid import volume as toroid_volume

GAP_MIN = 0.5e-6
"""Smallest gap of the viscous laws [m] (text after 28), independent of the radius."""
WATER_DENSITY = 998.0
"""Density in the Reynolds number of `buck_water` [kg/m3] (table 2), because a law does not receive the liquid's density."""


half_radius, reduced_radius = helper(contact.bridge_radius), helper(contact.reduced_radius)


@helper
def half_filling(volume_over_cube: float, theta: float) -> float:
    """Return the half-filling angle φ [rad] of a volume over R³ between touching bodies, by bisection, between 1e-3 and 90°."""
    low, high = 1e-3, 0.5 * math.pi
    for _ in range(50):
        middle = 0.5 * (low + high)
        if toroid_volume(1.0 - math.cos(middle), 1.0, middle, middle + theta, False, False) < volume_over_cube:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@helper
def _half(volume: float, radius_i: float, radius_j: float, theta: float) -> tuple[float, float, float]:
    """Return the share of a bridge in one toroid (two spheres have two), its radius R [m] and its φ [rad]."""
    radius, share = half_radius(radius_i, radius_j), 1.0 if math.isinf(radius_j) else 0.5
    return share, radius, half_filling(share * volume / radius**3, theta)


@helper
def _goldman(separation: float, radius_i: float, radius_j: float, viscosity: float) -> tuple[float, float]:
    """Return 6π η r [kg/s] and Λ = ln(r/S) ≥ 0, r = r_red."""
    r = reduced_radius(radius_i, radius_j)
    return 6.0 * math.pi * viscosity * r, max(math.log(r / max(separation, GAP_MIN)), 0.0)


@force_law("capillary")
def buck(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """Capillary force of the toroid of Buck et al. (2018); zero angle on the other side (a film), none in contact.

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
        Contact angle on body j [rad]; not used.
    surface_tension : float or array
        Surface tension σ [N/m].

    Returns
    -------
    float or array
        Attraction F ≥ 0 [N].

    Notes
    -----
    F = 2π σ r_c sin a + π r_c² σ (1/r_m − 1/r_a), a = φ + θ_i, r_c = R sin φ, r_m = (S + R(1 − cos φ))/(1 + cos a),
    r_a = r_c + r_m (sin a − 1); R = r_i at a wall; spheres: two such halves with V/2, S/2 and R = r_eff. φ from V at touch.

    0 where the neck closes. S < 0: 0 (phase II has no liquid force).

    References
    ----------
    (31)-(35), with the signs of docs/wall_collision.md.

    Examples
    --------
    >>> f"{buck(1e-4, 1e-10, 1e-3, float('inf'), 0.2618, 0.0, 0.0728):.5e}"
    '5.10375e-04'
    """
    if separation < 0.0 or volume <= 0.0:
        return 0.0
    share, radius, phi = _half(volume, radius_i, radius_j, contact_angle_i)
    height = share * separation + radius * (1.0 - math.cos(phi))
    rim, angle = radius * math.sin(phi), phi + contact_angle_i
    if radii(height, rim, angle, False)[1] <= 0.0:
        return 0.0
    return max(attraction(height, rim, angle, surface_tension, False, False), 0.0)


@force_law("viscous_normal")
def buck_water(
    separation: float, volume: float, radius_i: float, radius_j: float, normal_velocity: float, viscosity: float
) -> float:
    """Normal viscous force of Buck et al. (2018) for water: the larger of drag and lubrication, none in contact.

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
    F = −max(6π η r_c v (1 + Re/(4(1 + √Re)) + Re/60), 6π η r_red² v/max(S, 0.5 µm)), r_c = R sin φ, Re = 2 r_c |v| ρ/η with
    ρ = 998 kg/m3; φ from V at touch with a contact angle of 15°; r_red = r_i r_j/(r_i + r_j) (wall: r_i).

    S < 0: 0 (phase II has no liquid force).

    References
    ----------
    (25)-(28) with the gap S.

    Examples
    --------
    >>> f"{buck_water(1e-4, 1e-10, 1e-3, float('inf'), 0.5, 1e-3):.5e}"
    '-9.42478e-05'
    """
    if separation < 0.0 or volume <= 0.0:
        return 0.0
    share, radius, phi = _half(volume, radius_i, radius_j, 0.2617993877991494)
    reduced, rim = radius * share, radius * math.sin(phi)
    inertia = 2.0 * rim * abs(normal_velocity) * WATER_DENSITY
    if viscosity <= 0.0:  # remaining factor of the drag, without the viscosity
        return -math.pi / 10.0 * rim * inertia * normal_velocity
    reynolds = inertia / viscosity
    drag = rim * (1.0 + 0.25 * reynolds / (1.0 + math.sqrt(reynolds)) + reynolds / 60.0)
    return -6.0 * math.pi * viscosity * max(drag, reduced * reduced / max(separation, GAP_MIN)) * normal_velocity


@force_law("viscous_tangential", "buck")
def buck_translation(separation: float, radius_i: float, radius_j: float, viscosity: float) -> float:
    """Coefficient c_t of the tangential viscous force −c_t v_t, (29): 6π η r ((8/15) Λ + 0.9588), Λ = ln(r/S) ≥ 0.

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
    S < 0: 0. Their moment (30) cannot be had: the engine turns a sphere by lever arm times this force.

    Examples
    --------
    >>> f"{buck_translation(1e-4, 1e-3, float('inf'), 1e-3):.5e}"
    '4.12211e-05'
    """
    if separation < 0.0:
        return 0.0
    scale, log = _goldman(separation, radius_i, radius_j, viscosity)
    return scale * (8.0 / 15.0 * log + 0.9588)


@force_law("viscous_tangential", "buck")
def buck_rotation(separation: float, radius_i: float, radius_j: float, viscosity: float) -> float:
    """Coefficient c_r of the tangential viscous force −c_r v_rot of the spins, (29): 6π η r ((2/15) Λ − 0.2526).

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
        Coefficient c_r of spin [kg/s]; 0 in overlap.

    Notes
    -----
    Negative where S > 0.15 r, as in the paper.

    Examples
    --------
    >>> f"{buck_rotation(1e-4, 1e-3, float('inf'), 1e-3):.5e}"
    '1.02563e-06'
    """
    if separation < 0.0:
        return 0.0
    scale, log = _goldman(separation, radius_i, radius_j, viscosity)
    return scale * (2.0 / 15.0 * log - 0.2526)


@force_law("rupture", "buck")
def buck_rupture(
    volume: float, radius_i: float, radius_j: float, contact_angle_i: float, contact_angle_j: float
) -> float:
    """Static rupture distance (1 + θ_i/2) V^{1/3} (Pitois et al. 2001); with the dynamic factor `pitois` it is (36).

    Parameters
    ----------
    volume : float or array
        Volume V of the bridge [m³].
    radius_i : float or array
        Radius of sphere i [m]; not used.
    radius_j : float or array
        Radius of body j [m]; not used.
    contact_angle_i : float or array
        Contact angle on body i [rad].
    contact_angle_j : float or array
        Contact angle on body j [rad]; not used.

    Returns
    -------
    float or array
        Static rupture distance S_rup [m].

    Examples
    --------
    >>> f"{buck_rupture(1e-12, 1e-3, float('inf'), 0.2, 0.0):.5e}"
    '1.10000e-04'
    """
    return (1.0 + 0.5 * contact_angle_i) * volume ** (1.0 / 3.0)
