"""Load a finished run as tables with units: `pywet.load(folder)`, for screening cases and user-defined scenes."""

from __future__ import annotations

import math
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.errors import PywetError
from pywet.runs.measures import bed_angle, heap_angle, passed_mass, steady_rate, upward
from pywet.runs.rundir import RunDir
from pywet.runs.shapes import Plan, RunSummary
from pywet.scene import EngineScene, Rotation
from pywet.schema import CODES, meanings

CENTRE = "centre"
"""First word of the meaning of every column that is a position (pywet/schema.py)."""


def _stored(name: str, what: str) -> cached_property[pd.DataFrame]:
    """Make a property for a table of a run, by its path without suffix, that is read on access; `what` documents it."""

    def table(run: Run) -> pd.DataFrame:
        return run._table(name)

    table.__doc__ = what
    return cached_property(table)


class Run:
    """A run directory; tables are read on access, and their `attrs` contain `units`, `meanings` and `codes` of the columns."""

    def __init__(self, folder: Path) -> None:
        self.path = Path(folder)
        self._run = RunDir(self.path)
        self.scene: EngineScene = self._run.scene

    def has(self, name: str) -> bool:
        """Return whether the run has a file.

        Parameters
        ----------
        name : str
            Path in the run directory, such as `results/fraction_retained.parquet`.

        Returns
        -------
        bool
            True if the file exists.
        """
        return (self.path / name).exists()

    @property
    def origin_mm(self) -> tuple[float, float, float]:
        """Return the scene's `origin_mm`, to which positions in Parquet files are relative; those in tables here are not."""
        return self._run.origin_mm

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Return the summary of a run: settings, speed, liquid at the end, checks."""
        return dict(self._run.json("summary.json", RunSummary, required=True))

    @cached_property
    def replay(self) -> dict[str, Any]:
        """Return the result of the replay: `ok`, limits and deviations by quantity, what was not checked; empty for a dry run."""
        return dict(self._run.replay or {})

    @cached_property
    def plan(self) -> list[dict[str, Any]]:
        """Return every effect: whether it is on, by which law, and why."""
        return list(self._run.json("plan.json", Plan, required=True)["rows"])

    trajectory = _stored("trajectory", "Place, velocity and spin of every sphere at every output.")
    events = _stored(
        "history/events", "Every bridge that formed or broke (`kind` 0 and 1), in the order in which it was booked."
    )
    bridges = _stored("history/bridges", "Bridges that stood at the outputs.")
    contacts = _stored("history/contacts", "Forces of every bridge in every step of the windows.")
    films = _stored("history/films", "Film on every sphere at the outputs.")
    wall_films = _stored("history/wall_films", "Film on every wet triangle of the walls at the outputs.")
    ledger = _stored("history/ledger", "Where all liquid is at the outputs: films, bridges, walls, left.")
    energy = _stored("history/energy", "Energies at the outputs, and the works since the start.")
    contact_statistics = _stored(
        "results/contact_statistics",
        "Of a custom scene, at the outputs: contacts and bridges per sphere, overlaps, speeds.",
    )

    @cached_property
    def liquid(self) -> pd.DataFrame:
        """Return the liquid on each class of spheres and each wall (screening: each reservoir) at the outputs."""
        named = ("results/liquid_by_wall", "results/liquid_by_holder")
        there = [name for name in named if (self.path / f"{name}.parquet").exists()]
        return self._table(there[0] if there else named[0])

    @cached_property
    def fraction_retained(self) -> pd.DataFrame:
        """Read the fraction retained of a case, in all and by size class: mass outside the collecting bin over the mass fed."""
        if not self.has("results/fraction_retained.parquet"):
            raise PywetError(
                f"{self.path} has no fraction retained; expected the finished run of a case: a custom scene has no collecting "
                "bin",
                code="run.no_fraction", where=self.path,
            )  # fmt: skip
        return self._table("results/fraction_retained")

    def angle_of_repose(self) -> float:
        """Measure the angle of repose of a heap around the z axis at the end of the run.

        Returns
        -------
        float
            Angle of the heap [deg], of the spheres that have entered; nan without any.

        Raises
        ------
        PywetError
            If a wall turns; use `drum_angle` for a drum.

        Notes
        -----
        The heap must be at rest at the end of the run; the slope is fitted by `heap_angle`.
        """
        if self._turning():
            raise PywetError(
                f"{self.path} has a turning wall; expected a heap at rest around an upright axis: use drum_angle()",
                code="run.turns", where=self.path,
            )  # fmt: skip
        radius = {c.type: c.radius_m for c in self.scene.classes}
        table = self._run.trajectory
        last = self._entered(table[table["step"] == table["step"].max()])
        if last.empty:
            return math.nan
        of_each = np.array([radius[kind] for kind in last["type"]])
        return heap_angle(last[[*"xyz"]].to_numpy(dtype=float), of_each)

    def drum_angle(self, from_s: float | None = None) -> float:
        """Measure the dynamic angle of repose of the bed in a drum, the mean over the outputs from a time on.

        Parameters
        ----------
        from_s : float, optional
            Start of the mean [s]; default: half of the run.

        Returns
        -------
        float
            Angle of the bed [deg], see `bed_angle`, of the spheres that have entered; nan without any.

        Raises
        ------
        PywetError
            If no wall turns about a horizontal axis, or `from_s` is after the last output.
        """
        up, line = upward(self.scene.gravity_m_per_s2), self._run.timeline
        drums = [w for w in self._turning() if abs(np.dot(w.axis, up)) < 0.5 * float(np.linalg.norm(w.axis))]
        if not drums:
            raise PywetError(
                f"{self.path} has no wall that turns about a horizontal axis; expected a drum: use angle_of_repose()",
                code="run.no_drum", where=self.path,
            )  # fmt: skip
        drum = drums[0]
        start = 0.5 * self.scene.duration_s if from_s is None else from_s
        steps = line.steps[line.times >= start]
        if not len(steps):
            raise PywetError(
                f"from_s = {start:g} is after the last output, {line.times[-1]:g} s; expected an earlier time",
                code="run.late", key="from_s", given=start, expected=float(line.times[-1]),
            )  # fmt: skip
        mass = {c.type: c.mass_kg for c in self.scene.classes}
        chosen = self._entered(self._run.trajectory[self._run.trajectory["step"].isin(steps)])
        angles = [
            bed_angle(at[[*"xyz"]].to_numpy(dtype=float), np.asarray(at["type"].map(mass), dtype=float), drum, up)
            for _, at in chosen.groupby("step")
        ]
        return float(np.mean(angles)) if angles else math.nan

    def discharge(self, height_m: float | None = None) -> pd.DataFrame:
        """Measure the dry mass that has passed a horizontal plane until each output.

        Parameters
        ----------
        height_m : float, optional
            Height of the plane [m]; default: for a case that of the collecting bin.

        Returns
        -------
        DataFrame
            One row per output with `time_s` [s] and `passed_kg` [kg].

        Raises
        ------
        PywetError
            If `height_m` is missing and the run has no collecting bin.
        """
        if height_m is None and not self.has("results/fraction_retained.parquet"):
            raise PywetError(
                f"{self.path} has no collecting bin; expected height_m, the height of a plane below the outlet [m]",
                code="run.no_bin", key="height_m", where=self.path,
            )  # fmt: skip
        height = self.scene.bin_z_m if height_m is None else height_m
        line, up = self._run.timeline, upward(self.scene.gravity_m_per_s2)
        along = self.trajectory[["step", "id"]].assign(at=self.trajectory[[*"xyz"]].to_numpy(dtype=float) @ up)
        at = (
            along.pivot_table(index="step", columns="id", values="at")
            .reindex(index=line.steps, columns=line.ids)
            .to_numpy()
        )
        table = pd.DataFrame({"time_s": line.times, "passed_kg": passed_mass((at < height) & line.entered, line.mass)})
        table.attrs["units"] = {"time_s": "s", "passed_kg": "kg"}
        return table

    def discharge_rate(self, height_m: float | None = None) -> float:
        """Measure the steady mass flow through a horizontal plane.

        Parameters
        ----------
        height_m : float, optional
            Height of the plane [m]; default: for a case that of the collecting bin.

        Returns
        -------
        float
            Mass flow [kg/s]: the slope between 10 and 90 % of the mass that passes in all.
        """
        table = self.discharge(height_m)
        return steady_rate(table["time_s"].to_numpy(), table["passed_kg"].to_numpy())

    def _entered(self, trajectory: pd.DataFrame) -> pd.DataFrame:
        """Return the rows of a trajectory without spheres that have not been inserted yet and are outside."""
        enters = pd.Series(self._run.enters, index=self._run.spheres["id"].to_numpy())
        return trajectory[trajectory["step"] >= trajectory["id"].map(enters)]

    def _turning(self) -> list[Rotation]:
        return [motion for motion in self.scene.motions.values() if isinstance(motion, Rotation)]

    def _table(self, name: str) -> pd.DataFrame:
        if name.startswith("history/") and not self._run.moist:
            raise PywetError(
                f"{self.path} is a dry run and has no {name}; expected a run with liquid",
                code="run.dry", key=name, where=self.path,
            )  # fmt: skip
        table = self._run.table(name)
        known = meanings(name)
        positions = [c for c, (_, meaning) in known.items() if meaning.startswith(CENTRE) and c in table]
        for axis, shift in zip("xyz", self._run.origin_m.tolist(), strict=True):
            along = [c for c in positions if c.endswith(axis)]
            if shift and along:
                table[along] += shift
        table.attrs["units"] = {c: known[c][0] if c in known else unit(str(c)) for c in table.columns}
        table.attrs["meanings"] = {c: known[c][1] for c in table.columns if c in known}
        table.attrs["codes"] = {c: CODES[c] for c in table.columns if c in CODES}
        return table


UNITS = {"_m_per_s": "m/s", "_m3": "m3", "_kg": "kg", "_s": "s", "_m": "m"}
"""Suffix of a name -> its unit."""


def unit(column: str) -> str:
    """Return the unit at the end of a column's name, or - if it has none.

    >>> unit("wall_hopper_m3"), unit("time_s"), unit("step")
    ('m3', 's', '-')
    """
    return next((unit for end, unit in UNITS.items() if column.endswith(end)), "-")
