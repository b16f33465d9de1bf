"""Outlets of a scene, from scene.json alone: regions in which spheres are removed.

A sphere that has entered leaves at the first planned step at which an outlet contains its centre, low <= centre <
high; it is assigned to the first outlet that contains it. An outlet with a least height takes only spheres that were as
high as they crossed the plane of its low x, on the parabola of their last position and velocity. This plane and this
height move with a wall of the scene. Spheres that are later as high as that height ever is are taken too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.replay import io, plans
from reference_impl.replay.arrays import Floats

SAMPLES = 400
"""Instants at which the path since the last check but one is compared with plane and height; between them it is a line."""


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
    time_step: float
    walls: list[Mapping[str, Any]]
    """Vibration of the wall with which each outlet moves; empty for an outlet at rest."""
    stay: bool = False
    below: float = 1.0
    size: float = 0.0
    slower: float = 1.0
    """Scale of positions [m], below + size, and of speeds [m/s]."""

    def numbers(self, step: Floats, x: Floats, v: Floats, margin: float) -> Floats:
        """Return for each outlet a row of the spheres that it takes; with `margin` those that it may take, by rounding."""
        found = []
        for k, (low, high) in enumerate(zip(self.low, self.high, strict=True)):
            inside = ((low - margin <= x) & (x < high + margin)).all(axis=1)
            if np.isfinite(self.least[k]):
                at = np.flatnonzero(inside)
                inside[at] = self.clearance(k, step[at], x[at], v[at], margin) >= -margin
            found.append(inside)
        return np.array(found)

    def clearance(self, k: int, step: Floats, x: Floats, v: Floats, margin: float) -> Floats:
        """Return the heights of spheres above that of an outlet as they crossed its plane; -inf for those before it.

        Or later above the highest place that it has, if that is more; of a crossing before `longest` a check before decided.
        """
        most, live = np.full(len(x), -np.inf), np.arange(len(x))
        before, was_beyond, was_above = 0.0, np.zeros(0), np.zeros(0)

        def place(axis: int, limit: float) -> Floats:
            """Return the distances of those still followed beyond a limit, at a time before."""
            at = x[live, axis] - before * v[live, axis] + 0.5 * before**2 * self.gravity[axis]
            return np.asarray(at - limit)

        for n in range(SAMPLES + 1):
            before = self.longest * n / SAMPLES
            time, height = self.time_step * step[live] - before, place(2, self.least[k])
            beyond = place(0, self.low[k, 0] - margin) - self.shift(k, 0, time)
            above, out = height - self.shift(k, 2, time), beyond < 0.0
            if n:
                part = was_beyond / np.where(out, was_beyond - beyond, 1.0)
                at_plane = was_above + part * (above - was_above)
                most[live[out]] = np.maximum(most[live[out]], at_plane[out])
            stays = live[~out]
            most[stays] = np.maximum(most[stays], (height - self.top(k))[~out])
            live, was_beyond, was_above = stays, beyond[~out], above[~out]
            if not len(live):
                break
        return most

    def top(self, k: int) -> float:
        """Return how far an outlet's wall rises above where it is at the start [m]."""
        way = self.walls[k]
        return float(way["amplitude_m"][2] * (1.0 - np.sin(way["phase_rad"][2]))) if way else 0.0

    def shift(self, k: int, axis: int, time: Floats) -> Floats:
        """Return the displacement of an outlet's wall along an axis since the start [m]."""
        way = self.walls[k]
        if not way or not way["amplitude_m"][axis]:
            return np.zeros_like(time)
        phase, turns = way["phase_rad"][axis], 2.0 * np.pi * way["frequency_Hz"] * np.clip(time, 0.0, None)
        return np.asarray(way["amplitude_m"][axis] * (np.sin(turns + phase) - np.sin(phase)))

    def holds(self, step: Floats, x: Floats, v: Floats, margin: float = 0.0) -> Floats:
        """Return which spheres an outlet takes at a step."""
        return np.asarray(self.numbers(step, x, v, margin).any(axis=0))

    def booked(self, step: Floats, x: Floats, v: Floats, outlet: Floats, margin: float) -> Floats:
        """Check that each row names the first outlet that contains the sphere: no earlier one certainly contains it."""
        may, does = self.numbers(step, x, v, margin), self.numbers(step, x, v, -margin)
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
    ways: dict[str, Any] = {
        wall["name"]: wall.get("motion_parameters") or scene.get("vibration") for wall in scene["walls"]
    }
    return Regions(
        low, high, least, np.array(scene["gravity_m_per_s2"], float), 2.0 * interval, steps, enters,
        float(scene["time_step_s"]), [ways[o["moves_with"]] if o.get("moves_with") else {} for o in scene["outlets"]],
    )  # fmt: skip
