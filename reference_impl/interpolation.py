"""Error of the table of transfer ratios between its nodes, at the volumes of a run's own ruptures.

It is the table's, not the program's: reported as such, against the error that the table states.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from reference_impl import coverage, exact, laws, transfer
from reference_impl.compare import Floats, Quantity, compare
from reference_impl.io import Run
from reference_impl.liquid import RUPTURE, bodies

SAMPLE, EXACT_SAMPLE = 240, 24
"""Ruptures solved anew over all rows of the table (at least one a row), parabola and exact bridge."""
TOLERANCE = 2e-3
"""Linear interpolation is stated to be within 0.0011 of the solution for V* >= 1e-5."""


def of_bridges(rows: pd.DataFrame, volume: Floats, run: Run) -> tuple[Floats, Floats, Floats, Floats]:
    """Kind of partner, type of i, type or group of j, and V* of bridges, as the table's rows are named."""
    fixed = bodies(run)
    ri = rows["i"].map(fixed.radius).to_numpy(float)
    wall = (rows["partner_kind"] != laws.SPHERE).to_numpy()
    rj = np.where(wall, 1.0, rows["j"].map(fixed.radius).fillna(1.0)).astype(float)
    width = np.where(wall, rows["j"].map(fixed.half_width).fillna(np.inf), np.inf).astype(float)
    kind = np.where(wall, np.where(width < ri, laws.SMALL_WALL, laws.LARGE_WALL), laws.SPHERE)
    other = np.where(wall, rows["j"].map(fixed.group).fillna(-1), rows["j"].map(fixed.kind_of).fillna(-1)).astype(int)
    return kind, rows["i"].map(fixed.kind_of).to_numpy(int), other, volume / laws.harmonic_radius(ri, rj, wall) ** 3


def check(run: Run, tables: transfer.Tables) -> list[Quantity]:
    """The own solution against the interpolated table for a sample of the ruptures."""
    events = run.table("events")
    events = events[events["kind"] == RUPTURE]
    if not coverage.known(run, "transfer") or not len(events):
        return []
    kind, type_i, other, v_star = of_bridges(events, events["volume"].to_numpy(float), run)
    solved, pairs = coverage.solved(run, "transfer"), transfer.bodies_of_rows(run)
    number = max(1, (EXACT_SAMPLE if solved else SAMPLE) // len(pairs))
    rows: list[tuple[int, int, int, float]] = []
    own: list[float] = []
    for (k, a, b), (ri, rj, ti, tj) in exact.shown(pairs.items(), len(pairs), "transfer ratios at ruptures"):
        mine = np.unique(v_star[(kind == k) & (type_i == a) & (other == b) & (v_star > transfer.SMALLEST)])
        at = mine[np.linspace(0, len(mine) - 1, min(len(mine), number)).astype(int)] if len(mine) else mine
        which = np.arange(len(at))
        own += list(
            transfer.exact_ratios(k, ri, rj, ti, tj, at, which) if solved else transfer.own_ratio(k, ri, rj, ti, tj, at)
        )
        rows += [(k, a, b, float(v)) for v in at]
    table = pd.DataFrame(rows, columns=["partner_kind", "type_i", "other", "v_star"])
    there = np.isfinite(np.array(own))  # thin wires hold no large bridge
    table, found = table[there].reset_index(drop=True), np.array(own)[there]
    used = tables.ratios(*(table[c].to_numpy() for c in table.columns))
    result = compare("transfer_interpolation", "one", used, found, np.ones(len(found)), table, TOLERANCE)
    return [replace(result, sample_of=len(events))]
