"""Adaptive sampling: the next points where the response is least certain.

Rule (the pinned packages contain no Gaussian process): candidates are a Sobol set in the ranges of the axes. The
score of a candidate is its distance to the nearest point in the unit cube, times 1 + the difference of a linear and a
cubic radial-basis interpolation of the means there over their standard deviation. The best candidate then counts as a
point with its cubic value before the next is chosen, so that several points are spread out. So do a candidate that the
base refuses, which is not added, and a point without a result, as of a failed run, which would be chosen again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree
from scipy.stats import qmc

from pywet.errors import ConfigError, PywetError
from pywet.sweep import sweep_folder
from pywet.sweep.constraints import Constraint
from pywet.sweep.description import Axis, Point, Value, parsed
from pywet.sweep.plan import Plan, Run
from pywet.sweep.points import Numbered
from pywet.sweep.script_base import PREFIX
from pywet.sweep.table import DONE
from pywet.util.files import write_json

Floats = NDArray[np.float64]
CANDIDATES = 1024
SAME = 1e-9
"""Distance in the unit cube below which a candidate is a point already."""
FEWEST = 2
"""Number of points with results, in excess of the number of axes, required before others can be chosen."""
TRIES = 8
"""Largest number of candidates that are checked for each requested point."""


def extended(plan: Plan, made: pd.DataFrame, count: int) -> Plan:
    """Return the sweep with the next points, each checked; `write` adds them to the sweep of later calls."""
    return replace(plan, chosen=(*plan.added, *_next(plan, made, count)))


def write(plan: Plan) -> Path:
    """Write the added points into the sweep's folder, which adds them to the sweep."""
    path = plan.folder / sweep_folder.ADDED
    write_json(path, plan.added)
    return path


def _next(plan: Plan, made: pd.DataFrame, count: int) -> list[Point]:
    axes = _axes(plan)
    result = plan.sweep.goal.result if plan.sweep.goal else plan.results[0]
    rows = made[(made["status"] == DONE) & made[result].notna()]
    means = rows.groupby("point").agg({**dict.fromkeys(axes, "first"), result: "mean"})
    if len(means) < len(axes) + FEWEST:
        raise PywetError(
            f"{plan.file}: {len(means)} points have {result}, expected at least {len(axes) + FEWEST} before points are added",
            code="sweep.few_points", key=result, given=len(means), expected=len(axes) + FEWEST, where=plan.file,
        )  # fmt: skip
    places, values = _shares(axes, means[[*axes]].to_numpy(float)), means[result].to_numpy(float)
    lacking = [[float(p.values[key]) for key in axes] for p in plan.points if p.number not in means.index]
    if lacking:
        more = _shares(axes, np.array(lacking))
        values = np.append(values, _cubic(places, values)(more))
        places = np.vstack([places, more])
    rules = parsed(plan.sweep, plan.file)
    return least_known(places, values, count, axes, rules, lambda point: _accepted(plan, point))


def _accepted(plan: Plan, point: Point) -> bool:
    """Return whether a point can be run with all its seeds, checked as the points of the file are."""
    try:
        runs = [Run(Numbered(0, point), seed, plan.kind.built(point, seed)) for seed in range(plan.sweep.seeds)]
        plan.cost_of(runs[0])
    except PywetError:
        return False
    return True


def _axes(plan: Plan) -> dict[str, Axis]:
    """Return the axes as ranges between their smallest and largest value."""
    found = {}
    for key, axis in plan.sweep.axes.items():
        values = [axis.low, axis.high] if axis.is_range else list(axis.listed)
        if any(isinstance(v, str | bool) for v in values) or len(set(values)) < 2 or len(plan.sweep.factor(key)) > 1:
            raise ConfigError(
                f"{plan.file}: the axis {key} is not a range of numbers of its own; expected numerical axes without zips for "
                "adaptive sampling",
                file=plan.file, code="sweep.axis_range", key=f"axes.{key}",
            )  # fmt: skip
        low, high = min(map(float, values)), max(map(float, values))  # type: ignore[arg-type]
        whole = axis.whole or (not axis.is_range and _integer(plan, key, values))
        found[key] = Axis(low=low, high=high, log=axis.logarithmic, whole=whole)
    return found


def _integer(plan: Plan, key: str, values: Sequence[Value | None]) -> bool:
    """Return whether the base refuses a fraction between listed integers; for variables of a script, whether all are integers."""
    if key.startswith(PREFIX) and plan.sweep.base.script is not None:
        return all(isinstance(value, int) for value in values)
    least = min(map(float, values))  # type: ignore[arg-type]
    if not all(float(value).is_integer() for value in values):  # type: ignore[arg-type]
        return False
    there = next((point.values for point in plan.points if point.values[key] == least), plan.points[0].values)
    try:
        plan.kind.built({**there, key: least + 0.5}, 0)
    except PywetError:
        return True
    return False


def _shares(axes: dict[str, Axis], values: Floats) -> Floats:
    """Convert values (n, axes) to points in the unit cube."""
    columns = []
    for axis, column in zip(axes.values(), values.T, strict=True):
        assert axis.low is not None and axis.high is not None
        scale = np.log if axis.log else np.asarray
        low, high = scale(axis.low), scale(axis.high)
        columns.append((scale(column) - low) / (high - low))
    return np.column_stack(columns)


def _cubic(places: Floats, values: Floats) -> RBFInterpolator:
    return RBFInterpolator(places, values, kernel="cubic", degree=1)


def least_known(
    places: Floats, values: Floats, count: int, axes: dict[str, Axis], rules: list[Constraint],
    accepted: Callable[[Point], bool] = lambda point: True,
) -> list[Point]:  # fmt: skip
    """Return the given number of points, the least certain first, among candidates that satisfy the constraints.

    There are fewer where all whole numbers of the ranges are points already, or where most candidates are not accepted.
    """
    shares = qmc.Sobol(len(axes), rng=1).random(CANDIDATES)
    points = [{key: axis.at(float(u)) for (key, axis), u in zip(axes.items(), row, strict=True)} for row in shares]
    allowed = [k for k, point in enumerate(points) if all(rule.holds(point) for rule in rules)]
    if not allowed:
        raise ConfigError(
            "the constraints leave no candidate for adaptive sampling; expected a region between the ends of the axes",
            code="sweep.no_candidate", key="constraints",
        )  # fmt: skip
    candidates = _shares(axes, np.array([[float(points[k][key]) for key in axes] for k in allowed]))
    chosen: list[Point] = []
    for _ in range(min(TRIES * count, len(allowed))):
        cubic = _cubic(places, values)(candidates)
        linear = RBFInterpolator(places, values, kernel="linear", degree=0)(candidates)
        distance = np.asarray(cKDTree(places).query(candidates)[0])
        score = distance * (1.0 + np.abs(cubic - linear) / max(float(values.std()), 1e-300))
        best = int(score.argmax())
        if len(chosen) == count or distance[best] < SAME:
            break
        if accepted(points[allowed[best]]):
            chosen.append(points[allowed[best]])
        places, values = np.vstack([places, candidates[best]]), np.append(values, cubic[best])
    return chosen
