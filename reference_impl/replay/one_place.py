"""Bridges of one sphere with several parts of one wall: if they meet in a convex edge, at one point, there is one bridge.

A formation is judged if its position is known: at outputs and in windows. Of the bridges active at an output, those
that formed in one step are judged.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd

from reference_impl.motion import nearest
from reference_impl.replay import laws
from reference_impl.replay.arrays import Floats, size
from reference_impl.replay.bodies import bodies
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run, where
from reference_impl.replay.lives import FORMATION, Lives, keys

ONE_PLACE = 1e-6
"""Share of the radius within which points coincide; points nearer than half of it or farther than twice are judged."""


def check(run: Run, lives: Lives) -> Quantity:
    """Check that no bridge forms where its sphere has one, or with a part at whose closest point another continues nearer."""
    table = judged(run, lives)
    wrong, zero = table["wrong"].to_numpy(float), np.zeros(len(table))
    return compare("formation_shared", "second bridges at one place", wrong, zero, zero + 1.0, table, 0.0)


def judged(run: Run, lives: Lives) -> pd.DataFrame:
    """Return bridges at walls at formation and at outputs, with the position of their sphere, and whether they are `wrong`."""
    found = pd.concat([_formations(run, lives), _at_outputs(run, lives)], ignore_index=True)
    return found.sort_values("step", kind="stable", ignore_index=True)  # the same order as of a log read in chunks


def neighbours(parts: nearest.Parts) -> tuple[Floats, Floats]:
    """Return pairs of different parts of one wall that share a corner, sorted by the first."""
    corners, part = parts.setup.corners.reshape(-1, 3), np.repeat(parts.setup.part, 3)
    _, corner = np.unique(corners, axis=0, return_inverse=True)
    at = np.unique(np.stack([corner.ravel(), part], axis=1), axis=0)
    ends = np.append(np.flatnonzero(np.diff(at[:, 0], prepend=-1)), len(at))
    pairs = [(a, b) for k, m in pairwise(ends) if m - k > 1 for a in at[k:m, 1] for b in at[k:m, 1] if a != b]
    found = np.unique(np.array(pairs, np.int64).reshape(-1, 2), axis=0)
    found = found[parts.wall[found[:, 0]] == parts.wall[found[:, 1]]]
    return found[:, 0], found[:, 1]


def beside(run: Run, rows: pd.DataFrame) -> tuple[Floats, Floats]:
    """Return row numbers, each with every neighbour of its part in turn."""
    if "neighbours" not in run.known:
        run.known["neighbours"] = neighbours(nearest.parts(run))
    part, other = run.known["neighbours"]
    first, last = (np.searchsorted(part, rows["j"].to_numpy(np.int64), side) for side in ("left", "right"))
    row = np.repeat(np.arange(len(rows)), last - first)
    return row, other[np.arange(len(row)) - np.repeat(np.cumsum(last - first) - last, last - first)]


def _formations(run: Run, lives: Lives) -> pd.DataFrame:
    events = run.table("events")
    rows = events[(events["kind"] == FORMATION) & (events["partner_kind"] != laws.SPHERE)]
    rows = _placed(run, rows[["step", "partner_kind", "i", "j"]])
    at, other = beside(run, rows)
    wrong = np.zeros(len(rows), dtype=bool)
    if len(at):
        same, onward = _places(run, rows, at, other)
        bridged = lives.at(_ends(run, rows, at, other), rows["step"].to_numpy(np.int64)[at], strictly=False) >= 0
        np.logical_or.at(wrong, at, onward[0] | bridged & (same | onward[1]))
    return rows.assign(wrong=wrong)


def _at_outputs(run: Run, lives: Lives) -> pd.DataFrame:
    """Return bridges at walls active at outputs, and whether another that formed in the same step has its position."""
    bridges = run.table("bridges")
    rows = _placed(run, bridges.loc[bridges["partner_kind"] != laws.SPHERE, ["step", "partner_kind", "i", "j"]])
    at, other = beside(run, rows)
    wrong = np.zeros(len(rows), dtype=bool)
    step = rows["step"].to_numpy(np.int64)
    mine = lives.at(keys(rows), step, strictly=False)
    its = lives.at(_ends(run, rows, at, other), step[at], strictly=False) if len(at) else at
    both = (its >= 0) & (mine[at] >= 0)
    both[both] = lives.all.step[its[both]] == lives.all.step[mine[at[both]]]
    if both.any():
        near, far = _feet(run, rows, at[both], other[both])
        np.logical_or.at(wrong, at[both], near[0] & ~far)
    return rows.assign(wrong=wrong)


def _ends(run: Run, rows: pd.DataFrame, at: Floats, other: Floats) -> Floats:
    """Return the keys of the bridges that the spheres of rows can have with other parts."""
    i, fixed = rows["i"].to_numpy(np.int64)[at], bodies(run)
    kind = np.where(fixed.half_width[other] < fixed.radius[i], laws.SMALL_WALL, laws.LARGE_WALL)
    return keys(pd.DataFrame({"partner_kind": kind, "i": i, "j": other}))


def _feet(run: Run, rows: pd.DataFrame, at: Floats, other: Floats) -> tuple[Floats, Floats]:
    """Return whether the closest points of a row's part and of the other are on each other, and whether they are distinct."""
    parts, x = nearest.parts(run), rows[["x", "y", "z"]].to_numpy(float)[at]
    step, part = (rows[name].to_numpy(np.int64)[at] for name in ("step", "j"))
    radius = bodies(run).radius[rows["i"].to_numpy(np.int64)[at]]
    foot, its = parts.closest(step, x, part).point, parts.closest(step, x, other).point
    off = np.stack([parts.closest(step, foot, other).distance, parts.closest(step, its, part).distance])
    return off <= 0.5 * ONE_PLACE * radius, size(foot - its) > 2.0 * ONE_PLACE * radius


def _places(run: Run, rows: pd.DataFrame, at: Floats, other: Floats) -> tuple[Floats, Floats]:
    """Return whether the closest points of a row's part and of the other one certainly coincide.

    The second result is whether a point of either is on the other part, which certainly continues there towards
    the sphere: (2, pairs).
    """
    parts, x = nearest.parts(run), rows[["x", "y", "z"]].to_numpy(float)[at]
    step, part = (rows[name].to_numpy(np.int64)[at] for name in ("step", "j"))
    near = ONE_PLACE * bodies(run).radius[rows["i"].to_numpy(np.int64)[at]]
    foot, its = parts.closest(step, x, part).point, parts.closest(step, x, other).point
    onward = [parts.goes_on(step, x, p, q, 0.5 * near, 2.0 * near) for p, q in ((other, foot), (part, its))]
    return size(foot - its) <= 0.5 * near, np.stack(onward)


def _placed(run: Run, rows: pd.DataFrame) -> pd.DataFrame:
    """Select the rows of steps at which the positions of spheres are known, and add these positions."""
    names = ("trajectory", "window_states")
    tables = [run.table(name)[["step", "id", "x", "y", "z"]] for name in names if where(run.folder, name).exists()]
    if not tables or not len(rows):
        return rows.iloc[:0].assign(x=0.0, y=0.0, z=0.0)
    known = pd.concat(tables).drop_duplicates(["step", "id"]).rename(columns={"id": "i"})
    return rows.merge(known, on=["step", "i"])
