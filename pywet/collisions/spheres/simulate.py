"""Runs a `Problem` and gives back what happened, in the problem's own units."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pywet.collisions.spheres import marching, steppers
from pywet.collisions.spheres.dynamics import WORKS, System
from pywet.collisions.spheres.problem import Problem, Scales, scales, system
from pywet.errors import PywetError

METHODS = {"auto": ("dop853", marching.AUTO), "dop853": ("dop853", 0), "dopri5": ("dopri5", 0), "radau": ("dop853", 1)}
"""Integrators: DOP853 with a switch to Radau IIA where stiff, or one of them throughout."""
KINDS = ("overlap", "separation", "contact", "rest", "release")
MOST_STEPS = 150_000
"""Accepted steps, an implicit one counted ten times, or events, after which a run is refused: the bound on its work."""
LOG_ROWS = 20_000


@dataclass(frozen=True)
class Event:
    """Something that happened to a pair: time, kind, pair (from 0), normal approach speed just before (negative: parting)."""

    time: float
    kind: str
    pair: tuple[int, int]
    speed: float


@dataclass(frozen=True)
class Energy:
    """Budget of kinetic energy: in + gravity − out = viscous + capillary + impact + residual; friction of resting
    contacts is in impact."""

    start: float
    end: float
    viscous: float
    capillary: float
    impact: float
    gravity: float

    @property
    def residual(self) -> float:
        """What does not add up."""
        return self.start + self.gravity - self.end - self.viscous - self.capillary - self.impact


@dataclass(frozen=True)
class Run:
    """Result of a march, in the problem's units. Arrays: position, velocity (n, 2), omega (n,)."""

    problem: Problem
    speed: float
    events: list[Event]
    events_left_out: int
    position: np.ndarray
    velocity: np.ndarray
    omega: np.ndarray
    overlapping: list[tuple[int, int]]
    """Pairs whose films touch at the end."""
    resting: list[tuple[int, int]]
    gaps: dict[tuple[int, int], float]
    energy: Energy
    steps: int
    implicit_steps: int
    evaluations: int
    impacts: int
    rest_speed: float
    """Largest rest speed any pair ended with, in units of speed."""
    wall_s: float
    record: dict[str, np.ndarray]
    """With `record`: time (k,), position, velocity (k, n, 2), omega (k, n), gap, approach, sideways, angle (k, pairs)."""


def workspace(problem: Problem, s: System, unit: Scales, rows: int, polar: bool) -> steppers.Work:
    """State and scratch arrays of a march, at its start."""
    n, pairs = len(problem.radius), len(problem.pairs)
    size = 5 * n + WORKS + (4 * pairs if polar else 0)
    y = np.zeros(size)
    moved = (problem.position - problem.position.mean(axis=0)) / unit.length
    for i in range(n):
        y[5 * i : 5 * i + 2], y[5 * i + 2 : 5 * i + 4] = moved[i], problem.velocity[i] / unit.speed
        y[5 * i + 4] = problem.omega[i] * unit.time
    names = ("f", "y_new", "f_new", "y_trial", "scale")
    w = steppers.Work(
        y=y,
        **{name: np.zeros(size) for name in names},
        stages=np.zeros((13, size)),
        act=np.zeros(pairs, dtype=np.int64),
        slot=np.full(pairs, -1, dtype=np.int64),
        rest=np.zeros(pairs, dtype=np.bool_),
        lam=np.zeros(pairs),
        lam_new=np.zeros(pairs),
        geometry=np.zeros((pairs, 6)),
        impacts=np.zeros(pairs, dtype=np.int64),
        rest_speed=np.full(pairs, float(problem.rest_speed)),
        number=np.zeros(12, dtype=np.int64),
        value=np.zeros(9),
        log=np.zeros((LOG_ROWS, 4)),
        trace=np.zeros((rows, 1 + 5 * n + 4 * pairs)),
        final=np.zeros((pairs, 6)),
    )
    w.number[steppers.SIZE] = 5 * n + WORKS
    w.value[steppers.SPEED], w.value[steppers.TOLERANCE] = 1.0, problem.rtol
    return w


def first_gaps(problem: Problem, unit: Scales) -> np.ndarray:
    """Gaps of the pairs whose films touch at the start, −1 for others; a gap of exactly δ without parting counts."""
    gaps = np.full(len(problem.pairs), -1.0)
    for p, (i, j) in enumerate(problem.pairs):
        gap, film = problem.gap_of(i, j), problem.film[i, j]
        round_off = 1e-12 * film + (
            4e-16 * float(problem.radius[i] + problem.radius[j]) if (i, j) not in problem.gap else 0.0
        )
        n = problem.position[j] - problem.position[i]
        u = float((problem.velocity[i] - problem.velocity[j]) @ n) / float(np.hypot(*n)) / unit.speed
        if gap < film - round_off or (gap <= film + round_off and u > -1e-14):
            gaps[p] = min(gap, film) / unit.length
    return gaps


