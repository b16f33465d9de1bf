"""Tables 1 to 3 of Elskamp & Kruggel-Emden (2018), typed: spheres, walls, dry contacts, liquid, screens, motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, TypeVar

from pydantic import Field, model_validator

from pywet.config.entries import (
    AngleEntry,
    Entry,
    FrictionEntry,
    Limited,
    MaterialEntry,
    NonNegativeEntry,
    PoissonEntry,
    PositiveEntry,
    RatioEntry,
    doubled,
)
from pywet.errors import ConfigError
from pywet.strict import Strict

FILE = "materials.yaml"
MASS_MISFIT = 0.1
"""Allowed relative misfit between mass and density times volume if the mass has no tolerance."""


SIEVE_MM = 200.0
"""Default diameter of the paper's sieve, which the paper does not give."""


class Size(Limited):
    """One size of spheres. The simulation uses diameter and density; a given mass must agree with them."""

    diameter_mm: PositiveEntry
    mass_g: PositiveEntry | None = None
    density_kg_per_m3: PositiveEntry

    @property
    def radius_m(self) -> float:
        return 0.5e-3 * self.diameter_mm.value

    @property
    def sphere_mass_kg(self) -> float:
        """Return the mass of a sphere of this size [kg]: density times volume."""
        return self.density_kg_per_m3.value * 4.0 / 3.0 * math.pi * self.radius_m**3

    @property
    def as_weighed(self) -> Size:
        """Return a copy of the size with the density that follows from its weighed mass."""
        if self.mass_g is None:
            raise ConfigError(
                f"{FILE}: the size of {self.diameter_mm.value:g} mm has no mass_g, expected one where readings.sphere_mass in "
                "config.yaml is weighed",
                code="config.no_mass",
                key="mass_g",
                given=self.diameter_mm.value,
                file=FILE,
            )
        density = 1e-3 * self.mass_g.value / (4.0 / 3.0 * math.pi * self.radius_m**3)
        return self.model_copy(
            update={"density_kg_per_m3": self.density_kg_per_m3.model_copy(update={"value": density})}
        )

    @model_validator(mode="after")
    def _mass_agrees(self) -> Size:
        if self.mass_g is None:
            return self
        given, computed = self.mass_g.value, 1e3 * self.sphere_mass_kg
        allowed = self.mass_g.tolerance or MASS_MISFIT * given
        if abs(given - computed) > allowed:
            raise ValueError(
                f"mass_g {given:g} and density_kg_per_m3 times volume ({computed:.4g} g) "
                f"within {allowed:.2g} g of each other"
            )
        return self


class SphereMaterial(Limited):
    """A material of spheres; the linear contact law does not use Young's modulus and Poisson's ratio."""

    sizes: Annotated[tuple[Size, ...], Field(min_length=1)]
    youngs_modulus_Pa: PositiveEntry | None = None
    poissons_ratio: PoissonEntry | None = None
    stiffness_sphere_sphere_N_per_m: PositiveEntry
    stiffness_sphere_wall_N_per_m: PositiveEntry
    contact_angle_deg: AngleEntry
    residual_liquid_percent: NonNegativeEntry | None = None
    """Part of the liquid lost before the screening, used if `readings.liquid_amount` is less_residual."""


class WallMaterial(Limited):
    """Properties of a material of walls."""

    density_kg_per_m3: PositiveEntry
    youngs_modulus_Pa: PositiveEntry
    poissons_ratio: PoissonEntry
    contact_angle_deg: AngleEntry


class Contact(Limited):
    """Dry contact of a sphere material with a partner (the same material or a wall material)."""

    sphere: str
    partner: str
    friction: FrictionEntry
    rolling_friction_m: NonNegativeEntry
    restitution: RatioEntry

    @property
    def numbers(self) -> tuple[float, float, float]:
        """Return friction, rolling friction [m] and restitution of a pair of materials."""
        return self.friction.value, self.rolling_friction_m.value, self.restitution.value


class LiquidData(Limited):
    """Properties of a liquid."""

    surface_tension_N_per_m: PositiveEntry
    viscosity_Pa_s: NonNegativeEntry
    density_kg_per_m3: PositiveEntry


class Screen(Limited):
    """Aperture and wire diameter of a screen."""

    aperture_mm: PositiveEntry
    wire_diameter_mm: PositiveEntry

    @model_validator(mode="after")
    def _open(self) -> Screen:
        if self.aperture_mm.value < self.wire_diameter_mm.value:
            raise ValueError(
                f"aperture_mm at least wire_diameter_mm ({self.aperture_mm.value:g} is smaller than the wire's "
                f"{self.wire_diameter_mm.value:g})"
            )
        return self


class Stroke(Limited):
    """Measured amplitudes of the screen for a nominal amplitude."""

    set_amplitude_mm: PositiveEntry
    x_amplitude_mm: NonNegativeEntry
    y_amplitude_mm: NonNegativeEntry
    z_amplitude_mm: NonNegativeEntry


class Motion(Limited):
    """Motion of the vibrating parts: x_k(t) = amplitude_k sin(2 pi f t + phase_k)."""

    frequency_Hz: PositiveEntry
    strokes: tuple[Stroke, ...]
    x_phase_deg: Entry
    y_phase_deg: Entry
    z_phase_deg: Entry


class Feed(Limited):
    """Mass of the feed: `class_mass_g` of `reference_material` in each class; other materials have the same volume."""

    class_mass_g: PositiveEntry
    reference_material: str
    sieve_diameter_mm: PositiveEntry


