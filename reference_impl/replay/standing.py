"""The contact log against the event log: each logged contact belongs to a bridge that stands, unchanged since its formation."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl.motion import impulses
from reference_impl.replay.compare import Floats, Quantity, compare
from reference_impl.replay.io import Run
from reference_impl.replay.lives import Lives, keys, none


def formed(run: Run, lives: Lives | None = None) -> pd.DataFrame:
    """Volume, static rupture distance, step and event of formation by the event log for every row of the contact log.

    NaN where no bridge stands. A bridge acts from the step after its formation to the step before its rupture; where bridges act
    every few steps, from its formation on. Without `lives` of a part of the log those of all events are taken.
    """
    contacts = run.table("contacts")
    lives = lives or Lives(none(), run.table("events"), 0, -1)
    at = lives.at(keys(contacts), contacts["step"].to_numpy(np.int64), strictly=impulses.every(run) == 1)
    columns = {"volume": lives.all.volume, "rupture_distance": lives.all.rupture_distance,
               "formed": lives.all.step, "event": lives.all.row}  # fmt: skip
    return pd.DataFrame({name: np.append(v.astype(float), np.nan)[at] for name, v in columns.items()})


def check(run: Run, static: Floats, limit: Floats, gap: Floats, own: pd.DataFrame) -> list[Quantity]:
    """Volumes bit for bit as at formation, and no bridge beyond both its rupture distances."""
    table = run.table("contacts")
    volume, formed_with = table["volume"].to_numpy(float), own["volume"].to_numpy(float)
    beyond = (gap >= np.maximum(static, limit) * (1.0 + 1e-9)).astype(float)
    none, one = np.zeros(len(table)), np.ones(len(table))
    return [
        compare("contact_volume", "volume at formation", volume, formed_with, formed_with, table, 0.0),
        compare("standing_beyond_limit", "bridges that should have ruptured", beyond, none, one, table, 0.0),
    ]
