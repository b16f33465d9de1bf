"""Transfer ratios: the engine's table, and independent solutions with which it is compared.

The exact split is that of bridge.py. The parabola model solves the five equations of the paper (36-43, corrected) in
the unknowns a, b, c, d_i, d_j, lengths in units of r_i, by Levenberg-Marquardt, followed from small to large volumes.
Integrals use five-point Gauss quadrature.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import leastsq

from reference_impl.compiled import compiled
from reference_impl.replay import coverage, exact, laws
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run

Floats = NDArray[Any]
SMALLEST = 1e-5
"""V* below which the table is constant by definition and not judged."""
TABLE_TOLERANCE = 1e-6
"""Tolerance of the table's nodes: both solutions are converged to 1e-9; 1e-6 is a margin for the weakest root."""
EXACT_TOLERANCE = 1e-7
"""Tolerance of the exact table's nodes: both solvers find the split to better than 1e-8."""
EXACT_NODES = 48
"""Number of nodes solved over all rows of the exact table, at least two of each row."""


WALL_STRETCH = {"parabola": 1.0, "parabola_walls_at_fifth": 0.2, "parabola_walls_at_tenth": 0.1}
"""Law -> separation over the rupture distance at which the parabola is solved at walls; between spheres it is 1."""


class Tables:
    """Rows T_i(V*) of history/transfer.parquet, linear between nodes, constant beyond."""

    def __init__(self, table: pd.DataFrame) -> None:
        other = np.where(table["partner_kind"] == laws.SPHERE, table["type_j"], table["part_class"])
        self._rows: dict[tuple[int, int, int], tuple[Floats, Floats]] = {}
        for _, rows in table.groupby([table["partner_kind"], table["type_i"], other]):
            first = rows.iloc[0]
            kind = int(first["partner_kind"])
            name = (kind, int(first["type_i"]), int(first["type_j"] if kind == laws.SPHERE else first["part_class"]))
            self._rows[name] = (rows["v_star"].to_numpy(float), rows["transfer_i"].to_numpy(float))

    def ratios(self, kind: Floats, type_i: Floats, other: Floats, v_star: Floats) -> Floats:
        """Interpolate transfer ratios linearly; NaN if the table has no row."""
        result = np.full(len(v_star), np.nan)
        for (k, a, b), (nodes, values) in self._rows.items():
            rows = (kind == k) & (type_i == a) & (other == b)
            result[rows] = np.interp(v_star[rows], nodes, values)
        return result

    def rows(self) -> dict[tuple[int, int, int], tuple[Floats, Floats]]:
        """Return all rows of the transfer table by pair of bodies."""
        return self._rows


class Shape(NamedTuple):
    """Two bodies in units of r_i: radius of j, contact angles, and whether j's cap is inside the parabola."""

    rj: float
    ti: float
    tj: float
    cap_j: bool


NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)


@compiled
def _turned(a: float, b: float, c: float, low: float, high: float) -> float:
    """Return pi times the integral of Y^2; five Gauss points are exact for a fourth-degree polynomial."""
    total = 0.0
    for node, weight in zip(NODES, WEIGHTS):  # noqa: B905 - numba knows no `strict`
        x = low + (high - low) * (node + 1.0) / 2.0
        total += weight * (a * x**2 + b * x + c) ** 2
    return np.pi * (high - low) / 2.0 * total


@compiled
def _cap(y: float, d: float) -> float:
    return np.pi / 6.0 * (3.0 * y**2 * d + d**3)


@compiled
def parts(u: Any, shape: Any, gap: float) -> tuple[float, float, float, float]:
    """Return V_i, V_j, neck position and length of the parabola."""
    a, b, c, di, dj = u
    length = di + dj + gap
    neck = min(max(-b / (2.0 * a), 0.0), length) if a > 0 else 0.0
    end = a * length**2 + b * length + c
    vi = _turned(a, b, c, 0.0, neck) - _cap(c, di)
    vj = _turned(a, b, c, neck, length) - (_cap(end, dj) if shape.cap_j else 0.0)
    return vi, vj, neck, length


