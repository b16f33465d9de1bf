"""The contact log against the event log: each logged contact belongs to a bridge that stands, unchanged since its formation."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl import laws
from reference_impl.compare import Floats, Quantity, compare
from reference_impl.io import Run

FORMATION = 0


def formed(run: Run, contacts: pd.DataFrame | None = None) -> pd.DataFrame:
    """Volume, static rupture distance, step and event of formation by the event log for every row of the contact log.

    NaN where no bridge stands. A bridge acts from the step after its formation to the step before its rupture; where bridges act
    every few steps, from its formation on.
    """
    contacts, events = run.table("contacts") if contacts is None else contacts, run.table("events")
    key = ["step", "wall", "i", "j"]
    left = contacts.assign(wall=contacts["partner_kind"] != laws.SPHERE, row=np.arange(len(contacts)))[[*key, "row"]]
    right = events.assign(
        wall=events["partner_kind"] != laws.SPHERE, formed=events["step"], event=np.arange(len(events))
    )
    right = right[[*key, "kind", "volume", "rupture_distance", "formed", "event"]]
    found = pd.merge_asof(
        left.sort_values("step", kind="stable"),
        right.sort_values("step", kind="stable"),
        on="step",
        by=["wall", "i", "j"],
        allow_exact_matches=run.meta.get("bridges_every", 1) > 1,
    ).sort_values("row", kind="stable")
    columns = ["volume", "rupture_distance", "formed", "event"]
    return found[columns].where(found["kind"] == FORMATION).reset_index(drop=True)


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
