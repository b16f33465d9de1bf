"""Points of a sweep: grids, zips and designs, reduced by the constraints, each with all its seeds."""

from __future__ import annotations

import warnings
from itertools import product
from pathlib import Path
from typing import NamedTuple

from scipy.stats import qmc

from pywet.errors import ConfigError
from pywet.sweep.description import Point, Sweep, parsed


class Numbered(NamedTuple):
    """A point with its number in the table, from 1."""

    number: int
    values: Point


def numbered(sweep: Sweep, file: Path, more: list[Point] | None = None) -> list[Numbered]:
    """Return all points in the order of the file, then `more`; raises if the constraints exclude all."""
    rules = parsed(sweep, file)
    every = [*_all(sweep), *(more or [])]
    left: list[Point] = []
    for k, values in enumerate(every, start=1):
        try:
            if all(rule.holds(values) for rule in rules):
                left.append(values)
        except ConfigError as error:
            data = {**error.data, "where": file}
            raise ConfigError(f"{file}: {error} at combination {k} ({printed(values)})", **data) from error
    if not left:
        raise ConfigError(
            f"{file}: the constraints leave none of {len(every)} points, expected at least one",
            file=file, code="sweep.no_point", key="constraints", given=len(every),
        )  # fmt: skip
    distinct = list({tuple(values.items()): values for values in left}.values())
    return [Numbered(k, values) for k, values in enumerate(distinct, start=1)]


def _all(sweep: Sweep) -> list[Point]:
    groups = [
        [dict(zip(group, row, strict=True)) for row in zip(*(sweep.axes[key].listed for key in group), strict=True)]
        for group in sweep.groups
    ]
    order = list(sweep.axes)
    found: list[Point] = []
    for parts in product(*groups, drawn(sweep)):
        joined = {key: value for part in parts for key, value in part.items()}
        found.append({key: joined[key] for key in order})
    return found


def drawn(sweep: Sweep) -> list[Point]:
    """Return the points that the design draws from the ranges; one empty point without a design."""
    if sweep.design is None:
        return [{}]
    keys, how = sweep.ranges, sweep.design
    if how.sobol:
        with warnings.catch_warnings(action="ignore", category=UserWarning):  # a number that is not a power of two
            shares = qmc.Sobol(len(keys), rng=how.seed).random(how.sobol)
    else:
        shares = qmc.LatinHypercube(len(keys), rng=how.seed).random(how.latin_hypercube or 0)
    return [{key: sweep.axes[key].at(float(u)) for key, u in zip(keys, row, strict=True)} for row in shares]


def printed(values: Point) -> str:
    """Format a point as text: `friction 0.3, laws.0 willett`."""
    return ", ".join(
        f"{key} {value:.6g}" if isinstance(value, float) else f"{key} {value}" for key, value in values.items()
    )
