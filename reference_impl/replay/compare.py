"""Deviation of the engine's logs from the reference's results: largest, median, and the worst row in full.

A log that is read in parts is compared part by part; `merged` returns the result for the whole.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.replay.arrays import Floats, Table
from reference_impl.replay.arrays import size as length

TOLERANCE = 1e-9
STORED = 1 << 18
"""Number of deviations stored individually, for an exact median."""
DROPPED_BITS = 13
"""Bits dropped for a histogram of more deviations over the leading bits: the median is accurate to a thousandth."""


@dataclass(frozen=True)
class Deviations:
    """Deviations of all records, individually, or, above `STORED` records, as a histogram."""

    each: Floats
    classes: Floats | None = None
    classed: int = 0
    """Number of records in the histogram."""

    @property
    def count(self) -> int:
        """Number of deviations in the histogram."""
        return len(self.each) + self.classed

    @property
    def median(self) -> float:
        """Median of the deviations; 0 if there are none."""
        if self.classes is None:
            return float(np.median(self.each)) if len(self.each) else 0.0
        at = int(np.searchsorted(np.cumsum(self.classes), (self.count + 1) // 2))
        return float(np.array([at << DROPPED_BITS], np.uint32).view(np.float32)[0])


def gathered(parts: Sequence[Deviations]) -> Deviations:
    """Join the deviations of all chunks; the result does not depend on where the log was cut."""
    count = sum(part.count for part in parts)
    if count <= STORED:
        return Deviations(np.concatenate([np.zeros(0), *(part.each for part in parts)]))
    classes = parts[0].classes
    classes = np.zeros(1 << (32 - DROPPED_BITS - 1), np.int64) if classes is None else classes
    for part in parts:
        if part.classes is not None and part.classes is not classes:
            classes += part.classes
        _class(part.each, classes)
    return Deviations(np.zeros(0), classes, count)


def _class(each: Floats, classes: Floats) -> None:
    """Add deviations to a histogram."""
    more = np.bincount(np.minimum(each, 1e30).astype(np.float32).view(np.uint32) >> DROPPED_BITS)
    classes[: len(more)] += more  # most deviations are small: larger classes are unchanged


@dataclass
class Quantity:
    """Agreement of one quantity; deviations are relative to the stated scale."""

    name: str
    scale: str
    count: int
    largest: float
    tolerance: float
    row: dict[str, Any] = field(default_factory=dict)
    """The worst record, as numpy's or Python's values."""
    sample_of: int | None = None
    """Number of records of which `count` were sampled; None if all were compared."""
    deviations: Deviations = field(default_factory=lambda: Deviations(np.zeros(0)), repr=False)
    first: int | None = None
    """Step of the first record beyond the tolerance; None if all are within (or have no step)."""

    @cached_property
    def median(self) -> float:
        """Median of all deviations of a quantity."""
        return self.deviations.median

    @property
    def worst(self) -> dict[str, Any]:
        """Return the worst record as JSON values."""
        return plain(self.row)

    @property
    def ok(self) -> bool:
        """Return whether deviations are within tolerance; always false if an input overflowed."""
        return bool(self.largest <= self.tolerance < np.inf)

    def as_dict(self) -> dict[str, Any]:
        """Convert the quantity to plain data for replay.json."""
        return {
            "scale": self.scale,
            "count": self.count,
            "largest": self.largest,
            "median": self.median,
            "tolerance": self.tolerance,
            "ok": self.ok,
            "sample_of": self.sample_of,
            "worst": self.worst,
        }


def plain(row: Mapping[Any, Any] | pd.Series) -> dict[str, Any]:
    """Convert a row of a table to values for JSON."""
    return {str(k): number(v.item() if hasattr(v, "item") else v) for k, v in row.items()}


def number(value: Any) -> Any:
    """Replace NaN and inf, which JSON does not have, by None; in lists element by element."""
    if isinstance(value, list):
        return [number(v) for v in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def compare(
    name: str, scale: str, logged: Floats, expected: Floats, size: Floats, rows: Table, tolerance: float = TOLERANCE
) -> Quantity:
    """Compare |logged − expected|/size row by row; vectors (n, 3) by the length of the difference.

    A value that is not finite counts as infinite.
    """
    if len(logged) == 0:
        return Quantity(name, scale, 0, 0.0, tolerance)
    apart = logged - expected
    difference = np.abs(apart) if logged.ndim == 1 else length(apart)
    with np.errstate(divide="ignore", invalid="ignore"):
        deviation = difference / size
    if not (finite := np.isfinite(deviation)).all():
        deviation = np.where(finite, deviation, np.where(difference == 0.0, 0.0, 1e300))
    at = int(np.argmax(deviation))
    largest, first = float(deviation[at]), None
    if largest > tolerance and "step" in rows:
        first = int(np.asarray(rows["step"])[np.argmax(deviation > tolerance)])
    row = {str(name): np.asarray(column)[at] for name, column in rows.items()}  # creating a row is slow in pandas
    row |= {"reference": expected[at].tolist(), "logged": logged[at].tolist()}
    return Quantity(name, scale, len(logged), largest, tolerance, row, deviations=Deviations(deviation), first=first)


def merged(parts: Sequence[Quantity]) -> Quantity:
    """Merge one quantity over records that were compared part by part."""
    worst = max(parts, key=lambda q: q.largest)
    if not worst.row:  # the first of equal maxima may be a chunk without records
        worst = next((q for q in parts if q.row), worst)
    every, first = gathered([q.deviations for q in parts]), [q.first for q in parts if q.first is not None]
    return replace(worst, count=every.count, deviations=every, first=min(first, default=None))
