"""The true limit of the time step in the engine: a pair pressed together by its bridge is let go a little out of balance."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.cases.small import small
from pywet.cases.small.bodies import water
from pywet.laws import registry
from pywet.laws.contact import film_volume
from pywet.planning import time_steps
from pywet.scene import EngineScene
from tests.engines.liggghts.scenes import contacts, spheres_of

R, STIFFNESS, FILM = 2.5e-3, 1e4, 1e-4
STEPS = 3000
NORMAL = small.PAPER.model_copy(update={"viscous_tangential": None, "dynamic_rupture": None})


def pressed_pair(
    run_dir: Path, viscosity: float, step: float, how: str, bridges_every: int = 1
) -> tuple[EngineScene, list[small.Sphere]]:
    """Two spheres at the overlap where contact spring and capillary force balance; the bridge acts from the second step on.

    STEPS evaluations of the bridge.
    """
    film = film_volume(FILM, R)
    volume = 2.0 * registry.get("formation", "shi_mccarthy").functions[0](film, R, R)
    angle = math.radians(15.0)
    force = registry.get("capillary", "rabinovich").functions[0](0.0, volume, R, R, angle, angle, 0.07275)
    bodies = [small.Sphere(1, (0.0, 0.0, 0.0)), small.Sphere(1, (0.0, 0.0, 2 * R - force / STIFFNESS))]
    scene = small.prepare(
        run_dir, spheres_of(R), bodies, contacts(1, stiffness=STIFFNESS), liquid=water(FILM, viscosity), effects=NORMAL,
        time_step_s=step, steps=STEPS * bridges_every, output_interval_s=step, viscous_integration=how, log_every_step=False,
        bridges_every=bridges_every,
    )  # fmt: skip
    return scene, bodies


def is_stable(run_dir: Path, viscosity: float, step: float, how: str, bridges_every: int = 1) -> bool:
    """Return whether the swing dies away: the speed in the last fifth is below a hundredth of that in the first 20 steps."""
    _, bodies = pressed_pair(run_dir, viscosity, step, how, bridges_every)
    try:
        small.run(run_dir, bodies, allow_unstable=True)
    except Exception as error:  # a run-time check that stops the run
        if "step" not in str(error):
            raise
        return False
    table = pd.read_parquet(run_dir / "trajectory.parquet")
    one, two = (table[table["id"] == k].sort_values("step")["vz"].to_numpy() for k in (1, 2))
    speed = np.abs(two - one)
    early, late = speed[:20].max(), speed[-len(speed) // 5 :].max()
    return bool(np.isfinite(late) and late < 1e-2 * early)


def advised(run_dir: Path, viscosity: float, how: str, bridges_every: int = 1) -> tuple[float, str]:
    """Return the time step that the advisor allows for the pair, and the effect that limits it."""
    scene, _ = pressed_pair(run_dir, viscosity, 1e-6, how, bridges_every)
    limits = [
        limit for limit in time_steps.advise(scene).limits if limit.stability and limit.effect != "viscous tangential"
    ]
    normal = [limit for limit in limits if limit.effect == "viscous normal"]
    return normal[0].time_step_s, limits[0].effect


def true_limit(run_dir: Path, viscosity: float, how: str, guess: float, turns: int = 6) -> float:
    """The limit by bisection between 0.7 and 1.5 of a guess."""
    low, high = 0.7 * guess, 1.5 * guess
    for k in range(turns):
        middle = math.sqrt(low * high)
        if is_stable(run_dir / f"{how}-{viscosity:g}-{k}", viscosity, middle, how):
            low = middle
        else:
            high = middle
    return math.sqrt(low * high)
