"""Outlets of a scene, from scene.json alone: regions in which spheres are removed.

A sphere that has entered leaves at the first planned step at which an outlet contains its centre, low <= centre <
high; it is assigned to the first outlet that contains it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from reference_impl.replay import io, plans
from reference_impl.replay.arrays import Floats


@dataclass(frozen=True)
class Regions:
    """Corners of the outlets, infinite if open, and the steps at which spheres leave."""

    low: Floats
    high: Floats
    steps: Floats
    enters: pd.Series
    """Id -> step at which a sphere enters."""
    stay: bool = False
    below: float = 1.0
    size: float = 0.0
    slower: float = 1.0
    """Scale of positions [m], below + size, and of speeds [m/s]."""

    def numbers(self, x: Floats, margin: float) -> Floats:
        """Return for each outlet a row of the centres that it contains; with `margin` those that it may contain, by rounding."""
        low, high = self.low[:, None] - margin, self.high[:, None] + margin
        return np.asarray(((low <= x) & (x < high)).all(axis=2))

    def holds(self, x: Floats, v: Floats, margin: float = 0.0) -> Floats:
        """Return which spheres an outlet contains, at any velocity."""
        return np.asarray(self.numbers(x, margin).any(axis=0))

    def booked(self, x: Floats, v: Floats, outlet: Floats, margin: float) -> Floats:
        """Check that each row names the first outlet that contains the sphere: no earlier one certainly contains it."""
        may, does = self.numbers(x, margin), self.numbers(x, -margin)
        named = np.clip(outlet.astype(int), 1, len(self.low)) - 1
        column = np.arange(len(x))
        earlier = np.cumsum(does, axis=0)[named, column] - does[named, column]
        return (outlet >= 1) & (outlet <= len(self.low)) & may[named, column] & (earlier == 0)

    def entered(self, ids: pd.Series) -> Floats:
        """Return the step from which each sphere may leave."""
        return ids.map(self.enters).to_numpy(float)


def of(folder: Path, steps: Floats) -> Regions:
    """Return the outlets of a run; `steps` at which spheres leave."""
    scene = io.scene(folder)
    low, high = (
        np.array([[end if v is None else v for v in o[key]] for o in scene["outlets"]], float)
        for key, end in (("low_m", -np.inf), ("high_m", np.inf))
    )
    spheres = io.columns(folder / "history" / "spheres.parquet", ["id", "type"]).sort_values("id")
    enters = pd.Series(plans.enters(scene, spheres["type"].to_numpy()), index=spheres["id"])
    return Regions(low, high, steps, enters)
