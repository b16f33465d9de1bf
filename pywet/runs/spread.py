"""Format a number over several seeds as mean and 95 % confidence interval of the mean (Student); of one seed as the value."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, log10, sqrt
from statistics import mean, stdev, variance

from scipy.special import stdtrit  # scipy.stats takes a second to import, in each process of a run

ROUND_OFF = 1e-12
"""Half width of an interval over the value below which it is 0."""


def quantile(count: int) -> float:
    """Compute the quantile of Student's distribution that turns a standard error of `count` values into a 95 % interval.

    >>> round(quantile(2), 2)
    12.71
    """
    return float(stdtrit(count - 1, 0.975))


def difference(values: Sequence[float], usual: Sequence[float], comparisons: int = 1) -> tuple[float, float] | None:
    """Ends of the confidence interval of the difference of the means (Welch), of two values or more on each side.

    The intervals of so many `comparisons` together contain all their differences at 95 % (Bonferroni). None where it is
    unknown: with fewer values, and where they coincide on both sides, as few seeds may by accident.

    >>> [round(end, 3) for end in difference([0.72, 0.74], [0.68, 0.70])]
    [-0.021, 0.101]
    >>> [round(end, 3) for end in difference([0.72, 0.74], [0.68, 0.70], 2)]
    [-0.048, 0.128]
    >>> difference([0.52, 0.52], [0.5, 0.5])
    """
    both = values, usual
    if min(map(len, both)) < 2 or max(max(of) - min(of) for of in both) <= ROUND_OFF * max(map(abs, (*values, *usual))):
        return None
    middle, (a, b) = mean(values) - mean(usual), (variance(of) / len(of) for of in both)
    freedom = (a + b) ** 2 / (a**2 / (len(values) - 1) + b**2 / (len(usual) - 1))
    half = float(stdtrit(freedom, 1.0 - 0.025 / comparisons)) * sqrt(a + b)
    return middle - half, middle + half


def half_width(values: Sequence[float]) -> float | None:
    """Half width of the 95 % confidence interval of the mean; None of fewer than two values.

    >>> round(half_width([0.40, 0.44]), 3)
    0.254
    """
    if len(values) < 2:
        return None
    return quantile(len(values)) * stdev(values) / sqrt(len(values))


def with_interval(values: Sequence[float], digits: int = 3) -> str:
    """Mean ± half width, both to the half width's second digit, or to units; one value to so many digits.

    >>> with_interval([0.40, 0.44]), with_interval([0.4218]), with_interval([12047.0])
    ('0.42 ± 0.25', '0.422', '12047')
    >>> with_interval([1204.0, 1181.0, 1190.0]), with_interval([3.0, 3.0])
    ('1192 ± 29', '3 ± 0')
    """
    return plus_minus(mean(values), half_width(values), digits)


def plus_minus(middle: float, half: float | None, digits: int = 3) -> str:
    """A value and the half width of its interval, as `with_interval` prints them; None: without an interval.

    >>> plus_minus(1.8004, 0.0151), plus_minus(72.6, 25.3), plus_minus(72.64, None), plus_minus(1.0 - 1e-16, 1e-15)
    ('1.800 ± 0.015', '73 ± 25', '72.6', '1 ± 0')
    """
    if not half or half < ROUND_OFF * abs(middle):
        one = f"{middle:.0f}" if abs(middle) >= 10**digits else f"{middle:.{digits}g}"
        return one if half is None else f"{one} ± 0"
    places = max(0, 1 - floor(log10(half)))
    return f"{middle:.{places}f} ± {half:.{places}f}"
