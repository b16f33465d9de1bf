"""Compare samples of a run's records with the exact bridge (bridge.py), which the engine interpolates in a table.

A solution takes about a tenth of a second, so a fixed number of records is chosen, the same at every call: per kind
of partner, spread evenly over one quantity (gap over rupture limit, or volume) and, within it, over a second one.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.bridge import bridge
from reference_impl.replay.arrays import Floats
from reference_impl.replay.compare import Quantity, compare

FORCES, RUPTURES = 60, 24
"""Number of forces and ruptures solved per run."""
FORCE_TOLERANCE = 1e-3
"""Stated error of the engine's force table, relative to the force at touch."""
RUPTURE_TOLERANCE = 2e-4
"""Stated error of the engine's rupture table, relative to the distance."""
TABLE_FROM, BELOW_TABLE = 1e-9, 5e-3
"""V* at which the table begins, and the stated error of the limit that extends it to the smallest bridge, V* = 1e-12."""
LARGEST = 0.5
"""Largest V* in the engine's tables; larger volumes count as this."""
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
Body = tuple[float, float, float, float, float]
"""Volume, radii (infinite: plate), contact angles."""


@cache
def end(body: Body) -> bridge.Rupture | None:
    """Return the rupture of these bodies' bridge; None if no stable one exists or it cannot be resolved."""
    try:
        return bridge.rupture(*body)
    except (ValueError, ArithmeticError):
        return None


def counted(body: Body) -> Body:
    """Return the body with its volume limited as in the tables, V* <= 0.5 by r_eff (plate: 2 r_i)."""
    volume, ri, rj, ti, tj = body
    r = 2.0 * ri if math.isinf(rj) else 2.0 * ri * rj / (ri + rj)
    return min(volume, LARGEST * r**3), ri, rj, ti, tj


@cache
def force(gap: float, body: Body) -> float:
    """Return the force over surface tension [m].

    S < 0 counts as S = 0; beyond rupture (a stretched bridge) the force is that at rupture, NaN without a bridge.
    """
    try:
        return bridge.solve(max(gap, 0.0), *counted(body)).force
    except (ValueError, ArithmeticError):
        last = end(counted(body))
        return last.bridge.force if last is not None and gap >= last.separation else math.nan


def chosen(number: int, kind: Floats, first: Floats, second: Floats) -> list[int]:
    """Return the rows of the sample: equal parts of the range of `first` for each kind, with varying position in `second`."""
    rows: set[int] = set()
    kinds = np.unique(kind)
    for k in kinds:
        of_kind = np.flatnonzero(kind == k)
        share = -(-number // len(kinds))
        edges = np.linspace(first[of_kind].min(), first[of_kind].max(), share + 1)
        part = np.clip(np.searchsorted(edges, first[of_kind], side="right") - 1, 0, share - 1)
        for n in range(share):
            inside = of_kind[part == n]
            if len(inside):
                ordered = inside[np.argsort(second[inside], kind="stable")]
                rows.add(int(ordered[int(len(ordered) * ((n + 0.5) * GOLDEN % 1.0))]))
    return sorted(rows)


def shown(items: Iterable[Any], total: int, what: str) -> Iterator[Any]:
    """Yield the items, with a line that counts them on a terminal."""
    for n, item in enumerate(items, start=1):
        if sys.stderr.isatty():
            print(f"\r{what}: {n} of {total}", end="\n" if n == total else "", file=sys.stderr, flush=True)
        yield item


def _bodies(volume: Floats, ri: Floats, rj: Floats, wall: Floats, ti: Floats, tj: Floats) -> Callable[[int], Body]:
    def body(n: int) -> Body:
        return float(volume[n]), float(ri[n]), math.inf if wall[n] else float(rj[n]), float(ti[n]), float(tj[n])

    return body


def check_force(
    table: pd.DataFrame, gap: Floats, sigma: float, wall: Floats, ri: Floats, rj: Floats, ti: Floats, tj: Floats
) -> Quantity:
    """Check the logged capillary force of some contacts, relative to the force at touch."""
    body, rows = _bodies(table["volume"].to_numpy(float), ri, rj, wall, ti, tj), range(len(table))
    pairs = [
        (sigma * force(float(gap[n]), body(n)), sigma * force(0.0, body(n)))
        for n in shown(rows, len(rows), "exact forces")
    ]
    expected, touch = np.array(pairs, dtype=float).reshape(-1, 2).T
    logged = table["capillary"].to_numpy(float)
    return compare("capillary", "force at touch", logged, expected, touch, table, FORCE_TOLERANCE)


def check_rupture(events: pd.DataFrame, wall: Floats, ri: Floats, rj: Floats, ti: Floats, tj: Floats) -> Quantity:
    """Check the logged static rupture distance of some events."""
    volume, logged = events["volume"].to_numpy(float), events["rupture_distance"].to_numpy(float)
    body = _bodies(volume, ri, rj, wall, ti, tj)
    ends = [end(counted(body(n))) for n in shown(range(len(events)), len(events), "exact ruptures")]
    expected = np.array([math.nan if e is None else e.separation for e in ends])
    mean = np.where(wall, 2.0 * ri, 2.0 * ri * rj / (ri + rj))
    size = expected * np.where(volume < TABLE_FROM * mean**3, BELOW_TABLE / RUPTURE_TOLERANCE, 1.0)
    return compare("rupture_distance", "itself", logged, expected, size, events, RUPTURE_TOLERANCE)
