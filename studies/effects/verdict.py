"""Judge the plan: the change of each quantity of interest without an effect, beyond the scatter of seeds, and its saving.

Runs are compared seed by seed with everything on. A chaotic bed scatters as much between two choices of effects as
between two seeds; a collision of two scatters hardly at all. `spread` is twice the standard error of the mean
difference, from the median variance over all choices of the scene (divided by the expected ratio of such a median to
the true variance): smaller changes than that are not resolved.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import stats

from studies.effects.measures import ABSOLUTE, WORDS
from studies.effects.variants import EVERYTHING, IDLE, OF_THE_CONTACT, PLANNED, TOLERANCE

Floats = NDArray[np.float64]
SHORTEST = 0.3
"""Processor time of the steps [s] below which times are not compared."""


@dataclass(frozen=True)
class Change:
    """Mean change of one quantity of interest by one choice of effects, over its scale, and its spread."""

    quantity: str
    change: float
    spread: float

    @property
    def sure(self) -> float:
        """Return the part of the change that exceeds the spread."""
        return max(0.0, abs(self.change) - self.spread)


@dataclass(frozen=True)
class Choice:
    """One choice of effects in one scene compared with everything on."""

    scene: str
    variant: str
    same_as_everything: bool
    changes: tuple[Change, ...]
    saving: float
    """Saved processor time of the steps over that with everything on; median over the seeds, NaN if too short to time."""
    saving_spread: float
    """Half the range of the saving over the seeds."""
    cpu_s: tuple[float, float]
    """Processor time of the whole process, including the start: everything on, this choice; median over the seeds [s]."""

    @property
    def worst(self) -> Change:
        """Return the quantity with the largest change beyond its spread."""
        return max(self.changes, key=lambda c: (c.sure, abs(c.change)))

    @property
    def harmless(self) -> bool:
        """Return whether no quantity of interest changes by more than the tolerance beyond the spread."""
        return self.worst.sure <= TOLERANCE


def choices(runs: pd.DataFrame) -> list[Choice]:
    """Return all choices of one scene, all seeds, in the order of the runs."""
    by_run: Any = runs.set_index(["variant", "seed"]).assign(step_time=step_time)
    wanted: Any = by_run[[name for name in by_run if name in WORDS]].astype(float)
    full = wanted.loc[EVERYTHING]
    wanted = wanted[wanted.index.get_level_values("seed").isin(full.index)]
    sizes = {name: 1.0 if name in ABSOLUTE else abs(float(full[name].mean())) or 1.0 for name in full}
    changes = (wanted - full.loc[wanted.index.get_level_values("seed")].to_numpy()) / pd.Series(sizes)
    compared = [v for v in by_run.index.unique("variant") if v not in (EVERYTHING, IDLE)]
    spreads = {name: _spread([changes.loc[v, name].to_numpy() for v in compared], len(full)) for name in full}
    return [_choice(v, by_run.loc[v], by_run.loc[EVERYTHING], changes.loc[v], spreads) for v in compared]


def _spread(of_choices: list[Floats], seeds: int) -> float:
    """Return the spread of one quantity from the differences to all effects of every choice that changes it at all."""
    variances = [float(np.var(d, ddof=1)) for d in of_choices if len(d) > 1 and d.any()]
    low = float(stats.chi2.ppf(0.5, seeds - 1)) / (seeds - 1) if seeds > 1 else 1.0
    return 2.0 * math.sqrt(float(np.median(variances)) / low / seeds) if variances else 0.0


def _choice(
    variant: str, runs: pd.DataFrame, full: pd.DataFrame, changes: pd.DataFrame, spreads: dict[str, float]
) -> Choice:
    its, other = (of.loc[runs.index.intersection(full.index)] for of in (runs, full))
    same = bool(its["effects"].iloc[0] == other["effects"].iloc[0])
    times, reference = its["step_time"], other["step_time"]
    saved = 0.0 * times if same else 1.0 - times / reference
    timed = same or reference.min() >= SHORTEST
    return Choice(
        scene=str(its["scene"].iloc[0]),
        variant=variant,
        same_as_everything=same,
        changes=tuple(Change(str(name), float(changes[name].mean()), spreads[str(name)]) for name in changes),
        saving=float(saved.median()) if timed else math.nan,
        saving_spread=0.5 * float(saved.max() - saved.min()) if timed else math.nan,
        cpu_s=(float(other["cpu_s"].median()), float(its["cpu_s"].median())),
    )


def planned(choices_of_scene: Iterable[Choice]) -> Choice:
    return next(c for c in choices_of_scene if c.variant == PLANNED)


def step_time(runs: pd.DataFrame) -> pd.Series:
    """Return the processor time of the steps of each run [s]; for the stock program, whose start is short, of everything."""
    loop = runs["loop_cpu_s"].astype(float)
    return loop.where(loop > 0.0, runs["cpu_s"])


def left_out(runs: pd.DataFrame) -> list[str]:
    """Name the effects that the plan leaves out among those that are on in the full run."""
    full, plan = (runs.loc[runs["variant"] == name, "effects"].iloc[0] for name in (EVERYTHING, PLANNED))
    switched = set(runs["variant"].str.removeprefix("no "))
    names = ["sharing_by_size" if n == "transfer" else n for n in full if full[n] != plan[n]]
    names = [n for n in names if n in switched]
    return [n for n in names if n in ("bridges", *OF_THE_CONTACT)] if "bridges" in names else names


def costs(of_all: dict[str, list[Choice]]) -> dict[str, float]:
    """Return effect -> additional processor time over the run without it, median over the scenes that have it.

    Gravity is omitted, because without it there is no bed and the time is not comparable.
    """
    added: dict[str, list[float]] = {}
    for choice in (c for choices_of_scene in of_all.values() for c in choices_of_scene):
        effect = choice.variant.removeprefix("no ")
        timed = not choice.same_as_everything and math.isfinite(choice.saving)
        if effect != choice.variant and effect != "gravity" and timed:
            added.setdefault(effect, []).append(choice.saving / (1.0 - choice.saving))
    return {effect: round(float(np.median(values)), 3) for effect, values in added.items()}
