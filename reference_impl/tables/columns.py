"""Compare a table of a run with the recomputed one: columns, rows, values; and describe wrong columns."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from reference_impl.diagnosis.held import MISSING, NONE, Held, column, of_factor
from reference_impl.replay.arrays import Floats
from reference_impl.replay.compare import TOLERANCE
from reference_impl.replay.io import ReplayError, parquet_table

SHIFTS = (1, -1, 2, -2, 3, -3)
ROWS = {"step": "output steps of scene.json", "size": "sizes of which a sphere left"}
"""What numbers the rows of a table -> which rows there are."""
UNITS = {"step": "output", "size": "row"}
TIMES = ("time_s", "time_since_opening_s")


def read(path: Path) -> pd.DataFrame:
    """Read a table of the results, Parquet or CSV."""
    try:
        return parquet_table(path) if path.suffix == ".parquet" else pd.read_csv(path)
    except Exception as error:  # a damaged file raises many types
        raise ReplayError(
            f"{path} is not a readable table; expected what `pywet run` writes: make the results again"
        ) from error


def held(
    name: str, given: pd.DataFrame, recomputed: pd.DataFrame, scales: dict[str, float], key: str = "step"
) -> list[Held]:
    """Compare every value of a table, column by column; `scales`: scale of values by the start of a column's name.

    `key`: the column that numbers the rows.
    """
    found = [Held(f"{name}: column {c}", MISSING, "there", "docs/results.md") for c in recomputed if c not in given]
    found += [Held(f"{name}: column {c}", "there", NONE, "docs/results.md") for c in given if c not in recomputed]
    if key not in given:
        return found
    steps, want = column(given, key), recomputed[key].to_numpy()
    once, count = np.unique(steps, return_counts=True)
    for wrong_steps, is_, should in (
        (want[~np.isin(want, steps)], MISSING, "there"),
        (steps[~np.isin(steps, want)], "there", NONE),
        (once[count > 1], "there twice", "there once"),
    ):
        found += [Held(f"{name}: row of {key} {s:g}", is_, should, ROWS[key]) for s in wrong_steps]
    if not found and not np.array_equal(steps, want):
        found.append(Held(f"{name}: rows", "in another order", f"in the order of their {key}s", "docs/results.md"))
    table = recomputed.set_index(key).reindex(steps)
    both = np.isin(steps, want) & ~pd.Series(steps).duplicated().to_numpy()
    wrong: dict[str, Floats] = {}
    for c in map(str, recomputed):
        if c in given and c != key:
            expected, values = table[c].to_numpy()[both], column(given, c)[both]
            found.append(_worst(name, c, values, expected, steps[both], scale_of(c, scales), key))
            if found[-1].wrong:
                wrong[c] = values
    return [_named(name, h, wrong, recomputed.loc[np.isin(want, steps[both])], scales, key) for h in found]


def scale_of(name: str, scales: dict[str, float]) -> float:
    """Scale to which deviations of a column refer."""
    return next((size for start, size in scales.items() if name.startswith(start) or name.endswith(start)), 1.0)


def _worst(name: str, c: str, values: Floats, expected: Floats, steps: Floats, scale: float, key: str) -> Held:
    off = np.where(np.isfinite(values), np.abs(values - expected), np.inf)
    at = int(np.argmax(off)) if len(off) else 0
    if not len(off):
        return Held(f"{name}: {c}", None, None, "the raw logs")
    return Held(f"{name}: {c} at {key} {steps[at]:g}", float(values[at]), float(expected[at]), "the raw logs", scale)


def _named(
    name: str, h: Held, wrong: dict[str, Floats], recomputed: pd.DataFrame, scales: dict[str, float], key: str
) -> Held:
    c = h.name.removeprefix(f"{name}: ").partition(f" at {key} ")[0]
    if not h.wrong or c not in wrong:
        return h
    words = next(_likenesses(c, wrong, recomputed, scale_of(c, scales), key), "")
    return Held(h.name, h.given, h.expected, h.source, h.scale, h.allowance, words)


def _likenesses(c: str, wrong: dict[str, Floats], recomputed: pd.DataFrame, scale: float, key: str) -> Iterator[str]:
    """Yield what the values of a column could be instead, the most certain first."""
    values, expected = wrong[c], recomputed[c].to_numpy()

    def same(a: Floats, b: Floats) -> bool:
        with np.errstate(all="ignore"):
            return len(a) > 0 and bool((np.abs(a - b) <= TOLERANCE * scale).all())

    others = {n: recomputed[n].to_numpy() for n in map(str, recomputed) if n not in (c, key)}
    for n, v in others.items():
        # constant values may be equal by coincidence: then both columns must be swapped
        if same(values, v) and (np.ptp(values) > 0.0 or (n in wrong and same(wrong[n], expected))):
            yield f"it holds what {n} should hold"
    lasting = np.abs(expected) > 1e-6 * scale
    factor = float(np.median(values[lasting] / expected[lasting])) if lasting.any() else math.nan
    if same(values / max(abs(factor), 1.0), expected * factor / max(abs(factor), 1.0)):
        yield of_factor(factor) or "it is left out"
    for k in SHIFTS:
        if len(values) > abs(k) + 1 and same(values[k:], expected[:-k]) if k > 0 else same(values[:k], expected[-k:]):
            yield f"it is {abs(k)} {UNITS[key]}{'s' * (abs(k) > 1)} {'late' if k > 0 else 'early'}"
    shift = values - expected
    if len(shift) > 1 and same(shift, np.full(len(shift), shift[0])):
        yield f"it is shifted by {shift[0]:.6g}" + (" s" if c in TIMES else "")
    off = np.abs(shift) > TOLERANCE * scale
    if off.sum() == 1:
        yield "in this row alone"
    for n, v in others.items():
        if np.ptp(v) > 0.0 and same(shift, v):
            yield f"{n} is in it besides"
        if np.ptp(v) > 0.0 and same(-shift, v):
            yield f"{n} is taken off it"
    first = recomputed[key].to_numpy()[off]
    if len(first):
        yield f"in {int(off.sum())} of {len(off)} rows, the first at {key} {first[0]:g}"
