"""Compare the engine's interpolated transfer ratios with independent solutions at the volumes of the run's ruptures.

transfer.py checks the table's nodes; between them there is the error of linear interpolation, which has a stated bound and is
not a fault.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl.replay import coverage
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import bodies, pairs, shapes
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run
from reference_impl.replay.transfer import WALL_STRETCH, exact_ratios, recomputed_ratio

LARGEST = 0.5
PER_ROW = {"young_laplace": 3, **dict.fromkeys(WALL_STRETCH, 12)}
"""Number of volumes solved for each pair of bodies."""
BOUND = {"parabola": 0.0011, "parabola_walls_at_fifth": 0.006, "parabola_walls_at_tenth": 0.006}
"""Stated error of linear interpolation between the nodes of the parabolas' tables (docs/laws.md).

None is stated for the exact split, whose slope is infinite where the side of rupture changes: there the error is
reported but not judged.
"""


def check(run: Run) -> list[Quantity]:
    """Compare logged share_i over volume for some ruptures (of one pair of bodies in ascending order of volume)."""
    name = str(coverage.law(run, "transfer"))
    logged, expected, rows = [], [], []
    for _, table in _shapes(run, run.table("events")).groupby(["partner_kind", "ri", "rj", "ti", "tj"]):
        picked = table.sort_values("v_star")
        kind, *shape_of = (float(table[c].iloc[0]) for c in ("partner_kind", "ri", "rj", "ti", "tj"))
        found = _recomputed(name, int(kind), shape_of, picked["v_star"].to_numpy(float))
        keep = np.isfinite(found)
        logged.append(picked["ratio"].to_numpy(float)[keep])
        expected.append(found[keep])
        rows.append(picked[keep])
    if not rows:
        return []
    values, mine = np.concatenate(logged), np.concatenate(expected)
    return [
        compare(
            "transfer_interpolation", "one", values, mine, np.ones(len(mine)), pd.concat(rows), BOUND.get(name, 0.0)
        )
    ]


def judged(run: Run) -> bool:
    """Return whether the stated bound applies to this run's table."""
    return coverage.law(run, "transfer") in WALL_STRETCH


def note(found: Quantity) -> str:
    """Return the note on an error that is not judged."""
    at = found.worst.get("v_star", 0.0)
    return (
        f"transfer: between its nodes the exact table is off by up to {found.largest:.2g} (median {found.median:.1g}) in "
        f"{found.count} of {found.sample_of} ruptures that were solved, most at V* = {at:.4g}; no bound is stated for it"
    )


def _recomputed(name: str, kind: int, bodies_of: list[float], v_star: Floats) -> Floats:
    ri, rj, ti, tj = bodies_of
    if name == "young_laplace":
        return exact_ratios(kind, ri, rj, ti, tj, v_star, np.arange(len(v_star)))
    return recomputed_ratio(kind, ri, rj, ti, tj, v_star, name)


def _shapes(run: Run, broke: pd.DataFrame) -> pd.DataFrame:
    """Return for each rupture the two bodies, V* and the ratio used."""
    fixed, volume = bodies(run), broke["volume"].to_numpy(float)
    p = pairs(broke, fixed)
    columns = {"step": broke["step"], "i": broke["i"], "j": broke["j"], "partner_kind": p.kind, "ri": p.ri,
               "rj": np.where(p.wall, p.width, p.rj), "ti": p.ti, "tj": p.tj, "v_star": shapes(p, volume, fixed)[3],
               "ratio": broke["share_i"].to_numpy(float) / volume}  # fmt: skip
    return pd.DataFrame({name: np.asarray(values) for name, values in columns.items()})
