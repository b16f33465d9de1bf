"""Check tables that later stages read, row by row: positions of walls, times, counts and liquid of the ledger.

whole.py checks that they are complete; here they are compared with the logs and with scene.json.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from reference_impl.motion import window
from reference_impl.motion.wall_motion import Motion
from reference_impl.replay import io, liquid, plans, script
from reference_impl.replay import retired as retirement
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import bodies
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run, where
from reference_impl.replay.lives import FORMATION, Lives, keys, none

SHIFT = ["dx", "dy", "dz"]
COUNTED = ("formations", "ruptures", "bridge_count", "spheres")
HELD = ("films", "bridges", "walls", "left", "retired", "initial")


def wall_shifts(setup: window.Setup) -> tuple[pd.DataFrame, Floats]:
    """Return mesh_motion.parquet, and the correct displacement of each mesh [m]; a rotating mesh has none."""
    table = io.columns(setup.folder / "mesh_motion.parquet", ["step", "mesh", *SHIFT])
    motion, expected = Motion(setup), np.zeros((len(table), 3))
    step, name = table["step"].to_numpy(np.int64), table["mesh"].to_numpy()
    for wall in setup.walls:
        rows = name == wall.name
        expected[rows] = motion.shift(wall, step[rows])
    return table, expected


def reach(setup: window.Setup) -> float:
    """Return the largest displacement of the walls [m], the scale of their positions."""
    ways = [1e-6]
    for wall in setup.walls:
        if "amplitude_m" in wall.way:
            ways.append(float(np.linalg.norm(wall.way["amplitude_m"])))
        if "travel_s" in wall.way:
            ways.append(float(np.linalg.norm(wall.way["velocity_m_per_s"])) * float(wall.way["travel_s"]))
    return max(ways) if len(ways) > 1 else 1e-3


def mesh_motion(setup: window.Setup) -> list[Quantity]:
    """Compare the positions of walls at the outputs with the motion of scene.json, computed step by step like the engine's."""
    if not setup.walls:
        return []
    table, expected = wall_shifts(setup)
    logged, size = table[SHIFT].to_numpy(float), np.full(len(table), reach(setup))
    return [compare("mesh_motion", "how far walls move", logged, expected, size, table)]


def times(setup: window.Setup, moist: bool) -> list[Quantity]:
    """Check column `time` of every table: its step times the time step."""
    rows = all_times(setup, moist)
    expected, logged = rows["step"].to_numpy(float) * setup.step, rows["time"].to_numpy(float)
    return [compare("time", "itself, or one time step", logged, expected, np.maximum(expected, setup.step), rows)]


def all_times(setup: window.Setup, moist: bool) -> pd.DataFrame:
    """Return `step`, `time`, and the `table`, once for each step of a table."""
    parts = [pd.DataFrame({"step": np.zeros(0, np.int64), "time": np.zeros(0), "table": np.zeros(0, str)})]
    for name in ["trajectory", *(("events", "contacts", "ledger", "energy") if moist else ())]:
        path = where(setup.folder, name)
        if path.exists() and "time" in io.names(path):
            parts.append(io.columns(path, ["step", "time"]).drop_duplicates().assign(table=name))
    return pd.concat(parts, ignore_index=True)


class Count:
    """Accumulate, chunk by chunk, the value that events and snapshots give for every column of the ledger."""

    def __init__(self, run: Run) -> None:
        self.formed = self.ruptured = 0
        self.first, self.spheres = float(bodies(run).liquid().sum()), len(run.table("spheres"))
        self.gone, self.script = retirement.table(run.folder), script.of(run.folder) is not None
        self.fallen = run.shed[run.shed["partner_kind"] == 3]

    def values(self, run: Run) -> tuple[pd.DataFrame, tuple[Floats, Floats], tuple[Floats, Floats], Floats]:
        """Return the outputs of a part of the log: rows of the ledger; counts and liquid, logged and recomputed; their scale."""
        events, ledger = run.table("events"), run.table("ledger").sort_values("step")
        shots = run.table("films")["step"]
        ledger = ledger[ledger["step"].isin(shots.unique())].reset_index(drop=True)
        step, at, kind = ledger["step"].to_numpy(), events["step"].to_numpy(), events["kind"].to_numpy()
        formed, ruptured = (np.searchsorted(at[of], step, "right") for of in (kind == FORMATION, kind != FORMATION))
        formed, ruptured = formed + self.formed, ruptured + self.ruptured
        expected = np.stack([formed, ruptured, formed - ruptured, self._there(run, step)], axis=1).astype(float)
        self.formed += int((kind == FORMATION).sum())
        self.ruptured += int((kind != FORMATION).sum())
        drops = np.array([self.fallen["volume"][self.fallen["step"] <= s].sum() for s in step])
        coming = liquid.to_come(run, step)
        first = np.full(len(step), self.first)
        films, *rest = (_sums(run, step, *c) for c in CARRIED)
        retired = np.array([self.gone["film"][self.gone["step"] <= s].sum() for s in step])
        on_spheres = films if self.script else films - coming - retired
        held = np.stack([on_spheres, *rest, drops, retired, first - coming], axis=1)
        logged, one = ledger[list(COUNTED)].to_numpy(float), np.ones(len(step))
        amounts, size = ledger[list(HELD)].to_numpy(float), first if self.first > 0 else one
        return ledger, (logged, expected), (amounts, held), size

    def _there(self, run: Run, step: Floats) -> Floats:
        return script.present(run.folder, step) if self.script else np.full(len(step), self.spheres)

    def check(self, run: Run) -> list[Quantity]:
        """Compare the stored tables of films and ledger with the recomputed values."""
        ledger, (logged, expected), (liquid, held), size = self.values(run)
        one = np.ones(len(ledger))
        return [
            compare("ledger_counts", "each counts 1", logged, expected, one, ledger, 0.0),
            compare("ledger_held", "initial liquid", liquid, held, size, ledger, 1e-12),
        ]


