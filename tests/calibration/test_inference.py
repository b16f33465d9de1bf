"""Intervals against closed forms, directions that stay unknown, and how often an interval holds what is hidden."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats

from pywet.calibration.inference import Floats, Problem, Surface
from pywet.calibration.search import ENOUGH, SPENT, Found, Runs, rounds

NEVER = math.inf


def problem(
    response: Callable[[Floats], list[float]], values: list[float], errors: list[float], count: int = 1,
    freedom: float = NEVER, confidence: float = 0.95,
) -> Problem:  # fmt: skip
    """Targets of a response that is known exactly, over the unit cube."""
    zero, free = np.zeros(len(values)), np.full(len(values), freedom)
    return Problem(
        lambda place: (np.array(response(place)), zero, np.full(len(values), NEVER)),
        np.array(values), np.array(errors), free, confidence, (np.zeros(count), np.ones(count)),
    )  # fmt: skip


@pytest.mark.parametrize(("freedom", "quantile"), [(NEVER, 1.959964), (4.0, 2.776445)])
def test_a_straight_response_gives_the_interval_of_the_textbook(freedom: float, quantile: float) -> None:
    """y = 2 + 10 u, wanted 6 ± 0.5: u = 0.4 ± quantile 0.5/10; quantiles of normal and Student's distribution from tables."""
    (found,) = problem(lambda u: [2.0 + 10.0 * u[0]], [6.0], [0.5], freedom=freedom).intervals(0)
    assert (found.low, found.high) == pytest.approx((0.4 - 0.05 * quantile, 0.4 + 0.05 * quantile), abs=2e-6)
    assert not found.open_low and not found.open_high


def test_two_targets_of_one_parameter_weigh_as_their_scatter_says() -> None:
    """Means of 0.3 ± 0.02 and 0.5 ± 0.04: weighted 0.34, standard error (1/0.02² + 1/0.04²)^-1/2."""
    solved = problem(lambda u: [u[0], u[0]], [0.3, 0.5], [0.02, 0.04])
    (found,) = solved.intervals(0)
    assert solved.best[0] == pytest.approx(0.34, abs=1e-6)
    assert found.high - solved.best[0] == pytest.approx(1.959964 / math.sqrt(0.02**-2 + 0.04**-2), rel=1e-4)
    assert not solved.reached  # they contradict each other, by 0.2 over 0.045


def test_a_response_that_turns_gives_two_ranges() -> None:
    """(u - 0.5)² = 0.09 at 0.2 and 0.8; the ends at the root of 0.09 ± 1.96 0.01."""
    low, high = problem(lambda u: [(u[0] - 0.5) ** 2], [0.09], [0.01]).intervals(0)
    inner, outer = math.sqrt(0.09 - 0.01959964), math.sqrt(0.09 + 0.01959964)
    assert (low.low, low.high) == pytest.approx((0.5 - outer, 0.5 - inner), abs=1e-5)
    assert (high.low, high.high) == pytest.approx((0.5 + inner, 0.5 + outer), abs=1e-5)


def test_what_is_inconclusive_is_named() -> None:
    """A product of two; a response to one alone; both distinguished by a second target."""
    for slope, group in (
        (0.005, [1]),
        (0.015, [0, 1]),
    ):  # of half, and of one and a half of its error over the whole range
        assert problem(lambda u, b=slope: [10.0 * u[0] + b * u[1]], [5.0], [0.01], count=2).unknown() == [group]
    product = problem(lambda u: [u[0] * (0.5 + u[1])], [0.5], [0.01], count=2)
    assert product.unknown() == [[0, 1]]
    (first,), (second,) = product.intervals(0), product.intervals(1)
    assert first.low == pytest.approx((0.5 - 0.0195996) / 1.5, abs=1e-5) and first.open_high
    assert (second.low, second.high) == (0.0, 1.0) and second.open_low and second.open_high
    assert problem(lambda u: [u[0]], [0.5], [0.01], count=2).unknown() == [[1]]
    apart = problem(lambda u: [u[0] * (0.5 + u[1]), u[0]], [0.5, 0.6], [0.01, 0.01], count=2)
    assert apart.unknown() == [] and apart.best == pytest.approx([0.6, 1.0 / 3.0], abs=1e-6)


def test_a_fitted_parameter_takes_a_degree_of_freedom() -> None:
    """Two targets, 0.4 and 0.6 ± 0.05, of one parameter: the sum of squares is 8, p = 0.0047 with one degree of freedom."""
    assert not problem(lambda u: [u[0], u[0]], [0.4, 0.6], [0.05, 0.05]).reached
    assert problem(lambda u: [u[0], u[0]], [0.42, 0.58], [0.05, 0.05]).reached  # 5.12, p = 0.024


