"""How many spheres, how much liquid, how short a time step: plain functions of a scene's parts, in SI units."""

from __future__ import annotations

import math
from collections.abc import Sequence

from scipy.optimize import brentq

from pywet.config import Case, Config, Scale
from pywet.config.cases import CLASS_NAMES
from pywet.errors import PywetError
from pywet.laws.contact import S_MIN, bridge_radius, film_volume, pair_mass, pair_radii, reduced_radius
from pywet.planning.size_distribution import Amount, amounts
from pywet.scene import ContactPair, SphereClass

THINNEST = 1e-13
"""Thinnest film over the radius of its sphere; below it, their sum in double precision hardly knows of the film."""


def amounts_of(config: Config, case: Case, scale: Scale) -> tuple[Amount, ...]:
    """What is asked for and made of each class: its mass or volume where the case says it, else the reference material's mass.

    All for the sieve of `feed`, in proportion to the sieve's area. The same number of the same sizes as the reference material is
    the same volume, as the paper chose glass (section 5.1). Raises `ConfigError` where a class is less than half a sphere.
    """
    materials = config.materials
    screen = materials.screen(case.aperture_mm)
    pitch = 1e-3 * (screen.aperture_mm.value + screen.wire_diameter_mm.value)
    feed = materials.feed
    share = scale.sieve_area_m2(pitch) / (0.25 * math.pi * (1e-3 * feed.sieve_diameter_mm.value) ** 2)
    if case.class_volume_cm3 is not None:
        sizes = [4.0 / 3.0 * math.pi * (0.05 * d) ** 3 for d in case.diameters_mm]
        wanted = [share * case.class_volume_cm3 / volume for volume in sizes]
    else:
        material = feed.reference_material if case.class_mass_g is None else case.material
        class_mass = 1e-3 * (feed.class_mass_g.value if case.class_mass_g is None else case.class_mass_g)
        wanted = [share * class_mass / config.size(material, d).sphere_mass_kg for d in case.diameters_mm]
    masses = [config.size(case.material, d).sphere_mass_kg for d in case.diameters_mm]
    asked = [n * mass for n, mass in zip(wanted, masses, strict=True)]
    return amounts(CLASS_NAMES, asked, masses, f"case {case.case}, {case.name}")


def liquid_volume(classes: Sequence[SphereClass], liquid_percent: float, density_kg_per_m3: float) -> float:
    """Liquid [m3] that weighs `liquid_percent` of the spheres."""
    return 0.01 * liquid_percent * sum(c.count * c.mass_kg for c in classes) / density_kg_per_m3


def common_film_thickness(classes: Sequence[SphereClass], volume_m3: float) -> float:
    """Thickness h [m] with sum of 4/3 pi ((r+h)^3 - r^3) = volume: the same film on every sphere."""
    if volume_m3 <= 0:
        return 0.0
    area = sum(c.count * 4.0 * math.pi * c.radius_m**2 for c in classes)
    upper = volume_m3 / area  # as if flat: a sphere's film of this thickness holds more
    refuse_too_thin(upper, classes)

    def excess(share: float) -> float:
        return sum(c.count * film_volume(share * upper, c.radius_m) for c in classes) / volume_m3 - 1.0

    return upper * float(brentq(excess, 0.0, 1.0, xtol=1e-16, rtol=1e-15))


def refuse_too_thin(film_m: float, classes: Sequence[SphereClass]) -> None:
    """Refuse a film that is lost where it is added to a radius."""
    radius = max(c.radius_m for c in classes)
    if 0.0 < film_m < THINNEST * radius:
        raise PywetError(
            f"the liquid makes a film of {film_m:.3g} m on spheres of {2e3 * radius:g} mm, which round-off swallows; expected "
            f"none or at least {THINNEST * radius:.2g} m: more liquid, or none"
        )


def collision_time(pair: ContactPair, classes: Sequence[SphereClass]) -> float:
    """Half period [s] of the damped contact spring, the shorter of normal and tangential; E after (5).

    t_c = pi sqrt(m_eff/k)/sqrt(1 - zeta^2), zeta = -ln e/sqrt(pi^2 + ln^2 e). The tangential spring moves 2/7 of m_eff.
    """
    m_eff, log_e = pair_mass(classes, pair), math.log(pair.restitution)
    normal = math.sqrt(m_eff / pair.normal_stiffness_N_per_m) * math.hypot(math.pi, log_e)
    tangential = math.pi * math.sqrt(2.0 / 7.0 * m_eff / pair.tangential_stiffness_N_per_m)
    return min(normal, tangential)


def damping_time(pair: ContactPair, classes: Sequence[SphereClass], viscosity_Pa_s: float) -> float:
    """Shortest time m_eff/c [s] in which lubrication at the smallest gap stops a pair; c = 6 pi eta r_red^2/S_min."""
    radii = pair_radii(classes, pair)
    r_red, gap = reduced_radius(*radii), S_MIN * bridge_radius(*radii)
    return pair_mass(classes, pair) * gap / (6.0 * math.pi * viscosity_Pa_s * r_red**2)


def time_step(
    pairs: Sequence[ContactPair], classes: Sequence[SphereClass], fraction: float, viscosity_Pa_s: float = 0.0
) -> float:
    """Fraction of the shortest collision or damping time [s], cut (not rounded) to three digits.

    A viscosity of zero leaves the damping time out (dry scenes, or the normal viscous force switched off).
    """
    used = [p for p in pairs if classes[p.a - 1].count and (p.b == 0 or classes[p.b - 1].count)]
    shortest = min(collision_time(p, classes) for p in used)
    if viscosity_Pa_s > 0:
        shortest = min(shortest, *(damping_time(p, classes, viscosity_Pa_s) for p in used))
    step = fraction * shortest
    digit = 10.0 ** (math.floor(math.log10(step)) - 2)
    return float(f"{math.floor(step / digit) * digit:.3g}")