@compiled
def equations(u: Any, shape: Any, gap: float, volume: float) -> Any:
    """Return the five equations, each scaled to order one."""
    a, b, c, di, dj = u
    vi, vj, _, length = parts(u, shape, gap)
    end, slope = a * length**2 + b * length + c, 2.0 * a * length + b
    size = volume ** (1.0 / 3.0)
    return np.array(
        [
            (c**2 - (2.0 * di - di**2)) / size**2,
            (end**2 - (2.0 * shape.rj * dj - dj**2)) / size**2,
            np.pi / 2 + np.arctan(b) - np.arcsin(min(max(c, -1.0), 1.0)) - shape.ti,
            np.pi / 2 - np.arctan(slope) - np.arcsin(min(max(end / shape.rj, -1.0), 1.0)) - shape.tj,
            (vi + vj) / volume - 1.0,
        ]
    )


def first_guess(shape: Shape, gap: float, volume: float, widen: float) -> Floats:
    """Return a nearly cylindrical bridge of about that volume, as the initial guess."""
    y = min(widen * np.sqrt(volume / (np.pi * gap)), 0.8, 0.8 * shape.rj)
    di, dj = 1.0 - np.sqrt(1.0 - y**2), shape.rj - np.sqrt(shape.rj**2 - y**2)
    length = di + dj + gap
    sag = 0.3 * y
    return np.array([4.0 * sag / length**2, -4.0 * sag / length, y, di, dj])


def solve(shape: Shape, gap: float, volume: float, start: Floats | None) -> Floats | None:
    """Return the parabola, None if no initial guess leads to one."""
    guesses = [start] if start is not None else []
    guesses += [first_guess(shape, gap, volume, w) for w in (1.2, 1.0, 1.5, 0.8, 2.0)]
    for guess in guesses:
        if not np.isfinite(guess).all():  # no such bridge: the rupture law gives no gap
            continue
        # MINPACK computes the derivatives; least_squares would do so in Python, a third of a replay's time
        u, _, found, _, _ = leastsq(
            equations, guess, (shape, gap, volume), full_output=True, xtol=1e-15, ftol=1e-15, gtol=1e-15
        )
        vi, vj, _, _ = parts(u, shape, gap)
        convex = u[0] > 0 and u[2] - u[1] ** 2 / (4 * u[0]) > 0
        below = 0 < u[3] < 1 and 0 < u[4] < shape.rj  # both half-filling angles below 90 degrees
        if np.abs(found["fvec"]).max() < 1e-9 and convex and below and vi >= 0 and vj >= 0:
            return u
    return None


def recomputed_ratio(
    kind: int, ri: float, rj: float, ti: float, tj: float, v_star: Floats, law: str = "parabola"
) -> Floats:
    """Return T_i at increasing V*; NaN if the model has no solution."""
    stretch = 1.0 if kind == laws.SPHERE else WALL_STRETCH[law]
    return np.array(_recomputed_ratio(kind, ri, rj, ti, tj, tuple(v_star), stretch))


@cache
def _recomputed_ratio(
    kind: int, ri: float, rj: float, ti: float, tj: float, v_star: tuple[float, ...], stretch: float
) -> list[float]:
    if kind == laws.SPHERE and (ri, ti) == (rj, tj):
        return [0.5] * len(v_star)
    size = 2.0 * rj / (ri + rj) if kind == laws.SPHERE else 1.0  # r_eff in units of r_i
    shape = Shape(
        {laws.SPHERE: rj / ri, laws.LARGE_WALL: 1.0, laws.SMALL_WALL: rj / ri}[kind], ti, tj, kind == laws.SPHERE
    )
    wall = np.array([kind != laws.SPHERE])
    out, start = [], None
    for v in v_star:
        volume = v * size**3
        one = np.ones(1)
        gap = stretch * float(
            laws.willett_rupture(volume * one, one, rj / ri * one if not wall[0] else one, wall, ti * one, tj * one)[0]
        )
        start = solve(shape, gap, volume, start)
        if start is None:
            out.append(np.nan)
        else:
            vi, vj, _, _ = parts(start, shape, gap)
            out.append(vi / (vi + vj))
    return out


