"""Effect of semi-implicit drag on the impulse of one bridge between two outputs.

Each sphere is split into n equal parts, one per bridge; drag acts at the velocity of the parts after the step, which afterwards
take their mean (docs/engine.md). The part of sphere i that belongs to a bridge is faster than the sphere by dt (n F - D)/m, with
F the drag of the bridge on i and D the sum over all bridges of i, tangential drag included. With J = sum of dt F along the normal
and I the impulse of D, both logged, and C the integral of the coefficient c over the separation S

    J = -(C(S2) - C(S1)) - c dt ((n_i J - I_i n)/m_i + (n_j J + I_j n)/m_j).

I follows from the impulse of all bridges on a sphere less their capillary impulses along the normals at the output. Where c
varies, normals turn, bridges form or rupture between the outputs, this is known within a bound only (`Shift.doubt`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from reference_impl.motion.window import Setup
from reference_impl.replay import images
from reference_impl.replay.arrays import Floats, dot, size, vectors
from reference_impl.replay.bodies import bodies, pairs
from reference_impl.replay.io import Run
from reference_impl.replay.lives import FORMATION


@dataclass(frozen=True)
class Shift:
    """Shift of each bridge's impulse: -J = (C(S2) - C(S1) - `pushed`)/(1 + `shared`) within `doubt`/(1 + `shared`) [N s]."""

    pushed: Floats
    shared: Floats
    doubt: Floats


@dataclass(frozen=True)
class _Ends:
    """One end of each bridge: row of its sphere among all outputs, its inverse mass [1/kg] (`_end`), sign of the force on it."""

    row: Floats
    inverse_mass: Floats
    sign: float


def none(count: int) -> Shift:
    """Return a zero shift, for explicit drag."""
    return Shift(*(np.zeros(count) for _ in range(3)))


def normals(run: Run, rows: pd.DataFrame) -> Floats:
    """Return unit vectors from body j to sphere i."""
    n = images.of(run.folder).nearest(vectors(rows, "xi") - vectors(rows, "xj"))
    return np.asarray(n / size(n)[:, None])


def shift(
    run: Run,
    setup: Setup,
    rows: pd.DataFrame,
    tables: dict[str, pd.DataFrame],
    drag: tuple[Floats, Floats],
    moved: Floats,
) -> Shift:
    """Return the shift for all bridges at outputs.

    Parameters
    ----------
    run, setup
        The run, and its spheres.
    rows
        Bridges at outputs with their impulses since the output before, all of each output.
    tables
        `impulses` of the spheres and `events` of the same outputs.
    drag
        Coefficient c at the smallest and at the largest separation since the output before [kg/s].
    moved
        Path of both ends along each other since the output before [m].
    """
    p, steps = pairs(rows, bodies(run)), np.unique(rows["step"].to_numpy(np.int64))
    of = np.searchsorted(steps, rows["step"].to_numpy(np.int64)) * len(setup.ids)
    ends = [_end(setup, of, np.asarray(rows["i"]), np.ones(len(rows), dtype=bool), 1.0)]
    ends.append(_end(setup, of, np.where(p.wall, rows["i"], rows["j"]), ~p.wall, -1.0))
    n = normals(run, rows)
    pull, viscous = (rows[f"{name}_impulse"].to_numpy(float) for name in ("capillary", "viscous"))
    turned = np.minimum(moved / p.ri, 2.0)
    open_ = (np.abs(pull) + np.abs(viscous)) * turned
    dragged = _impulses(setup, steps, tables["impulses"])
    share, vague = np.zeros(len(dragged)), np.zeros(len(dragged))
    for end in ends:
        there = end.inverse_mass >= 0.0
        np.add.at(dragged, end.row[there], end.sign * (pull[:, None] * n)[there])
        np.add.at(share, end.row[there], 1.0)
        np.add.at(vague, end.row[there], open_[there])
    formed, ended = _events(run, setup, steps, tables["events"])
    vague[ended > 0] = np.inf
    inverse, pushed, all_of_it, doubt = (np.zeros(len(rows)) for _ in range(4))
    for end in ends:
        m, at = np.maximum(end.inverse_mass, 0.0), end.row
        inverse += share[at] * m
        pushed += end.sign * dot(dragged[at], n) * m
        strength = size(dragged[at])
        all_of_it += (share[at] * np.abs(viscous) + strength) * m
        free = m > 0.0
        doubt[free] += ((vague[at] + strength * turned + formed[at] * np.abs(viscous)) * np.where(free, m, 1.0))[free]
    at_least, at_most = drag
    mean, spread = 0.5 * (at_least + at_most), 0.5 * np.abs(at_least - at_most)
    return Shift(
        mean * setup.step * pushed,
        mean * setup.step * inverse,
        setup.step * (spread * all_of_it + np.maximum(at_least, at_most) * doubt),
    )


def _end(setup: Setup, of: Floats, ids: Floats, there: Floats, sign: float) -> _Ends:
    """Return one end of bridges; a wall has an inverse mass of -1, a driven sphere 0."""
    sphere = np.searchsorted(setup.ids, ids)
    inverse = np.where(setup.free[sphere], 1.0 / setup.mass[sphere], 0.0)
    return _Ends(of + sphere, np.where(there, inverse, -1.0), sign)


def _impulses(setup: Setup, steps: Floats, table: pd.DataFrame) -> Floats:
    """Return the impulse of all bridges on each sphere at each output, one row per output and sphere [N s]."""
    found = np.zeros((len(steps) * len(setup.ids), 3))
    rows = table[np.isin(table["step"], steps)]
    at = np.searchsorted(steps, rows["step"]) * len(setup.ids) + np.searchsorted(setup.ids, rows["id"])
    found[at] = vectors(rows, "impulse")
    return found


def _events(run: Run, setup: Setup, steps: Floats, events: pd.DataFrame) -> tuple[Floats, Floats]:
    """Return formations, and ruptures or other ends, of each sphere since the previous output."""
    p, at = pairs(events, bodies(run)), np.searchsorted(steps, events["step"].to_numpy(np.int64))
    counts = []
    for kind in (events["kind"].to_numpy() == FORMATION, events["kind"].to_numpy() != FORMATION):
        found = np.zeros(len(steps) * len(setup.ids))
        for ids, there in ((p.i, True), (p.sphere_j, ~p.wall)):
            rows = kind & there & (at < len(steps))
            np.add.at(found, at[rows] * len(setup.ids) + np.searchsorted(setup.ids, ids[rows].astype(np.int64)), 1.0)
        counts.append(found)
    return counts[0], counts[1]
