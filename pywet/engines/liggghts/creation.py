"""Spheres that are inserted during a run and that the engine holds only from a checkpoint shortly before.

Until then they are on the straight path on which they enter. Every table contains all spheres, so that its readers
need not handle their creation.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd

from pywet.engines.schedule import created
from pywet.runs.tables import in_order
from pywet.scene import EngineScene
from pywet.util.files import read_table

Table = TypeVar("Table", pd.DataFrame, np.ndarray)
COMING = np.dtype(
    [("created", "<i8"), ("enters", "<i8"), ("id", "<i4"), ("type", "<i4"), ("density", "<f8"), ("film", "<f8"), ("x", "<f8", 3),
     ("v", "<f8", 3)]
)  # fmt: skip
"""Record of a sphere that the engine does not hold yet: steps of its creation and insertion; it is at x + v t."""
ROWS = 1 << 18
"""Number of rows of a part of a table in memory."""
AXES, SPEEDS = ["x", "y", "z"], ["vx", "vy", "vz"]


def at_start(scene: EngineScene, spheres: pd.DataFrame) -> pd.DataFrame:
    """Return the spheres with which the engine starts."""
    order = spheres.sort_values("id", ignore_index=True)
    return order[created(scene, np.array(scene.enters(order["type"]))) == 0]


def to_come(scene: EngineScene, start: pd.DataFrame, films: pd.DataFrame, done: int) -> np.ndarray:
    """Return the records of the spheres that the engine does not hold after `done` steps; `start` positions, `films` films."""
    start = start.sort_values("id", ignore_index=True)
    enters = np.array(scene.enters(start["type"]))
    steps = created(scene, enters)
    later = np.flatnonzero(steps > done)
    rows, found = start.iloc[later], np.zeros(len(later), COMING)
    found["created"], found["enters"] = steps[later], enters[later]
    found["id"], found["type"] = rows["id"], rows["type"]
    found["density"] = np.array([c.density_kg_per_m3 for c in scene.classes])[rows["type"].to_numpy() - 1]
    found["x"], found["v"] = rows[AXES], rows[SPEEDS]
    if "film" in films and scene.effects.bridges:
        found["film"] = films.set_index("id")["film"].reindex(rows["id"]).to_numpy()
    return found


class ToCome:
    """Rows of the spheres that the engine does not hold, for the tables of a run; `gone`: records of those that left."""

    def __init__(self, scene: EngineScene, run_dir: Path, gone: np.ndarray | None) -> None:
        self.dt, self.some = scene.time_step_s, gone is not None
        self.rows, self.first = np.zeros(0, COMING), 0
        self.left = np.sort(gone["step"]) if gone is not None else np.zeros(0, np.int64)
        if self.some:
            start, films = (read_table(run_dir / name) for name in (scene.spheres_file, "history/spheres.parquet"))
            self.rows = np.sort(to_come(scene, start, films, 0), order=["created", "id"])
            self.first = len(start) - len(self.rows)
        self.last = int(self.rows["created"].max(initial=0))
        """Last step at which a sphere is still to be created."""

    def nobody(self, steps: np.ndarray, leaving: bool = False) -> np.ndarray:
        """Return the steps at which the engine holds no sphere; with `leaving` those are gone that leave in the step."""
        steps = np.asarray(steps, dtype=np.int64)
        come = self.first + np.searchsorted(self.rows["created"], steps, "left")
        return steps[self.some & (come == np.searchsorted(self.left, steps, "right" if leaving else "left"))]

    def at(self, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return step and record of every sphere that is still to be created at each of these steps."""
        first = np.searchsorted(self.rows["created"], steps, "left")
        which = [np.arange(k, len(self.rows)) for k in first]
        return np.repeat(steps, len(self.rows) - first), self.rows[np.concatenate([*which, np.zeros(0, np.int64)])]

    def motion(self, part: pd.DataFrame, empty: np.ndarray) -> pd.DataFrame:
        """Add rows to complete steps of a table of motion, and those of steps at which the engine holds no sphere."""
        step, of = self.at(np.union1d(part["step"].unique(), empty))
        if not len(step):
            return part
        time = step * self.dt
        values = {"step": step, "time": time, "id": of["id"].astype(np.int64), "type": of["type"].astype(np.int64)}
        values |= dict(zip(SPEEDS, of["v"].T, strict=True))
        values |= dict(zip(AXES, (of["x"] + time[:, None] * of["v"]).T, strict=True))
        more = pd.DataFrame({name: values.get(name, np.zeros(len(step))) for name in part.columns})
        both = pd.concat([part, more], ignore_index=True).drop_duplicates(["step", "id"])
        return both.sort_values(["step", "id"], kind="stable", ignore_index=True)

    def records(self, part: np.ndarray, empty: np.ndarray) -> np.ndarray:
        """Add records to complete outputs of films or impulses, as `motion` does."""
        step, of = self.at(np.union1d(part["step"], empty))
        more = np.zeros(len(step), part.dtype)
        more["step"], more["id"] = step, of["id"]
        if "film" in (part.dtype.names or ()):
            more["film"] = of["film"]
        return np.concatenate([part, more])

    def in_motion(self, parts: Iterator[pd.DataFrame], empty: np.ndarray) -> Iterator[pd.DataFrame]:
        """Yield parts of a table of motion with all spheres; `empty`: steps at which the engine holds no sphere."""
        return (self.motion(part, some) for part, some in self._pieces(parts, empty))

    def in_records(self, parts: Iterator[np.ndarray], empty: np.ndarray) -> Iterator[np.ndarray]:
        """Yield parts of a table of films or impulses with all spheres."""
        return (self.records(part, some) for part, some in self._pieces((in_order(p, ["step"]) for p in parts), empty))

    def _pieces(self, parts: Iterator[Table], empty: np.ndarray) -> Iterator[tuple[Table, np.ndarray]]:
        """Divide parts so that each, with the rows to be added, has about `ROWS` rows; with the empty steps that follow it."""
        for part, some in _with_empty(parts, empty[empty <= self.last]):
            steps = np.union1d(part["step"], some)
            more = len(self.rows) - np.searchsorted(self.rows["created"], steps, "left")
            piece = np.cumsum(more) // ROWS
            for number in np.unique(piece):
                first, last = steps[piece == number][[0, -1]]
                low, high = np.searchsorted(part["step"], [first, last + 1])
                yield part[low:high], some[(some >= first) & (some <= last)]
            if not len(steps):
                yield part, some


def _with_empty(parts: Iterator[Table], empty: np.ndarray) -> Iterator[tuple[Table, np.ndarray]]:
    """Yield each part with the empty steps up to its end, and after the last one the others with a part without rows."""
    kind: Table | None = None
    for part in parts:
        last = part["step"].max() if len(part) else -1
        yield part, empty[empty <= last]
        empty, kind = empty[empty > last], part[:0]
    if kind is not None and len(empty):
        yield kind, empty
