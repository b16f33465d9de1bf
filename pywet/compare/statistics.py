"""Test whether two groups differ by more than their scatter: one family of tests over all quantities and times.

For large groups (2/(number of permutations) not above the level): a permutation test on the largest |t|, single step
(Westfall & Young 1993): exact for exchangeable runs, for any distribution and correlation of quantities. For smaller
groups: Student's or Welch's t with few degrees of freedom, Bonferroni within a curve (five times), Holm over
quantities.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Floats = NDArray[np.float64]
LEVEL = 0.05
"""Probability that equal groups are reported as different anywhere in the comparison."""
ROUND_OFF = 1e-9
"""Deviation over the scale below which no test is made: round-off of sums, not physics."""
PERMUTATIONS = 5000
POINTS = 5
"""Number of times of a curve that are tested individually in small groups."""


@dataclass(frozen=True)
class Sample:
    """One quantity in both groups: arrays (runs, times) in the quantity's scale (a number has one time)."""

    a: Floats
    b: Floats


@dataclass(frozen=True)
class Finding:
    """Largest |t| of a quantity, its position (index of time), and its p-value adjusted for the whole comparison."""

    t: float
    at: int
    p: float


def half_width(deviation: float, count: float, freedom: int, confidence: float) -> float:
    """Half width of the confidence interval (Student) of a mean of n values with that standard deviation.

    >>> round(half_width(1.0, 2, 1, 0.95), 3)
    8.985
    """
    return float(stats.t.ppf(0.5 + 0.5 * confidence, freedom)) * deviation / sqrt(count)


def of_difference(a: Floats, b: Floats, confidence: float = 0.95) -> float | None:
    """Half width of the confidence interval of mean b − mean a (pooled standard deviation); None where both are single runs.

    >>> round(of_difference(np.array([1.0, 3.0]), np.array([4.0, 6.0])), 3)
    6.085
    """
    n, m = len(a), len(b)
    if n + m < 3:
        return None
    squares = ((a - a.mean()) ** 2).sum() + ((b - b.mean()) ** 2).sum()
    return half_width(sqrt(float(squares) / (n + m - 2)), n * m / (n + m), n + m - 2, confidence)


def pooled_t(a: Floats, b: Floats) -> Floats:
    """(mean a − mean b) over the pooled standard error, ROUND_OFF added in squares; a single run adds no variance.

    >>> pooled_t(np.array([[1.0], [3.0]]), np.array([[4.0], [6.0]])).round(3).tolist()
    [-2.121]
    """
    n, m = len(a), len(b)
    squares = ((a - a.mean(0)) ** 2).sum(0) + ((b - b.mean(0)) ** 2).sum(0)
    variance = squares / max(n + m - 2, 1) * (1.0 / n + 1.0 / m)
    return np.asarray((a.mean(0) - b.mean(0)) / np.sqrt(variance + ROUND_OFF**2))


def arrangements(n: int, m: int) -> list[NDArray[np.int64]]:
    """Return index sets that form group a: all of them, the real one first, or PERMUTATIONS random ones if there are more."""
    total = comb(n + m, n)
    if total <= PERMUTATIONS:
        return [np.array(c) for c in combinations(range(n + m), n)]
    random = np.random.default_rng(1)
    return [np.arange(n), *(random.permutation(n + m)[:n] for _ in range(PERMUTATIONS))]


def least_p(n: int, m: int) -> float:
    """Return the smallest p of a permutation test of these groups: one arrangement of all; equal groups count each split twice.

    >>> least_p(2, 2) == 2 / 6, least_p(1, 4) == 1 / 5
    (True, True)
    """
    return (2.0 if n == m else 1.0) / comb(n + m, n)


def can_permute(n: int, m: int) -> bool:
    """Return whether a permutation test of these groups can reach the level.

    >>> can_permute(3, 3), can_permute(4, 4), can_permute(5, 5)
    (False, True, True)
    """
    return least_p(n, m) <= LEVEL


