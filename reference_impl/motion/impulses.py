"""Bridges that act every k steps (`bridges_every` of the scene): at which steps, and for how many at once.

This is the symmetric splitting of r-RESPA (Tuckerman et al. 1992): k times the force at every k-th step. A bridge
formed at such a step acts for the k/2 steps to the middle of the interval, minus the half step by which it is late
with k = 1, where it acts from the next step on; in the first step, after which the engine adds only half a kick,
twice as much.
"""

from __future__ import annotations

import numpy as np

from reference_impl.replay.arrays import Floats, Table, column
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run
from reference_impl.replay.lives import Lives, keys, none


def every(run: Run) -> int:
    """Return the steps from one evaluation to the next."""
    return int(run.meta.get("bridges_every", 1))


def new(run: Run, table: Table) -> Floats:
    """Return the rows of bridges that act in the step in which they form."""
    step = np.asarray(table["step"], dtype=np.int64)
    if every(run) == 1 or not len(table):
        return np.zeros(len(table), dtype=bool)
    # events of the same steps are sufficient to identify a new bridge
    lives = Lives(none(), run.rows("events", int(step.min()), int(step.max())), 0, int(step.min()) - 1)
    at = lives.at(keys(table), step, strictly=False)
    return np.asarray(np.append(lives.all.step, -1)[at] == step)


def weights(run: Run, table: Table) -> Floats:
    """Return the steps for which each logged force acts."""
    k, step = every(run), np.asarray(table["step"], dtype=np.int64)
    if k == 1:
        return np.ones(len(table))
    return np.asarray(np.where(new(run, table), np.where(step > 0, 0.5, 1.0) * (k - 1), k))


def check(run: Run, table: Table) -> list[Quantity]:
    """Check the logged weights, and that bridges act only at their steps."""
    if "weight" not in table:
        return []
    expected = weights(run, table)
    return [compare("contact_weight", "itself", column(table, "weight"), expected, expected, table, 0.0)]
