"""Liquid that each sphere carries in every step, for its weight: its film and its side of each bridge by the transfer ratio.

Elskamp & Kruggel-Emden (2018, after 43) count the liquid of a standing bridge to each side as if it ruptured now; so does the
weight. At rupture nothing moves then: only formations and drops change what a sphere carries. A step has the mass of the
liquid at its start.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl import laws
from reference_impl.compare import Floats
from reference_impl.io import Run
from reference_impl.links_rows import of_bridges
from reference_impl.liquid import FORMATION
from reference_impl.transfer import Tables


def of_events(events: pd.DataFrame, run: Run, tables: Tables) -> pd.DataFrame:
    """What some events add to what spheres carry: `step`, `id`, `more` [m3]."""
    rows = events[events["kind"] == FORMATION]
    volume = rows["volume"].to_numpy(float)
    kind, type_i, other, star = of_bridges(rows, volume, run)
    share = volume * tables.ratios(kind, type_i, other, star)
    i, j = (rows[f"share_{side}"].to_numpy(float) for side in "ij")
    pair = kind == laws.SPHERE
    return pd.DataFrame(
        {
            "step": np.concatenate([rows["step"], rows["step"][pair]]),
            "id": np.concatenate([rows["i"], rows["j"][pair]]),
            "more": np.concatenate([share - i, (volume - share - j)[pair]]),
        }
    )


def of_drops(drops: pd.DataFrame) -> pd.DataFrame:
    """The same of drops."""
    on = drops[drops["partner_kind"] == laws.SPHERE]
    return pd.DataFrame(
        {
            "step": np.concatenate([drops["step"], on["step"]]),
            "id": np.concatenate([drops["i"], on["j"]]),
            "more": np.concatenate([-drops["volume"], on["volume"]]),
        }
    )


class Carried:
    """Volume of the liquid on a sphere [m3] at the start of a step, from the start films and the logs."""

    def __init__(self, run: Run) -> None:
        spheres = run.table("spheres").sort_values("id")
        self._ids, self._first = spheres["id"].to_numpy(), spheres["film"].to_numpy(float)
        parts = [of_events(run.table("events"), run, Tables(run.table("transfer")))]
        if "drops" in run.tables:
            parts.append(of_drops(run.table("drops")))
        changes = pd.concat(parts, ignore_index=True).sort_values(["id", "step"], kind="stable")
        self._who = np.searchsorted(self._ids, changes["id"].to_numpy())
        self._far = float(changes["step"].max() + 1) if len(changes) else 1.0
        self._when = self._who * self._far + changes["step"].to_numpy()
        self._sums = np.concatenate([[0.0], np.cumsum(changes["more"].to_numpy(float))])

    def of(self, step: Floats, sphere: Floats) -> Floats:
        """For pairs of a step and a sphere's id; what a step books counts from the next one on."""
        who = np.searchsorted(self._ids, sphere)
        last = np.searchsorted(self._when, who * self._far + np.minimum(step, self._far), "left")
        since = self._sums[last] - self._sums[np.searchsorted(self._who, who, "left")]
        return np.asarray(self._first[who] + since)

    def at(self, steps: Floats) -> Floats:
        """Shape (steps, spheres in the order of their ids)."""
        found = self.of(np.repeat(steps, len(self._ids)), np.tile(self._ids, len(steps)))
        return found.reshape(len(steps), -1)