@pytest.mark.parametrize(("targets", "repeats"), [(2, 3), (2, 10), (5, 3)])
def test_targets_that_agree_are_rejected_as_rarely_as_the_level_says(targets: int, repeats: int) -> None:
    """Means of few measurements of one number: 1 % contradict each other, within three standard deviations."""
    random, sets, rejected = np.random.default_rng(6), 1000, 0
    for _ in range(sets):
        measured = random.normal(0.5, 0.05, (targets, repeats))
        values, errors = measured.mean(axis=1), measured.std(axis=1, ddof=1) / math.sqrt(repeats)
        solved = problem(lambda u: [u[0]] * targets, values.tolist(), errors.tolist(), freedom=repeats - 1.0)
        solved.__dict__["minima"] = [np.array([np.average(values, weights=errors**-2.0)])]
        rejected += not solved.reached
    assert rejected / sets == pytest.approx(0.01, abs=3.0 * math.sqrt(0.01 * 0.99 / sets))


def test_slopes_are_those_at_the_place() -> None:
    """y = u² has the slope 2 u within the window and at its upper bound."""
    curved = problem(lambda u: [u[0] ** 2], [0.25], [1.0])
    assert [abs(curved.slopes(np.array([u]))[0, 0]) for u in (0.5, 1.0)] == pytest.approx([1.0, 2.0], rel=1e-2)


def test_a_surface_knows_how_well_it_is_known() -> None:
    """A straight line fitted to cubic terms: the mean of 1000 fits is the line, their spread what each fit says of itself."""
    random, places = np.random.default_rng(2), np.tile(np.linspace(0, 1, 5), 4)[:, None]
    fits = [Surface.through(places, 3.0 + places + random.normal(0, 0.5, places.shape)) for _ in range(1000)]
    reported = [fit.at(np.array([0.3])) for fit in fits]
    means, variances = np.array([m[0] for m, _ in reported]), np.array([v[0] for _, v in reported])
    assert means.mean() == pytest.approx(3.3, abs=4 * means.std() / math.sqrt(1000))
    assert variances.mean() == pytest.approx(means.var(), rel=0.15)
    assert np.mean([fit.misfit < 0.05 for fit in fits]) == pytest.approx(0.05, abs=0.02)
    assert Surface.through(places, np.sin(20 * places) + random.normal(0, 0.01, places.shape)).misfit < 1e-6


def searched(
    response: Callable[[float], float], wanted: float, error: float, scatter: float, random: np.random.Generator, most: int
) -> Found:  # fmt: skip
    """Search one parameter with a noisy response in rounds of runs and return the result."""
    runs = Runs(lambda u, seed: (np.array([response(u[0]) + random.normal(0, scatter)]), 1.0), lambda line: None)

    def solved(surface: Surface, window: tuple[Floats, Floats]) -> Problem:
        return Problem(
            lambda u: (*surface.at(u), np.full(1, float(surface.freedom))),
            np.array([wanted]), np.array([error]), np.array([NEVER]), 0.95, window,
        )  # fmt: skip

    return rounds(solved, runs, np.array([error]), 1, 2, most)


def test_rounds_hold_what_is_hidden_as_often_as_they_say() -> None:
    """A response that levels off: of 100 hidden values 95 are expected, 88 are three standard deviations less."""
    random, held = np.random.default_rng(4), 0
    for hidden in random.uniform(0.03, 0.97, 100):
        angle = lambda u: 20.0 + 18.0 * (1.0 - math.exp(-3.0 * u))  # noqa: E731
        found = searched(angle, angle(hidden) + random.normal(), 1.0, 1.0, random, 60)
        held += any(r.low <= hidden <= r.high for r in found.problem.intervals(0))
    assert 88 <= held <= 100
    assert stats.binom.cdf(87, 100, 0.95) < 0.003


def test_rounds_stop_when_enough_is_known_or_the_runs_are_spent() -> None:
    random = np.random.default_rng(1)
    quiet = searched(lambda u: 10.0 * u, 5.0, 2.0, 0.1, random, 40)
    assert quiet.stopped == ENOUGH and quiet.runs is not None and len(quiet.runs.places) == 10
    narrow = searched(lambda u: 10.0 * u, 5.0, 0.1, 0.01, random, 40)  # the second round refines the range
    assert narrow.runs is not None and len(narrow.runs.places) == 20
    assert np.ptp(np.array(narrow.runs.places)[10:]) == pytest.approx(2 * 2 * 1.96 * 0.1 / 10, rel=0.1)
    bound = searched(lambda u: 10.0 * u, 0.0, 0.1, 0.01, random, 40)  # up to the bound, no further and no less
    assert bound.runs is not None and min(bound.runs.places[10:]) == 0.0
    loud = searched(lambda u: 10.0 * u, 5.0, 0.1, 3.0, random, 40)
    assert loud.stopped == SPENT and loud.runs is not None and len(loud.runs.places) == 40
