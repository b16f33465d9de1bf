"""How long a run takes: steps and neighbour lists times what they cost for each sphere, triangle and bridge on this machine.

    seconds = steps (c0 + c1 spheres + c2 triangles + c3 bridges) + lists (c4 spheres + c5 triangles)

A list is made anew when a sphere has gone half the skin. The six coefficients are fitted, none below zero, to a few short runs
on this machine (processor time of the engine's time loop) and kept in the cache, since machines differ. On a machine with
nothing else to do this is the wall time.
"""

from __future__ import annotations

import datetime
import hashlib
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import nnls

from pywet import caches
from pywet.config import Config
from pywet.engines.liggghts import driver
from pywet.engines.liggghts.build import ENGINE_VERSION
from pywet.errors import PywetError
from pywet.files import read_model, write_json
from pywet.geometry import build_apparatus
from pywet.screening import cases
from pywet.study.accuracy import runs, sieve
from pywet.study.accuracy.knobs import Setting
from pywet.study.accuracy.sieve import Size

VERSION = 2
"""Part of the cache's key; to be raised with any change of the formula or of CALIBRATION."""
SKIN = 0.4
"""Skin of the neighbour list over the smallest radius, see `pywet.engines.liggghts.deck.skin`."""
SPEED = 1.25
"""Least speed [m/s] taken for the lists of a whole case: 1.18 to 1.32 in whole smoke runs of cases 1, 2, 10 and 11 (lists
counted by the engine); the study's short runs end before the spheres are that fast."""
SMALLEST_M = 2.5e-3
"""Smallest radius of the study's screening cases."""


@dataclass(frozen=True)
class Load:
    """What a run asks of the machine; `bridges` is the mean over the run."""

    steps: float
    lists: float
    spheres: float
    triangles: float
    bridges: float
    bridges_every: int = 1

    @property
    def terms(self) -> list[float]:
        """What the coefficients are multiplied with."""
        per_step = [1.0, self.spheres, self.triangles, self.bridges / self.bridges_every]
        return [self.steps * x for x in per_step] + [self.lists * self.spheres, self.lists * self.triangles]


@dataclass(frozen=True)
class Coefficients:
    """Seconds per step, step and sphere, step and triangle, step and bridge, list and sphere, list and triangle.

    `start` [s] is what a dry and a moist run take before the first step, `misfit` the largest ratio between a calibrating run
    and the formula.
    """

    values: tuple[float, ...]
    start: tuple[float, float]
    misfit: float

    def seconds(self, load: Load) -> float:
        """Processor time of the time loop [s]."""
        return float(np.dot(self.values, load.terms))


CALIBRATION: tuple[tuple[str, float, float, Setting], ...] = (
    ("dry", 40.0, 0.2, Setting()),
    ("dry", 40.0, 0.2, Setting(wire_sides=16)),
    ("dry", 70.0, 0.2, Setting()),
    ("dry", 40.0, 0.2, Setting(stiffness=0.1)),
    ("moist", 40.0, 0.2, Setting()),
    ("moist", 60.0, 0.2, Setting()),
    ("moist", 40.0, 0.2, Setting(stiffness=0.1)),
)
"""Scene, sieve [mm], simulated time [s] and setting of the calibrating runs."""
SEED = runs.SEEDS[0]


def fit(loads: Sequence[Load], seconds: Sequence[float]) -> tuple[tuple[float, ...], float]:
    """Coefficients not below zero with the least relative misfit, and the largest ratio left."""
    terms, wanted = np.array([load.terms for load in loads]), np.array(seconds)
    scale = terms.max(axis=0)
    scale[scale == 0.0] = 1.0
    solved, _ = nnls(terms / scale / wanted[:, None], np.ones(len(wanted)))
    values = solved / scale
    ratio = terms @ values / wanted
    return tuple(float(v) for v in values), float(np.maximum(ratio, 1.0 / ratio).max())