def exact_ratios(kind: int, ri: float, rj: float, ti: float, tj: float, nodes: Floats, at: Floats) -> Floats:
    """Return T_i of the exact bridge at nodes `at`.

    V* below 1e-5 counts as 1e-5, too large a volume as the largest with a bridge.
    """
    other = np.inf if kind == laws.LARGE_WALL else rj
    if (ri, ti) == (other, tj):
        return np.full(len(at), 0.5)  # after symmetry breaking either body may have the larger share
    r = 2.0 * ri * rj / (ri + rj) if kind == laws.SPHERE else ri
    turned = kind == laws.SPHERE and (rj, tj) < (ri, ti)  # rows (i, j) and (j, i) have the same solution

    def ratio(node: int) -> float | None:
        volume = max(float(nodes[node]), SMALLEST) * r**3
        found = exact.end((volume, rj, ri, tj, ti) if turned else (volume, ri, float(other), ti, tj))
        if found is None:
            return None
        return 1.0 - found.transfer_ratio_i if turned else found.transfer_ratio_i

    def last(low: int, high: int) -> int:
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if ratio(middle) is not None else (low, middle)
        return low

    values = []
    for node in at:
        value = ratio(int(node))
        values.append(ratio(last(0, int(node))) if value is None else value)
    return np.array([np.nan if v is None else v for v in values])


def bodies_of_rows(run: Run) -> dict[tuple[int, int, int], tuple[float, float, float, float]]:
    """Return radii (for a wall the half width) and contact angles r_i, r_j, theta_i, theta_j of every row of the table."""
    types, found = {t["type"]: t for t in run.meta["types"]}, {}
    for kind, i, other in Tables(run.table("transfer")).rows():
        ri, ti = types[i]["radius"], types[i]["contact_angle"]
        if kind == laws.SPHERE:
            rj, tj = types[other]["radius"], types[other]["contact_angle"]
        else:
            parts_table = run.table("parts")
            part = parts_table[parts_table["part_class"] == other].iloc[0]
            rj, tj = float(part["half_width"]), float(part["contact_angle"])
        found[kind, i, other] = (ri, rj, ti, tj)
    return found


def solved_nodes(run: Run) -> tuple[pd.DataFrame, Floats, Floats, float]:
    """Return some nodes of every row of the engine's table that can be solved: index, logged and recomputed value, tolerance."""
    solved = coverage.solved(run, "transfer")
    table, bodies = run.table("transfer"), bodies_of_rows(run)
    held = Tables(table).rows()
    rows, logged, expected = [], [], []
    for (kind, i, other), (nodes, values) in exact.shown(held.items(), len(held), "transfer rows"):
        ri, rj, ti, tj = bodies[kind, i, other]
        first = int(np.searchsorted(nodes, SMALLEST))
        if solved:
            at = np.unique(np.linspace(0, len(nodes) - 1, max(2, EXACT_NODES // len(held))).astype(int))
            mine = exact_ratios(kind, ri, rj, ti, tj, nodes, at)
        elif coverage.law(run, "transfer") == "half":
            at = np.arange(len(nodes))
            mine = np.full(len(nodes), 0.5)
        else:
            at = np.unique(np.linspace(first, len(nodes) - 1, 40).astype(int))
            mine = recomputed_ratio(kind, ri, rj, ti, tj, nodes[at], str(coverage.law(run, "transfer")))
        for n, v in zip(at, mine, strict=True):
            if solved or np.isfinite(v):
                rows.append({"partner_kind": kind, "type_i": i, "other": other, "v_star": float(nodes[n])})
                logged.append(values[n])
                expected.append(v)
    return pd.DataFrame(rows), np.array(logged), np.array(expected), EXACT_TOLERANCE if solved else TABLE_TOLERANCE


def of_law(run: Run, where: pd.DataFrame, law: str) -> Floats:
    """Return T_i of some nodes of `solved_nodes` by another law; NaN if it has no solution."""
    found, of = np.full(len(where), np.nan), bodies_of_rows(run)
    for _, rows in where.groupby(["partner_kind", "type_i", "other"]):
        kind, i, other = (int(rows[name].iloc[0]) for name in ("partner_kind", "type_i", "other"))
        found[rows.index] = recomputed_ratio(kind, *of[kind, i, other], rows["v_star"].to_numpy(float), law)
    return found


def check(run: Run) -> list[Quantity]:
    """Compare every row of the engine's table at some of its nodes with independent solutions, if possible."""
    if not coverage.known(run, "transfer"):
        return []
    where, logged, expected, tolerance = solved_nodes(run)
    result = compare("transfer_table", "one", logged, expected, np.ones(len(expected)), where, tolerance)
    return [replace(result, sample_of=len(run.table("transfer")))]
