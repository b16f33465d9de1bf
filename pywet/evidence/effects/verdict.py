"""Judges the plan: what each effect's absence changes in each wanted quantity, beyond what the seeds scatter, and what it saves.

Runs are compared seed by seed with everything on. A chaotic bed scatters as much between two choices of effects as between
two seeds; a collision of two scatters hardly at all. `spread` is twice the standard error of the mean difference, from the
median variance over all choices of the scene (over what the median of such variances is of the true one): smaller changes than
that are not resolved.
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

from pywet.evidence.effects.measures import ABSOLUTE
from pywet.evidence.effects.runs import EVERYTHING, IDLE, PLANNED, TOLERANCE

Floats = NDArray[np.float64]
Record = dict[str, Any]
SHORTEST = 0.3
"""Processor time of the steps [s] below which times are not compared."""


@dataclass(frozen=True)
class Change:
    """Mean change of one wanted quantity by one choice of effects, over its scale, and its spread."""

    quantity: str
    change: float
    spread: float

    @property
    def sure(self) -> float:
        """Size of the change that is beyond the spread."""
        return max(0.0, abs(self.change) - self.spread)


@dataclass(frozen=True)
class Choice:
    """One choice of effects in one scene against everything on."""

    scene: str
    variant: str
    same_as_everything: bool
    changes: tuple[Change, ...]
    saving: float
    """Processor time of the steps saved, over that with everything on; median over the seeds, NaN where too short to time."""
    saving_spread: float
    """Half the range of the saving over the seeds."""
    cpu_s: tuple[float, float]
    """Processor time of the whole process, start included: everything on, this choice; median over the seeds [s]."""

    @property
    def worst(self) -> Change:
        """The quantity that changes most beyond its spread."""
        return max(self.changes, key=lambda c: (c.sure, abs(c.change)))

    @property
    def harmless(self) -> bool:
        """No wanted quantity changes by more than the tolerance beyond the spread."""
        return self.worst.sure <= TOLERANCE

    @property
    def largest(self) -> Change:
        """The largest change, resolved or not."""
        return max(self.changes, key=lambda c: abs(c.change))


def choices(records: Iterable[Record]) -> list[Choice]:
    """All choices of one scene, all seeds, in the order they were run."""
    every = list(records)
    runs: Any = pd.DataFrame(every, index=pd.MultiIndex.from_tuples([(r["variant"], r["seed"]) for r in every]))
    wanted: Any = pd.DataFrame(list(runs["wanted"]), index=runs.index, dtype=float)
    full = wanted.loc[EVERYTHING]
    wanted = wanted[[seed in full.index for _, seed in wanted.index]]
    sizes = {name: 1.0 if name in ABSOLUTE else abs(float(full[name].mean())) or 1.0 for name in full}
    changes = (wanted - full.loc[[seed for _, seed in wanted.index]].to_numpy()) / pd.Series(sizes)
    compared = [v for v in dict.fromkeys(r["variant"] for r in every) if v not in (EVERYTHING, IDLE)]
    spreads = {name: _spread([changes.loc[v, name].to_numpy() for v in compared], len(full)) for name in full}
    return [_choice(v, runs.loc[v], runs.loc[EVERYTHING], changes.loc[v], spreads) for v in compared]


def _spread(of_choices: list[Floats], seeds: int) -> float:
    """Of one quantity, from the differences to everything on of every choice that changes it at all."""
    variances = [float(np.var(d, ddof=1)) for d in of_choices if len(d) > 1 and d.any()]
    low = float(stats.chi2.ppf(0.5, seeds - 1)) / (seeds - 1) if seeds > 1 else 1.0
    return 2.0 * math.sqrt(float(np.median(variances)) / low / seeds) if variances else 0.0


def _choice(
    variant: str, runs: pd.DataFrame, full: pd.DataFrame, changes: pd.DataFrame, spreads: dict[str, float]
) -> Choice:
    both = [seed for seed in runs.index if seed in full.index]
    its, other = runs.loc[both], full.loc[both]
    same = bool(its["effects"].iloc[0] == other["effects"].iloc[0])
    times, reference = (
        [step_time({str(k): v for k, v in r.items()}) for r in of.to_dict("records")] for of in (its, other)
    )
    saved = [0.0] if same else [1.0 - t / r for t, r in zip(times, reference, strict=True)]
    timed = same or min(reference) >= SHORTEST
    return Choice(
        scene=str(its["scene"].iloc[0]),
        variant=variant,
        same_as_everything=same,
        changes=tuple(Change(str(name), float(changes[name].mean()), spreads[str(name)]) for name in changes),
        saving=float(np.median(saved)) if timed else math.nan,
        saving_spread=0.5 * (max(saved) - min(saved)) if timed else math.nan,
        cpu_s=(float(other["cpu_s"].median()), float(its["cpu_s"].median())),
    )


def planned(found: Iterable[Choice]) -> Choice:
    """The plan's choice."""
    return next(c for c in found if c.variant == PLANNED)


def step_time(record: Record) -> float:
    """Processor time of the steps of a run [s]; of the stock program, whose start takes some hundredths, of all."""
    loop = record["loop_cpu_s"]
    return float(record["cpu_s"] if loop is None or math.isnan(loop) or loop == 0.0 else loop)


def left_out(records: Iterable[Record]) -> list[str]:
    """What the plan leaves out of what is on with everything on."""
    every = list(records)
    full = next(r for r in every if r["variant"] == EVERYTHING)["effects"]
    planned = next(r for r in every if r["variant"] == PLANNED)["effects"]
    switched = {r["variant"].removeprefix("no ") for r in every}
    names = ["sharing_by_size" if n == "transfer" else n for n in full if full[n] != planned[n]]
    names = [n for n in names if n in switched]
    if "bridges" in names:
        return ["bridges", *(n for n in names if n in ("rolling", "tangential_history", "gravity"))]
    return names


def costs(of_all: dict[str, list[Choice]]) -> dict[str, float]:
    """Effect -> processor time it adds over the run without it, median over the scenes that have it.

    Without gravity there is no bed, so that its time says nothing about gravity: it is left out.
    """
    added: dict[str, list[float]] = {}
    for found in of_all.values():
        for choice in found:
            if (
                choice.variant.startswith("no ")
                and choice.variant != "no gravity"
                and not choice.same_as_everything
                and math.isfinite(choice.saving)
            ):
                added.setdefault(choice.variant.removeprefix("no "), []).append(choice.saving / (1.0 - choice.saving))
    return {effect: round(float(np.median(values)), 3) for effect, values in added.items()}