def run(
    problem: Problem,
    method: str = "auto",
    polar: bool = True,
    times: Sequence[float] | np.ndarray = (),
    record: int = 0,
) -> Run:
    """March a problem to its end; `times` are stops whose states are recorded, `record` the most steps recorded besides."""
    if method not in METHODS:
        raise PywetError(f"there is no integrator named {method}; expected one of {', '.join(METHODS)}")
    unit = scales(problem)
    s = system(problem, unit)
    w = workspace(problem, s, unit, max(record, len(times) + 1), polar)
    tableau, mode = METHODS[method]
    stops = np.array([*sorted(t / unit.time for t in times), problem.t_end / unit.time])
    began = time.perf_counter()
    code = marching.march(
        stops, first_gaps(problem, unit), s, w, steppers.TABLEAUS[tableau], mode, polar, MOST_STEPS, record > 0
    )
    wall = time.perf_counter() - began
    if code != marching.DONE:
        raise PywetError(explain(code, w, unit))
    return collect(problem, s, w, unit, wall)


def explain(code: int, w: steppers.Work, unit: Scales) -> str:
    """Why a march stopped early."""
    at = w.value[steppers.TIME] * unit.time
    why = {
        marching.TOO_MANY_STEPS: f"more than {MOST_STEPS} steps or events were needed",
        marching.STALLED: "contacts open and close without time going on",
        marching.TOO_SMALL: "the step became too small for double precision",
    }[code]
    return (
        f"the collision was given up at t = {at:.6g}: {why}; expected a shorter time, a larger rtol or a larger h_min"
    )


def collect(problem: Problem, s: System, w: steppers.Work, unit: Scales, wall: float) -> Run:
    """Results of a march in the problem's units."""
    n, pairs = len(problem.radius), problem.pairs
    origin = problem.position.mean(axis=0)
    state = w.y[: 5 * n].reshape(n, 5)
    logged = w.log[: min(w.number[steppers.LOGGED], LOG_ROWS)]
    works = w.y[5 * n : 5 * n + WORKS] * unit.energy
    impact = w.value[steppers.IMPACT_LOSS] * unit.energy + works[3]
    start, end = w.value[steppers.START] * unit.energy, w.value[steppers.END] * unit.energy
    traced = w.trace[: w.number[steppers.TRACED]]
    return Run(
        problem=problem,
        speed=unit.speed,
        events=[
            Event(float(t * unit.time), KINDS[int(k)], pairs[int(p)], float(u * unit.speed)) for t, k, p, u in logged
        ],
        events_left_out=int(w.number[steppers.LOGGED] - len(logged)),
        position=origin + state[:, :2] * unit.length,
        velocity=state[:, 2:4] * unit.speed,
        omega=state[:, 4] / unit.time,
        overlapping=sorted(pairs[int(p)] for p in w.act[: w.number[steppers.PAIRS]]),
        resting=[pairs[p] for p in range(len(pairs)) if w.rest[p]],
        gaps={pair: float(w.final[p, 0] * unit.length) for p, pair in enumerate(pairs)},
        energy=Energy(*(float(x) for x in (start, end, works[0], works[1], impact, works[2]))),
        steps=int(w.number[steppers.STEPS]),
        implicit_steps=int(w.number[steppers.STEPS_IMPLICIT]),
        evaluations=int(w.number[steppers.EVALUATIONS]),
        impacts=int(w.number[steppers.IMPACTS]),
        rest_speed=float(w.rest_speed.max()),
        wall_s=wall,
        record=columns(traced, n, len(pairs), unit, origin),
    )


def columns(traced: np.ndarray, n: int, pairs: int, unit: Scales, origin: np.ndarray) -> dict[str, np.ndarray]:
    """The recorded rows by quantity."""
    if not len(traced):
        return {}
    state, geometry = traced[:, 1 : 5 * n + 1].reshape(-1, n, 5), traced[:, 5 * n + 1 :].reshape(-1, pairs, 4)
    return {
        "time": traced[:, 0] * unit.time,
        "position": origin + state[:, :, :2] * unit.length,
        "velocity": state[:, :, 2:4] * unit.speed,
        "omega": state[:, :, 4] / unit.time,
        "gap": geometry[:, :, 0] * unit.length,
        "approach": geometry[:, :, 1] * unit.speed,
        "sideways": geometry[:, :, 2] * unit.speed,
        "angle": np.unwrap(geometry[:, :, 3], axis=0) if not math.isnan(geometry[0, 0, 3]) else geometry[:, :, 3],
    }
