"""The engine's normal collision in a few lines of Python: its laws, its linear contact, its bridge; and the steps towards it.

It explains the difference between the model and the engine: deviations that these equations share with the engine are
no errors of the engine. Only the normal motion is computed; the tangential one does not affect it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp

from pywet.collisions.wall import wall
from pywet.collisions.wall.adaptive import ending
from pywet.collisions.wall.problem import Problem, Readings
from pywet.laws import registry
from pywet.laws.contact import damping, film_volume
from pywet.laws.force_law import ForceLaw
from pywet.scene import Effects
from studies.buck2018 import engine
from studies.buck2018.curves import problem


def _law(kind: str, name: str | None) -> ForceLaw:
    assert name is not None
    return registry.get(kind, name).functions[0]


def normal_coefficient(case: Problem, effects: Effects = engine.BUCK) -> float:
    """Return e_n of the engine's equations for a wet problem: bridge from touch to rupture, linear spring in overlap."""
    liquid, radius, mass = case.liquid, case.particle.radius_m, case.mass
    assert liquid is not None
    pair = engine.contact_of(case)
    stiffness = pair.normal_stiffness_N_per_m
    gamma = damping(pair.restitution, mass, stiffness)
    angle = math.radians(liquid.contact_angle_deg)
    film_liquid = film_volume(liquid.layer_thickness_m, radius)
    volume = float(_law("formation", effects.formation)(film_liquid, radius, math.inf))
    capillary, viscous = _law("capillary", effects.capillary), _law("viscous_normal", effects.viscous_normal)
    static = float(_law("rupture", effects.rupture)(volume, radius, math.inf, angle, 0.0))
    stretch = _law("dynamic_rupture", effects.dynamic_rupture)

    def rates(t: float, y: np.ndarray) -> list[float]:
        s, u = float(y[0]), float(y[1])
        force = viscous(s, volume, radius, math.inf, u, liquid.viscosity_Pa_s)
        force -= capillary(s, volume, radius, math.inf, angle, 0.0, liquid.surface_tension_N_per_m)
        if s < 0.0:
            force += max(-stiffness * s - gamma * u, 0.0)  # the engine's contact force is never attractive
        return [u, force / mass - case.gravity_m_per_s2]

    def broken(t: float, y: np.ndarray) -> float:
        return float(y[0] - static * stretch(abs(y[1]), liquid.viscosity_Pa_s, liquid.surface_tension_N_per_m))

    def stopped(t: float, y: np.ndarray) -> float:
        return float(y[1]) if t > 0.0 else 1.0

    contact = 2.0 * math.pi * math.sqrt(mass / stiffness)
    film = {"max_step": 0.05 * liquid.layer_thickness_m}
    down, up = ending(lambda t, y: float(y[0]), -1.0), ending(lambda t, y: float(y[0]), 1.0)
    y = np.array([liquid.layer_thickness_m, -case.normal_velocity_m_per_s])
    y = _solved(rates, 1.0, y, down, **film).y[:, -1] - np.array([1e-15, 0.0])
    y = _solved(rates, 5.0 * contact, y, up, max_step=contact / 200).y[:, -1]
    end = _solved(rates, 1.0, y, (ending(broken, 1.0), ending(stopped, -1.0)), **film)
    return max(float(end.y[1, -1]), 0.0) / case.normal_velocity_m_per_s if len(end.t_events[0]) else 0.0


def _solved(rates: Callable[..., list[float]], until: float, y: np.ndarray, events: Any, max_step: float) -> Any:
    return solve_ivp(rates, (0.0, until), y, events=events, rtol=1e-9, atol=[1e-14, 1e-11], max_step=max_step)


def over_velocity(velocities: tuple[float, ...] = (0.3, 0.4, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0)) -> pd.DataFrame:
    """Return e_n of 1.74 mm glass on 100 µm of water over the velocity: model, its nearest readings, equations, engine."""
    near = Readings(bridge_volume="frozen", rupture_from="wall", capillary="film_and_bridge")
    rows = []
    with TemporaryDirectory() as scratch:
        for v in np.linspace(0.15, 3.0, 58):
            case = problem("glass_1.74mm", ("water", 100), normal_velocity_m_per_s=float(v))
            like = case.model_copy(update={"readings": near})
            for line, e_n in (
                ("model", wall.collide(case)["e_n"]),
                ("model, volume frozen, counted from the wall", wall.collide(like)["e_n"]),
                ("engine's equations in Python", normal_coefficient(case)),
            ):
                rows.append({"line": line, "x": float(v), "e_n": e_n})
        for v in velocities:
            case = problem("glass_1.74mm", ("water", 100), normal_velocity_m_per_s=v)
            rows.append({"line": "engine", "x": v, "e_n": engine.impact(case, Path(scratch) / f"{v:g}").e_n})
    return pd.DataFrame(rows)
