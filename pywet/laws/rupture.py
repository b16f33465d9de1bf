"""Rupture distance of a liquid bridge and its growth with speed. Sphere-wall: radius_j is infinite."""

from __future__ import annotations

import math

from pywet.laws.capillary import bridge_radius, effective_radius
from pywet.laws.force_law import force_law


@force_law("rupture")
def willett_unequal(
    volume: float, radius_i: float, radius_j: float, contact_angle_i: float, contact_angle_j: float
) -> float:
    """Static rupture distance of Willett et al. (2000) for unequal spheres.

    Parameters
    ----------
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

    Returns
    -------
    float or array
        Static rupture distance S_rup [m].

    Notes
    -----
    S_rup = r (1 + (θ_i + θ_j)/8 (1 + q)) (V*^(1/3) + (q/2 − 2/5) V*^(2/3)), V* = V/r³, r = r_eff = 2 r_i r_j/(r_i + r_j),
    q = smaller/larger radius. At a wall r = 2 r_i (the limit r_j → ∞) and q = 0.

    Valid for V* up to about 0.1.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (32); at a wall the paper puts r = r_i, 7 to 12 % short.

    Examples
    --------
    >>> f"{willett_unequal(1e-12, 1e-3, 1e-3, 0.0, 0.0):.6e}"
    '1.010000e-04'
    """
    r, q = effective_radius(radius_i, radius_j), min(radius_i, radius_j) / max(radius_i, radius_j)
    root = (volume / r**3) ** (1.0 / 3.0)
    angles = 1.0 + 0.125 * (contact_angle_i + contact_angle_j) * (1.0 + q)
    return r * angles * (root + (0.5 * q - 0.4) * root * root)


@force_law("rupture")
def willett_unequal_as_printed(
    volume: float, radius_i: float, radius_j: float, contact_angle_i: float, contact_angle_j: float
) -> float:
    """`willett_unequal` with r = r_i at a wall, as Elskamp & Kruggel-Emden print it; spheres as `willett_unequal`.

    Parameters
    ----------
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

    Returns
    -------
    float or array
        Static rupture distance S_rup [m].

    Notes
    -----
    S_rup = r (1 + (θ_i + θ_j)/8 (1 + q)) (V*^(1/3) + (q/2 − 2/5) V*^(2/3)), V* = V/r³, q = smaller/larger radius, 0 at a wall.

    Valid for V* up to about 0.1; at a wall 7 to 12 % short.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (32).

    Examples
    --------
    >>> f"{willett_unequal_as_printed(1e-12, 1e-3, math.inf, 0.0, 0.0):.6e}"
    '9.600000e-05'
    """
    r, q = bridge_radius(radius_i, radius_j), min(radius_i, radius_j) / max(radius_i, radius_j)
    root = (volume / r**3) ** (1.0 / 3.0)
    angles = 1.0 + 0.125 * (contact_angle_i + contact_angle_j) * (1.0 + q)
    return r * angles * (root + (0.5 * q - 0.4) * root * root)


@force_law("rupture")
def lian(volume: float, radius_i: float, radius_j: float, contact_angle_i: float, contact_angle_j: float) -> float:
    """Static rupture distance of Lian et al. (1993): S_rup = (1 + θ/2) V^(1/3), θ the mean contact angle.

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
        Contact angle on body j [rad].

    Returns
    -------
    float or array
        Static rupture distance S_rup [m].

    Notes
    -----
    The radii cancel: r (1 + θ/2) V*^(1/3) with V* = V/r³.

    Valid for equal spheres, θ below about 40°, V* up to about 0.01.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (30).

    Examples
    --------
    >>> f"{lian(1e-12, 1e-3, 1e-3, 0.2, 0.2):.6e}"
    '1.100000e-04'
    """
    return (1.0 + 0.25 * (contact_angle_i + contact_angle_j)) * volume ** (1.0 / 3.0)


@force_law("rupture")
def willett(volume: float, radius_i: float, radius_j: float, contact_angle_i: float, contact_angle_j: float) -> float:
    """Static rupture distance of Willett et al. (2000) for equal spheres.

    Parameters
    ----------
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

    Returns
    -------
    float or array
        Static rupture distance S_rup [m].

    Notes
    -----
    S_rup = r (1 + θ/2)(V*^(1/3) + 0.1 V*^(2/3)), V* = V/r³, r = r_eff (harmonic mean; 2 r_i at a wall), θ the mean contact angle.

    Valid for equal spheres, V* up to about 0.1.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (31).

    Examples
    --------
    >>> f"{willett(1e-12, 1e-3, 1e-3, 0.0, 0.0):.6e}"
    '1.010000e-04'
    """
    r = effective_radius(radius_i, radius_j)
    root = (volume / r**3) ** (1.0 / 3.0)
    return r * (1.0 + 0.25 * (contact_angle_i + contact_angle_j)) * (root + 0.1 * root * root)


@force_law("dynamic_rupture", "pitois")
def pitois_dynamic(speed: float, viscosity: float, surface_tension: float) -> float:
    """Factor on the rupture distance of a bridge drawn at a speed (Pitois et al. 2001): 1 + √(|v| η/σ).

    Parameters
    ----------
    speed : float or array
        Relative speed |v_i − v_j| [m/s].
    viscosity : float or array
        Dynamic viscosity η [Pa s].
    surface_tension : float or array
        Surface tension σ [N/m].

    Returns
    -------
    float or array
        Factor ≥ 1 on the static rupture distance.

    References
    ----------
    Elskamp & Kruggel-Emden 2018 (33).

    Examples
    --------
    >>> f"{pitois_dynamic(0.7, 1e-3, 0.07):.6f}"
    '1.100000'
    """
    if surface_tension <= 0.0:
        return 1.0
    return 1.0 + math.sqrt(speed * viscosity / surface_tension)
