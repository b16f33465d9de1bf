"""The liquid bridge as a toroid between a sphere and a wall's film: radii, force, volume, rupture length; not itself a law.

Equation numbers are those of Buck et al. (2018). R is the sphere's radius, φ the half-filling angle, θ the contact
angle on the sphere, a = φ + θ; the bridge meets the film at zero angle. H = y − R cos φ − δ_l [m] is the height of
the contact line above the film. The volume is that of the meridian's solid of revolution minus the sphere's cap
(tests integrate it).
"""

from __future__ import annotations

import math

from numba import njit


@njit(error_model="numpy")
def radii(height: float, rim: float, angle: float, printed: bool) -> tuple[float, float]:
    """(r_m, r_a): meridional radius H/(1 + cos a) and neck r_c + r_m (sin a − 1) [m]; rim r_c = R sin φ [m], angle a [rad].

    `printed`: r_a = r_c from a = 90° on, where the neck is then not continuous. Source: (34), (35).

    >>> "{:.4e} {:.4e}".format(*radii(3e-4, 5e-4, 1.0, False))
    '1.9477e-04 4.6912e-04'
    """
    meridional = height / (1.0 + math.cos(angle))
    if printed and angle >= 0.5 * math.pi:
        return meridional, rim
    return meridional, rim + meridional * (math.sin(angle) - 1.0)


@njit(error_model="numpy")
def attraction(
    height: float, rim: float, angle: float, surface_tension: float, neck_printed: bool, suction_printed: bool
) -> float:
    """2π σ r_c sin a + π r_c² σ (1/r_m − 1/r_a) [N], attraction positive; `suction_printed` turns the second term's sign.

    Not defined at H ≤ 0 or r_a ≤ 0; negative (no bridge) close to r_a = 0. Source: (31)-(33), mended.

    >>> f"{attraction(3e-4, 5e-4, 1.0, 0.0728, False, False):.5e}"
    '3.64137e-04'
    """
    meridional, neck = radii(height, rim, angle, neck_printed)
    suction = math.pi * rim * rim * surface_tension * (1.0 / meridional - 1.0 / neck)
    line = 2.0 * math.pi * surface_tension * rim * math.sin(angle)
    return line - suction if suction_printed else line + suction


@njit(error_model="numpy")
def volume(height: float, radius: float, phi: float, angle: float, neck_printed: bool, volume_printed: bool) -> float:
    """V_b = V_1 − V_2 − V_3 − V_4 [m3], see `pieces`; `volume_printed`: without the factors π lost in print. Source: (39)-(43).

    >>> f"{volume(3e-4, 8.7e-4, 0.6109, 0.8727, False, False):.5e}"
    '1.59673e-10'
    """
    one, two, three, four = pieces(height, radius, phi, angle, neck_printed)
    total = one - two - three - four
    return total / math.pi if volume_printed else total


@njit(error_model="numpy")
def pieces(
    height: float, radius: float, phi: float, angle: float, neck_printed: bool
) -> tuple[float, float, float, float]:
    """(V_1, V_2, V_3, V_4) [m3]: cylinder, toroid's segment, triangle, cap of the sphere.

    With ψ = π − a, c = R(1 − cos φ):
    V_1 = π R_0² H; V_2 = π r_m² ψ [R_0 − (4 r_m/(3ψ)) sin²(ψ/2)]; V_3 = π r_m² sin a cos a (r_c + (2/3) r_m sin a);
    V_4 = (π/3) c² (3R − c); R_0 = r_c + r_m sin a (print: r_a + r_m, which is another radius where r_a is the printed one).
    Source: (40)-(43).

    >>> "{:.3e} {:.3e} {:.3e} {:.3e}".format(*pieces(3e-4, 8.7e-4, 0.6109, 0.8727, False))
    '3.848e-10 1.309e-10 3.056e-11 6.360e-11'
    """
    rim = radius * math.sin(phi)
    meridional, neck = radii(height, rim, angle, neck_printed)
    sine, opening = math.sin(angle), math.pi - angle
    far = neck + meridional if neck_printed else rim + meridional * sine
    half = math.sin(0.5 * opening)
    square = math.pi * meridional * meridional
    cap = radius * (1.0 - math.cos(phi))
    return (
        math.pi * far * far * height,
        square * (opening * far - 4.0 / 3.0 * meridional * half * half),
        square * sine * math.cos(angle) * (rim + 2.0 / 3.0 * meridional * sine),
        math.pi / 3.0 * cap * cap * (3.0 * radius - cap),
    )


@njit(error_model="numpy")
def rupture_length(
    bridge_volume: float, speed: float, contact_angle: float, viscosity: float, surface_tension: float
) -> float:
    """l = (1 + θ/2)(1 + √Ca) V_b^{1/3} [m], Ca = μ |v_n|/σ (Pitois et al. 2001); infinite for σ = 0 and |v_n| > 0.

    bridge_volume [m3] (taken as 0 if negative), speed |v_n| [m/s], contact_angle [rad]. Source: (36), (37).

    >>> f"{rupture_length(1e-10, 0.7, 0.2618, 1e-3, 0.07):.5e}"
    '5.77409e-04'
    """
    root = max(bridge_volume, 0.0) ** (1.0 / 3.0)
    static = (1.0 + 0.5 * contact_angle) * root
    if speed <= 0.0:
        return static
    if surface_tension <= 0.0:
        return math.inf
    return static * (1.0 + math.sqrt(viscosity * speed / surface_tension))
