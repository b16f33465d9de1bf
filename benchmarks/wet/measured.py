"""How straight restitution over 1/St is in the model of Buck et al. (2018), as experiments find it to be: docs/measured.md.

python benchmarks/wet/measured.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from pywet.collisions.wall import wall
from pywet.collisions.wall.problem import Problem
from pywet.config.loading import parse
from pywet.files import read_json

VISCOSITIES = (1e-3, 5e-3, 20e-3)
"""Of water and of thicker liquids [Pa s]."""
SPEEDS = np.geomspace(0.5, 5.0, 10)
"""Of impact, as in the experiments [m/s]."""


def restitution(viscosity: float) -> tuple[np.ndarray, np.ndarray]:
    """1/St and restitution of glass of 1.74 mm that rebounds from a film of 200 µm; impacts that stick are left out."""
    given = read_json(Path(__file__).parents[2] / "examples" / "wall_wet.json", "")
    sphere = given["particle"]
    given["liquid"] |= {"viscosity_Pa_s": viscosity, "layer_thickness_m": 200e-6}
    points = []
    for speed in SPEEDS:
        e_n = wall.collide(
            parse(Problem, {**given, "normal_velocity_m_per_s": float(speed)}, "examples/wall_wet.json")
        )["e_n"]
        mass = 4.0 / 3.0 * math.pi * sphere["radius_m"] ** 3 * sphere["density_kg_per_m3"]
        if e_n:
            points.append((6.0 * math.pi * viscosity * sphere["radius_m"] ** 2 / (mass * speed), e_n))
    inverse, kept = np.array(points).T
    return inverse, kept


def bend(inverse: np.ndarray, kept: np.ndarray) -> float:
    """Largest distance of a point from the straight line through all, over the range of restitution."""
    line = np.polyval(np.polyfit(inverse, kept, 1), inverse)
    return float(np.abs(kept - line).max() / np.ptp(kept))


if __name__ == "__main__":
    for viscosity in VISCOSITIES:
        inverse, kept = restitution(viscosity)
        quick = inverse < np.median(inverse)
        print(f"{1e3 * viscosity:g} mPa s: {len(kept)} rebounds, e_n {kept.min():.3f} to {kept.max():.3f},", end=" ")
        print(f"St {1 / inverse.max():.0f} to {1 / inverse.min():.0f}; bend {bend(inverse, kept):.1%},", end=" ")
        print(f"of the faster half {bend(inverse[quick], kept[quick]):.1%}")
