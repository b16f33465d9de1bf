"""Solve a `Problem` and return the result in the units of the problem."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pywet.collisions.runge_kutta import DOP853, DOPRI5
from pywet.collisions.spheres import marching
from pywet.collisions.spheres.problem import Problem, Scales, scales, system
from pywet.collisions.spheres.state import WORKS, Work, workspace
from pywet.errors import PywetError

METHODS = {"auto": (DOP853, marching.AUTO), "dop853": (DOP853, 0), "dopri5": (DOPRI5, 0), "radau": (DOP853, 1)}
"""Integrators: DOP853 with a switch to Radau IIA if stiff, or one of them throughout."""
KINDS = ("overlap", "separation", "contact", "rest", "release")
MOST_STEPS = 150_000
"""Number of accepted steps (an implicit one counts ten times) or events after which a run is refused."""
LOG_ROWS = 20_000


@dataclass(frozen=True)
class Event:
    """An event of a pair: time, kind, pair (from 0), normal approach speed just before (negative: separating)."""

    time: float
    kind: str
    pair: tuple[int, int]
    speed: float


@dataclass(frozen=True)
class Energy:
    """Budget of kinetic energy: in + gravity − out = viscous + capillary + impact + residual.

    The friction of resting contacts is included in impact.
    """

    start: float
    end: float
    viscous: float
    capillary: float
    impact: float
    gravity: float

    @property
    def residual(self) -> float:
        """Return the residual of the energy budget, which its terms do not explain."""
        return self.start + self.gravity - self.end - self.viscous - self.capillary - self.impact


@dataclass(frozen=True)
class Run:
    """Result of an integration, in the problem's units. Arrays: position, velocity (n, 2), omega (n,)."""

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
    """Largest rest speed of any pair at the end, in units of speed."""
    wall_s: float
    record: dict[str, np.ndarray]
    """With `record`: time (k,), position, velocity (k, n, 2), omega (k, n), gap, approach, sideways, angle (k, pairs)."""


def first_gaps(problem: Problem, unit: Scales) -> np.ndarray:
    """Return the gaps of pairs whose films touch at the start, −1 for others; a gap of exactly δ without separation counts."""
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
    """Integrate a problem to its end.

    `times` are stops whose states are recorded, `record` the maximum number of other steps recorded.
    """
    if method not in METHODS:
        raise PywetError(
            f"there is no integrator named {method}; expected one of {', '.join(METHODS)}",
            code="spheres.integrator", given=method, expected=tuple(METHODS),
        )  # fmt: skip
    tableau, mode = METHODS[method]
    unit = scales(problem)
    s = system(problem, unit, polar)
    at = (problem.position - problem.position.mean(axis=0)) / unit.length
    first = np.column_stack([at, problem.velocity / unit.speed, problem.omega * unit.time])
    w = workspace(s, first, tableau, LOG_ROWS, max(record, len(times) + 1))
    w.now.tolerance, w.rest_speed[:] = problem.rtol, problem.rest_speed
    stops = np.array([*sorted(t / unit.time for t in times), problem.t_end / unit.time])
    began = time.perf_counter()
    code = marching.march(stops, first_gaps(problem, unit), s, w, mode, MOST_STEPS, record > 0)
    wall = time.perf_counter() - began
    if code != marching.DONE:
        raise PywetError(explain(code, w.now.time * unit.time), code="spheres.not_finished")
    return collect(problem, w, unit, wall)


def explain(code: int, at: float) -> str:
    """Name the reason why the integration stopped early."""
    why = {
        marching.TOO_MANY_STEPS: f"more than {MOST_STEPS} steps or events were needed",
        marching.STALLED: "contacts open and close without time going on",
        marching.TOO_SMALL: "the step became too small for double precision",
    }[code]
    return (
        f"the collision was given up at t = {at:.6g}: {why}; expected a shorter time, a larger rtol or a larger h_min"
    )


def collect(problem: Problem, w: Work, unit: Scales, wall: float) -> Run:
    """Return the results of an integration in the problem's units."""
    n, pairs = len(problem.radius), problem.pairs
    origin = problem.position.mean(axis=0)
    state = w.y[: 5 * n].reshape(n, 5)
    logged = w.log[: w.count.logged]
    viscous, capillary, gravity, friction = (float(x) for x in w.y[5 * n : 5 * n + WORKS] * unit.energy)
    return Run(
        problem=problem,
        speed=unit.speed,
        events=[
            Event(float(t * unit.time), KINDS[int(k)], pairs[int(p)], float(u * unit.speed)) for t, k, p, u in logged
        ],
        events_left_out=int(w.count.logged) - len(logged),
        position=origin + state[:, :2] * unit.length,
        velocity=state[:, 2:4] * unit.speed,
        omega=state[:, 4] / unit.time,
        overlapping=sorted(pairs[int(p)] for p in w.act[: w.count.pairs]),
        resting=[pair for pair, rests in zip(pairs, w.rest, strict=True) if rests],
        gaps={pair: float(w.seen[p, 0] * unit.length) for p, pair in enumerate(pairs)},
        energy=Energy(
            start=float(w.now.start * unit.energy),
            end=float(w.now.end * unit.energy),
            viscous=viscous,
            capillary=capillary,
            impact=float(w.now.impact_loss * unit.energy) + friction,
            gravity=gravity,
        ),
        **{name: int(getattr(w.count, name)) for name in ("steps", "implicit_steps", "evaluations", "impacts")},
        rest_speed=float(w.rest_speed.max()),
        wall_s=wall,
        record=columns(w.trace[: w.count.traced], n, len(pairs), unit, origin),
    )


def columns(traced: np.ndarray, n: int, pairs: int, unit: Scales, origin: np.ndarray) -> dict[str, np.ndarray]:
    """Split the recorded rows by quantity."""
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
        "angle": np.unwrap(geometry[:, :, 3], axis=0),
    }
