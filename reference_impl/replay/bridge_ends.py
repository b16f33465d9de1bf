"""Ends of a bridge: gap, closest point of a wall and its triangle, at every output and at events with known positions.

Positions are known at output steps and in the windows that record motion. The triangle that exchanges liquid
determines which wall film changes; next to an edge any triangle as near as the closest is accepted.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl.motion import nearest
from reference_impl.replay import images, io, laws
from reference_impl.replay.arrays import Floats, vectors
from reference_impl.replay.bodies import bodies, pairs
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run, where

STRANGE = 1e300
"""Deviation assigned to a triangle that is not part of the wall part."""


def places(run: Run) -> pd.DataFrame:
    """Return positions of spheres in this part of the logs: `step`, `id`, x, y, z [m]; the last row of a pair is used."""
    names = [name for name in ("window_states", "trajectory") if where(run.folder, name).exists()]
    tables = [run.table(name)[["step", "id", "x", "y", "z"]] for name in names]
    none = pd.DataFrame({"step": np.zeros(0, np.int64), "id": np.zeros(0, np.int64), **{a: np.zeros(0) for a in "xyz"}})
    return pd.concat([none, *tables], ignore_index=True)


class Ends:
    """Rows of a log with known positions of spheres: centres of i, ends at j, gap.

    `off`: how much nearer than the logged triangle another one of the same part is [m].
    """

    def __init__(self, run: Run, table: pd.DataFrame, places: pd.DataFrame) -> None:
        p = pairs(table, bodies(run))
        x, step = places[["x", "y", "z"]].to_numpy(float), table["step"].to_numpy(np.int64)
        steps, shot = np.unique(places["step"].to_numpy(np.int64), return_inverse=True)
        row_of = np.full((len(steps) + 1, len(bodies(run).radius)), -1)  # the last row is for steps without positions
        row_of[shot, places["id"].to_numpy(np.int64)] = np.arange(len(x))
        here = np.searchsorted(steps, step)
        here[np.append(steps, -1)[here] != step] = len(steps)
        i, j = row_of[here, p.i], row_of[here, p.sphere_j]
        rows = np.flatnonzero((i >= 0) & ((j >= 0) | p.wall))
        if len(bodies(run).area) < 2:
            rows = rows[~p.wall[rows]]
        self.table, self.radius, self.wall = table.iloc[rows].reset_index(drop=True), p.ri[rows], p.wall[rows]
        self.xi = x[i[rows]]
        self.xj = np.where(self.wall[:, None], np.nan, x[j[rows]])
        self.off = np.zeros(len(rows))
        if self.wall.any():
            self._at_walls(run, step[rows], p.part[rows])
        self.rj = p.rj[rows]
        apart = images.of(run.folder).nearest(self.xi - self.xj)
        self.xj = np.where(self.wall[:, None], self.xj, self.xi - apart)
        distance = np.sqrt((apart**2).sum(axis=1))
        self.normal = apart / distance[:, None]
        self.gap = distance - self.radius - np.where(self.wall, 0.0, self.rj)

    def _at_walls(self, run: Run, step: Floats, part: Floats) -> None:
        parts, w = nearest.parts(run), np.flatnonzero(self.wall)
        triangle = self.table["triangle"].to_numpy(np.int64)[w]
        expected = parts.closest(step[w], self.xi[w], part[w])
        distance, point = parts.to(step[w], self.xi[w], triangle)
        right = parts.setup.part[triangle] == part[w]
        # of several triangles at equal distance the logged one has the correct point
        same = right & (distance <= expected.distance * (1.0 + nearest.SAME))
        self.xj[w] = np.where(same[:, None], point, expected.point)
        self.off[w] = np.where(right, distance - expected.distance, STRANGE)

    def triangle(self, name: str) -> Quantity:
        """Check that the logged triangle belongs to the part, and that none of the part is nearer."""
        w = np.flatnonzero(self.wall)
        return compare(name, "radius", self.off[w], 0.0 * self.off[w], self.radius[w], self.table.iloc[w])

    def separation(self, name: str) -> Quantity:
        """Check the logged separation of a bridge."""
        return compare(name, "radius", self.table["separation"].to_numpy(float), self.gap, self.radius, self.table)


def of_events(run: Run) -> Ends:
    """Return the events of this part of the log with known positions."""
    return Ends(run, run.table("events"), places(run))


def of_snapshots(run: Run) -> Ends:
    """Return the bridges at the outputs of this part."""
    names = ["step", "id", "x", "y", "z"]
    path = io.where(run.folder, "trajectory")
    return Ends(run, run.table("bridges"), run.table("trajectory")[names] if path.exists() else places(run))


def check(run: Run) -> list[Quantity]:
    """Check the ends of the bridges in one chunk of the log."""
    known = len(run.tables.get("trajectory", [])) or where(run.folder, "trajectory").exists()
    if not known:
        return []
    events, shots = of_events(run), of_snapshots(run)
    logged = vectors(shots.table, "xj")
    return [
        _parts(run),
        events.triangle("event_triangle"),
        events.separation("event_separation"),
        shots.triangle("snapshot_triangle"),
        shots.separation("snapshot_separation"),
        compare("snapshot_ends", "radius", logged, shots.xj, shots.radius, shots.table),
    ]


def _parts(run: Run) -> Quantity:
    """Check that the triangle of every event at a wall belongs to its wall part."""
    events = run.table("events")
    rows = events[events["partner_kind"] != laws.SPHERE].reset_index(drop=True)
    logged = rows["j"].to_numpy(np.int64)
    part = nearest.parts(run).setup.part[rows["triangle"].to_numpy(np.int64)] if len(rows) else logged
    wrong, one = (part != logged).astype(float), np.ones(len(rows))
    return compare("event_part", "triangles of another part", wrong, 0.0 * one, one, rows, 0.0)
