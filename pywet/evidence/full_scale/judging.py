"""How a statement of the paper is judged by kept runs, with what seeds leave open.

A quantity is taken for every seed that all its cases have; with two or more seeds its 95 % interval (Student) must lie on one
side of the threshold, else it cannot be told. A single run is taken at its word.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pywet.evidence.compare.statistics import half_width
from pywet.evidence.full_scale.kept import Kept

Cases = Mapping[int, Kept]
HOLDS, FAILS, OPEN, MISSING = "holds", "does not hold", "cannot be told", "not run"


@dataclass(frozen=True)
class Part:
    """One number that must be above (`more`) or below a threshold."""

    text: str
    quantity: Callable[[Cases], float]
    more: bool
    threshold: float


@dataclass(frozen=True)
class Statement:
    """A sentence of the paper, the cases it is about, and the numbers by which it is judged."""

    number: int
    place: str
    says: str
    cases: tuple[int, ...]
    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Answer:
    """`values`: for each part its value with every seed."""

    verdict: str
    values: tuple[tuple[float, ...], ...] = ()


def judge(statement: Statement, runs: Mapping[int, Sequence[Kept]]) -> Answer:
    """Whether the kept runs show a statement."""
    if not statement.cases:  # of the law alone
        return Answer(*_decided(statement, [{}]))
    if any(not runs.get(case) for case in statement.cases):
        return Answer(MISSING)
    by_seed = {case: {int(k.about["seed"]): k for k in runs[case]} for case in statement.cases}
    common = sorted(set.intersection(*(set(seeds) for seeds in by_seed.values())))
    if not common:
        return Answer(MISSING)
    worlds = [{case: seeds[seed] for case, seeds in by_seed.items()} for seed in common]
    return Answer(*_decided(statement, worlds))


def _decided(statement: Statement, worlds: Sequence[Cases]) -> tuple[str, tuple[tuple[float, ...], ...]]:
    values = tuple(tuple(part.quantity(world) for world in worlds) for part in statement.parts)
    verdicts = [decide(part, of_seeds) for part, of_seeds in zip(statement.parts, values, strict=True)]
    return FAILS if FAILS in verdicts else OPEN if OPEN in verdicts else HOLDS, values


def decide(part: Part, values: Sequence[float]) -> str:
    """One part over its seeds."""
    margin = np.array(values) - part.threshold if part.more else part.threshold - np.array(values)
    half = 0.0
    if len(margin) > 1:
        half = half_width(float(margin.std(ddof=1)), len(margin), len(margin) - 1, 0.95)
    if margin.mean() - half > 0.0:
        return HOLDS
    return FAILS if margin.mean() + half <= 0.0 else OPEN


def above(text: str, threshold: float, quantity: Callable[[Cases], float]) -> Part:
    """The quantity must be larger than the threshold."""
    return Part(text, quantity, True, threshold)


def below(text: str, threshold: float, quantity: Callable[[Cases], float]) -> Part:
    """The quantity must be smaller than the threshold."""
    return Part(text, quantity, False, threshold)
