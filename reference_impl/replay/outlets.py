"""Outlets of a scene, from scene.json alone: regions in which spheres are removed.

A sphere that has entered leaves at the first planned step at which an outlet contains its centre, low <= centre <
high; it is assigned to the first outlet that contains it. An outlet with a least height takes only spheres that were as
high beyond the plane of its low x, on the parabola of their last position and velocity.
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
    """Corners and least heights of the outlets, infinite if open, and the steps at which spheres leave."""

    low: Floats
    high: Floats
    least: Floats
    gravity: Floats
    """Acceleration along x, y, z [m/s2]."""
    longest: float
    """Longest time [s] between two checks of a sphere."""
    steps: Floats
    enters: pd.Series
    """Id -> step at which a sphere enters."""
    stay: bool = False
    below: float = 1.0
    size: float = 0.0
    slower: float = 1.0
    """Scale of positions [m], below + size, and of speeds [m/s]."""

    def numbers(self, x: Floats, v: Floats, margin: float) -> Floats:
        """Return for each outlet a row of the spheres that it takes; with `margin` those that it may take, by rounding."""
        low, high = self.low[:, None] - margin, self.high[:, None] + margin
        inside = ((low <= x) & (x < high)).all(axis=2)
        return np.asarray(inside & (self.highest(x, v) >= self.least[:, None] - margin))

    def highest(self, x: Floats, v: Floats) -> Floats:
        """Return for each outlet a row of the largest heights since the spheres crossed its plane: at a vertex or an end.

        The time since then is the smallest positive root of g t²/2 - v t + (x - low) = 0, along x.
        """
        along, down = self.gravity[0], self.gravity[2]
        beyond = x[:, 0] - self.low[:, :1]
        with np.errstate(divide="ignore", invalid="ignore"):
            since = 2.0 * beyond / np.maximum(v[:, 0] + np.sqrt(v[:, 0] ** 2 - 2.0 * along * beyond), 0.0)
        since = np.where(np.isfinite(since), np.clip(since, 0.0, self.longest), self.longest)
        vertex = np.clip(v[:, 2] / down, 0.0, since) if down < 0.0 else np.zeros_like(since)
        times = np.stack([np.zeros_like(since), vertex, since])
        return np.asarray((x[:, 2] - v[:, 2] * times + 0.5 * down * times**2).max(axis=0))

    def holds(self, x: Floats, v: Floats, margin: float = 0.0) -> Floats:
        """Return which spheres an outlet takes."""
        return np.asarray(self.numbers(x, v, margin).any(axis=0))

    def booked(self, x: Floats, v: Floats, outlet: Floats, margin: float) -> Floats:
        """Check that each row names the first outlet that contains the sphere: no earlier one certainly contains it."""
        may, does = self.numbers(x, v, margin), self.numbers(x, v, -margin)
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
    least = np.array(
        [-np.inf if o.get("crossing_above_m") is None else o["crossing_above_m"] for o in scene["outlets"]]
    )
    interval = plans.checkpoints_every(scene, plans.plan(folder).steps) * float(scene["time_step_s"])
    return Regions(low, high, least, np.array(scene["gravity_m_per_s2"], float), 2.0 * interval, steps, enters)
