"""A number of several seeds as mean and 95 % confidence interval of the mean (Student); of one seed as it is."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, log10, sqrt
from statistics import mean, stdev

from scipy import stats


def half_width(values: Sequence[float]) -> float | None:
    """Half width of the 95 % confidence interval of the mean; None of fewer than two values.

    >>> round(half_width([0.40, 0.44]), 3)
    0.254
    """
    if len(values) < 2:
        return None
    return float(stats.t.ppf(0.975, len(values) - 1)) * stdev(values) / sqrt(len(values))


def with_interval(values: Sequence[float], digits: int = 3) -> str:
    """Mean ± half width, both to the half width's second digit, or to units; one value to so many digits.

    >>> with_interval([0.40, 0.44]), with_interval([0.4218]), with_interval([12047.0])
    ('0.42 ± 0.25', '0.422', '12047')
    >>> with_interval([1204.0, 1181.0, 1190.0]), with_interval([3.0, 3.0])
    ('1192 ± 29', '3 ± 0')
    """
    half, middle = half_width(values), mean(values)
    if not half:
        one = f"{middle:.0f}" if abs(middle) >= 10**digits else f"{middle:.{digits}g}"
        return one if half is None else f"{one} ± 0"
    places = max(0, 1 - floor(log10(half)))
    return f"{middle:.{places}f} ± {half:.{places}f}"
