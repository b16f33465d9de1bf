"""Judge a statement of the paper by stored runs, with the uncertainty of seeds.

A quantity is evaluated for every seed common to all its cases, and its 95 % interval (Student) must be inside the
range that the statement's words allow, or outside it; otherwise the statement is inconclusive. If its cases have one
seed in common, each is shifted by the differences of the seeds of its neighbour. Without seeds of the neighbours a
single run decides.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from pywet.compare.statistics import half_width
from studies.full_scale.stored_runs import Moved, StoredRun

Cases = Mapping[int, StoredRun]
HOLDS, FAILS, OPEN, MISSING = "confirmed", "not confirmed", "inconclusive", "not run"


@dataclass(frozen=True)
class Part:
    """One number that must lie between `low` and `high`."""

    text: str
    low: float
    high: float
    quantity: Callable[[Cases], float]

    @property
    def range(self) -> str:
        """Return the range as an inequality."""
        if math.isinf(self.low):
            return f"{self.text} < {self.high:g}"
        if math.isinf(self.high):
            return f"{self.text} > {self.low:g}"
        return f"{self.low:g} < {self.text} < {self.high:g}"


def within(text: str, low: float, high: float, quantity: Callable[[Cases], float]) -> Part:
    """Return a part: the quantity must be between two limits."""
    return Part(text, low, high, quantity)


def above(text: str, threshold: float, quantity: Callable[[Cases], float]) -> Part:
    """Return a part: the quantity must be larger than the threshold."""
    return Part(text, threshold, math.inf, quantity)


def below(text: str, threshold: float, quantity: Callable[[Cases], float]) -> Part:
    """Return a part: the quantity must be smaller than the threshold."""
    return Part(text, -math.inf, threshold, quantity)


@dataclass(frozen=True)
class Statement:
    """A sentence of the paper, its cases, and the numbers by which it is judged."""

    number: int
    place: str
    says: str
    cases: tuple[int, ...]
    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Answer:
    """Answer to a statement; `values`: each part's value for every seed; `chance`: half the 95 % interval of each part."""

    verdict: str
    values: tuple[tuple[float, ...], ...] = ()
    uncertainty: tuple[float, ...] = ()


def neighbour(case: int) -> int:
    """Return the most similar case of table 4 with more seeds: 8 mm, 1 mm, of the same material, dry or with 5 % of liquid."""
    return (1 if case < 10 else 10) + ((case - 1) % 3 > 0)


def neighbours(case: int, runs: Mapping[int, Sequence[StoredRun]], run: StoredRun | None = None) -> list[Moved]:
    """Shift a run of a case, or its first one, by the difference of each seed of the neighbouring case.

    The list is empty if that case has one seed.
    """
    seeds = tuple(runs.get(neighbour(case), ()))
    return _moved((run or runs[case][0]).folder, seeds) if len(seeds) > 1 else []


@cache  # their tables are made once, not once for each statement
def _moved(folder: Path, seeds: tuple[StoredRun, ...]) -> list[Moved]:
    return [Moved(folder, seeds, k) for k in range(len(seeds))]


def judge(statement: Statement, runs: Mapping[int, Sequence[StoredRun]]) -> Answer:
    """Judge whether the stored runs confirm a statement."""
    if not statement.cases:  # of the law only
        return _decided(statement, [{}], [0.0] * len(statement.parts))
    if any(not runs.get(case) for case in statement.cases):
        return Answer(MISSING)
    by_seed = {case: {int(k.about["seed"]): k for k in runs[case]} for case in statement.cases}
    common = sorted(set.intersection(*(set(seeds) for seeds in by_seed.values())))
    if not common:
        return Answer(MISSING)
    worlds = [{case: seeds[seed] for case, seeds in by_seed.items()} for seed in common]
    worlds = [w for w in worlds if not np.isnan([part.quantity(w) for part in statement.parts]).any()]
    if not worlds:  # not recorded in any run
        return Answer(MISSING)
    if len(worlds) > 1:
        spreads = [scatter([part.quantity(w) for w in worlds]) for part in statement.parts]
        halves = [half_width(s, len(worlds), len(worlds) - 1, 0.95) for s in spreads]
        return _decided(statement, worlds, halves)
    return _decided(statement, worlds, _of_neighbours(statement, worlds[0], runs))


