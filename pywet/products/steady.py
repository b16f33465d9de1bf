"""Detect where a time series becomes steady, and compute its mean from there on with its uncertainty.

The start-up is removed so that the standard error of the mean of the rest is smallest (marginal standard error rule,
White 1997). A series whose minimum is in its second half has not become steady. The interval is that of the means of
blocks, which are nearly independent if a block is long compared with the correlation time of the series.
"""

from __future__ import annotations

import numpy as np

from pywet.geometry.surface import Floats
from pywet.products.partition import mean_and_half_width

BLOCKS = 8
"""Number of blocks for the interval of a mean."""


def start_of_steady(values: Floats) -> int | None:
    """Index from which on a series is steady; None where it is not by its middle.

    >>> start_of_steady(np.array([9.0, 4.0] + 10 * [1.0, 1.2]))
    2
    """
    given = np.asarray(values, dtype=float)
    n = len(given)
    if n < 2 * BLOCKS:
        return None
    errors = [((given[d:] - given[d:].mean()) ** 2).sum() / (n - d) ** 2 for d in range(n - BLOCKS + 1)]
    least = int(np.argmin(errors))
    return least if least <= n // 2 else None


def block_mean(values: Floats) -> tuple[float, float]:
    """Return mean and half the 95 % interval from `BLOCKS` blocks of equal length; excess values at the start are dropped."""
    given = np.asarray(values, dtype=float)
    size = len(given) // BLOCKS
    if size == 0:
        return float(given.mean()) if len(given) else float("nan"), float("nan")
    return mean_and_half_width(given[len(given) - BLOCKS * size :].reshape(BLOCKS, size).mean(axis=1).tolist())
