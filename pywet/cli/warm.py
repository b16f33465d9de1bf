"""Compile machine code ahead of time, so that the first command of each kind does not wait; called by `tools/setup`.

Each kind of command is run once in a process of its own, so that the code it compiles is cached. Fast if the cache is
complete. `python -m pywet.cli.warm laws bridge` compiles what simulations need, without an argument everything is compiled.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor

from pywet.ending import die_with_parent
from pywet.errors import border
from pywet.util import machine_code


def _laws() -> None:
    """Compile the laws in the form that the engine uses: forces together with those of the preset `paper`."""
    from pywet.engines.liggghts.plugin_api import loops
    from pywet.laws import registry
    from pywet.laws.kinds import FORCES, PRESETS

    paper = {kind: registry.get(kind, name) for kind, name in PRESETS["paper"].items() if kind in FORCES}
    for kind, names in registry.BUILT_IN.items():
        for law in (registry.get(kind, name) for name in names):
            for function in [loop for _, loop, _ in loops({**paper, kind: law})] if kind in FORCES else law.functions:
                _ = function.address


def _bridge() -> None:
    from pywet.cases.small.bridge_query import Query, answer

    body = {"radius_m": 2e-3, "contact_angle_deg": 20}
    given = {"bodies": [body, body], "volume_m3": 1e-10, "surface_tension_N_per_m": 0.07, "separations_m": [0.0, 1e-4]}
    answer(Query.model_validate(given))


def _wall() -> None:
    from pywet.collisions.wall import wall
    from pywet.collisions.wall.problem import Problem

    glass = {"youngs_modulus_Pa": 63e9, "poisson_ratio": 0.23}
    water = {
        "density_kg_per_m3": 998, "viscosity_Pa_s": 1e-3, "surface_tension_N_per_m": 0.0728, "layer_thickness_m": 100e-6,
        "contact_angle_deg": 15, "half_filling_angle_deg": 55,
    }  # fmt: skip
    given = {
        "particle": {**glass, "radius_m": 0.87e-3, "density_kg_per_m3": 2500, "restitution": 0.96},
        "wall": glass, "liquid": water, "friction": 0.195, "normal_velocity_m_per_s": 1,
    }  # fmt: skip
    wall.collide(Problem.model_validate(given))


def _spheres() -> None:
    from pywet.collisions.spheres.command import collide

    collide({"form": "three_equal_spheres", "St_n": 12, "t_end": 4})


QUESTIONS: dict[str, tuple[str, Callable[[], None]]] = {
    "spheres": ("wet spheres", _spheres),
    "bridge": ("one bridge", _bridge),
    "laws": ("force laws", _laws),
    "wall": ("a sphere and a wall", _wall),
}
"""Longest first."""


def main(*wanted: str) -> None:
    """Compile what is not yet compiled for these sources and this processor."""
    if machine_code.ready():
        return
    if missing := [question for question in wanted or QUESTIONS if not machine_code.ready(question)]:
        workers = min(len(missing), len(os.sched_getaffinity(0)))
        with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), die_with_parent) as pool:
            list(pool.map(_compile, missing))
    if not wanted:
        machine_code.mark()


def _compile(question: str) -> None:
    name, ask = QUESTIONS[question]
    print(f"machine code, once for this processor: {name}", flush=True)
    ask()
    machine_code.mark(question)


if __name__ == "__main__":
    with border():
        main(*sys.argv[1:])
