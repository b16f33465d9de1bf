"""Number of spheres and amount of liquid: functions of a scene's parts, in SI units."""

from __future__ import annotations

import math
from collections.abc import Sequence

from scipy.optimize import brentq

from pywet.config import Case, Config, Scale
from pywet.config.cases import CLASS_NAMES
from pywet.errors import PywetError
from pywet.laws.contact import film_volume
from pywet.planning.size_distribution import Amount, amounts
from pywet.scene import SphereClass

THINNEST = 1e-13
"""Thinnest film over the radius of its sphere; below it the film is lost in the round-off of their sum."""


def amounts_of(config: Config, case: Case, scale: Scale) -> tuple[Amount, ...]:
    """Return the requested and simulated amounts of each class: those of the case, otherwise the reference material's mass.

    Amounts refer to the sieve of `feed` and are scaled with the sieve's area. A case of other materials has the
    same number of the same sizes as the reference material, so the same volume, as for glass in the paper
    (section 5.1). Raises `ConfigError` where a class is less than half a sphere.
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
    upper = volume_m3 / area  # of a flat film; on a sphere the same thickness contains more liquid
    refuse_too_thin(upper, classes)

    def excess(share: float) -> float:
        return sum(c.count * film_volume(share * upper, c.radius_m) for c in classes) / volume_m3 - 1.0

    return upper * float(brentq(excess, 0.0, 1.0, xtol=1e-16, rtol=1e-15))


def refuse_too_thin(film_m: float, classes: Sequence[SphereClass]) -> None:
    """Refuse a film so thin that it is lost to round-off when added to a radius."""
    radius = max(c.radius_m for c in classes)
    if 0.0 < film_m < THINNEST * radius:
        raise PywetError(
            f"the liquid makes a film of {film_m:.3g} m on spheres of {2e3 * radius:g} mm, which is below round-off; expected "
            f"none or at least {THINNEST * radius:.2g} m: more liquid, or none",
            code="case.thin_film", given=film_m, expected=THINNEST * radius,
        )  # fmt: skip