def calibrate(config_dir: Path, report: Callable[[int, int], None] = lambda done, of: None) -> Coefficients:
    """Measure this machine: seven short runs, some ten seconds in all."""
    loads, seconds = [], []
    start: dict[str, list[float]] = {"dry": [], "moist": []}
    for k, (scene, width, duration, setting) in enumerate(CALIBRATION):
        report(k, len(CALIBRATION))
        found = _short(scene, Size("smoke", width, duration, 0.02, 1), setting, config_dir)
        loads.append(Load(found["steps"], found["builds"], found["spheres"], found["triangles"], found["bridges"]))
        seconds.append(found["loop_cpu_s"])
        start[scene].append(found["cpu_s"] - found["loop_cpu_s"])
    values, misfit = fit(loads, seconds)
    began = (float(np.median(start["dry"])), float(np.median(start["moist"])))
    return Coefficients(values, began, misfit)


def _short(scene: str, size: Size, setting: Setting, config_dir: Path) -> dict[str, Any]:
    with tempfile.TemporaryDirectory(prefix="pywet-calibrate-") as name:
        folder = Path(name)
        sieve.prepare(folder, scene, setting, size, SEED, config_dir)
        return runs.timed(folder, lambda: driver.run(folder, 1, progress=False))


def _path() -> Path:
    key = hashlib.sha256(f"{VERSION} {runs.machine()} {ENGINE_VERSION}".encode()).hexdigest()[:16]
    return caches.folder() / f"cost-{key}.json"


def kept() -> Coefficients | None:
    """The coefficients in the cache; None where there are none or they are damaged."""
    try:
        return read_model(_path(), Coefficients)
    except PywetError:
        return None


def of_this_machine(
    config_dir: Path, report: Callable[[int, int], None] = lambda done, of: None, anew: bool = False
) -> Coefficients:
    """The coefficients from the cache, or measured now and kept there."""
    held = None if anew else kept()
    if held is not None:
        return held
    found = calibrate(config_dir, report)
    date = datetime.datetime.now(datetime.UTC).isoformat()
    write_json(_path(), {**asdict(found), "machine": runs.machine(), "date": date})
    return found


@dataclass(frozen=True)
class Habit:
    """What the study knows of any screening: bridges per sphere, and how fast the fastest sphere is as far as lists go [m/s].

    `laws`: price of a moist run with a capillary law over that with the default's; `exact_start`: the same of the start, where
    the exact bridge's functions are compiled as well.
    """

    bridges_per_sphere: float
    speed: float
    laws: dict[str, float] = field(default_factory=dict)
    integrations: dict[str, float] = field(default_factory=dict)
    exact_start: float = 1.0


def load_of(config: Config, case: int, scale: str, habit: Habit) -> tuple[Load, bool]:
    """What a case will ask for, from its configuration alone, and whether it is moist. Takes a tenth of a second."""
    made = cases.ingredients(config, case, scale)
    apparatus = build_apparatus(cases.apparatus_spec(config, config.case(case), config.scale(scale)))
    duration = config.scale(scale).duration_s.value
    spheres = sum(c.count for c in made.classes)
    moist = made.plan.effects.bridges
    radius = min(c.radius_m for c in made.classes if c.count)
    steps = duration / made.time_step_s
    lists = min(duration * habit.speed / (0.5 * SKIN * radius), steps)
    bridges = habit.bridges_per_sphere * spheres if moist else 0.0
    every = config.settings.time_step.bridges_every
    meshes = [s for s in apparatus.surfaces if s.holder != "wires" or config.scale(scale).wires == "mesh"]
    return Load(steps, lists, spheres, sum(len(s.triangles) for s in meshes), bridges, every), moist


def predict(config: Config, case: int, scale: str, machine: Coefficients, habit: Habit) -> tuple[float, Load]:
    """Wall time of the engine's run on a quiet machine [s], with its start, and the load behind it."""
    load, moist = load_of(config, case, scale, habit)
    if not moist:
        return machine.start[0] + machine.seconds(load), load
    laws = config.settings.laws
    exact = laws.capillary == "young_laplace" or (laws.preset == "exact" and laws.capillary is None)
    law = "exact" if exact else laws.capillary or "rabinovich"
    price = habit.laws.get(law, 1.0) * habit.integrations.get(config.settings.time_step.viscous_integration, 1.0)
    return machine.start[1] * (habit.exact_start if exact else 1.0) + price * machine.seconds(load), load
