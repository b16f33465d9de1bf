"""Significance in a sweep: main effects and interactions by F tests, and points that do not differ from the best one.

A numerical axis is represented by a polynomial of second order (first for two values) on its scale, text by its
levels, axes of a zip by the first of them with text, or else the first; the interaction of two axes by the products of
their first terms. The F of a term compares the least-squares
fits with and without it; the error is the scatter of seeds if there are several, otherwise the residual of the full
fit. p is adjusted by Holm over the terms of a result, and two points are compared by the tests of `pywet compare`.

The best of many points is better by chance, too, so that its interval and its comparisons with others hold for all
points at once. A seed gives all points the same start: their means share an error, which the scatter of the seeds'
means over all points shows and that within points does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from pywet.compare import statistics
from pywet.compare.statistics import LEVEL, Finding, Floats, Sample, holm
from pywet.sweep.description import Sweep, joined
from pywet.sweep.table import DONE

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Term:
    """A main effect or an interaction of two axes: share of the variation, change of the result, p (None: no error estimate)."""

    axes: tuple[str, ...]
    """Names; those of a zip are one, `a + b`."""
    share: float
    change: float
    """Largest minus smallest fitted contribution over the points."""
    p: float | None

    @property
    def name(self) -> str:
        return " × ".join(self.axes)

    @property
    def significant(self) -> bool:
        return self.p is not None and self.p <= LEVEL


@dataclass(frozen=True)
class Effects:
    """Terms of a result, the source of the error estimate, and the effects that the design cannot resolve."""

    terms: list[Term]
    error: str
    left_out: str


def coordinates(sweep: Sweep, made: pd.DataFrame) -> dict[str, Floats]:
    """Return numerical axes with more than one value, each scaled from -1 to 1 over its values, on its scale."""
    found = {}
    for key, axis in sweep.axes.items():
        values = made[key]
        if not pd.api.types.is_numeric_dtype(values) or values.nunique() < 2:
            continue
        on_scale = np.log(values.to_numpy(float)) if axis.logarithmic else values.to_numpy(float)
        low, high = on_scale.min(), on_scale.max()
        found[key] = 2.0 * (on_scale - low) / (high - low) - 1.0
    return found


def _columns(sweep: Sweep, made: pd.DataFrame) -> dict[tuple[str, ...], Floats]:
    """Return the columns of the fit for each term, main effects before interactions."""
    first: dict[str, Floats] = {}
    found: dict[tuple[str, ...], Floats] = {}
    numerical = coordinates(sweep, made)
    for group in sweep.factors:
        name, varied = joined(group), [key for key in group if len(made[key].unique()) > 1]
        if not varied:
            continue
        key = next((key for key in varied if key not in numerical), varied[0])
        if key in numerical:
            u = numerical[key]
            first[name] = u[:, None]
            found[(name,)] = np.column_stack([u, u**2]) if made[key].nunique() > 2 else first[name]
        else:
            levels = pd.get_dummies(made[key].astype(str), drop_first=True).to_numpy(float)
            first[name] = found[(name,)] = levels - levels.mean(axis=0)
    for a, b in combinations(first, 2):
        found[a, b] = np.einsum("ni,nj->nij", first[a], first[b]).reshape(len(made), -1)
    return found


def _with(made: pd.DataFrame, result: str) -> pd.DataFrame:
    """Return the rows that have a result."""
    return made[(made["status"] == DONE) & made[result].notna()]


def effects(sweep: Sweep, made: pd.DataFrame, result: str, seeded: bool = True) -> Effects | None:
    """Return main effects and interactions of a result over all runs that have it, each run once.

    The result is None if there are too few, or if all are equal. For runs without a seed, and where the seeds coincide,
    nothing is tested.
    """
    every = _with(made, result)
    rows = every.drop_duplicates("run").reset_index(drop=True)
    if len(rows) < 3 or rows[result].nunique() < 2:
        return None
    columns, left_out = _columns(sweep, rows), ""
    if not _estimable(columns, len(rows)):
        columns = {axes: c for axes, c in columns.items() if len(axes) == 1}
        left_out = "the points do not determine the interactions"
    if not columns or not _estimable(columns, len(rows)):
        return None
    y = rows[result].to_numpy(float)
    residual, coefficients = _fit(columns, y)
    variance, freedom, error = _error(rows, result, residual, sum(c.shape[1] for c in columns.values()))
    if not seeded:
        freedom, error = 0, "none, as there are no seeds: nothing is tested"
    if repeats := len(every) - len(rows):
        error += f"; {repeats} of {len(every)} rows repeat the run of another point and are not counted"
    variance = max(variance, (statistics.ROUND_OFF * float(np.abs(y).max())) ** 2)
    found, p_values = [], []
    for axes, inside in columns.items():
        without = _fit({k: c for k, c in columns.items() if k != axes}, y)[0]
        explained, count = without - residual, inside.shape[1]
        fitted = inside @ coefficients[axes]
        found.append((axes, explained / float(((y - y.mean()) ** 2).sum()), float(np.ptp(fitted))))
        p_values.append(1.0 if freedom == 0 else float(stats.f.sf(explained / count / variance, count, freedom)))
    adjusted = [f.p for f in holm([Finding(0.0, 0, p) for p in p_values])]
    terms = [Term(axes, s, c, p if freedom else None) for (axes, s, c), p in zip(found, adjusted, strict=True)]
    return Effects(terms, error, left_out)


def _estimable(columns: dict[tuple[str, ...], Floats], rows: int) -> bool:
    """Return whether the points determine every coefficient of a fit."""
    matrix = np.column_stack([np.ones(rows), *columns.values()])
    return bool(np.linalg.matrix_rank(matrix) == matrix.shape[1])


def _fit(columns: dict[tuple[str, ...], Floats], y: Floats) -> tuple[float, dict[tuple[str, ...], Floats]]:
    """Return the sum of squared residuals of a least-squares fit with a constant, and the coefficients of each term."""
    matrix = np.column_stack([np.ones(len(y)), *columns.values()])
    solved = np.linalg.lstsq(matrix, y, rcond=None)[0]
    ends = np.cumsum([1, *(c.shape[1] for c in columns.values())])
    parts = {axes: np.asarray(solved[a:b], dtype=float) for axes, a, b in zip(columns, ends, ends[1:], strict=False)}
    return float(((y - matrix @ solved) ** 2).sum()), parts


def _error(rows: pd.DataFrame, result: str, residual: float, count: int) -> tuple[float, int, str]:
    """Return the variance of a single run, its degrees of freedom, and its source."""
    groups = _groups(rows, result)
    scatter, inside = _scatter(groups)
    if inside:
        return scatter**2, inside, f"the scatter of seeds ({inside} degrees of freedom)"
    if len(rows) > len(groups):
        return 0.0, 0, "none, as the seeds coincide: nothing is tested"
    freedom = len(rows) - count - 1
    if freedom > 0:
        return (
            residual / freedom,
            freedom,
            f"what the fit leaves open ({freedom} degrees of freedom): no seeds were repeated",
        )
    return 0.0, 0, "none: as many coefficients as runs"


@dataclass(frozen=True)
class Optimum:
    """The best point of a result, its mean, half width of its 95 % interval, and points that do not differ from it."""

    result: str
    sense: str
    number: int
    values: dict[str, Any]
    mean: float
    runs: int
    half_width: float | None
    alike: list[int]
    """Points that do not differ significantly from it, including itself; it alone if nothing is tested."""
    ranges: dict[str, str]
    """Axis -> its values over those points."""
    next_best: int | None


def optimum(sweep: Sweep, made: pd.DataFrame, result: str, largest: bool) -> Optimum | None:
    """Find the point at which a result is largest (or smallest); None if no run has the result."""
    every = _with(made, result)
    rows = every.drop_duplicates("run")
    if rows.empty:
        return None
    groups = _groups(rows, result)
    order = sorted(groups, key=lambda n: groups[n].mean(), reverse=largest)
    best = order[0]
    first = every.drop_duplicates("point").set_index("point")
    scatter, freedom = _scatter(groups)
    runs = rows.loc[rows["point"].isin([best, *_alike(groups, best, order[1:], scatter, freedom)]), "run"]
    alike = sorted({int(n) for n in every.loc[every["run"].isin(runs), "point"]})
    spans = {key: _span(first.loc[alike, key]) for key in sweep.axes}
    half = _half_width(rows.pivot_table(result, "point", "seed"), best) if freedom else None
    return Optimum(
        result, "largest" if largest else "smallest", best, {key: first.loc[best, key] for key in sweep.axes},
        float(groups[best].mean()), len(groups[best]), half, alike, spans, order[1] if len(order) > 1 else None,
    )  # fmt: skip


def _groups(rows: pd.DataFrame, result: str) -> dict[int, Floats]:
    """Return the values of a result by point."""
    return {int(n): rows.loc[rows["point"] == n, result].to_numpy(float) for n in rows["point"].unique()}


def _scatter(groups: dict[int, Floats]) -> tuple[float, int]:
    """Return the standard deviation of a single run within points, pooled over all of them, and its degrees of freedom.

    None are left where the seeds coincide at all points, exactly (no random start) or by accident (a small count).
    """
    freedom = sum(len(v) - 1 for v in groups.values())
    scatter = np.sqrt(sum(float(((v - v.mean()) ** 2).sum()) for v in groups.values()) / max(freedom, 1))
    least = statistics.ROUND_OFF * max(float(np.abs(v).max()) for v in groups.values())
    return (float(scatter), freedom) if scatter > least else (0.0, 0)


def _half_width(table: pd.DataFrame, best: int) -> float | None:
    """Half width of the interval of the best point's mean from a table (points, seeds); None for fewer than two of either.

    It is the sum of two: for the mean over points, whose values at each seed are the sample, and for the deviations of
    all points from it (Bonferroni).
    """
    whole = table.loc[:, table.loc[best].notna()].dropna().to_numpy(float)
    points, seeds = whole.shape
    if points < 2 or seeds < 2:
        return None
    common = whole.mean(axis=0)
    rest = whole - common - whole.mean(axis=1, keepdims=True) + whole.mean()
    freedom, level = (points - 1) * (seeds - 1), 0.5 * (1.0 - CONFIDENCE)
    scatter = float(np.sqrt((rest**2).sum() / freedom * (1.0 - 1.0 / points)))
    return statistics.half_width(float(common.std(ddof=1)), seeds, seeds - 1, 1.0 - level) + statistics.half_width(
        scatter, seeds, freedom, 1.0 - level / len(table)
    )


def _alike(groups: dict[int, Floats], best: int, others: list[int], scatter: float, freedom: int) -> list[int]:
    """Return points whose mean is not significantly worse: t tests with the pooled scatter, Bonferroni over all pairs."""
    if freedom == 0 or not others:
        return []
    most = float(stats.t.isf(LEVEL / (len(groups) * (len(groups) - 1)), freedom))
    return [
        n
        for n in others
        if abs(groups[n].mean() - groups[best].mean())
        <= most * scatter * np.sqrt(1.0 / len(groups[n]) + 1.0 / len(groups[best]))
    ]


def _span(values: pd.Series) -> str:
    if pd.api.types.is_bool_dtype(values) or not pd.api.types.is_numeric_dtype(values):
        return ", ".join(dict.fromkeys(str(v) for v in values))
    low, high = float(values.min()), float(values.max())
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"


@dataclass(frozen=True)
class Difference:
    """A result at two points, compared like groups of seeds in `pywet compare`: means and p over all gathered results."""

    result: str
    a: float
    b: float
    p: float


def differences(made: pd.DataFrame, results: list[str], a: int, b: int) -> tuple[str, list[Difference]]:
    """Return the method and the difference of each result of two points; empty for fewer than two seeds each."""
    groups = [made[(made["point"] == n) & (made["status"] == DONE)] for n in (a, b)]
    names = [r for r in results if all(g[r].notna().all() and len(g) > 1 for g in groups)]
    if not names:
        return "", []
    scales = {r: max(float(made[r].abs().max()), 1e-300) for r in names}
    samples = [Sample(*(g[[r]].to_numpy(float) / scales[r] for g in groups)) for r in names]
    method, findings = statistics.test(samples)
    rows = [
        Difference(r, float(groups[0][r].mean()), float(groups[1][r].mean()), f.p)
        for r, f in zip(names, findings, strict=True)
    ]
    return method, rows
