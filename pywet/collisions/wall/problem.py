"""The input of `pywet collide wall`: typed and checked, with one sentence per mistake; converted to `Parameters` in SI units."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, create_model, model_validator

from pywet.collisions.wall import contact
from pywet.collisions.wall.forces import MISPRINTS, READINGS, Other, Parameters
from pywet.config.entries import Excusable
from pywet.laws.contact import effective_mass, reduced_radius
from pywet.strict import Strict

Positive = Annotated[float, Field(ge=1e-30, le=1e30, allow_inf_nan=False)]
Poisson = Annotated[float, Field(gt=-1, le=0.5)]
Restitution = Annotated[float, Field(ge=0, le=1)]
Integrator = Literal["compiled", "DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA"]
RTOL = 1e-9
"""Default relative tolerance; docs/wall_collision.md gives the reason."""
STEEPEST_DEG = 170.0


class Wall(Excusable):
    """A rigidly fixed elastic half-space."""

    youngs_modulus_Pa: Positive
    poisson_ratio: Poisson


class Partner(Wall):
    """A free sphere at rest that replaces the wall."""

    radius_m: Annotated[float, Field(gt=0, le=1)]
    density_kg_per_m3: Positive


class Particle(Partner):
    """The sphere that moves; `restitution` is that of the dry, normal contact."""

    restitution: Restitution


class Liquid(Excusable):
    """The layer on the wall and the bridge that it forms."""

    density_kg_per_m3: Positive
    viscosity_Pa_s: Positive
    surface_tension_N_per_m: Annotated[float, Field(ge=0, le=1e30)]
    layer_thickness_m: Annotated[float, Field(gt=0, le=1)]
    contact_angle_deg: Annotated[float, Field(ge=0, le=90)] = 15.0
    half_filling_angle_deg: Annotated[float, Field(gt=0, le=90)]

    @model_validator(mode="after")
    def _toroid(self) -> Liquid:
        if self.contact_angle_deg + self.half_filling_angle_deg > STEEPEST_DEG:
            raise ValueError(
                f"contact_angle_deg + half_filling_angle_deg of at most {STEEPEST_DEG:g} "
                "(at 180 the toroid's radius r_m is infinite)"
            )
        return self


NO_LIQUID = Liquid.model_construct(
    density_kg_per_m3=1.0, viscosity_Pa_s=1.0, surface_tension_N_per_m=0.0, layer_thickness_m=0.0, half_filling_angle_deg=57.0
)  # fmt: skip
"""Placeholders without effect."""
_Readings: Any = create_model(
    "_Readings",
    __base__=Strict,
    **{name: (Literal[*both] | None, None) for name, both in READINGS.items()},  # type: ignore[call-overload]
)


class Readings(_Readings):  # type: ignore[misc]
    """Selected reading of each ambiguity of the paper; None: that of the variant."""


VARIANTS = {
    name: Readings.model_validate({k: name if k in MISPRINTS else default for k, (default, _) in READINGS.items()})
    for name in ("mended", "as_printed")
}
"""Return the readings of a variant: all equations corrected, or as printed in the paper (or its scan).

Readings that are no misprints are the same in both.
"""


class Problem(Strict):
    """Describe one collision of a wet sphere with a wall or a free sphere."""

    particle: Particle
    wall: Wall | None = None
    partner: Partner | None = None
    liquid: Liquid | None
    friction: Annotated[float, Field(ge=0, le=10)]
    normal_velocity_m_per_s: Annotated[float, Field(ge=1e-9, le=1e4)]
    angle_deg: Annotated[float, Field(ge=0, lt=90)] = 0.0
    omega_rad_per_s: Annotated[float, Field(ge=-1e9, le=1e9)] = 0.0
    gravity_m_per_s2: Annotated[float, Field(ge=0, le=1e4)] = 9.81
    rtol: Annotated[float, Field(ge=1e-13, le=1e-2)] = RTOL
    variant: Literal["mended", "as_printed"] = "mended"
    readings: Readings = Readings()
    integrator: Integrator = "compiled"

    @model_validator(mode="after")
    def _consistent(self) -> Problem:
        if (self.wall is None) == (self.partner is None):
            raise ValueError("either wall or partner, and not both")
        if self.partner is not None and "gravity_m_per_s2" in self.model_fields_set and self.gravity_m_per_s2:
            raise ValueError("no gravity_m_per_s2 with partner: free spheres fall alike")
        if self.liquid is not None and self.chosen().capillary != "bridge":
            c = self.particle.radius_m * (1.0 - math.cos(math.radians(self.liquid.half_filling_angle_deg)))
            if self.liquid.layer_thickness_m >= c:
                raise ValueError(
                    f"a layer thinner than R(1 − cos φ) = {c:.3g} m where the capillary force acts in the film as well "
                    "(the toroid's radius r_m passes through zero there)"
                )
        return self

    def chosen(self) -> Readings:
        """Return the readings of the variant, except those selected individually."""
        return VARIANTS[self.variant].model_copy(update=self.readings.model_dump(exclude_none=True))

    @property
    def tangential_velocity(self) -> float:
        """Return the tangential velocity before the collision [m/s]: v_n tan(angle)."""
        return self.normal_velocity_m_per_s * math.tan(math.radians(self.angle_deg))

    @property
    def mass(self) -> float:
        """Mass of the sphere [kg]."""
        return _mass(self.particle)

    def parameters(self) -> Parameters:
        """Return the parameters of the force balance."""
        body = self.wall or self.partner
        assert body is not None
        particle, liquid, chosen = self.particle, self.liquid or NO_LIQUID, self.chosen().model_dump()
        radius = reduced = particle.radius_m
        mass = self.mass
        if self.partner is not None:
            mass = effective_mass(mass, _mass(self.partner))
            reduced = reduced_radius(radius, self.partner.radius_m)
        moduli = (particle.youngs_modulus_Pa, particle.poisson_ratio, body.youngs_modulus_Pa, body.poisson_ratio)
        stiffness = 4.0 / 3.0 * contact.effective_modulus(*moduli) * math.sqrt(reduced)
        other: Any = Other(**{name: chosen[name] != default for name, (default, _) in READINGS.items()})
        return Parameters(
            mass=mass,
            radius=radius,
            reduced=reduced,
            stiffness=stiffness,
            damping=contact.damping_constant(particle.restitution) * math.sqrt(mass * stiffness),
            shear=8.0 * contact.effective_shear(*moduli, other.shear_modulus) * math.sqrt(reduced),
            friction=float(self.friction),
            gravity=0.0 if self.partner is not None else float(self.gravity_m_per_s2),
            speed=float(self.normal_velocity_m_per_s),
            wet=self.liquid is not None,
            layer=float(liquid.layer_thickness_m),
            density=float(liquid.density_kg_per_m3),
            viscosity=float(liquid.viscosity_Pa_s),
            surface_tension=float(liquid.surface_tension_N_per_m),
            contact_angle=math.radians(liquid.contact_angle_deg),
            half_filling=math.radians(liquid.half_filling_angle_deg),
            other=other,
        )


def _mass(body: Partner) -> float:
    return 4.0 / 3.0 * math.pi * body.density_kg_per_m3 * body.radius_m**3
