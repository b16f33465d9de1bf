"""Random collisions for the comparison of two implementations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def three(rng: np.random.Generator) -> dict[str, Any]:
    """Three equal spheres anywhere in the range of the paper's table I."""
    theta12 = float(rng.uniform(-80.0, 80.0))
    return {
        "form": "three_equal_spheres",
        "St_n": float(10 ** rng.uniform(-0.3, 1.5)),
        "Ca": None if rng.random() < 0.4 else float(10 ** rng.uniform(1.0, 4.0)),
        "h_a": float(10 ** rng.uniform(-2.3, -1.0)),
        "h_min": float(10 ** rng.uniform(-3.0, -1.0)),
        "theta12_deg": theta12,
        "theta23_deg": theta12 + float(rng.uniform(-110.0, 110.0)),
        "h23_0": float(rng.uniform(0.2, 3.0)),
        "d23": float(rng.uniform(0.5, 2.0)),
        "d13": float(rng.uniform(0.5, 2.0)),
        "e_dry": float(rng.uniform(0.5, 1.0)),
        "mu_f": float(rng.choice([0.0, rng.uniform(0.0, 0.3)])),
        "t_end": 12.0,
        "rtol": 1e-11,
    }


def several(rng: np.random.Generator) -> dict[str, Any]:
    """Two to five unequal spheres on a ring, thrown at the middle, under gravity; SI units."""
    n = int(rng.integers(2, 6))
    spheres = []
    for k in range(n):
        r, angle = float(rng.uniform(0.5e-3, 1.5e-3)), 2.0 * math.pi * (k + float(rng.uniform(-0.15, 0.15))) / n
        at = 4.0e-3 * np.array([math.cos(angle), math.sin(angle)])
        v = -rng.uniform(0.3, 1.5) * at / 4.0e-3 + rng.normal(0.0, 0.1, 2)
        spheres.append(
            {
                "radius_m": r, "mass_kg": 4.0 / 3.0 * math.pi * r**3 * float(rng.uniform(1000.0, 4000.0)),
                "film_m": float(rng.uniform(5e-6, 4e-5)), "position_m": at.tolist(), "velocity_m_per_s": v.tolist(),
                "omega_rad_per_s": float(rng.normal(0.0, 50.0)),
            }
        )  # fmt: skip
    return {
        "form": "spheres", "spheres": spheres, "viscosity_Pa_s": float(10 ** rng.uniform(-2.0, 0.0)),
        "surface_tension_N_per_m": float(rng.uniform(0.0, 0.07)), "h_min_m": float(10 ** rng.uniform(-6.5, -5.5)),
        "e_dry": float(rng.uniform(0.5, 1.0)), "mu_f": float(rng.uniform(0.0, 0.3)), "gravity_m_per_s2": [0.0, -9.81],
        "t_end_s": 0.006, "rtol": 1e-11,
    }  # fmt: skip
