"""Diagnosis of impulses between the sampling windows: which factor brings them within their bounds (see between.py of motion)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from reference_impl.diagnosis.diagnosis import KINDS, Link, Suspect
from reference_impl.diagnosis.suspects import factor, middle
from reference_impl.motion.between import OF_DRAG, Between
from reference_impl.replay.arrays import Floats
from reference_impl.replay.compare import TOLERANCE
from reference_impl.replay.io import Run

ROUGH = 0.1
"""Margin at the bounds for a factor that does not hold in every step."""
TIGHT = 1e-3
"""Relative width of the bounds within which they determine a factor."""


def links(run: Run) -> Iterator[Link]:
    """Diagnose the quantities of `motion.between`."""
    unseen: Between = run.known["between"]
    tables = {name: pd.concat(parts, ignore_index=True) for name, parts in unseen.rows.items() if parts}
    for name, make in (("capillary", _capillary), ("drag", _drag), ("momentum", _momentum)):
        if name in tables:
            yield make(tables[name])


def _marks(table: pd.DataFrame) -> dict[str, Floats]:
    wall = table["wall"].to_numpy(bool)
    kinds = {
        name: (table["partner_kind"] == k).to_numpy()
        for k, name in enumerate(KINDS[:3])
        if k and "partner_kind" in table
    }
    return {"between spheres": ~wall, "at walls": wall, **kinds}


def _capillary(table: pd.DataFrame) -> Link:
    logged, low, high = (table[n].to_numpy(float) for n in ("logged", "low", "high"))
    expected = np.clip(logged, low, high)

    def suspects(rows: Floats) -> Iterator[Suspect]:
        tight = rows & (high - low <= TIGHT * np.abs(high))
        ratio = logged / np.where(high == 0.0, np.nan, 0.5 * (low + high))
        f = middle(ratio[tight] if tight.any() else ratio[rows])
        if np.isfinite(f) and f != 0.0:
            # a factor that applies to part of an interval or of the run is outside the bounds elsewhere
            near = (logged / f >= (1.0 - ROUGH) * low) & (logged / f <= (1.0 + ROUGH) * high)
            yield Suspect(f"it is {f:.4g} times what is expected", np.where(near, logged, np.nan), f)

    return Link("between_capillary", "capillary impulse between sampled steps", table, logged, expected,
                np.maximum(high, 1e-300), suspects, TOLERANCE, marks=_marks(table))  # fmt: skip


def _drag(table: pd.DataFrame) -> Link:
    logged, one = table["median"].to_numpy(float), np.ones(len(table))

    def suspects(rows: Floats) -> Iterator[Suspect]:
        f = middle(logged[rows])
        near = np.abs(logged - f) <= OF_DRAG * abs(f)
        yield Suspect(f"it is about {f:.2g} times what is expected", np.where(near, logged, np.nan), f)

    return Link("between_drag", "impulse of the normal viscous force between sampled steps", table, logged, one, one, suspects,
                OF_DRAG, marks=_marks(table))  # fmt: skip


def _momentum(table: pd.DataFrame) -> Link:
    gain, impulse = (table[[f"{n}_{axis}" for axis in "xyz"]].to_numpy(float) for n in ("gain", "impulse"))

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield from factor(gain, impulse, rows)

    return Link("between_momentum", "change of momentum by bridges between sampled steps", table, gain, impulse,
                table["scale"].to_numpy(float), suspects, TOLERANCE)  # fmt: skip
