"""Description of the residuals of violated records: factor or amount, whatever the cause."""

from __future__ import annotations

import numpy as np

from reference_impl.replay.arrays import Floats

NEAR = 0.05
"""Distance of a factor from one below which the size of the deviation is more informative."""
NARROW = 0.02
"""Relative width of the middle half of the ratios within which one factor describes all records."""


def described(logged: Floats, expected: Floats) -> str:
    """Describe the factor between logged and expected values, its range, or their difference, in one phrase."""
    columns = logged.reshape(len(logged), -1), expected.reshape(len(expected), -1)
    with np.errstate(all="ignore"):
        along, square = (columns[0] * columns[1]).sum(axis=1), (columns[1] ** 2).sum(axis=1)
        ratio = (along / square)[np.isfinite(along / square)]
        rest = columns[0] - (along / square)[:, None] * columns[1]
        across = np.linalg.norm(rest, axis=1) / np.maximum(np.linalg.norm(columns[0], axis=1), 1e-300)
    if not len(ratio):
        typical = float(np.median(np.linalg.norm(columns[0], axis=1)))
        return f"it is {typical:.4g} where zero is expected"
    low, middle, high = np.quantile(ratio, [0.25, 0.5, 0.75])
    if logged.ndim > 1 and np.nanmedian(across) > 0.5:
        return "its direction is not the expected one"
    off = np.linalg.norm(columns[0] - columns[1], axis=1) / np.sqrt(np.maximum(square, 1e-300))
    if abs(middle - 1.0) < NEAR:
        return f"it is off by {float(np.median(off)):.2g} of its value"
    if high - low <= NARROW * abs(middle):
        return f"it is {middle:.4g} times what is expected"
    return f"it is {middle:.3g} times what is expected (middle half of the records {low:.3g} to {high:.3g})"
