"""Plan of a scene: outputs, windows, recorded tables, from scene.json alone."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.replay import io, script
from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import ReplayError

AGAIN = "run the case again"


@dataclass(frozen=True)
class Plan:
    """Planned numbers of a scene: walls, last step, steps of the outputs, half-open windows of steps and their tables."""

    moist: bool
    walls: int
    steps: int
    outputs: Floats
    windows: tuple[tuple[int, int], ...]
    recorded: tuple[str, ...]
    energy: bool
    """Whether works are logged."""
    every: int = 1
    """Number of steps between evaluations of the bridges."""

    @property
    def window_steps(self) -> Floats:
        """Return all steps of the windows, once each."""
        return np.unique(np.concatenate([np.zeros(0, int), *(np.arange(a, b) for a, b in self.windows)]))

    @property
    def contact_steps(self) -> Floats:
        """List the window steps at which bridges act and are logged."""
        return self.window_steps[self.window_steps % self.every == 0]


def plan(folder: Path) -> Plan:
    """Return the plan of a run directory."""
    scene = io.scene(folder)
    if (noted := script.of(folder)) is not None:
        at = np.array(noted["output_steps"], dtype=np.int64)
        last = int(noted["last_step"])
        return Plan(True, len(scene["walls"]), last, at, script.windows(noted, last), (), False)
    out, effects, step = scene["output"], scene["effects"], float(scene["time_step_s"])
    steps = round(scene["duration_s"] / step)
    count, length = int(out.get("contact_windows", 2)), int(out.get("contact_window_steps", 20))
    if length <= SHORT:
        first = [sample_start(scene, steps, k) for k in range(count)]
    else:
        first = [int(steps * (k + 0.5) / count) - length // 2 for k in range(count)]
    windows = tuple((max(0, a), min(a + length, steps + 1)) for a in first)
    recorded: tuple[str, ...] = ()
    if windows and out.get("window_trajectories", False) and engine(folder) != "LAMMPS":
        springs = ("window_pair_springs", "window_wall_springs")[: 2 if scene["walls"] else 1]
        springs = () if engine(folder) in FOREIGN else springs
        recorded = ("window_states", *(springs if effects.get("tangential_history", True) else ()))
    outputs, energy = np.arange(0, steps + 1, outputs_every(scene)), bool(out.get("energy", True))
    return Plan(
        bool(effects["bridges"]), len(scene["walls"]), steps, outputs, windows, recorded, energy, impulse(scene)
    )


SHORT = 4
"""Largest number of steps of windows at random positions."""


def sample_start(scene: dict[str, Any], steps: int, k: int) -> int:
    """Return the first step of the k-th short window; each window is in one of equal parts of the run."""
    out, slow = scene["output"], impulse(scene)
    count, length = int(out["contact_windows"]), int(out["contact_window_steps"])
    begin, end = steps * k // count, steps * (k + 1) // count
    fraction = int(hashlib.sha256(f"window {k} of seed {scene['seed']}".encode()).hexdigest()[:12], 16) / 16.0**12
    at = begin + int(fraction * max(1, end // 8 if k == 0 else end - begin - length))
    at = at // slow * slow
    output = outputs_every(scene) * math.ceil(at / outputs_every(scene))
    if k % 4 == 3 and output < end - length:
        at = output
    between = checkpoints_every(scene, steps)
    if between == 0:
        return at
    next_one = (at + between - 1) // between * between
    repeated = slow if not scene["effects"]["bridges"] or taken_out(scene) else 0
    inside = next_one < at + length
    fits = 0 < next_one < min(end, steps) - repeated
    return next_one + repeated if fits and (inside or k % 4 == 1) else at


def checkpoints_every(scene: dict[str, Any], steps: int) -> int:
    """Return the number of steps between checkpoints; 0 if the scene has none."""
    wanted, slow = int(scene["output"].get("checkpoints", 0)), impulse(scene)
    if wanted == 0:
        return 0
    if not taken_out(scene):
        return slow * max(1, math.ceil(steps / ((wanted + 1) * slow)))
    unit, step = outputs_every(scene), float(scene["time_step_s"])
    longest = OUTLETS_WITHIN_S if scene.get("outlets") else RETIRED_WITHIN_S
    return unit * min(max(1, math.ceil(steps / ((wanted + 1) * unit))), max(1, int(longest / (unit * step))))


RETIRED_WITHIN_S = 0.25
"""Longest time between two steps at which spheres may be retired."""
OUTLETS_WITHIN_S = 0.02
"""Longest time between two steps at which spheres may leave at outlets."""


def taken_out(scene: dict[str, Any]) -> bool:
    """Return whether spheres are removed from a run, from the bin or at outlets."""
    return bool(scene.get("retire", False) or scene.get("outlets"))


def outputs_every(scene: dict[str, Any]) -> int:
    """Return the number of steps between outputs, each of which is a check for drops too if films shed them."""
    wanted = _interval_steps(scene)
    unit = drops_every(scene) if scene["effects"].get("shedding") else impulse(scene)
    return max(unit, wanted - wanted % unit)


DROPS_EVERY_S = 1e-3
"""Time between two checks for drops, about."""


def drops_every(scene: dict[str, Any]) -> int:
    """Return the number of steps between checks for drops, at which bridges are evaluated too."""
    parts = max(round(scene["output"]["interval_s"] / DROPS_EVERY_S), 1)
    return max(_interval_steps(scene) // parts // impulse(scene), 1) * impulse(scene)


def _interval_steps(scene: dict[str, Any]) -> int:
    """Return the steps in the time between outputs that was asked for, to the nearest."""
    return round(scene["output"]["interval_s"] / float(scene["time_step_s"]))


def impulse(scene: dict[str, Any]) -> int:
    """Return the number of steps between evaluations of the bridges (`bridges_every`).

    Their forces act for all these steps at once.
    """
    return int(scene.get("bridges_every", 1))


FOREIGN = ("YADE",)
"""Engines whose dry contacts differ from those of LIGGGHTS, and whose springs are not recorded."""


def engine(folder: Path) -> str:
    """The engine of a run; LAMMPS records no motion in windows."""
    path = Path(folder) / "engine" / "run.json"
    try:
        return str(json.loads(path.read_text()).get("engine", "LIGGGHTS")) if path.exists() else "LIGGGHTS"
    except (OSError, ValueError, AttributeError) as error:
        raise ReplayError(f"{path} cannot be read ({error!r}); expected what the driver wrote: {AGAIN}") from error


def entered(scene: dict[str, Any], spheres: pd.DataFrame) -> Floats:
    """Return the step at which each sphere enters: from its table for a script's run, else from its class."""
    return np.asarray(spheres["enters"] if "enters" in spheres else enters(scene, spheres["type"].to_numpy()))


