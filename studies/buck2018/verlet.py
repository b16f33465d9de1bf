"""Wet impact with a fixed time step, as an engine solves it: velocity Verlet, phases detected step by step.

Positions advance with the velocity after half a kick, which is also used in velocity-dependent forces (as in
LIGGGHTS); contact, film exit, rupture and sticking are detected at the end of the step in which they occur, and not
located within it.
"""

from __future__ import annotations

import numpy as np

from pywet.collisions.wall import forces
from pywet.collisions.wall.adaptive import Course
from pywet.collisions.wall.compiled import OK, PASSAGE, TOO_MANY, next_phase
from pywet.collisions.wall.forces import CONTACT, DONE, ENTRY, SIZE, WORK, H, Parameters, S, U, V, W
from pywet.util.machine_code import njit

MOST = 20_000_000


@njit(error_model="numpy")
def phase_after(phase: int, state: np.ndarray, p: Parameters) -> int:
    """Return the phase of the next step, from position and velocity at the end of this one."""
    passage, stop, rest = forces.events(phase, state, p)
    if rest >= 0.0 or (stop >= 0.0 and phase != CONTACT):  # in contact every sphere flies towards the wall at first
        return DONE
    return next_phase(phase, PASSAGE, state, p) if passage >= 0.0 else phase


@njit(nogil=True, cache=True, error_model="numpy")
def march(p: Parameters, state: np.ndarray, step: float) -> tuple[int, bool]:
    """Advance `state` to the end and return (steps, whether the end was reached)."""
    out = np.empty(SIZE)
    phase = ENTRY if p.wet else CONTACT
    forces.rates(phase, state, p, out)
    for n in range(MOST):
        for k in (U, V, W):
            state[k] += 0.5 * step * out[k]
        state[H] += step * state[U]
        state[S] = state[S] + step * (state[V] + state[W]) if phase == CONTACT else 0.0
        phase = phase_after(phase, state, p)
        if phase == DONE:
            return n + 1, True
        forces.rates(phase, state, p, out)
        for k in (U, V, W):
            state[k] += 0.5 * step * out[k]
        for k in range(WORK, SIZE):
            state[k] += step * out[k]
    return MOST, False


def collide(p: Parameters, state: np.ndarray, step: float) -> Course:
    """Run a collision from `state` with time step `step` [s]; it keeps no log."""
    end = state.copy()
    steps, done = march(p, end, float(step))
    return Course(end, OK if done else TOO_MANY, [], int(steps), int(steps))
