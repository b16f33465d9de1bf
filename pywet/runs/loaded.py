"""A finished run as tables with units: `pywet.load(folder)`, of the screening cases and of scenes of one's own."""

from __future__ import annotations

import math
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.errors import PywetError
from pywet.files import AGAIN, read_json
from pywet.runs.rundir import Floats, RunDir
from pywet.runs.shapes import Replay, RunSummary
from pywet.scene import Scene
from pywet.schema import CODES, meanings

ZERO = (0.0, 0.0, 0.0)


def _kept(name: str, what: str) -> cached_property[pd.DataFrame]:
    """A table of a run by its path without suffix, read when it is asked for and kept; `what` is its documentation."""

    def table(run: Run) -> pd.DataFrame:
        return run._table(name)

    table.__doc__ = what
    return cached_property(table)


class Run:
    """A run directory; tables are read when they are asked for, their `attrs` hold `units`, `meanings`, `codes` of columns."""

    def __init__(self, folder: Path) -> None:
        self.path = Path(folder)
        self._run = RunDir(self.path)
        self.scene: Scene = self._run.scene

    @cached_property
    def origin_mm(self) -> tuple[float, ...]:
        """The scene's `origin_mm`, from which positions in all results count: its coordinates are theirs plus this."""
        description = self.path / "description.json"
        return tuple(read_json(description, AGAIN).get("origin_mm", ZERO)) if description.exists() else ZERO

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What was run, how fast, the liquid at the end, the checks."""
        return dict(read_json(self.path / "summary.json", AGAIN, RunSummary))

    @cached_property
    def replay(self) -> dict[str, Any]:
        """What the replay said: `ok`, its limits and deviations by quantity, what was not checked; empty for a dry run."""
        return dict(self._run.json("replay.json", Replay) or {})

    @cached_property
    def plan(self) -> list[dict[str, Any]]:
        """Every effect: whether it is on, by which law, and why."""
        return list(read_json(self.path / "plan.json", AGAIN)["rows"])

    trajectory = _kept("trajectory", "Place, velocity and spin of every sphere at every output.")
    events = _kept(
        "history/events", "Every bridge that formed or broke (`kind` 0 and 1), in the order in which it was booked."
    )
    bridges = _kept("history/bridges", "Bridges that stood at the outputs.")
    contacts = _kept("history/contacts", "Forces of every bridge in every step of the windows.")
    films = _kept("history/films", "Film on every sphere at the outputs.")
    wall_films = _kept("history/wall_films", "Film on every wet triangle of the walls at the outputs.")
    ledger = _kept("history/ledger", "Where all liquid is at the outputs: films, bridges, walls, left.")
    energy = _kept("history/energy", "Energies at the outputs, and the works since the start.")
    contact_statistics = _kept(
        "results/contact_statistics",
        "Of a scene of one's own, at the outputs: contacts and bridges per sphere, overlaps, speeds.",
    )

    @cached_property
    def liquid(self) -> pd.DataFrame:
        """Liquid on each class of spheres and each wall (screening: each holder) at the outputs."""
        named = ("results/liquid_by_wall", "results/liquid_by_holder")
        there = [name for name in named if (self.path / f"{name}.parquet").exists()]
        return self._table(there[0] if there else named[0])

    def angle_of_repose(self) -> float:
        """Slope [deg] of the heap around the z axis at the end, see `heap_angle`; of one that has come to rest."""
        radius = {c.type: c.radius_m for c in self.scene.classes}
        last = self.trajectory[self.trajectory["step"] == self.trajectory["step"].max()]
        return heap_angle(last[[*"xyz"]].to_numpy(dtype=float), last["type"].map(radius).to_numpy(dtype=float))

    def _table(self, name: str) -> pd.DataFrame:
        if name.startswith("history/") and not self._run.moist:
            raise PywetError(f"{self.path} is a dry run and has no {name}; expected one with bridges: give it liquid")
        table = self._run.table(name)
        told = meanings(name)
        table.attrs["units"] = {c: told[c][0] if c in told else unit(str(c)) for c in table.columns}
        table.attrs["meanings"] = {c: told[c][1] for c in table.columns if c in told}
        table.attrs["codes"] = {c: CODES[c] for c in table.columns if c in CODES}
        return table


def heap_angle(at: Floats, radius: Floats) -> float:
    """Slope [deg] of the surface of a heap of spheres around its own upright axis.

    The surface is the top of the highest sphere of each ring, two radii wide; a straight line is put through it from the second
    ring on, as far as the heap is higher than a layer. A heap of fewer than three such rings has no slope (NaN).
    """
    size = float(radius.max())
    away = np.hypot(*(at[:, :2] - np.median(at[:, :2], axis=0)).T)
    ring = (away // (2.0 * size)).astype(int)
    top = pd.Series(at[:, 2] + radius).groupby(ring).max()
    flank = top[(top - float((at[:, 2] - radius).min()) > 2.5 * size) & (top.index > 0)]
    if len(flank) < 3:
        return math.nan
    slope = np.polyfit(2.0 * size * (flank.index.to_numpy(dtype=float) + 0.5), flank.to_numpy(dtype=float), 1)[0]
    return math.degrees(math.atan(-float(slope)))


UNITS = {"_m_per_s": "m/s", "_m3": "m3", "_kg": "kg", "_s": "s", "_m": "m"}
"""End of a name -> its unit."""


def unit(column: str) -> str:
    """Unit of a column that ends in it; - where it has none.

    >>> unit("wall_hopper_m3"), unit("time_s"), unit("step")
    ('m3', 's', '-')
    """
    return next((unit for end, unit in UNITS.items() if column.endswith(end)), "-")
