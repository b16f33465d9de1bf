"""Source `single`: wet collisions of single spheres, resolved models (Buck et al. 2018, Davis 2023) against the engine.

The head-on collision of Davis has a closed-form solution; three spheres are solved by `reference_impl.spheres`.
Buck's wall impact is compared with the engine's equations integrated by scipy, because the engine's form of the model
differs (docs/wall_collision.md).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from studies.cross_code.model import Cell, Source, empty, impossible, measured, truth
from studies.cross_code.rows import EASO, EXACT, LIGGGHTS, REFERENCE, WASHINO, YADE

STOKES = (6.0, 12.0, 24.0)
SPEEDS = (0.5, 1.0, 2.0)
THREE: dict[str, Any] = {"St_n": 12.0, "theta12_deg": 30.0, "Ca": None, "t_end": 8.0, "h_a": 0.01, "h_min": 0.05}
STIFFNESS = 1e9
OTHERS = {
    YADE: "no viscous force of the liquid, on which the model rests",
    WASHINO: "its capillary and viscous laws are its own; the model's cannot be given to it",
    EASO: "its capillary and viscous laws are its own; the model's cannot be given to it",
}


def source(folder: Path) -> Source:
    """Compute all cells of the single collisions."""
    return Source("single", [*_buck(folder), *_pair(), *_three(folder)])


def _buck(folder: Path) -> Iterator[Cell]:
    """Yield the impact of a wet sphere on a wall: the engine compared with its equations in Python, integrated to 1e-9."""
    from pywet.collisions.wall import wall
    from studies.buck2018 import engine
    from studies.buck2018.buck_impact import normal_coefficient
    from studies.buck2018.curves import problem

    row, engine_e, expected, model = "buck", [], [], []
    for k, speed in enumerate(SPEEDS):
        case = problem("glass_1.74mm", ("water", 100), normal_velocity_m_per_s=speed)
        engine_e.append(engine.impact(case, folder / f"buck_{k}").e_n)
        expected.append(normal_coefficient(case))
        model.append(float(wall.collide(case)["e_n"]))
    names = [f"{speed:g} m/s" for speed in SPEEDS]
    apart = float(np.max(np.abs(np.array(model) - expected)))
    yield truth(row, EXACT, "the engine's equations integrated by scipy to 1e-9", len(SPEEDS))
    yield impossible(
        row, REFERENCE, "the reference has no model of a wall impact; the budget of energy is checked instead"
    )
    note = f"50 steps per contact; the paper's own reading of the model gives e up to {apart:.3f} away"
    yield measured(
        row,
        LIGGGHTS,
        np.array(engine_e),
        np.array(expected),
        np.ones(len(expected)),
        at=names,
        note=note,
        link="runs/buck_0/",
    )
    yield from empty(row, OTHERS)


def _pair() -> Iterator[Cell]:
    """Yield two wet spheres head on, compared with the closed form (Davis 41)."""
    from pywet.collisions.spheres.equal import head_on_restitution
    from reference_impl.spheres import spheres

    row = "davis_pair"
    exact = np.array([head_on_restitution(s, 0.05) for s in STOKES])
    expected = [restitution(spheres.solve(two_spheres(s))) for s in STOKES]
    names = [f"St {s:g}" for s in STOKES]
    yield truth(row, EXACT, "closed form, equation 41", len(STOKES))
    yield measured(
        row, REFERENCE, np.array(expected), exact, np.ones(len(exact)), at=names, note="scipy's DOP853, own events"
    )
    yield impossible(row, LIGGGHTS, "run as three spheres in the row below")
    yield from empty(row, OTHERS)


def two_spheres(stokes: float) -> dict[str, Any]:
    """Return two equal spheres whose films touch, head on, in SI units: δ = 20 µm, h_min/δ = 0.05, no surface tension."""
    r, delta, speed, density = 1e-3, 2e-5, 0.4, 2000.0
    mass = density * 4.0 / 3.0 * math.pi * r**3
    viscosity = 0.5 * mass * speed / (6.0 * math.pi * (0.5 * r) ** 2 * stokes)
    one = {"radius_m": r, "mass_kg": mass, "film_m": 0.5 * delta}
    return {
        "form": "spheres",
        "spheres": [
            {**one, "position_m": [-(2.0 * r + delta), 0.0], "velocity_m_per_s": [speed, 0.0]},
            {**one, "position_m": [0.0, 0.0], "velocity_m_per_s": [0.0, 0.0]},
        ],
        "viscosity_Pa_s": viscosity,
        "surface_tension_N_per_m": 0.0,
        "h_min_m": 0.05 * delta,
        "e_dry": 1.0,
        "t_end_s": 60.0 * delta / speed,
    }


def restitution(answer: dict[str, Any]) -> float:
    """Return the relative speed after over that before, from the answer of `two_spheres`."""
    v = np.asarray(answer["final"]["velocity"], dtype=float)
    return float(v[1, 0] - v[0, 0]) / 0.4


def _three(folder: Path) -> Iterator[Cell]:
    """Yield three wet spheres: the reference, our resolved solver (in the note), the engine with stiff contacts."""
    from reference_impl.spheres import spheres
    from studies.davis2023 import engine

    row = "davis_three"
    truth_v = np.asarray(spheres.solve({"form": "three_equal_spheres", **THREE})["final"]["velocity"], dtype=float)
    expected = engine.model(12.0, 30.0, None, 8.0)
    comparison = engine.in_engine(folder / "davis_three", 12.0, 30.0, None, 8.0, STIFFNESS)
    size = np.full(truth_v.size, float(np.abs(truth_v).max()))
    off = float(np.abs(expected.velocity - truth_v).max() / size[0])
    names = [f"sphere {k + 1} {a}" for k in range(3) for a in "xy"]
    note = f"scipy's DOP853, own events; pywet's resolved solver is {off:.0e} away"
    yield impossible(row, EXACT, "no closed form for three spheres")
    yield truth(row, REFERENCE, note, truth_v.size)
    note = f"a spring of {STIFFNESS:.0e} N/m represents the model's hard impact; stiffer ones come closer"
    final = comparison.velocity[-1, :, :2].ravel()
    yield measured(row, LIGGGHTS, final, truth_v.ravel(), size, at=names, note=note, link="runs/davis_three/")
    yield from empty(row, OTHERS)