def created(scene: dict[str, Any], spheres: pd.DataFrame, steps: int) -> Floats:
    """Return the checkpoint at which the engine creates each sphere, 0 for those that it has from the start.

    It is the first one at most `created_ahead_s`, or one interval of checkpoints if that is longer, before the sphere enters.
    """
    ahead, every = scene.get("created_ahead_s"), checkpoints_every(scene, steps)
    if ahead is None or not every:
        return np.zeros(len(spheres), dtype=np.int64)
    first = np.maximum(entered(scene, spheres) - max(every, round(ahead / scene["time_step_s"])), 0)
    return np.asarray(np.ceil(first / every).astype(np.int64) * every)


def enters(scene: dict[str, Any], kind: Floats) -> Floats:
    """Return the step at which each sphere enters; inserted classes enter one by one; `kind` in the order of ids."""
    found = np.zeros(len(kind), dtype=np.int64)
    for c in scene["classes"]:
        if given := c.get("insertion"):
            members = np.flatnonzero(kind == c["type"])
            at = enter_times(given, c["count"])[: len(members)]
            found[members] = np.rint(at / scene["time_step_s"]).astype(np.int64)
    return found


def enter_times(given: Mapping[str, Any], count: int) -> Floats:
    """Return the times [s] at which equal parts of the mass have entered, each in the middle of its part.

    The rate is constant, rises in proportion to time, or is limited to a share of each period.
    """
    order, profile = np.arange(count) + 0.5, given.get("profile", "constant")
    if profile == "constant":
        return np.asarray(given["from_s"] + given["for_s"] * order / count)
    come = order / count
    if profile == "ramp":
        return np.asarray(given["from_s"] + given["for_s"] * come**0.5)
    period = given["for_s"] / given["pulses"]
    nth = np.floor(come * given["pulses"])
    return np.asarray(given["from_s"] + period * (nth + given["pulse_share"] * (come * given["pulses"] - nth)))
