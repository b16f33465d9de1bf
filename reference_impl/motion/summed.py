"""Bound on the difference between capillary work, which the engine sums as powers over steps, and the energy of the bridges.

The engine multiplies the force of a step by the speed in the middle of its kick, so that from one step to the next it
adds dt/2 (F(n) v(n) + F(n+1) v(n+1)). With v(n) = v(n+1/2) - a(n) dt/2 that is the trapezoidal rule over the gap, and
dt^2/4 F a at the end minus that at the start: zero at events, where no force acts, so that it remains only for
bridges active at an output (`active`). `of_events` has the error of the trapezoidal rule, and the half steps at
events.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd

from reference_impl.motion import impulses
from reference_impl.motion.window import Setup
from reference_impl.replay import capillary, coverage, laws
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import Pairs, bodies, pairs
from reference_impl.replay.io import Run
from reference_impl.replay.lives import FORMATION

SLACK = 0.5
"""Factor on the work along the whole relative displacement in the steps of events.

A bridge acts from the step after its formation and no longer at its rupture, so that sums of the halves of both
steps' powers omit half a step; half an interval at ruptures if bridges act every few steps (see impulses.py).
"""


def _ends(setup: Setup, table: pd.DataFrame, p: Pairs) -> tuple[Floats, Floats]:
    """Return the positions of i and j in `setup.ids`; for a wall that of i."""
    i = np.searchsorted(setup.ids, table["i"])
    return i, np.where(p.wall, i, np.searchsorted(setup.ids, np.where(p.wall, table["i"], table["j"])))


def drag_at_touch(run: Run, table: pd.DataFrame, p: Pairs) -> Floats:
    """Return the normal drag per speed at touch [kg/s], where it is largest; zero if the law is not known."""
    name, zero = coverage.law(run, "viscous_normal"), np.zeros(len(table))
    if name not in laws.VISCOUS_NORMAL:
        return zero
    volume = table["volume"].to_numpy(float)
    return np.abs(laws.VISCOUS_NORMAL[name](zero, volume, p.ri, p.rj, p.wall, zero + 1.0, run.meta["viscosity"]))


def active(run: Run, setup: Setup, shots: pd.DataFrame, outputs: Floats, v: Floats) -> Floats:
    """Return at each output the sum of dt^2/4 F a over the bridges [J]; `v` are the speeds of all spheres.

    The acceleration of a sphere is at most the sum of all forces on it over its mass: of its bridges, with normal drag twice for
    the tangential one, and of the dry contacts of bodies that a bridge joins.
    """
    p, every = pairs(shots, bodies(run)), impulses.every(run)
    (i, j), at = _ends(setup, shots, p), np.searchsorted(outputs, shots["step"].to_numpy())
    speed, acceleration = walls_motion(setup)
    kinds = setup.kind[i], np.where(p.wall, 0, setup.kind[j])
    gap, ma, mb = shots["separation"].to_numpy(float), setup.mass[i], np.where(p.wall, np.inf, setup.mass[j])
    stiffness, _, damping, of_side = setup.dry.at(kinds, np.abs(gap), ma / (1.0 + ma / mb))
    friction = setup.dry.friction[kinds]
    force = every * np.abs(pull_of(run, shots)(np.maximum(gap, 0.0)))
    rate = np.linalg.norm(v[at, i] - np.where(p.wall[:, None], 0.0, v[at, j]), axis=1) + p.wall * speed
    dry = (gap <= 0.0) * (1.0 + friction) * (stiffness * np.abs(gap) + damping * rate) + (gap <= 0.0) * of_side * rate
    push = dry + force + 2.0 * every * drag_at_touch(run, shots, p) * rate
    most = np.full(v.shape[:2], float(np.linalg.norm(setup.gravity)))
    np.add.at(most, (at, i), push / setup.mass[i])
    pair = np.flatnonzero(~p.wall)
    np.add.at(most, (at[pair], j[pair]), push[pair] / setup.mass[j[pair]])
    of_both = most[at, i] + np.where(p.wall, acceleration, most[at, j])
    return np.bincount(at, 0.25 * setup.step**2 * force * of_both, len(outputs))


def walls_motion(setup: Setup) -> tuple[float, float]:
    """Return the largest speed [m/s] and acceleration [m/s2] of any wall."""
    found = [(0.0, 0.0)]
    for wall in setup.walls:
        way = wall.way
        if "velocity_m_per_s" in way:
            found.append((float(np.linalg.norm(way["velocity_m_per_s"])), 0.0))
        elif way:
            rate = 2.0 * np.pi * way["frequency_Hz"] if "frequency_Hz" in way else 2.0 * np.pi / way["period_s"]
            corners = setup.corners[wall.first : wall.last].reshape(-1, 3)
            arms = [way["amplitude_m"]] if "frequency_Hz" in way else corners - np.array(way["origin_m"])
            reach = float(np.linalg.norm(arms, axis=1).max())
            found.append((rate * reach, rate**2 * reach))
    return max(f[0] for f in found), max(f[1] for f in found)


def pull_of(run: Run, table: pd.DataFrame) -> Callable[[Floats], Floats]:
    """Return the capillary force of bridges as a function of their gaps."""
    name, p = coverage.law(run, "capillary"), pairs(table, bodies(run))
    volume, sigma = table["volume"].to_numpy(float), run.meta["surface_tension"]
    return lambda s: capillary.LAWS[name](s, volume, p.ri, p.rj, p.wall, p.ti, p.tj, sigma) if name else 0.0 * s


def of_events(run: Run, setup: Setup, events: pd.DataFrame) -> Floats:
    """Return the largest error of the work [J] when a sum of powers over steps is used for every bridge from touch to its gap at
    an event.

    At the event half the step is left out: F(gap) way/2; after a formation the step's way is the event's and what the pull and
    gravity add in it. The rest is the trapezoidal rule for a force that falls with the gap, convex: in every interval at most
    half of it times the fall of the force there, in all most/2 (F(0) - F(gap)); or, beyond the interval that holds touch and the
    next one, most^2/8 times the slope there (the bound of a convex function), and the slope at most the fall over the interval
    before: in all 9/8 most (F(0) - F(most)). The smaller of the two counts. `most` is the way in an interval at touch: from touch
    to the gap a drag -c v takes c(S) dS/m, at most c(0) S/m, the pull 2 F(0) S/m of v^2.
    """
    p, force, interval = pairs(events, bodies(run)), pull_of(run, events), setup.step * impulses.every(run)
    gap, speed = np.maximum(events["separation"].to_numpy(float), 0.0), events["speed"].to_numpy(float)
    i, j = _ends(setup, events, p)
    inverse = 1.0 / setup.mass[i] + np.where(p.wall, 0.0, 1.0 / setup.mass[j])
    at, touch, formation = force(gap), np.abs(force(0.0 * gap)), (events["kind"] == FORMATION).to_numpy()
    pulled = (touch * inverse + float(np.linalg.norm(setup.gravity))) * interval
    way = np.where(formation, setup.step * (speed + pulled), interval * speed)
    fastest = np.sqrt((speed + drag_at_touch(run, events, p) * gap * inverse) ** 2 + 2.0 * touch * gap * inverse)
    most = interval * (fastest + pulled)
    fall = np.minimum(9.0 / 8.0 * np.abs(touch - force(most)), 0.5 * np.abs(touch - at))
    return np.asarray(SLACK * np.abs(at) * way + fall * most)
