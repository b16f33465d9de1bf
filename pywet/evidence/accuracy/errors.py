"""Errors and prices from the kept runs: each level of a knob against the knob's finest, with what chance alone makes.

Screening and bed are chaotic: two runs that differ in a rounding drift apart as far as two seeds. The error of a level is the
mean over seeds of its difference to the finest level with the same seed; its limit is the half width of the 99 % confidence
interval (Student) of that mean. The standard deviation is pooled over all levels and knobs of the scene, which are equally
good samples of chance. An error within its limit is not resolved. Of a hundred such errors one is beyond its limit by chance;
what is said of the defaults rests on all of them at once and takes `family`, at which the odds are one in a hundred for all
together (Bonferroni). Colliding pairs take the instants of touch for seeds, each
level with its own deviation. Everything is in the unit of `QUANTITIES`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pywet.evidence.accuracy import knobs
from pywet.evidence.accuracy.runs import KNOBS_OF, SCREENING
from pywet.evidence.compare.statistics import half_width

CONFIDENCE = 0.99


@dataclass(frozen=True)
class Quantity:
    """What a user wants: the group it belongs to, in words, its scene, and whether errors are relative to its size."""

    name: str
    group: str
    text: str
    scenes: tuple[str, ...]
    relative: bool = False
    absolute_error: bool = False
    """The number is itself an error against an exact solution."""


QUANTITIES = (
    Quantity("retained_mean", "fraction retained", "mean over the run, of the feed", SCREENING),
    Quantity("retained_end", "fraction retained", "at the end, of the feed", SCREENING),
    Quantity("liquid_coarse_material", "liquid shares", "on the screen, of all liquid", ("moist",)),
    Quantity("liquid_fines", "liquid shares", "on the fines, of all liquid", ("moist",)),
    Quantity("liquid_walls", "liquid shares", "on wires and walls, of all liquid", ("moist",)),
    Quantity("liquid_bridges", "liquid shares", "in bridges, of all liquid", ("moist",)),
    Quantity(
        "law_force", "force", "largest over the gap, of that at touch, against the exact bridge", ("laws",), False, True
    ),
    Quantity("law_rupture", "force", "rupture distance against the exact bridge", ("laws",), False, True),
    Quantity("sharing_ratio", "liquid shares", "of one rupture, in the table", ("laws",), False, True),
    Quantity("pull_force", "force", "two bodies drawn apart, at a gap of r/50", ("pull",), True),
    Quantity("pull_work", "force", "work of drawing apart", ("pull",), True),
    Quantity("pull_rupture", "force", "rupture distance of two bodies drawn apart", ("pull",), True),
    Quantity("restitution", "restitution", "of two bodies, of the speed of approach", ("pair_dry", "pair_wet")),
    Quantity("bed_height", "packing", "height of a settling bed", ("bed",), True),
    Quantity("bed_bridges", "packing", "bridges per sphere of a settling bed", ("bed",), True),
    Quantity("bed_liquid", "packing", "liquid in bridges of a settling bed", ("bed",)),
)
GROUPS = tuple(dict.fromkeys(q.group for q in QUANTITIES))
WET_SCENES = ("moist", "bed", "pair_wet", "pull", "laws")
Kept = Mapping[str, Any]


@dataclass(frozen=True)
class Error:
    """Error of one level of a knob in one quantity of one scene.

    `limit` is what chance alone may make of it, `family` what it may make of the largest of all errors of the study.
    """

    scene: str
    knob: str
    level: knobs.Level
    quantity: str
    group: str
    value: float
    limit: float
    family: float
    seeds: int

    @property
    def resolved(self) -> bool:
        """Whether it is more than chance."""
        return abs(self.value) > self.limit

    @property
    def bound(self) -> float:
        """What it may be."""
        return abs(self.value) + self.limit


@dataclass(frozen=True)
class Price:
    """Processor time of the time loop over that of the default in the same round (wall time for ranks)."""

    scene: str
    knob: str
    level: knobs.Level
    ratio: float
    low: float
    high: float


def errors(kept: Iterable[Kept], size: str) -> list[Error]:
    """Every error that the runs allow to say; levels that failed have none."""
    runs = [r for r in kept if r["failed"] is None and r["knob"] != "again"]
    found: list[_Sample] = []
    for quantity in QUANTITIES:
        for scene in quantity.scenes:
            values = _values([r for r in runs if r["scene"] == scene], quantity.name)
            found += _of_scene(scene, quantity, values, size)
    together = sum(bool(np.any(s.differences != 0.0)) for s in found) or 1
    return [_error(s, together) for s in found]


@dataclass(frozen=True)
class _Sample:
    """Differences of one level to the finest in one quantity, with the pooled deviation of its scene."""

    scene: str
    knob: str
    level: knobs.Level
    quantity: Quantity
    differences: np.ndarray
    spread: tuple[float, int] | None


def _error(s: _Sample, together: int) -> Error:
    d, alone = s.differences, 1.0 - CONFIDENCE
    limit, family = (_limit(d, s.spread, 1.0 - risk) for risk in (alone, alone / together))
    return Error(s.scene, s.knob, s.level, s.quantity.name, s.quantity.group, float(d.mean()), limit, family, len(d))


Values = dict[tuple[str, Any], dict[int, float]]


def _values(runs: list[Kept], name: str) -> Values:
    """(knob, level) -> seed -> value; the samples of a pair count as seeds."""
    found: Values = {}
    for run in runs:
        key = (run["knob"], run["level"])
        for k, value in enumerate(run.get("samples", {}).get(name, ())):
            found.setdefault(key, {})[k] = value
        if name in run["quantities"]:
            found.setdefault(key, {})[run["seed"]] = run["quantities"][name]
    return found


def _of_scene(scene: str, quantity: Quantity, values: Values, size: str) -> list[_Sample]:
    base = values.get(("default", None))
    if base is None:
        return []
    differences: dict[tuple[str, Any], np.ndarray] = {}
    for knob in KNOBS_OF[scene]:
        own = {**{level: v for (k, level), v in values.items() if k == knob}}
        if not own:
            continue
        own[getattr(knobs.default(size), knob)] = base
        finest = own.get(knobs.reference(knob, size))
        if finest is None:
            continue
        for level, at in own.items():
            differences[knob, level] = _differences(at, finest, quantity)
    spread = _pooled([d for (_, level), d in differences.items()]) if scene in (*SCREENING, "bed") else None
    return [_Sample(scene, knob, level, quantity, d, spread) for (knob, level), d in differences.items()]


def _differences(at: dict[int, float], finest: dict[int, float], quantity: Quantity) -> np.ndarray:
    shared = sorted(at.keys() & finest.keys())
    one, two = np.array([at[s] for s in shared]), np.array([finest[s] for s in shared])
    if quantity.absolute_error:
        return one
    if quantity.name == "restitution" and at is not finest:
        two = np.full(len(two), two.mean())  # instants are not paired
    return (one - two) / abs(two.mean()) if quantity.relative else one - two


def _pooled(differences: Iterable[np.ndarray]) -> tuple[float, int]:
    """Standard deviation of a difference and its degrees of freedom, over levels that are not bit for bit the reference."""
    moved = [d for d in differences if len(d) > 1 and np.any(d != 0.0)]
    freedom = sum(len(d) - 1 for d in moved)
    if freedom == 0:
        return 0.0, 0
    return math.sqrt(sum(float(((d - d.mean()) ** 2).sum()) for d in moved) / freedom), freedom


def _limit(d: np.ndarray, pooled: tuple[float, int] | None, confidence: float) -> float:
    if not np.any(d != 0.0) or len(d) == 0:
        return 0.0
    if pooled is not None:
        deviation, freedom = pooled
    elif len(d) > 1:
        deviation, freedom = float(d.std(ddof=1)), len(d) - 1
    else:
        return 0.0
    if freedom == 0:
        return 1.0  # one seed says nothing of chance
    return half_width(deviation, len(d), freedom, confidence)


def prices(kept: Iterable[Kept], size: str) -> list[Price]:
    """Price of every level that was run in a screening scene, the median over seeds with its range; 1 for the default."""
    runs = [r for r in kept if r["scene"] in SCREENING and r["failed"] is None]
    found = []
    for scene in SCREENING:
        of = [r for r in runs if r["scene"] == scene]
        for knob in KNOBS_OF[scene]:
            clock = "loop_wall_s" if knob == "ranks" else "loop_cpu_s"
            base = {
                seed: float(np.mean([r[clock] for r in of if r["seed"] == seed and r["knob"] in ("default", "again")]))
                for seed in {r["seed"] for r in of if r["knob"] == "default"}
            }
            for level in knobs.KNOBS[knob].levels(size):
                ratios = [
                    r[clock] / base[r["seed"]]
                    for r in of
                    if (r["knob"], r["level"]) == (knob, level) and r["seed"] in base
                ]
                if level == getattr(knobs.default(size), knob):
                    ratios = _repeats(of, base, clock)
                if ratios:
                    found.append(
                        Price(scene, knob, level, _middle(ratios, level, knob, size), min(ratios), max(ratios))
                    )
    return found


def _middle(ratios: list[float], level: knobs.Level, knob: str, size: str) -> float:
    return 1.0 if level == getattr(knobs.default(size), knob) else float(np.median(ratios))


def _repeats(runs: list[Kept], base: dict[int, float], clock: str) -> list[float]:
    """The default against its own mean of a round: how well times repeat."""
    return [r[clock] / base[r["seed"]] for r in runs if r["knob"] in ("default", "again") and r["seed"] in base]