def each(part: Part, runs: Mapping[int, Sequence[StoredRun]]) -> list[float]:
    """Return the values of a part in all seeds that have its cases; those of other parts need not have been run."""
    by_seed: dict[int, dict[int, StoredRun]] = {}
    for case, found in runs.items():
        for run in found:
            by_seed.setdefault(int(run.about["seed"]), {})[case] = run
    values = []
    for _, world in sorted(by_seed.items()):
        try:
            values.append(part.quantity(world))
        except KeyError:  # a case was not run
            continue
    return [value for value in values if not math.isnan(value)]


def refuted(
    statement: Statement, runs: Mapping[int, Sequence[StoredRun]], seeds: Mapping[int, Sequence[StoredRun]]
) -> int | None:
    """Return the first part that makes a statement false whatever its other parts are, None if there is none.

    The mean over the seeds of `runs` must be outside the range by more than half its 95 % interval, which follows from the
    scatter in `seeds`, runs with more seeds.
    """
    for k, part in enumerate(statement.parts):
        values, others = each(part, runs), each(part, seeds)
        if not values or len(others) < 2:
            continue
        half = half_width(scatter(others), len(values), len(others) - 1, 0.95)
        if decide(part, float(np.mean(values)), half) == FAILS:
            return k
    return None


def redecided(
    statements: Sequence[Statement], single: Mapping[int, Sequence[StoredRun]], seeds: Mapping[int, Sequence[StoredRun]]
) -> list[tuple[Statement, Part, str, float, float, str]]:
    """Decide each range by runs of one seed, with the scatter of `seeds`, where both have its cases.

    Returns statement, range, its verdict by `seeds`, its value in the single runs, half the 95 % interval and its verdict.
    """
    found = []
    for statement, part in ((s, p) for s in statements if s.cases for p in s.parts):
        values, others = each(part, single), each(part, seeds)
        if len(values) != 1 or len(others) < 2:
            continue
        spread, free = scatter(others), len(others) - 1
        half, single_half = (half_width(spread, n, free, 0.95) for n in (len(others), 1))
        was = decide(part, float(np.mean(others)), half)
        found.append((statement, part, was, values[0], single_half, decide(part, values[0], single_half)))
    return found


def scatter(values: Sequence[float]) -> float:
    """Return the standard deviation of values; inf if some are infinite (a time not reached), 0 if all of them are."""
    if np.isfinite(values).all():
        return float(np.std(values, ddof=1))
    return 0.0 if len(set(values)) == 1 else math.inf


def _of_neighbours(statement: Statement, world: Cases, runs: Mapping[int, Sequence[StoredRun]]) -> list[float]:
    """Return half the 95 % interval of each part: variances of its cases, shifted one at a time, are added."""
    moved = {case: neighbours(case, runs, world[case]) for case in statement.cases}
    freedom = sum(len(runs[n]) - 1 for n in {neighbour(case) for case, runs_of in moved.items() if runs_of})
    if not freedom:
        return [0.0] * len(statement.parts)
    halves = []
    for part in statement.parts:
        each = [[part.quantity({**world, case: one}) for one in ones] for case, ones in moved.items() if ones]
        halves.append(half_width(float(np.sqrt(sum(scatter(v) ** 2 for v in each))), 1, freedom, 0.95))
    return halves


def _decided(statement: Statement, worlds: Sequence[Cases], uncertainty: Sequence[float]) -> Answer:
    values = tuple(tuple(part.quantity(world) for world in worlds) for part in statement.parts)
    verdicts = [
        decide(part, float(np.mean(v)), half)
        for part, v, half in zip(statement.parts, values, uncertainty, strict=True)
    ]
    verdict = FAILS if FAILS in verdicts else OPEN if OPEN in verdicts else HOLDS
    return Answer(verdict, values, tuple(uncertainty))


def decide(part: Part, value: float, half: float) -> str:
    """Judge one part by its mean over seeds and half its interval."""
    if math.isinf(half):
        return OPEN
    if part.low < value - half and value + half < part.high:
        return HOLDS
    return OPEN if part.low < value + half and value - half < part.high else FAILS


def fingerprint(statements: Sequence[Statement]) -> str:
    """Return the digest of all statements with their ranges, stored with each run to detect later changes of a range."""
    rows = [
        [s.number, s.place, s.says, list(s.cases), [[p.text, str(p.low), str(p.high)] for p in s.parts]]
        for s in statements
    ]
    return hashlib.sha256(json.dumps(rows, ensure_ascii=False).encode()).hexdigest()[:16]