class WallMaterials(Strict):
    """Material of each part of the apparatus."""

    wires: MaterialEntry
    side_wall: MaterialEntry
    feed_bin: MaterialEntry
    slide: MaterialEntry
    outlet: MaterialEntry
    impact_plate: MaterialEntry
    collecting_bin: MaterialEntry


class Materials(Limited):
    """Content of materials.yaml."""

    spheres: dict[str, SphereMaterial]
    walls: dict[str, WallMaterial]
    contacts: tuple[Contact, ...]
    tangential_stiffness_ratio: PositiveEntry
    liquid: LiquidData
    """Liquid of every case that names none of `liquids`."""
    liquids: dict[str, LiquidData] = Field(default_factory=dict)
    screens: tuple[Screen, ...]
    motion: Motion
    feed: Feed
    wall_materials: WallMaterials

    @model_validator(mode="after")
    def _names(self) -> Materials:
        for part, choice in self.wall_materials:
            if choice.material not in self.walls:
                raise ValueError(f"wall_materials.{part} to name one of {_listed(self.walls)}, not {choice.material}")
        if self.feed.reference_material not in self.spheres:
            raise ValueError(f"feed.reference_material to name one of {_listed(self.spheres)}")
        return self

    @model_validator(mode="after")
    def _each_once(self) -> Materials:
        wrong = doubled("contacts of different materials", (f"{c.sphere} with {c.partner}" for c in self.contacts))
        lists: list[tuple[str, str, Sequence[Limited]]] = [
            ("screens", "aperture_mm", self.screens), ("motion.strokes", "set_amplitude_mm", self.motion.strokes),
            *((f"spheres.{name}.sizes", "diameter_mm", one.sizes) for name, one in self.spheres.items()),
        ]  # fmt: skip
        for where, key, rows in lists:
            wrong += doubled(f"{where} of different {key}", (f"{getattr(row, key).value:.9g}" for row in rows))
        if wrong:
            raise ValueError("; ".join(wrong))
        return self

    def sphere(self, material: str) -> SphereMaterial:
        if material not in self.spheres:
            raise ConfigError(
                f"{FILE}: spheres has no {material}, expected one of {_listed(self.spheres)}",
                code="config.unknown_material",
                key="spheres",
                given=material,
                expected=tuple(sorted(self.spheres)),
                file=FILE,
            )
        return self.spheres[material]

    def liquid_named(self, name: str | None) -> LiquidData:
        """Return one of `liquids` by name; None: the default liquid."""
        if name is None:
            return self.liquid
        if name not in self.liquids:
            raise ConfigError(
                f"{FILE}: liquids has no {name}, expected one of {', '.join(sorted(self.liquids)) or 'none'}",
                code="config.unknown_liquid",
                key="liquids",
                given=name,
                expected=tuple(sorted(self.liquids)),
                file=FILE,
            )
        return self.liquids[name]

    def size(self, material: str, diameter_mm: float) -> Size:
        place = f"spheres.{material}.sizes has no"
        return _of_length(self.sphere(material).sizes, "diameter_mm", diameter_mm, place)

    def screen(self, aperture_mm: float) -> Screen:
        return _of_length(self.screens, "aperture_mm", aperture_mm, "screens has no aperture of")

    def stroke(self, set_amplitude_mm: float) -> Stroke:
        place = "motion.strokes has no set amplitude"
        return _of_length(self.motion.strokes, "set_amplitude_mm", set_amplitude_mm, place)

    def contact(self, sphere: str, partner: str) -> Contact:
        for contact in self.contacts:
            if (contact.sphere, contact.partner) == (sphere, partner):
                return contact
        raise ConfigError(
            f"{FILE}: contacts has no entry for {sphere} spheres with {partner}; add one",
            code="config.no_contact",
            key="contacts",
            given=(sphere, partner),
            file=FILE,
        )

    def wall_contact(self, sphere: str) -> Contact:
        """Return the only dry contact of a sphere material with all walls: engines treat the walls as one material."""
        partners = sorted({choice.material for _, choice in self.wall_materials})
        found = [self.contact(sphere, partner) for partner in partners]
        for other in found[1:]:
            if other.numbers != found[0].numbers:
                raise ConfigError(
                    f"{FILE}: contacts of {sphere} with {found[0].partner} and with {other.partner} differ, expected "
                    "equal friction, rolling_friction_m and restitution: all walls are one material in the engine",
                    code="config.walls_differ",
                    key="contacts",
                    given=(found[0].partner, other.partner),
                    file=FILE,
                )
        return found[0]


Row = TypeVar("Row", bound=Limited)


def _of_length(rows: Sequence[Row], key: str, length_mm: float, lacks: str) -> Row:
    """Return the row whose `key` equals a length [mm]."""
    lengths = [getattr(row, key).value for row in rows]
    for row, length in zip(rows, lengths, strict=True):
        if math.isclose(length, length_mm, rel_tol=1e-9):
            return row
    have = ", ".join(f"{length:g}" for length in lengths)
    raise ConfigError(
        f"{FILE}: {lacks} {length_mm:g} mm, expected one of {have} mm",
        code="config.unknown_size",
        given=length_mm,
        expected=have,
        file=FILE,
    )


def _listed(names: dict[str, SphereMaterial] | dict[str, WallMaterial]) -> str:
    return ", ".join(sorted(names))