def permutation(samples: Sequence[Sample]) -> list[Finding]:
    """Return p of each quantity: share of arrangements whose largest |t| over all quantities and times is at least its own."""
    n, m = len(samples[0].a), len(samples[0].b)
    joined = np.concatenate([np.concatenate([s.a, s.b]) for s in samples], axis=1)
    every = arrangements(n, m)
    largest = _largest(joined - joined.mean(0), every, n, m)
    mirrored = n == m and len(every) == comb(n + m, n)
    least = (2.0 if mirrored else 1.0) / len(every)  # the arrangement itself, and its mirror image
    findings = []
    for s in samples:
        t = np.abs(pooled_t(s.a, s.b))
        at = int(t.argmax())
        p = max(float(np.mean(largest >= t[at] * (1.0 - 1e-6))), least)
        findings.append(Finding(float(t[at]), at, p))
    return findings


def _largest(centred: Floats, chosen: list[NDArray[np.int64]], n: int, m: int) -> Floats:
    """Return the largest |t| over all columns for each arrangement at once; `pooled_t` of centred columns."""
    first = np.zeros((len(chosen), n + m))
    np.put_along_axis(first, np.array(chosen), 1.0, axis=1)
    a, b = first @ centred / n, (1.0 - first) @ centred / m
    squares = np.maximum((centred**2).sum(0) - n * a**2 - m * b**2, 0.0)
    variance = squares / (n + m - 2) * (1.0 / n + 1.0 / m)
    return np.asarray(np.abs((a - b) / np.sqrt(variance + ROUND_OFF**2)).max(axis=1))


def student(samples: Sequence[Sample]) -> list[Finding]:
    """Compute Welch's t of two small groups, Student's if one is a single run; Bonferroni over POINTS times, then Holm.

    A number without scatter where others scatter may coincide in a few runs by accident: its p is that of a permutation test.
    """
    scatter = any(float(x.std(axis=0).max()) >= ROUND_OFF for s in samples for x in (s.a, s.b))
    coincident = least_p(len(samples[0].a), len(samples[0].b)) if scatter else 0.0
    raw = []
    for s in samples:
        picks = np.unique(np.linspace(0, s.a.shape[1] - 1, min(POINTS, s.a.shape[1])).round().astype(int))
        tested = [(_p_value(s.a[:, k], s.b[:, k], coincident), int(k)) for k in picks]
        (t, p), at = min(tested, key=lambda f: f[0][1])
        raw.append(Finding(t, at, min(1.0, p * len(picks))))
    return holm(raw)


def _p_value(a: Floats, b: Floats, coincident: float) -> tuple[float, float]:
    """Return |t| and two-sided p of one number; `coincident`: p of a difference between groups without scatter."""
    difference = abs(float(a.mean() - b.mean()))
    one, two = (float(x.std(ddof=1)) if len(x) > 1 else 0.0 for x in (a, b))
    if max(one, two) < ROUND_OFF:
        return (0.0, 1.0) if difference <= ROUND_OFF else (difference / ROUND_OFF, coincident)
    several = min(len(a), len(b)) > 1
    t, p = stats.ttest_ind_from_stats(a.mean(), one, len(a), b.mean(), two, len(b), equal_var=not several)
    return abs(float(t)), float(p)


def holm(findings: Sequence[Finding]) -> list[Finding]:
    """Holm's step-down adjustment over the quantities.

    >>> [f.p for f in holm([Finding(1.0, 0, 0.01), Finding(1.0, 0, 0.04)])]
    [0.02, 0.04]
    """
    order = sorted(range(len(findings)), key=lambda k: findings[k].p)
    adjusted, largest = list(findings), 0.0
    for rank, k in enumerate(order):
        largest = max(largest, min(1.0, (len(findings) - rank) * findings[k].p))
        adjusted[k] = Finding(findings[k].t, findings[k].at, largest)
    return adjusted


def test(samples: Sequence[Sample]) -> tuple[str, list[Finding]]:
    """Return the name of the method for these group sizes, and the finding of each quantity."""
    n, m = len(samples[0].a), len(samples[0].b)
    if can_permute(n, m):
        ways = comb(n + m, n)
        how = f"all {ways}" if ways <= PERMUTATIONS else f"{PERMUTATIONS} random"
        method = f"permutation test on the largest |t| over all quantities and times, {how} arrangements"
        return method, permutation(samples)
    method = f"t test with small-sample quantiles, {POINTS} times of each curve, Holm over the quantities"
    return method, student(samples)
