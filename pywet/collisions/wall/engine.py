"""The same collision inside the engine: a sphere with a film thrown at a dry plate, with the laws of `pywet.laws.buck` or others.

The engine has its film on the sphere, a linear spring in contact and a constant volume of the bridge; what that changes is laid
out step by step in docs/wall_collision.md. The contact's stiffness is chosen so that it lasts as long as the Hertzian one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.bench import small
from pywet.collisions.wall import wall
from pywet.collisions.wall.problem import Liquid, Problem
from pywet.errors import PywetError
from pywet.files import read_table
from pywet.laws.contact import damping_ratio
from pywet.scene import ContactPair, Effects, SphereClass
from pywet.scene import Liquid as SceneLiquid

BUCK = small.PAPER.model_copy(
    update={"capillary": "buck", "viscous_normal": "buck_water", "viscous_tangential": "buck", "rupture": "buck"}
)
"""The laws of Buck et al. in the form the engine takes; formation and sharing are those of the preset `paper`."""
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
    """A linear contact that lasts as long as the model's, with its restitution and friction."""
    events = wall.collide(case.model_copy(update={"liquid": None, "gravity_m_per_s2": 0.0}))["events"]
    zeta = damping_ratio(case.particle.restitution)
    stiffness = case.mass * (math.pi / events[-1]["t"]) ** 2 / (1.0 - zeta**2)
    return ContactPair(
        a=1,
        b=0,
        normal_stiffness_N_per_m=stiffness,
        tangential_stiffness_N_per_m=2.0 / 7.0 * stiffness,
        friction=case.friction,
        rolling_friction_m=0.0,
        restitution=case.particle.restitution,
    )


def run(case: Problem, folder: Path, effects: Effects = BUCK, film: float | None = None) -> EngineRun:
    """Throw the sphere of a problem at a plate inside the engine; `film` [m] on the sphere, by default the layer's thickness."""
    if case.wall is None:
        raise PywetError("the engine's comparison takes a wall, expected `wall` and no `partner`")
    pair = contact_of(case)
    liquid, radius = case.liquid, case.particle.radius_m
    thickness = 0.0 if liquid is None else film or liquid.layer_thickness_m
    modelled = wall.collide(case)
    step = math.pi * math.sqrt(case.mass / pair.normal_stiffness_N_per_m) / STEPS_PER_CONTACT
    steps = math.ceil(1.5 * modelled["duration_s"] / step) + 4 * STEPS_PER_CONTACT
    body = small.Sphere(
        1,
        (0.0, 0.0, radius + thickness * (1.0 + 1e-9)),
        (case.tangential_velocity, 0.0, -case.normal_velocity_m_per_s),
        (0.0, -case.omega_rad_per_s, 0.0),  # the contact point below the centre moves along x by ωR
    )
    angle = math.radians(liquid.contact_angle_deg) if liquid else 0.0
    small.prepare(
        folder,
        [_class(case, angle)],
        [body],
        [pair, pair.model_copy(update={"b": 1})],
        liquid=_scene_liquid(liquid, thickness),
        effects=effects if liquid else small.DRY,
        walls=[small.floor()],
        time_step_s=step,
        steps=steps,
        output_interval_s=steps * step,
        gravity=(0.0, 0.0, -case.gravity_m_per_s2),
    )
    small.run(folder, [body])
    return _read(folder, case, liquid is not None)


def _class(case: Problem, angle: float) -> SphereClass:
    particle = case.particle
    return SphereClass(
        name="sphere",
        type=1,
        radius_m=particle.radius_m,
        density_kg_per_m3=particle.density_kg_per_m3,
        contact_angle_rad=angle,
        count=1,
    )


def _scene_liquid(liquid: Liquid | None, thickness: float) -> SceneLiquid | None:
    if liquid is None:
        return None
    return SceneLiquid(
        surface_tension_N_per_m=liquid.surface_tension_N_per_m,
        viscosity_Pa_s=liquid.viscosity_Pa_s,
        density_kg_per_m3=liquid.density_kg_per_m3,
        initial_film_thickness_m=thickness,
    )


def _read(folder: Path, case: Problem, wet: bool) -> EngineRun:
    """State in the last step of the bridge, or at the end of a dry run."""
    if not wet:
        end = read_table(folder / "trajectory.parquet").sort_values("step").iloc[-1]
        return EngineRun(
            float(end["vz"]) / case.normal_velocity_m_per_s, float(end["vx"]), -float(end["wy"]), None, None
        )
    log = read_table(folder / "history" / "contacts.parquet").sort_values("step")
    events = read_table(folder / "history" / "events.parquet")
    first: Any = log[log["step"] <= _rupture_step(events)]
    last = first.iloc[-1]
    stays = 1 not in set(events["kind"])
    e_n = 0.0 if stays else max(float(last["vi_z"]), 0.0) / case.normal_velocity_m_per_s
    return EngineRun(e_n, float(last["vi_x"]), -float(last["wi_y"]), float(last["volume"]), first)


def _rupture_step(events: pd.DataFrame) -> float:
    """Step of the first rupture (kind 1); infinite where there is none."""
    steps = events.loc[events["kind"] == 1, "step"]
    return float(steps.min()) if len(steps) else float(np.inf)
