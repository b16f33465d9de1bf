"""Materials of a user-defined scene, their dry contacts and the liquid."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from pywet.cases.custom.walls import chosen
from pywet.config.entries import Excusable
from pywet.laws.hertz import Modulus, Poisson
from pywet.products.feed import MOST_PERCENT
from pywet.scene import NonNegative, Positive

WATER = {"surface_tension_N_per_m": 0.0728, "viscosity_Pa_s": 1e-3, "density_kg_per_m3": 1000.0}
Angle = Annotated[float, Field(ge=0, lt=90)]
Percent = Annotated[float, Field(ge=0, le=MOST_PERCENT)]
Coefficient = Annotated[float, Field(ge=0, le=10)]
Restitution = Annotated[float, Field(gt=0, le=1)]
ROLLING = ("rolling_friction", "rolling_friction_m")
STIFFNESS = "stiffness_N_per_m"
DRY = (STIFFNESS, "friction", "restitution", *ROLLING)
"""Keys of a dry contact; rolling friction has one of two."""


class Dry(Excusable):
    """A dry contact: linear contact stiffness and its damping, Coulomb friction, rolling friction as a length or without unit."""

    stiffness_N_per_m: Positive = 2000.0
    """Normal stiffness of `contact: linear`.

    A soft contact is usual, as long as overlaps stay below a few per cent of the radius (see
    `contact_statistics`).
    """
    friction: Coefficient = 0.4
    """Coulomb friction coefficient, static and sliding."""
    rolling_friction_m: NonNegative = 2e-5
    """Rolling friction as a length: torque over normal force."""
    rolling_friction: Coefficient | None = None
    """Dimensionless rolling friction, in place of `rolling_friction_m`, as in LIGGGHTS, EDEM and YADE.

    It is torque over normal force times r_red, r_i r_j/(r_i + r_j) of two spheres, the radius at a wall.
    """
    restitution: Restitution = 0.8
    """Coefficient of restitution of a normal impact: rebound speed over impact speed."""

    @model_validator(mode="after")
    def _one_rolling_friction(self) -> Self:
        if self.rolling_friction is not None and "rolling_friction_m" in self.model_fields_set:
            raise ValueError("rolling_friction (without unit) or rolling_friction_m (a length), not both")
        return self

    def rolling_m(self, reduced_radius_m: float) -> float:
        """Rolling friction of two bodies as a length [m]."""
        return self.rolling_friction_m if self.rolling_friction is None else self.rolling_friction * reduced_radius_m


class Material(Dry):
    """A material of spheres, with its dry contact with itself and, unless `contacts` gives another one, with walls."""

    density_kg_per_m3: Positive
    """Density of a sphere."""
    contact_angle_deg: Angle | None = None
    """Contact angle of the liquid on this material; by default 15 degrees on spheres and 40 on walls."""
    youngs_modulus_Pa: Modulus | None = None
    """Young's modulus of the contact law `hertz`, instead of a stiffness; 1e6 to 1e8 is usual for solids of 1e9 and more."""
    poissons_ratio: Poisson | None = None
    """Poisson's ratio of the contact law `hertz`."""


class Contact(Excusable):
    """The dry contact between two materials, or between a material and `walls`.

    A key that is not given has the value of both materials. If these differ, it must be given: a contact has no law of mixing.
    """

    between: Annotated[tuple[str, str], Field(min_length=2, max_length=2)]
    """Names of two materials, or of one and `walls`."""
    stiffness_N_per_m: Positive | None = None
    """Normal stiffness of linear springs; by default that of both materials."""
    friction: Coefficient | None = None
    """Coulomb friction coefficient, static and sliding; by default that of both materials."""
    rolling_friction_m: NonNegative | None = None
    """Rolling friction as a length, torque over normal force; by default that of both materials."""
    rolling_friction: Coefficient | None = None
    """Dimensionless rolling friction, in place of `rolling_friction_m`."""
    restitution: Restitution | None = None
    """Coefficient of restitution of a normal impact; by default that of both materials."""

    @model_validator(mode="after")
    def _one_rolling_friction(self) -> Self:
        chosen(self, *ROLLING, needed=False)
        return self

    def taken(self, material: Material) -> dict[str, float]:
        """Return the values that are not given, by key, as a material has them."""
        given, found = _values(self), _values(material)
        rolls = not given.keys().isdisjoint(ROLLING)
        return {key: x for key, x in found.items() if key not in given and not (rolls and key in ROLLING)}

    def of(self, material: Material) -> Dry:
        """Return the contact in full; what is not given is that of a material."""
        values: dict[str, Any] = self.taken(material) | _values(self)
        return Dry.model_construct(**values)

    def differing(self, *materials: Material) -> list[str]:
        """Return the keys that are not given and differ between the materials."""
        each = [self.taken(material) for material in materials]
        keys = {key for found in each for key in found if any(of.get(key) != found[key] for of in each)}
        return sorted({" or ".join(ROLLING) if key in ROLLING else key for key in keys})


def _values(of: Dry | Contact) -> dict[str, float]:
    """Return the values of a dry contact by key, of rolling friction the one that counts."""
    found = {key: x for key in DRY if (x := getattr(of, key)) is not None}
    return {key: x for key, x in found.items() if key != "rolling_friction_m" or "rolling_friction" not in found}


class Liquid(Excusable):
    """The liquid (water by default) and its amount: per cent of the spheres' mass, or the film's thickness."""

    surface_tension_N_per_m: NonNegative = WATER["surface_tension_N_per_m"]
    """Surface tension against air; that of water if not given."""
    viscosity_Pa_s: NonNegative = WATER["viscosity_Pa_s"]
    """Dynamic viscosity; that of water if not given."""
    density_kg_per_m3: Positive = WATER["density_kg_per_m3"]
    """Density of the liquid; that of water if not given."""
    percent: Percent | None = None
    """Mass of the liquid over that of the spheres, in per cent."""
    film_um: NonNegative | None = None
    """Thickness of the film on every sphere at the start, in place of `percent`."""

    @model_validator(mode="after")
    def _one_amount(self) -> Self:
        chosen(self, "percent", "film_um", needed=False)
        return self