CARRIED = (("films", "film"), ("bridges", "volume"), ("wall_films", "film"))


def _sums(run: Run, steps: Floats, table: str, column: str) -> Floats:
    """Return a column of a snapshot summed at each output."""
    rows = run.table(table)
    return added_up(rows[column].to_numpy(float), np.searchsorted(steps, rows["step"].to_numpy()), len(steps))


def added_up(values: Floats, group: NDArray[np.intp], groups: int) -> Floats:
    """Return sums of groups 0, 1, ..., pairwise, because a plain sum of a hundred thousand equal bridges loses 1e-12."""
    order = np.argsort(group, kind="stable")
    ends = np.searchsorted(group[order], np.arange(groups + 1))
    ordered = values[order]
    return np.array([ordered[first:end].sum() for first, end in pairwise(ends)])


def velocities(setup: window.Setup) -> list[Quantity]:
    """Compare speeds and spins of trajectory.parquet with the recorded motion, at outputs within windows."""
    both, logged, mine = both_velocities(setup)
    if not len(both):
        return []
    size = np.maximum(np.abs(mine).max(axis=1), 1e-3)
    return [compare("trajectory_velocity", "itself, or 1 mm/s", logged, mine, size, both)]


def both_velocities(setup: window.Setup) -> tuple[pd.DataFrame, Floats, Floats]:
    """Return rows of spheres and steps in both tables, and vx … wz of the trajectory and of the windows."""
    states, path = where(setup.folder, "window_states"), where(setup.folder, "trajectory")
    names = [f"{q}{axis}" for q in "vw" for axis in "xyz"]
    if not states.exists() or not set(names) <= set(io.names(path)):
        return pd.DataFrame(), np.zeros((0, 6)), np.zeros((0, 6))
    expected = io.columns(states, ["step", "id", *names])
    table = io.columns(path, ["step", "id", *names])
    both = table[table["step"].isin(expected["step"].unique())].merge(
        expected, on=["step", "id"], suffixes=("", "_window")
    )
    logged, mine = (both[[f"{n}{end}" for n in names]].to_numpy(float) for end in ("", "_window"))
    return both, logged, mine


def bridges_in_windows(run: Run) -> pd.DataFrame:
    """Return the bridges that act at the recorded steps by the event log: step, ends, position of sphere i.

    A flag marks those without a row in the contact log.
    """
    planned, events = plans.plan(run.folder), run.table("events")
    lives, fixed = Lives(none(), events, 0, -1), events.drop_duplicates(["partner_kind", "i", "j"])
    log, states, found = run.table("contacts"), run.table("window_states"), []
    for step in planned.contact_steps:
        rows = fixed[["partner_kind", "i", "j"]].assign(step=step)
        rows = rows[lives.at(keys(rows), np.full(len(rows), step), strictly=planned.every == 1) >= 0]
        # a bridge that ruptures in a step does not act in it
        rows = rows[lives.at(keys(rows), np.full(len(rows), step), strictly=False) >= 0]
        rows = rows.assign(missing=~np.isin(keys(rows), keys(log[log["step"].to_numpy() == step])))
        found.append(rows.merge(states[states["step"] == step][["id", *"xyz"]], left_on="i", right_on="id"))
    return pd.concat(found, ignore_index=True) if found else pd.DataFrame()
