"""How often the intervals that decide an answer hold the truth: over 1,000 made-up data sets or more; faults injected."""

from __future__ import annotations

import math
import statistics as plain
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from pywet.calibration.inference import Problem, Surface
from pywet.compare import statistics
from pywet.runs import spread, tables

MANY, SETS = 5000, 1000
"""Data sets of means and differences; of calibrations, which cost more."""


def margin(sets: int) -> float:
    """Three standard deviations of a share of 0.95 counted in so many sets."""
    return 3.0 * math.sqrt(0.95 * 0.05 / sets)


def of_mean(count: int) -> float:
    """Share of sets of so many normal values whose interval of the mean holds 7."""
    values = np.random.default_rng(count).normal(7.0, 0.3, (MANY, count)).tolist()
    return float(np.mean([abs(plain.mean(v) - 7.0) <= (spread.half_width(v) or 0.0) for v in values]))


def of_difference(n: int, m: int) -> float:
    """Return the share of intervals that contain the true difference of two groups, 3."""
    random = np.random.default_rng(10 * n + m)
    one, two = random.normal(1.0, 0.5, (MANY, n)), random.normal(4.0, 0.5, (MANY, m))
    half = [statistics.of_difference(a, b) or 0.0 for a, b in zip(one, two, strict=True)]
    return float(np.mean(np.abs(two.mean(axis=1) - one.mean(axis=1) - 3.0) <= half))


def of_calibration(scatter: float, error: float) -> float:
    """Return the share of intervals that contain a parameter with response 2 + 10 u (eight runs) and a measured target."""
    random, places, held = np.random.default_rng(5), np.tile(np.linspace(0.2, 0.8, 4), 2)[:, None], 0
    for hidden in random.uniform(0.3, 0.7, SETS):
        surface = Surface.through(places, 2.0 + 10.0 * places + random.normal(0.0, scatter, places.shape))
        wanted = 2.0 + 10.0 * hidden + random.normal(0.0, error)
        problem = Problem(
            lambda u, of=surface: (*of.at(u), np.full(1, float(of.freedom))),
            np.array([wanted]), np.array([error]), np.array([math.inf]), 0.95, (np.full(1, 0.1), np.full(1, 0.9)),
        )  # fmt: skip
        # one target of one parameter: the minimum of the sum is zero, and the hidden value fits if its sum is within the quantile
        problem.__dict__["minima"] = [np.array([hidden])]
        held += problem.sum(np.array([hidden])) <= problem.quantile**2
    return held / SETS


COVERAGE: dict[str, Callable[[], float]] = {
    "mean of 2 seeds": lambda: of_mean(2),
    "mean of 5 seeds": lambda: of_mean(5),
    "difference of 2 and 3": lambda: of_difference(2, 3),
    "difference of 4 and 8": lambda: of_difference(4, 8),
    "calibration, runs scatter": lambda: of_calibration(0.3, 1e-3),
    "calibration, target scatters": lambda: of_calibration(0.05, 0.3),
}


@pytest.mark.parametrize("name", COVERAGE)
def test_intervals_hold_the_truth_as_often_as_they_say(name: str) -> None:
    assert COVERAGE[name]() == pytest.approx(0.95, abs=margin(SETS if "calibration" in name else MANY))


def patched(owner: Any, name: str, changed: Any) -> Callable[[pytest.MonkeyPatch], None]:
    return lambda patch: patch.setattr(owner, name, changed)


SOUND, AT = statistics.half_width, Surface.at
FAULTS: dict[str, tuple[str, Callable[[pytest.MonkeyPatch], None]]] = {
    "deviation by n": ("mean of 2 seeds", patched(spread, "stdev", plain.pstdev)),
    "root of n - 1": ("mean of 2 seeds", patched(spread, "sqrt", lambda n: math.sqrt(n - 1))),
    "deviation, not standard error": ("mean of 5 seeds", patched(spread, "sqrt", lambda n: 1.0)),
    "variance for deviation": ("mean of 5 seeds", patched(spread, "stdev", plain.variance)),
    "one freedom too many": (
        "difference of 2 and 3", patched(statistics, "half_width", lambda d, c, f, q: SOUND(d, c, f + 2, q))),
    "one-sided quantile": (
        "difference of 4 and 8", patched(statistics, "half_width", lambda d, c, f, q: SOUND(d, c, f, 2.0 * q - 1.0))),
    "all runs counted": (
        "difference of 4 and 8", patched(statistics, "half_width", lambda d, c, f, q: SOUND(d, 12.0, f, q))),
    "variance of the response left out": (
        "calibration, runs scatter", patched(Surface, "at", lambda s, u: (AT(s, u)[0], 0.0 * AT(s, u)[1]))),
    "variance of a run for that of the mean": (
        "calibration, runs scatter", patched(Surface, "at", lambda s, u: (AT(s, u)[0], s.deviation**2))),
    "normal quantile": (
        "calibration, runs scatter", patched(Problem, "quantile", property(lambda p: float(stats.norm.ppf(0.975))))),
    "error of the target halved": (
        "calibration, target scatters",
        patched(Problem, "residuals", lambda p, u: (p.response(u)[0] - p.values) / (0.5 * p.errors))),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_wrong_interval_is_found(monkeypatch: pytest.MonkeyPatch, fault: str) -> None:
    """By its coverage alone."""
    name, plant = FAULTS[fault]
    plant(monkeypatch)
    assert abs(COVERAGE[name]() - 0.95) > margin(SETS if "calibration" in name else MANY)


def test_a_permutation_test_never_gives_a_probability_below_that_of_one_arrangement() -> None:
    """Five against five, far apart, with scatter near round-off or none: 2 of 252 arrangements."""
    random = np.random.default_rng(3)
    for scatter in (0.0, 1e-7, 1e-6):
        a, b = (mean + scatter * random.normal(size=(5, 1)) for mean in (0.2, 0.8))
        assert statistics.permutation([statistics.Sample(a, b)])[0].p == pytest.approx(2.0 / 252.0)


def test_a_ledger_with_a_number_that_is_none_does_not_close() -> None:
    held = {name: [0.0, 0.0] for name in ("bridges", "walls", "left", "retired")}
    assert math.isnan(tables.ledger_error(pd.DataFrame({"films": [1.0, math.nan], "initial": [1.0, 1.0], **held})))


def test_runs_that_lie_in_the_polynomial_fit_it() -> None:
    """A cubic without scatter between seeds differs from its fit by round-off alone, which is no lack of fit."""
    u = np.repeat(np.linspace(0.0, 1.0, 5), 2)[:, None]
    for values in (0.7 * u + 0.31, u**3 + 0.1, 0.0 * u + 0.3, 0.0 * u):
        assert Surface.through(u, values).misfit == 1.0
