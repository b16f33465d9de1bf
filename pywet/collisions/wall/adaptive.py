"""Solve a collision by `scipy.integrate.solve_ivp`, with any of its methods; slower than `compiled` and its reference.

It can also store the path, for pictures of a collision and for integrals along it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from pywet.collisions.wall import forces
from pywet.collisions.wall.compiled import NOTHING, OK, PASSAGE, STOP, TOO_MANY, TOO_SMALL, next_phase, scales
from pywet.collisions.wall.forces import BRIDGE, CONTACT, DONE, ENTRY, SIZE, H, Parameters, S, U, rupture

MOST_CALLS = 4_000_000
"""Number of force evaluations after which a collision is abandoned."""


@dataclass
class Course:
    """Result of an integration: final state, log of phases (end, phase, event that ended it), number of evaluations.

    `pieces` contains (phase, start time, solution with dense output) if the path is stored.
    """

    state: np.ndarray
    code: int = OK
    log: list[tuple[float, int, int]] = field(default_factory=list)
    steps: int = 0
    calls: int = 0
    pieces: list[tuple[int, float, Any]] = field(default_factory=list)


def collide(p: Parameters, state: np.ndarray, rtol: float, method: str, keep_path: bool = False) -> Course:
    """Run a collision from `state`; `method` is one of solve_ivp's."""
    course = Course(np.array(state))
    phase, time = (ENTRY if p.wet else CONTACT), 0.0
    while phase != DONE:
        course.state[S] = 0.0
        if phase == BRIDGE and rupture(course.state[H], course.state[U], p) >= 0.0:
            which, spent = PASSAGE, 0.0
        else:
            which, spent = _run_phase(phase, time, p, rtol, method, keep_path, course)
        time += spent
        course.log.append((time, phase, which))
        if course.code != OK:
            break
        phase = next_phase(phase, which, course.state, p)
    return course


def _run_phase(
    phase: int, time: float, p: Parameters, rtol: float, method: str, keep: bool, course: Course
) -> tuple[int, float]:
    """Advance `course.state` to the end of the phase and return (event, duration)."""
    scale, atol = scales(phase, course.state, p, rtol)

    def rhs(t: float, y: np.ndarray) -> np.ndarray:
        course.calls += 1
        if course.calls > MOST_CALLS:
            raise _TooMany
        change = np.empty(SIZE)
        forces.rates(phase, y, p, change)
        return change

    # implicit methods and LSODA start badly on δ^{1/4}: the first step is prescribed, and no step may skip a phase
    options: dict[str, Any] = {"method": method, "rtol": max(rtol, 2.3e-14), "atol": atol, "first_step": 1e-4 * scale}
    events = [ending(lambda t, y, n=n: forces.events(phase, y, p)[n], 1.0) for n in range(3)]  # type: ignore[misc]
    options |= {"events": events, "dense_output": True}
    try:
        solved: Any = solve_ivp(rhs, (0.0, 1e9 * scale), course.state.copy(), **options)
    except _TooMany:
        course.code = TOO_MANY
        return NOTHING, 0.0
    course.steps += len(solved.t) - 1
    if solved.status != 1:
        course.code = TOO_SMALL
        return NOTHING, float(solved.t[-1])
    which = 1 + int(np.argmax([len(t) for t in solved.t_events]))
    at, end = float(solved.t[-1]), solved.y[:, -1]
    if phase == BRIDGE and which >= STOP and rupture(end[H], 0.0, p) >= 0.0:
        which, at = PASSAGE, _rupture_before(solved, at, p)
        end = solved.sol(at)
    if keep:
        course.pieces.append((phase, time, solved))
    course.state[:] = end
    return which, at


def _rupture_before(solved: Any, stop: float, p: Parameters) -> float:
    """Return the time of rupture within the step that ends with the stop, where √Ca becomes zero."""

    def beyond(t: float) -> float:
        state = solved.sol(t)
        return float(rupture(state[H], 0.0 if t == stop else state[U], p))

    before = float(solved.t[-2])
    return float(brentq(beyond, before, stop, xtol=1e-300, rtol=1e-14)) if beyond(before) < 0.0 else before


def ending(event: Callable[[float, np.ndarray], float], direction: float) -> Any:
    """Return an event that ends solve_ivp's integration where it passes zero, rising (1) or falling (−1)."""
    event.terminal, event.direction = True, direction  # type: ignore[attr-defined]
    return event


class _TooMany(Exception):
    """Raised after more force evaluations than allowed."""
