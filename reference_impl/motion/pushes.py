"""Inputs of semi-implicit drag in the recorded windows, recomputed.

They are the velocity change of a bridge's bodies by all other forces in the step, and the number of bridges among which the
mass of a sphere is divided. Forces are those of newton.py without the drag.

If bridges act every few steps, a new one acts in the step in which it forms, after all others: their drag affects it, the new
bridges affect none of them; and it shares its spheres with the remaining bridges, they with those that rupture.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from reference_impl.motion import impulses
from reference_impl.motion.wet import Bridges
from reference_impl.motion.window import Setup, Window
from reference_impl.replay.arrays import Floats, vectors
from reference_impl.replay.io import Run
from reference_impl.replay.laws import SPHERE
from reference_impl.replay.lives import RUPTURE

SCALES = {
    "window_push": "speed that the sizes of all forces on both bodies give in the step, at least that of the weight",
    "window_spin_push": "the same of the spin at the surface, and the doubt about a rolling direction over the limit",
    "window_sharing": "each counts 1",
}


def against_log(
    run: Run, setup: Setup, window: Window, b: Bridges, force: Floats, torque: Floats, sizes: Floats, doubt: Floats
) -> dict[str, tuple[Any, ...]]:
    """Compare the log's velocity changes and counts, given all forces and their magnitudes by step and sphere.

    Results are logged and recomputed values, scale and rows, followed by the second sphere's part of the
    recomputed value.
    """
    new = impulses.new(run, b.table)
    broke = _ruptured(run, setup, window.steps)
    pair = np.flatnonzero(~b.wall)
    whole = b.weight[:, None] * b.force()
    drag = whole + b.weight[:, None] * (b.capillary * b.acting["capillary"])[:, None] * b.n
    turns = [b.weight[:, None] * turn for turn in b.torques(setup)]
    ends = (np.arange(len(b.k)), b.a, 1.0), (pair, b.b, -1.0)
    linear = np.where(setup.free, setup.step / window.mass, 0.0)
    turning = linear / (0.4 * setup.radius**2)
    expected = {name: np.zeros((len(b.k), 3)) for name in ("window_push", "window_spin_push")}
    of_second = {name: np.zeros((len(b.k), 3)) for name in expected}
    scale = {name: np.full(len(b.k), 1e-300) for name in expected}
    shared = np.zeros((len(b.k), 2))
    for mine, later, broken in ((~new, new, broke), (new, np.zeros_like(new), np.zeros_like(broke))):
        if not mine.any():
            continue
        apart = np.where(mine[:, None], drag, later[:, None] * whole), mine | later
        pushed_by, turned_by, count = force.copy(), torque.copy(), broken.copy()
        for (at, who, sign), turn in zip(ends, turns, strict=True):
            on = b.k[at], who[at]
            np.add.at(pushed_by, on, -sign * apart[0][at])
            np.add.at(turned_by, on, -turn[at] * apart[1][at, None])
            np.add.at(count, on, 1.0 - later[at])
        for (at, who, sign), column in zip(ends, (0, 1), strict=True):
            at = at[mine[at]]
            on, r = (b.k[at], who[at]), setup.radius[who[at]]
            of_second["window_push"][at] = sign * linear[on][:, None] * pushed_by[on]
            of_second["window_spin_push"][at] = (r * turning[on])[:, None] * turned_by[on]
            for name, pushed in expected.items():
                pushed[at] += of_second[name][at]
            scale["window_push"][at] += linear[on] * sizes[on]
            scale["window_spin_push"][at] += r * turning[on] * (r * sizes[on] + doubt[on])
            shared[at, column] = count[on] * setup.free[who[at]]
    logged = {"window_push": vectors(b.table, "push"), "window_spin_push": vectors(b.table, "spin_push")}
    for pushed in of_second.values():
        pushed[b.wall] = 0.0  # only of the first body
    found: dict[str, tuple[Any, ...]] = {n: (logged[n], expected[n], scale[n], b.table, of_second[n]) for n in expected}
    message = b.table[["sharing_i", "sharing_j"]].to_numpy(float)
    return {**found, "window_sharing": (message, shared, np.ones(len(message)), b.table, shared * [0.0, 1.0])}


def _ruptured(run: Run, setup: Setup, steps: Floats) -> Floats:
    """Count the bridges of each sphere that rupture in a step: they exert no force in it, but the sphere's liquid is still
    shared among them.
    """
    events, count = run.rows("events", int(steps[0]), int(steps[-1])), np.zeros((len(steps), len(setup.ids)))
    for end, broke in (
        ("i", events["kind"] == RUPTURE),
        ("j", (events["kind"] == RUPTURE) & (events["partner_kind"] == SPHERE)),
    ):
        at = events[broke & events["step"].isin(steps)]
        np.add.at(count, (np.searchsorted(steps, at["step"]), np.searchsorted(setup.ids, at[end])), 1.0)
    return count
