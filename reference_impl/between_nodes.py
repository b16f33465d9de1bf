"""The engine's interpolated transfer ratios against the own solution at the volumes of the run's ruptures.

The table's nodes are checked in transfer.py; what is left between them is the error of linear interpolation, information with a
stated bound and not a fault.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from reference_impl import coverage, laws
from reference_impl.compare import Floats, Quantity, compare
from reference_impl.io import Run
from reference_impl.liquid import bodies
from reference_impl.transfer import SMALLEST, exact_ratios, own_ratio

LARGEST = 0.5
PER_ROW = {"parabola": 12, "young_laplace": 3}
"""Volumes solved for each pair of bodies."""
BOUND = 0.0011
"""Stated error of linear interpolation between the nodes of the parabola's table (docs/laws.md). None is stated for the exact
split, whose slope is infinite where the bridge's way of breaking changes: there the error is reported and not judged."""
LARGEST = 0.5
PER_ROW = {"parabola": 12, "young_laplace": 3}
"""Volumes solved for each pair of bodies."""


def check(run: Run) -> list[Quantity]:
    """Logged share_i over volume of a sample of the ruptures, spread evenly over V* for each pair of bodies."""
    name = coverage.law(run, "transfer")
    events = run.table("events")
    broke = events[events["kind"] == 1]
    if name not in PER_ROW or not len(broke):
        return []
    shape = _shapes(run, broke)
    logged, own, rows = [], [], []
    inside = shape[(shape["v_star"] >= SMALLEST) & (shape["v_star"] <= LARGEST)]
    for _, table in inside.sort_values("v_star").groupby(["partner_kind", "ri", "rj", "ti", "tj"]):
        picked = table.iloc[np.unique(((np.arange(PER_ROW[name]) + 0.5) / PER_ROW[name] * len(table)).astype(int))]
        picked = picked.drop_duplicates("v_star")
        v_star = picked["v_star"].to_numpy(float)
        kind, *shape_of = (float(table[c].iloc[0]) for c in ("partner_kind", "ri", "rj", "ti", "tj"))
        found = _own(name, int(kind), shape_of, v_star)
        keep = np.isfinite(found)
        logged.append(picked["ratio"].to_numpy(float)[keep])
        own.append(found[keep])
        rows.append(picked[keep])
    if not rows:
        return []
    values, mine = np.concatenate(logged), np.concatenate(own)
    result = compare("transfer_interpolation", "one", values, mine, np.ones(len(mine)), pd.concat(rows), BOUND)
    return [replace(result, sample_of=len(broke))]


def judged(run: Run) -> bool:
    """Whether the stated bound is one for this run's table."""
    return coverage.law(run, "transfer") == "parabola"


def note(found: Quantity) -> str:
    """What is said of an error that is not judged."""
    at = found.worst.get("v_star", 0.0)
    return (
        f"transfer: between its nodes the exact table is off by up to {found.largest:.2g} (median {found.median:.1g}) in "
        f"{found.count} of {found.sample_of} ruptures that were solved, most at V* = {at:.4g}; no bound is stated for it"
    )


def _own(name: str, kind: int, bodies_of: list[float], v_star: Floats) -> Floats:
    ri, rj, ti, tj = bodies_of
    if name == "young_laplace":
        return exact_ratios(kind, ri, rj, ti, tj, v_star, np.arange(len(v_star)))
    return own_ratio(kind, ri, rj, ti, tj, v_star)


def _shapes(run: Run, broke: pd.DataFrame) -> pd.DataFrame:
    """For each rupture the two bodies, V* and the ratio that was used."""
    fixed = bodies(run)
    wall = (broke["partner_kind"] != laws.SPHERE).to_numpy()
    angle = {i: fixed.angle(i) for i in fixed.radius}
    ri = broke["i"].map(fixed.radius).to_numpy(float)
    width = broke["j"].map(fixed.half_width).to_numpy(float)
    rj = np.where(wall, width, broke["j"].map(fixed.radius).to_numpy(float))
    tj = np.where(wall, broke["j"].map(fixed.wall_angle).to_numpy(float), broke["j"].map(angle).to_numpy(float))
    other = np.where(wall, ri, rj)  # a wall's half width may be infinite
    r = np.where(wall, ri, 2.0 * ri * other / (ri + other))
    volume = broke["volume"].to_numpy(float)
    kind = np.where(wall, np.where(rj < ri, laws.SMALL_WALL, laws.LARGE_WALL), laws.SPHERE)
    return pd.DataFrame(
        {
            "step": broke["step"].to_numpy(), "i": broke["i"].to_numpy(), "j": broke["j"].to_numpy(), "partner_kind": kind,
            "ri": ri, "rj": rj, "ti": broke["i"].map(angle).to_numpy(float), "tj": tj, "v_star": volume / r**3,
            "ratio": broke["share_i"].to_numpy(float) / volume,
        }
    ).reset_index(drop=True)  # fmt: skip
