"""Find the parameters: directly for deterministic experiments, else by rounds of engine runs that narrow the range.

A round tries points throughout a window with several seeds each; all runs inside the window give the response. Then
the first condition that is met decides: if the answer is at a side of the window that is not a bound, the window
grows there; if the interval fills less than a third of the window, the window shrinks; if the standard error of the
response exceeds half that of the target, another round follows; otherwise the search ends.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

import numpy as np

from pywet.calibration.experiments import Experiment
from pywet.calibration.inference import Floats, Problem, Surface
from pywet.calibration.question import LEVELS, Question

DRAWN_IN = 1.0 / 3.0
"""Share of the window below which an interval causes the window to shrink."""
KNOWN = 0.5
"""Standard error of the response over that of the target at which the search ends: the interval is at most 12 % too wide."""
ENOUGH = "the response is known at least twice as well as the target"
SPENT = "most_runs are spent, more would narrow the intervals"
AT_ONCE = "nothing is of chance"
Report = Callable[[str], None]
Measure = Callable[[Floats, int], tuple[Floats, float]]
"""Point, seed -> values of the targets that depend on the seed, computing time [s]."""


@dataclass
class Runs:
    """Engine runs so far: points (n, parameters), values (n, targets that depend on the seed)."""

    measure: Measure
    say: Report
    places: list[Floats] = field(default_factory=list)
    values: list[Floats] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)

    def do(self, places: list[Floats], most: int) -> None:
        """Simulate points, each with the next seed; the predicted cost follows from the mean of earlier runs."""
        for k, place in enumerate(places):
            value, seconds = self.measure(place, len(self.places))
            self.places.append(place)
            self.values.append(value)
            self.seconds.append(seconds)
            mean, left = float(np.mean(self.seconds)), len(places) - k - 1
            self.say(
                f"run {len(self.places)}: {', '.join(f'{v:.5g}' for v in value)} in {seconds:.0f} s; this round ends in about "
                f"{left * mean:.0f} s, all in {max(left, most - len(self.places)) * mean:.0f} s at most"
            )

    def inside(self, window: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
        """Return points and values of the runs within a window."""
        places, values = np.array(self.places), np.array(self.values)
        here = ((places >= window[0] - 1e-9) & (places <= window[1] + 1e-9)).all(axis=1)
        return places[here], values[here]


@dataclass(frozen=True)
class Found:
    """The solved problem, the reason why the search ended, and, if an engine was run, its runs and their surface."""

    problem: Problem
    stopped: str
    runs: Runs | None = None
    surface: Surface | None = None


def find(question: Question, experiments: list[Experiment], folder: Path, ranks: int, say: Report) -> Found:
    """Solve a question and return the result; runs are stored in the folder."""
    scattered = [k for k, e in enumerate(experiments) if e.random_start]
    targets, names = question.targets, [t.quantity for t in question.targets]

    def direct(place: Floats) -> Floats:
        """Return the means of all deterministic targets, zero for the others."""
        settings = question.settings(place)
        return np.array(
            [0.0 if e.random_start else e.value(q, settings) for e, q in zip(experiments, names, strict=True)]
        )

    def measure(place: Floats, seed: int) -> tuple[Floats, float]:
        settings, values, seconds = question.settings(place), [], 0.0
        for k in scattered:
            same = tuple(names[j] for j in scattered if experiments[j] == experiments[k])
            stored = experiments[k].run(same, settings, seed, folder / "runs", ranks)
            values.append(stored["quantities"][names[k]])
            seconds += stored["wall_s"] if experiments.index(experiments[k]) == k else 0.0
        return np.array(values), seconds

    def problem(surface: Surface | None, window: tuple[Floats, Floats]) -> Problem:
        def response(place: Floats) -> tuple[Floats, Floats, Floats]:
            mean, variance, freedom = direct(place), np.zeros(len(targets)), np.full(len(targets), np.inf)
            if surface is not None:
                mean[scattered], variance[scattered] = surface.at(place)
                freedom[scattered] = surface.freedom
            return mean, variance, freedom

        values, errors, freedoms = (np.array([getattr(t, n) for t in targets]) for n in ("value", "error", "freedom"))
        return Problem(response, values, errors, freedoms, question.confidence, window)

    count = len(question.parameters)
    if not scattered:
        return Found(problem(None, (np.zeros(count), np.ones(count))), AT_ONCE)
    errors = np.array([targets[k].error for k in scattered])
    return rounds(problem, Runs(measure, say), errors, count, question.seeds, question.most_runs)


def rounds(
    problem: Callable[[Surface, tuple[Floats, Floats]], Problem], runs: Runs, errors: Floats, count: int, seeds: int, most: int
) -> Found:  # fmt: skip
    """Simulate rounds of runs until the standard error is small enough or `most` runs have been used."""
    window = np.zeros(count), np.ones(count)
    while True:
        runs.do(_round(window, seeds), most)
        surface = Surface.through(*runs.inside(window))
        solved = problem(surface, window)
        moved = _moved(solved, window)
        spread = np.sqrt(surface.at(solved.best)[1])
        if moved is None and (spread <= KNOWN * errors).all():
            return Found(solved, ENOUGH, runs, surface)
        if len(runs.places) + len(_round(window, seeds)) > most:
            return Found(solved, SPENT, runs, surface)
        window = moved or window


def _round(window: tuple[Floats, Floats], seeds: int) -> list[Floats]:
    """Return the points of a round, as many times as there are seeds."""
    grid = product(np.linspace(0.0, 1.0, LEVELS[len(window[0])]), repeat=len(window[0]))
    return [window[0] + np.array(u) * (window[1] - window[0]) for u in grid] * seeds


def _moved(solved: Problem, window: tuple[Floats, Floats]) -> tuple[Floats, Floats] | None:
    """Return the bounds of the next round (shares of the given bounds); None if they stay the same."""
    width = window[1] - window[0]
    ranges = [solved.intervals(k) for k in range(solved.count)]
    first, last = np.array([r[0].low for r in ranges]), np.array([r[-1].high for r in ranges])
    low = np.where([r[0].open_low for r in ranges], np.maximum(window[0] - width, 0.0), window[0])
    high = np.where([r[-1].open_high for r in ranges], np.minimum(window[1] + width, 1.0), window[1])
    if (low == window[0]).all() and (high == window[1]).all():
        narrow, beside = last - first < DRAWN_IN * width, 0.5 * (last - first)
        low = np.where(narrow, np.maximum(low, first - beside), low)
        high = np.where(narrow, np.minimum(high, last + beside), high)
    return (low, high) if (low != window[0]).any() or (high != window[1]).any() else None
