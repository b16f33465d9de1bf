"""Compute a collision from entry to rupture by scipy's DOP853 (tableau and step control), compiled, one call each."""

from __future__ import annotations

import numpy as np

from pywet.collisions.runge_kutta import DOP853, F_HIGH, HIGH, LOW, combine, error_of, narrow, trial
from pywet.collisions.wall import forces
from pywet.collisions.wall.forces import BRIDGE, CONTACT, DONE, ENTRY, LEAVING, SIZE, WORK, H, Parameters, S, U, V, W
from pywet.util.machine_code import njit

A, ERROR, ERROR_LOW = DOP853.a, DOP853.error, DOP853.error_low
STAGES = len(A) - 1
MAX_STEPS = 100_000
OK, TOO_MANY, TOO_SMALL = 0, 1, 2
"""Outcome of an integration: ended by an event; more than MAX_STEPS steps; a step below round-off."""
NOTHING, PASSAGE, STOP, REST = 0, 1, 2, 3
"""Event function that ended a phase."""


@njit(error_model="numpy")
def stages(phase: int, state: np.ndarray, step: float, p: Parameters, k: np.ndarray, end: np.ndarray) -> None:
    """Make one step from `state` with k[0] given: compute the other stages and write the new state to `end`."""
    for i in range(1, len(k)):
        combine(state, k, A[i], i, step, end)
        forces.rates(phase, end, p, k[i])


@njit(error_model="numpy")
def locate(
    which: int, phase: int, state: np.ndarray, step: float, p: Parameters, k: np.ndarray, low: float, high: float
) -> float:
    """Return the smallest fraction of the step found at which event function `which` is no longer negative."""
    end, bracket = np.empty(SIZE), np.array([0.0, low, 1.0, high, 0.0])
    for number in range(200):
        x = trial(bracket, number)
        if bracket[HIGH] - bracket[LOW] <= 1e-15 or bracket[F_HIGH] == 0.0 or not bracket[LOW] < x < bracket[HIGH]:
            break
        stages(phase, state, x * step, p, k, end)
        narrow(bracket, x, forces.events(phase, end, p)[which - 1])
    return float(bracket[HIGH])


@njit(error_model="numpy")
def first_event(
    phase: int,
    state: np.ndarray,
    step: float,
    p: Parameters,
    k: np.ndarray,
    before: tuple[float, float, float],
    after: tuple[float, float, float],
) -> tuple[int, float]:
    """Return (event, fraction) of the first event of a step; a bridge is tested again where the sphere stops."""
    which, at = NOTHING, 1.0
    for n in range(1, 4):
        if before[n - 1] < 0.0 and after[n - 1] >= 0.0:
            x = locate(n, phase, state, step, p, k, before[n - 1], after[n - 1])
            if which == NOTHING or x < at:
                which, at = n, x
    if phase == BRIDGE and which > PASSAGE:
        end = np.empty(SIZE)
        stages(phase, state, at * step, p, k, end)
        length = forces.rupture(end[H], 0.0, p)  # without √Ca it is shorter than at any velocity before
        if length >= 0.0 and before[0] < 0.0:
            return PASSAGE, at * locate(PASSAGE, phase, state, at * step, p, k, before[0], length)
    return which, at


@njit(error_model="numpy")
def run_phase(
    phase: int, state: np.ndarray, p: Parameters, rtol: float, atol: np.ndarray, first: float
) -> tuple[int, int, float, int, int]:
    """Advance `state` to the end of the phase and return (code, event, duration, steps, force evaluations)."""
    k, end = np.empty((STAGES + 1, SIZE)), np.empty(SIZE)
    time, step, steps, tried, rejected = 0.0, first, 0, 0, False
    forces.rates(phase, state, p, k[0])
    before = forces.events(phase, state, p)
    while steps < MAX_STEPS and tried < 4 * MAX_STEPS:
        if step < 1e-15 * time or step < 1e-300:
            return TOO_SMALL, NOTHING, time, steps, STAGES * tried
        tried += 1
        stages(phase, state, step, p, k, end)
        error = error_of(k, ERROR, ERROR_LOW, atol + rtol * np.maximum(np.abs(state), np.abs(end)), step)
        if not error < 1.0:
            step *= max(0.2, 0.9 * error ** (-0.125)) if np.isfinite(error) else 0.2
            rejected = True
            continue
        steps += 1
        after = forces.events(phase, end, p)
        which, at = first_event(phase, state, step, p, k, before, after)
        if which != NOTHING:
            forces.rates(phase, state, p, k[0])
            stages(phase, state, at * step, p, k, end)
            state[:] = end
            return OK, which, time + at * step, steps, STAGES * tried
        time += step
        growth = min(10.0, 0.9 * error ** (-0.125)) if error > 0.0 else 10.0
        step *= min(1.0, growth) if rejected else growth
        rejected = False
        state[:] = end
        k[0] = k[STAGES]
        before = after
    return TOO_MANY, NOTHING, time, steps, STAGES * tried


@njit(error_model="numpy", cache=True)
def scales(phase: int, state: np.ndarray, p: Parameters, rtol: float) -> tuple[float, np.ndarray]:
    """Return a time scale [s] of a phase and its absolute tolerances (a thousandth of rtol, B section 3.2, of its scales)."""
    speed = max(abs(state[U]), 1e-3 * np.sqrt(2.0 * p.gravity * p.layer), 1e-9 * p.speed)
    along = abs(state[V]) + abs(state[W])
    depth = (1.25 * p.mass * speed * speed / p.stiffness) ** 0.4
    length = depth if phase == CONTACT else min(p.layer, p.radius)
    along = max(along, 1e-12 * speed)
    atol = np.full(SIZE, max(1e-3 * rtol, 1e-15))
    atol[H] *= length
    atol[U] *= speed
    atol[S] *= depth * along / speed
    atol[V] *= along
    atol[W] *= along
    atol[WORK:] *= 0.5 * (max(p.speed, speed) ** 2)
    return length / speed, atol


@njit(error_model="numpy", cache=True)
def next_phase(phase: int, which: int, state: np.ndarray, p: Parameters) -> int:
    """Return the phase that follows; DONE after rupture and when the sphere remains stuck."""
    if which != PASSAGE or phase == BRIDGE:
        return DONE
    if phase == ENTRY:
        return CONTACT
    if phase == CONTACT:
        return LEAVING if p.wet else DONE
    return BRIDGE


@njit(nogil=True, cache=True, error_model="numpy")
def collide(p: Parameters, state: np.ndarray, rtol: float, log: np.ndarray) -> tuple[int, int, int, int]:
    """Run a collision; `log` gets one row per event (time, phase that ended, which event); (code, rows, steps, calls)."""
    phase, time, steps, calls, rows = (ENTRY if p.wet else CONTACT), 0.0, 0, 0, 0
    while phase != DONE:
        state[S] = 0.0
        scale, atol = scales(phase, state, p, rtol)
        if phase == BRIDGE and forces.rupture(state[H], state[U], p) >= 0.0:
            code, which, spent, n, m = OK, PASSAGE, 0.0, 0, 0
        else:
            code, which, spent, n, m = run_phase(phase, state, p, rtol, atol, 1e-4 * scale)
        time, steps, calls = time + spent, steps + n, calls + m
        log[rows, 0], log[rows, 1], log[rows, 2] = time, phase, which
        rows += 1
        if code != OK:
            return code, rows, steps, calls
        phase = next_phase(phase, which, state, p)
    return OK, rows, steps, calls
