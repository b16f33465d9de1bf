"""The two JSON input forms of `pywet collide spheres`, typed; a mistake is reported in one sentence that names the key."""

from __future__ import annotations

import inspect
import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, create_model, model_validator

from pywet.collisions.spheres.equal import three_equal_spheres
from pywet.collisions.spheres.problem import MOST_SPHERES, NotNegative, Number, Positive, Problem
from pywet.config import loading
from pywet.config.entries import Excusable
from pywet.errors import PywetError
from pywet.strict import Strict
from pywet.util.ranges import LIMITS

ARGUMENTS = inspect.signature(three_equal_spheres, eval_str=True).parameters.values()
_Equal: Any = create_model(
    "_Equal",
    __base__=Strict,
    **{a.name: (a.annotation, ... if a.default is a.empty else a.default) for a in ARGUMENTS},  # type: ignore[call-overload]
)


class ThreeEqualSpheres(_Equal):  # type: ignore[misc]
    """Dimensionless, as in Davis 2023, table I: the arguments of `three_equal_spheres`."""

    form: Literal["three_equal_spheres"]

    def problem(self) -> Problem:
        """Convert the dimensionless description to a problem."""
        return three_equal_spheres(**self.model_dump(exclude={"form"}))


class WetSphere(Excusable):
    """One sphere in SI units, including its film thickness."""

    radius_m: Positive
    mass_kg: Positive
    film_m: NotNegative
    position_m: tuple[Number, Number]
    velocity_m_per_s: tuple[Number, Number] = (0.0, 0.0)
    omega_rad_per_s: Number = 0.0

    @model_validator(mode="after")
    def _heavy(self) -> WetSphere:
        density = self.mass_kg / (4.0 / 3.0 * math.pi * self.radius_m**3)
        limits = LIMITS["density_kg_per_m3"]
        if density not in limits and self.unusual is None:
            raise ValueError(
                f"mass_kg and radius_m that give a density of {limits}, not {density:.3g}, unless `unusual: why` says so"
            )
        return self


class Spheres(Excusable):
    """Spheres of any sizes, masses and films, in SI units.

    `reference_speed_m_per_s`: reference of e_wet; null: the largest initial normal approach of a pair whose paths cross.
    """

    form: Literal["spheres"]
    spheres: Annotated[list[WetSphere], Field(min_length=2, max_length=MOST_SPHERES)]
    viscosity_Pa_s: Positive
    surface_tension_N_per_m: NotNegative = 0.0
    h_min_m: Positive
    e_dry: Positive = 1.0
    mu_f: NotNegative = 0.0
    gravity_m_per_s2: tuple[Number, Number] = (0.0, 0.0)
    t_end_s: Positive
    rtol: Positive = 1e-9
    reference_speed_m_per_s: Positive | None = None

    def problem(self) -> Problem:
        """Convert the description in SI units to a problem."""
        s = self.spheres
        return Problem(
            radius=np.array([k.radius_m for k in s]),
            mass=np.array([k.mass_kg for k in s]),
            position=np.array([k.position_m for k in s]),
            velocity=np.array([k.velocity_m_per_s for k in s]),
            omega=np.array([k.omega_rad_per_s for k in s]),
            film={(i, j): s[i].film_m + s[j].film_m for i in range(len(s)) for j in range(i + 1, len(s))},
            viscosity=self.viscosity_Pa_s,
            surface_tension=self.surface_tension_N_per_m,
            h_min=self.h_min_m,
            e_dry=self.e_dry,
            mu_f=self.mu_f,
            gravity=self.gravity_m_per_s2,
            t_end=self.t_end_s,
            rtol=self.rtol,
            reference_speed=self.reference_speed_m_per_s,
        )


FORMS: dict[str, type[ThreeEqualSpheres] | type[Spheres]] = {
    "three_equal_spheres": ThreeEqualSpheres,
    "spheres": Spheres,
}


def parse(description: Any, where: str = "the description") -> Problem:
    """Return the problem that a JSON description defines."""
    form = description.get("form") if isinstance(description, dict) else None
    if not isinstance(form, str) or form not in FORMS:
        raise PywetError(
            f'{where}: "form" is {form!r}; expected one of {", ".join(FORMS)} (pywet docs sphere_collisions)',
            code="spheres.form", key="form", given=form, expected=tuple(FORMS), where=where,
        )  # fmt: skip
    return loading.parse(FORMS[form], description, where).problem()
