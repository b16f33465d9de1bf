"""Liquid of each sphere in every step, for its weight: its film and its share of each bridge by the transfer ratio.

Elskamp & Kruggel-Emden (2018, after 43) assign the liquid of an active bridge to each side as if it ruptured at that
time; the same is done for the weight. No liquid moves at rupture then: only formations and drops change the liquid of
a sphere. A step uses the mass of the liquid at its start.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl.motion import window
from reference_impl.replay import coverage, laws, plans
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import bodies, of_bridges
from reference_impl.replay.io import Run
from reference_impl.replay.lives import FORMATION
from reference_impl.replay.stream import END
from reference_impl.replay.transfer import Tables


def of_events(events: pd.DataFrame, run: Run, tables: Tables) -> pd.DataFrame:
    """Return the liquid that events add to spheres: `step`, `id`, `more` [m3]."""
    rows = events[events["kind"] == FORMATION]
    volume = rows["volume"].to_numpy(float)
    kind, type_i, other, star = of_bridges(rows, volume, run)
    share = volume * tables.ratios(kind, type_i, other, star)
    i, j = (rows[f"share_{side}"].to_numpy(float) for side in "ij")
    pair = kind == laws.SPHERE
    return pd.DataFrame(
        {
            "step": np.concatenate([rows["step"], rows["step"][pair]]).astype(np.int64),
            "id": np.concatenate([rows["i"], rows["j"][pair]]).astype(np.int64),
            "more": np.concatenate([share - i, (volume - share - j)[pair]]),
        }
    )


def of_drops(drops: pd.DataFrame) -> pd.DataFrame:
    """Return the changes of the liquid on spheres by drops that they catch or shed."""
    on = drops[drops["partner_kind"] == laws.SPHERE]
    return pd.DataFrame(
        {
            "step": np.concatenate([drops["step"], on["step"]]).astype(np.int64),
            "id": np.concatenate([drops["i"], on["j"]]).astype(np.int64),
            "more": np.concatenate([-drops["volume"], on["volume"]]),
        }
    )


class Carried:
    """Volume of the liquid on each sphere [m3] at the start of every step of the windows, from initial films and logs."""

    def __init__(self, run: Run) -> None:
        heavy = run.meta["effects"].get("liquid_weight")
        wanted = window.recorded(run.folder) or (heavy and coverage.semi_implicit(run))
        self._steps = plans.plan(run.folder).window_steps if wanted else np.zeros(0, np.int64)
        self._now = np.nan_to_num(bodies(run).film)
        self._at = np.empty((len(self._steps), len(self._now)))
        self._ids = np.sort(run.table("spheres")["id"].to_numpy())
        self._tables, self._done, self._last = Tables(run.table("transfer")), 0, -1

    def add(self, part: Run, last: int) -> None:
        """Add a chunk of the logs up to a step; changes in a step count from the next step on."""
        if self._done == len(self._steps):
            return
        events, drops = part.table("events"), part.shed
        of_part = drops[(drops["step"] > self._last) & (drops["step"] <= last)]
        changes = pd.concat([of_events(events, part, self._tables), of_drops(of_part)]).sort_values(
            "step", kind="stable"
        )
        step, sphere, more = (changes[name].to_numpy() for name in ("step", "id", "more"))
        start, until = 0, int(np.searchsorted(self._steps, last, "right"))
        for k in range(self._done, until):
            end = int(np.searchsorted(step, self._steps[k], "left"))
            np.add.at(self._now, sphere[start:end], more[start:end])
            self._at[k], start = self._now, end
        np.add.at(self._now, sphere[start:], more[start:])
        self._done, self._last = until, last

    def of(self, step: Floats, sphere: Floats) -> Floats:
        """Return the liquid for pairs of a step of a window and a sphere's id."""
        return np.asarray(self._at[np.searchsorted(self._steps, step), sphere])

    def at(self, steps: Floats) -> Floats:
        """Return the liquid, shape (steps, spheres in the order of their ids)."""
        return self.of(steps[:, None], self._ids[None, :])


def carried(run: Run) -> Carried:
    """Return the volumes collected while the logs were read in chunks (spans.py), or compute them from all events."""
    if "carried" not in run.known:
        run.known["carried"] = Carried(run)
        run.known["carried"].add(run, END)
    found: Carried = run.known["carried"]
    return found
