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
from scipy import stats

from pywet.study.effects.measures import ABSOLUTE
from pywet.study.effects.runs import EVERYTHING, IDLE, PLANNED, TOLERANCE

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
    by: dict[str, dict[int, Record]] = {}
    for record in records:
        by.setdefault(record["variant"], {})[record["seed"]] = record
    full = by[EVERYTHING]
    spreads = _spreads(by)
    return [_choice(variant, runs, full, spreads) for variant, runs in by.items() if variant not in (EVERYTHING, IDLE)]


def scales(full: dict[int, Record]) -> dict[str, float]:
    """What a change of each quantity is divided by: 1 for parts of a whole, else the mean with everything on."""
    names = next(iter(full.values()))["wanted"]
    return {
        name: 1.0 if name in ABSOLUTE else abs(float(np.mean([r["wanted"][name] for r in full.values()]))) or 1.0
        for name in names
    }


def _differences(runs: dict[int, Record], full: dict[int, Record], name: str, scale: float) -> list[float]:
    return [(runs[seed]["wanted"][name] - full[seed]["wanted"][name]) / scale for seed in runs if seed in full]


def _spreads(by: dict[str, dict[int, Record]]) -> dict[str, float]:
    full, found = by[EVERYTHING], {}
    for name, scale in scales(full).items():
        variances, free = [], len(full) - 1
        for variant, runs in by.items():
            d = _differences(runs, full, name, scale)
            if variant not in (EVERYTHING, IDLE) and len(d) > 1 and any(d):
                variances.append(float(np.var(d, ddof=1)))
        low = float(stats.chi2.ppf(0.5, free)) / free if free else 1.0
        found[name] = 2.0 * math.sqrt(float(np.median(variances)) / low / len(full)) if variances else 0.0
    return found


def _choice(variant: str, runs: dict[int, Record], full: dict[int, Record], spreads: dict[str, float]) -> Choice:
    changes = tuple(
        Change(name, float(np.mean(_differences(runs, full, name, scale))), spreads[name])
        for name, scale in scales(full).items()
    )
    first = next(iter(runs.values()))
    same = first["effects"] == next(iter(full.values()))["effects"]
    both = [s for s in runs if s in full]
    saved = [0.0] if same else [1.0 - step_time(runs[s]) / step_time(full[s]) for s in both]
    timed = same or min(step_time(full[s]) for s in both) >= SHORTEST
    return Choice(
        scene=first["scene"],
        variant=variant,
        same_as_everything=same,
        changes=changes,
        saving=float(np.median(saved)) if timed else math.nan,
        saving_spread=0.5 * (max(saved) - min(saved)) if timed else math.nan,
        cpu_s=(float(np.median([full[s]["cpu_s"] for s in both])), float(np.median([runs[s]["cpu_s"] for s in both]))),
    )


def step_time(record: Record) -> float:
    """Processor time of the steps of a run [s]; of the stock program, whose start takes some hundredths, of all."""
    return float(record["loop_cpu_s"] or record["cpu_s"])


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
