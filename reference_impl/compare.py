"""Deviation of what the engine logged from what the reference computes: largest, median, and the worst row in full."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Floats = NDArray[Any]
TOLERANCE = 1e-9


@dataclass
class Quantity:
    """Agreement of one quantity; deviations are relative to the stated scale."""

    name: str
    scale: str
    count: int
    largest: float
    median: float
    tolerance: float
    worst: dict[str, Any] = field(default_factory=dict)
    sample_of: int | None = None
    """Number of records of which `count` were taken; None where all were."""
    deviations: Floats = field(default_factory=lambda: np.zeros(0, np.float32), repr=False)
    """Of every record, to three digits and more: for the median of several parts."""

    @property
    def ok(self) -> bool:
        """Within tolerance."""
        return self.largest <= self.tolerance

    def as_dict(self) -> dict[str, Any]:
        """For replay.json."""
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


def plain(row: pd.Series) -> dict[str, Any]:
    """A table's row as JSON values."""
    return {str(k): number(v.item() if hasattr(v, "item") else v) for k, v in row.items()}


def number(value: Any) -> Any:
    """None for NaN and inf, which JSON does not have; lists element by element."""
    if isinstance(value, list):
        return [number(v) for v in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def compare(
    name: str, scale: str, logged: Floats, own: Floats, size: Floats, rows: pd.DataFrame, tolerance: float = TOLERANCE
) -> Quantity:
    """|logged − own|/size row by row; vectors (n, 3) by the length of the difference. A value that is not finite is infinite."""
    if len(logged) == 0:
        return Quantity(name, scale, 0, 0.0, 0.0, tolerance)
    difference = np.abs(logged - own) if logged.ndim == 1 else np.linalg.norm(logged - own, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        deviation = np.where(difference == 0.0, 0.0, difference / size)
    deviation = np.where(np.isfinite(deviation), deviation, 1e300)
    at = int(np.argmax(deviation))
    worst = plain(rows.iloc[at])
    worst["reference"] = number(own[at].tolist())
    worst["logged"] = number(logged[at].tolist())
    middle, largest = float(np.median(deviation)), float(deviation[at])
    kept = np.minimum(deviation, 1e30).astype(np.float32)
    return Quantity(name, scale, len(logged), largest, middle, tolerance, worst, deviations=kept)


def merged(parts: Sequence[Quantity]) -> Quantity:
    """One quantity over records that were compared part by part."""
    if len(parts) == 1:
        return parts[0]
    worst = max(parts, key=lambda q: q.largest)
    every = np.concatenate([q.deviations for q in parts])
    return replace(worst, count=len(every), median=float(np.median(every)) if len(every) else 0.0, deviations=every)
