"""Compiled parts of both collision models: scipy's tableaus, a stage of a step, its error, location of an event.

An event is the root of a function of the step length; each trial is a full step from the same start, so there is no
interpolation error, and the state after an event is a state of the method.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from scipy import integrate

from pywet.util.machine_code import njit

LOW, F_LOW, HIGH, F_HIGH, SIDE = range(5)
"""Bracket of a root: its ends, the values there, and which end moved last (−1, 1; 0 none)."""


class Tableau(NamedTuple):
    """Explicit method (Hairer, Nørsett & Wanner I) whose last stage is the first of the next step."""

    a: np.ndarray
    """Weights of the preceding stages, one row per stage; the last row gives the new state."""
    error: np.ndarray
    error_low: np.ndarray
    order: float
    """Order of the error estimate that controls the step length."""


def tableau(method: Any, error: np.ndarray, error_low: np.ndarray, order: float) -> Tableau:
    """Return the tableau of one of scipy's methods."""
    stages = np.pad(method.A, ((0, 0), (0, method.n_stages - method.A.shape[1])))
    return Tableau(np.vstack([stages, method.B]), np.array(error), np.array(error_low), order)


DOP853 = tableau(integrate.DOP853, integrate.DOP853.E5, integrate.DOP853.E3, 8.0)
DOPRI5 = tableau(integrate.RK45, integrate.RK45.E, 0.0 * integrate.RK45.E, 5.0)


@njit(error_model="numpy")
def combine(y: Any, stages: Any, weights: Any, count: int, dt: float, out: Any) -> None:
    """Compute `out` = y + dt Σ weights·stages, over the first `count` stages."""
    for q in range(out.size):
        out[q] = y[q]
    for k in range(count):
        c = dt * weights[k]
        if c != 0.0:
            for q in range(out.size):
                out[q] += c * stages[k, q]


@njit(error_model="numpy")
def error_of(stages: Any, error: Any, error_low: Any, scale: Any, dt: float) -> float:
    """Return scipy's estimate of a step's local error over the tolerance `scale`; infinite if it is not a number."""
    high = low = 0.0
    for q in range(scale.size):
        x = z = 0.0
        for k in range(error.size):
            x += error[k] * stages[k, q]
            z += error_low[k] * stages[k, q]
        high += (x / scale[q]) ** 2
        low += (z / scale[q]) ** 2
    if not math.isfinite(high + low):
        return math.inf
    return abs(dt) * high / math.sqrt((high + 0.01 * low) * scale.size) if high > 0.0 else 0.0


@njit(error_model="numpy")
def trial(bracket: Any, number: int) -> float:
    """Return the next point to try: by the secant; the middle every sixth time and if the secant leads outside the bracket."""
    low, high = bracket[LOW], bracket[HIGH]
    x = low + (high - low) * (-bracket[F_LOW] / (bracket[F_HIGH] - bracket[F_LOW]))
    return x if number % 6 != 5 and low < x < high else 0.5 * (low + high)


@njit(error_model="numpy")
def narrow(bracket: Any, x: float, f: float) -> None:
    """Update the bracket with the value f at x (Illinois: the value of an end that remains twice is halved)."""
    side = 1 if f >= 0.0 else -1
    moves, stays = (HIGH, LOW) if f >= 0.0 else (LOW, HIGH)
    bracket[moves], bracket[moves + 1] = x, f
    if bracket[SIDE] == side:
        bracket[stays + 1] *= 0.5
    bracket[SIDE] = side
