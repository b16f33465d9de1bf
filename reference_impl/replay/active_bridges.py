"""Consistency of contact log and event log: each logged contact belongs to an active bridge, unchanged since its formation."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl.motion import impulses
from reference_impl.replay.arrays import Floats, Table, column
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run
from reference_impl.replay.lives import Lives, keys, none


def when(run: Run, table: Table) -> tuple[Floats, Floats, bool]:
    """Return the bridge of each row of the contact log, in the form in which `Lives` looks it up.

    A bridge acts from the step after its formation to the step before its rupture; if bridges act every few
    steps, from its formation on.
    """
    return keys(table), np.asarray(table["step"], dtype=np.int64), impulses.every(run) == 1


def formed(run: Run) -> pd.DataFrame:
    """Return volume, static rupture distance, step and event of formation by the event log for every row of the contact log.

    NaN if no bridge is active. Only the events in memory are considered.
    """
    lives = Lives(none(), run.table("events"), 0, -1)
    at = lives.at(*when(run, run.table("contacts")))
    columns = {"volume": lives.all.volume, "rupture_distance": lives.all.rupture_distance,
               "formed": lives.all.step, "event": lives.all.row}  # fmt: skip
    return pd.DataFrame({name: np.append(v.astype(float), np.nan)[at] for name, v in columns.items()})


def check(table: Table, static: Floats, limit: Floats, gap: Floats, formed_with: Floats) -> list[Quantity]:
    """Check that volumes equal those at formation bit for bit, and that no bridge exceeds both its rupture distances."""
    volume = column(table, "volume")
    beyond = (gap >= np.maximum(static, limit) * (1.0 + 1e-9)).astype(float)
    none, one = np.zeros(len(table)), np.ones(len(table))
    return [
        compare("contact_volume", "volume at formation", volume, formed_with, formed_with, table, 0.0),
        compare("standing_beyond_limit", "bridges that should have ruptured", beyond, none, one, table, 0.0),
    ]
