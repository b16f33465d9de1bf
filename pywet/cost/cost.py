"""Run time of a case: operation counts (`counts.py`) times the cost of each on this machine (`trial.py`).

seconds = start + steps (step + touches touch + triangles triangle + near (mesh or analytic)) + evaluations of bridges
(bridge) + lists (list)

Costs are measured once with few and once with many spheres, and stored in the cache under the machine and the
program. With n spheres the cost per operation is a + b/n between the two. It is processor time, which on an idle
machine equals the wall time.
"""

from __future__ import annotations

import datetime
import hashlib
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from pywet import config as settings
from pywet import laws
from pywet.cases.screening import cases
from pywet.config import Config
from pywet.cost import trial
from pywet.cost.counts import Load, load_of
from pywet.cost.timing import machine
from pywet.cost.trial import Costs
from pywet.engines.liggghts.build import source_hash
from pywet.errors import PywetError
from pywet.shipped import place
from pywet.util import caches
from pywet.util.files import read_model, write_json

VERSION = 3
"""Version in the cache's key; to be increased with any change of `trial.py` or of the meaning of its numbers."""


@dataclass(frozen=True)
class Coefficients:
    """Cost of each operation with few and with many spheres."""

    few: Costs
    many: Costs

    def _total(self, spheres: float, name: str) -> float:
        """Return a cost of the whole bed, linear in the number of spheres, so that each sphere has the same share."""
        low, high = getattr(self.few, name), getattr(self.many, name)
        slope = (high - low) / (self.many.spheres - self.few.spheres)
        return float(max(low + slope * (spheres - self.few.spheres), 0.0))

    def _each(self, spheres: float, name: str) -> float:
        """Return a cost per operation, linear in 1/n, as is the share of n spheres whose data fit in the cache."""
        sizes = [1.0 / self.many.spheres, 1.0 / self.few.spheres]
        return float(np.interp(1.0 / spheres, sizes, [getattr(self.many, name), getattr(self.few, name)]))

    def loop(self, load: Load) -> float:
        """Return the processor time of the time loop [s]."""
        n = load.spheres
        stock = _program(load) == "stock"
        # with few spheres the cost of a triangle cannot be separated from that of the plugin
        more = load.triangles - (self._total(n, "triangles") if stock else 0.0)
        step = self._total(n, "step_stock" if stock else "step") + more * self.few.triangle
        step += load.touches * self._each(n, "touch")
        step += load.near * self._each(n, "analytic" if load.analytic_wires else "mesh")
        lists = self._total(n, f"list_{_program(load)}")
        if load.bridges and not load.analytic_wires:  # moist lattices were measured with analytic wires
            lists += max(0.0, self._total(n, "list_stock") - self._total(n, "list_analytic"))
        return load.steps * step + load.evaluations * self._each(n, "bridge") + load.lists * lists

    def start(self, load: Load) -> float:
        """Return the processor time before the first step [s]."""
        return self._total(load.spheres, f"start_{_program(load)}")


def _program(load: Load) -> str:
    return "moist" if load.bridges else "analytic" if load.analytic_wires else "stock"


def _path() -> Path:
    """Name the cache file of the measured costs of this machine, plugin and set of laws."""
    sources = sorted(Path(laws.__file__).parent.glob("*.py"))
    program = source_hash() + "".join(path.read_text() for path in sources)
    key = hashlib.sha256(f"{VERSION} {machine()} {program}".encode()).hexdigest()[:16]
    return caches.folder() / f"cost-{key}.json"


def measured_here() -> Coefficients | None:
    """Return the coefficients in the cache; None if there are none or they are damaged."""
    try:
        return read_model(_path(), Coefficients)
    except PywetError:
        return None


def of_this_machine(report: Callable[[int, int], None] = lambda done, of: None) -> Coefficients:
    """Return the coefficients from the cache, or measure them in about a minute with the shipped configuration and cache them."""
    held, done = measured_here(), 0
    if held is not None:
        return held

    def count() -> None:
        nonlocal done
        done += 1
        report(done, trial.LATTICES * len(trial.SIZES))

    config = settings.load(place("config"))
    measured = Coefficients(*(trial.measure(config, case, width, count) for case, width in trial.SIZES))
    date = datetime.datetime.now(datetime.UTC).isoformat()
    write_json(_path(), {**asdict(measured), "machine": machine(), "date": date})
    return measured


@dataclass(frozen=True)
class Habit:
    """Measured cost factors of a moist run by law and by integration, relative to the defaults.

    `exact_start`: factor on the start, when the exact bridge's functions are compiled as well.
    """

    laws: dict[str, float] = field(default_factory=dict)
    integrations: dict[str, float] = field(default_factory=dict)
    exact_start: float = 1.0


def predict(config: Config, case: int, scale: str, machine: Coefficients, habit: Habit) -> tuple[float, Load]:
    """Predict the engine's wall time on an idle machine [s], including its start, and the operation counts."""
    load, retirement = load_of(config, case, scale), cases.ingredients(config, case, scale).retirement
    loop = machine.loop(load) * (1.0 - retirement.saves if retirement.on else 1.0)
    if not load.bridges:
        return machine.start(load) + loop, load
    chosen = config.settings.laws
    exact = chosen.capillary == "young_laplace" or (chosen.preset == "exact" and chosen.capillary is None)
    law = "exact" if exact else chosen.capillary or "rabinovich"
    factor = habit.laws.get(law, 1.0) * habit.integrations.get(config.settings.time_step.viscous_integration, 1.0)
    return machine.start(load) * (habit.exact_start if exact else 1.0) + factor * loop, load
