"""The two JSON descriptions of `pywet collide spheres`, typed; a mistake is answered in one sentence that names the key."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from pywet.collisions.nspheres.equal import three_equal_spheres
from pywet.collisions.nspheres.problem import Problem
from pywet.config.messages import explain
from pywet.errors import PywetError

LEAST, MOST = 1e-30, 1e12
"""Sizes of numbers, in SI units or of order one, whose squares and quotients stay within double precision."""


def _sized(value: float) -> float:
    if value != 0.0 and not LEAST <= abs(value) <= MOST:
        raise ValueError(f"0 or a number of size {LEAST:g} to {MOST:g}")
    return value


Number = Annotated[float, AfterValidator(_sized)]
Positive = Annotated[Number, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[Number, Field(ge=0, allow_inf_nan=False)]


class Strict(BaseModel):
    """No unknown keys."""

    model_config = ConfigDict(extra="forbid")


class ThreeEqualSpheres(Strict):
    """Dimensionless, as in Davis 2023, table I; times in t̂ = v_n0 t/δ_12. `h23_0` null: no third sphere."""

    form: Literal["three_equal_spheres"]
    St_n: Positive
    Ca: Positive | None = None
    h_a: Positive = 0.01
    h_min: Positive = 0.05
    theta12_deg: Number = 45.0
    theta23_deg: Number = 0.0
    h23_0: Positive | None = 1.0
    d23: Positive = 1.0
    d13: Positive = 1.0
    e_dry: Positive = 1.0
    mu_f: NotNegative = 0.0
    t_end: Positive = 400.0
    rtol: Positive = 1e-9

    def problem(self) -> Problem:
        """The problem described."""
        return three_equal_spheres(**self.model_dump(exclude={"form"}))


class WetSphere(Strict):
    """One sphere in SI units, its film's thickness included."""

    radius_m: Positive
    mass_kg: Positive
    film_m: NotNegative
    position_m: tuple[Number, Number]
    velocity_m_per_s: tuple[Number, Number] = (0.0, 0.0)
    omega_rad_per_s: Number = 0.0


class Spheres(Strict):
    """Spheres of any sizes, masses and films, in SI units."""

    form: Literal["spheres"]
    spheres: Annotated[list[WetSphere], Field(min_length=2)]
    viscosity_Pa_s: Positive
    surface_tension_N_per_m: NotNegative = 0.0
    h_min_m: Positive
    e_dry: Positive = 1.0
    mu_f: NotNegative = 0.0
    gravity_m_per_s2: tuple[Number, Number] = (0.0, 0.0)
    t_end_s: Positive
    rtol: Positive = 1e-9

    def problem(self) -> Problem:
        """The problem described."""
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
        )


FORMS: dict[str, type[ThreeEqualSpheres] | type[Spheres]] = {
    "three_equal_spheres": ThreeEqualSpheres,
    "spheres": Spheres,
}


def parse(description: Any, where: str = "the description") -> Problem:
    """The problem a JSON description stands for."""
    form = description.get("form") if isinstance(description, dict) else None
    if not isinstance(form, str) or form not in FORMS:
        raise PywetError(f'{where}: "form" is {form!r}; expected one of {", ".join(FORMS)} (docs/sphere_collisions.md)')
    model = FORMS[form]
    try:
        return model.model_validate(description).problem()
    except ValidationError as error:
        raise PywetError(explain(error, model, where)) from error
