"""Wet impact on a dry plate inside the engine, with the laws of `pywet.laws.buck` or others.

The engine has its film on the sphere, a linear spring in contact and a constant volume of the bridge;
docs/wall_collision.md describes the differences step by step. The contact's stiffness is chosen so that it lasts as
long as the Hertzian one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.cases.small import bodies, small
from pywet.collisions.wall import wall
from pywet.collisions.wall.problem import Problem
from pywet.errors import PywetError
from pywet.laws.contact import damping_ratio
from pywet.scene import ContactPair, Effects
from pywet.util.files import read_table

BUCK = small.PAPER.model_copy(
    update={"capillary": "buck", "viscous_normal": "buck_water", "viscous_tangential": "buck", "rupture": "buck"}
)
"""Laws of Buck et al. in the engine's form; formation and transfer are those of the preset `paper`."""
STEPS_PER_CONTACT = 50


@dataclass(frozen=True)
class EngineRun:
    """Coefficients at rupture (dry: at the end), the bridge's volume [m3], and the log of the bridge."""

    e_n: float
    v_t: float
    omega: float
    volume: float | None
    log: pd.DataFrame | None


def contact_of(case: Problem) -> ContactPair:
    """Return a linear contact that lasts as long as the model's, with its restitution and friction."""
    events = wall.collide(case.model_copy(update={"liquid": None, "gravity_m_per_s2": 0.0}))["events"]
    zeta = damping_ratio(case.particle.restitution)
    stiffness = case.mass * (math.pi / events[-1]["t"]) ** 2 / (1.0 - zeta**2)
    return bodies.contact(1, 0, stiffness, friction=case.friction, restitution=case.particle.restitution)


def impact(case: Problem, folder: Path, effects: Effects = BUCK, film: float | None = None) -> EngineRun:
    """Collide the sphere of a problem with a plate in the engine; `film` [m] on the sphere, by default the layer's thickness."""
    if case.wall is None:
        raise PywetError("the engine's comparison takes a wall, expected `wall` and no `partner`")
    pair, liquid, particle = contact_of(case), case.liquid, case.particle
    thickness = 0.0 if liquid is None else film or liquid.layer_thickness_m
    step = math.pi * math.sqrt(case.mass / pair.normal_stiffness_N_per_m) / STEPS_PER_CONTACT
    steps = math.ceil(1.5 * wall.collide(case)["duration_s"] / step) + 4 * STEPS_PER_CONTACT
    angle = math.radians(liquid.contact_angle_deg) if liquid else 0.0
    kinds = bodies.sphere_classes(particle.radius_m, density=particle.density_kg_per_m3, angle_rad=angle)
    body = small.Sphere(
        1,
        (0.0, 0.0, particle.radius_m + thickness * (1.0 + 1e-9)),
        (case.tangential_velocity, 0.0, -case.normal_velocity_m_per_s),
        (0.0, -case.omega_rad_per_s, 0.0),  # the contact point below the centre moves along x by ωR
    )
    film_on_sphere = None if liquid is None else bodies.water(
        thickness, liquid.viscosity_Pa_s, liquid.surface_tension_N_per_m, liquid.density_kg_per_m3
    )  # fmt: skip
    small.prepare(
        folder, kinds, [body], [pair, pair.model_copy(update={"b": 1})], liquid=film_on_sphere,
        effects=effects if liquid else small.DRY, walls=[small.floor()], time_step_s=step, steps=steps,
        output_interval_s=steps * step, gravity=(0.0, 0.0, -case.gravity_m_per_s2),
    )  # fmt: skip
    small.run(folder, [body])
    return _read(folder, case, liquid is not None)


def _read(folder: Path, case: Problem, wet: bool) -> EngineRun:
    """Return the state in the last step of the bridge, or at the end of a dry run."""
    if not wet:
        end = read_table(folder / "trajectory.parquet").sort_values("step").iloc[-1]
        e_n = float(end["vz"]) / case.normal_velocity_m_per_s
        return EngineRun(e_n, float(end["vx"]), -float(end["wy"]), None, None)
    log = read_table(folder / "history" / "contacts.parquet").sort_values("step")
    events = read_table(folder / "history" / "events.parquet")
    ruptures = events.loc[events["kind"] == 1, "step"]
    first: Any = log[log["step"] <= ruptures.min()] if len(ruptures) else log
    last = first.iloc[-1]
    e_n = max(float(last["vi_z"]), 0.0) / case.normal_velocity_m_per_s if len(ruptures) else 0.0
    return EngineRun(e_n, float(last["vi_x"]), -float(last["wi_y"]), float(last["volume"]), first)
