"""Partition curve, cut size, sharpness and efficiencies of a screen, from masses by size class.

All follow from two columns, the mass of each class in the overs and in the unders, which `streams.py` provides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from pywet.geometry.surface import Floats
from pywet.runs.spread import quantile

NORMAL_95 = 1.959963984540054
"""Two-sided 95 % point of the normal distribution."""


def wilson(successes: float, trials: float) -> tuple[float, float]:
    """95 % interval of a proportion by its score (Wilson 1927).

    >>> "{:.4f} {:.4f}".format(*wilson(5, 10))
    '0.2366 0.7634'
    """
    if trials <= 0:
        return 0.0, 1.0
    p, z2 = successes / trials, NORMAL_95**2
    middle = (p + z2 / (2.0 * trials)) / (1.0 + z2 / trials)
    half = NORMAL_95 * math.sqrt(p * (1.0 - p) / trials + z2 / (4.0 * trials**2)) / (1.0 + z2 / trials)
    return max(0.0, middle - half), min(1.0, middle + half)


def partition_curve(diameter_m: Floats, overs: Floats, unders: Floats, sphere_kg: Floats) -> pd.DataFrame:
    """Partition (Tromp) curve: share T of the mass of each size that goes to the overs, with its 95 % interval.

    Parameters
    ----------
    diameter_m : ndarray, shape (classes,)
    overs, unders : ndarray of int, shape (classes,)
        Number of spheres of each class in the two products.
    sphere_kg : ndarray, shape (classes,)
        Mass of one sphere.

    Returns
    -------
    DataFrame
        A row for each size of which a sphere left, from the finest on: diameter_mm, feed_kg, overs_kg, unders_kg, T, T_low,
        T_high.
        The interval counts spheres as independent trials; seeds show what it leaves out.
    """
    rows = []
    for d, o, u, m in sorted(zip(diameter_m, overs, unders, sphere_kg, strict=True)):
        if o + u > 0:
            low, high = wilson(o, o + u)
            rows.append((1e3 * d, (o + u) * m, o * m, u * m, o / (o + u), low, high))
    return pd.DataFrame(rows, columns=["diameter_mm", "feed_kg", "overs_kg", "unders_kg", "T", "T_low", "T_high"])


TIE = 1e-12
"""Difference of two values of T that is round-off of the masses: a class with exactly a quarter encloses 0.25."""


def size_at(curve: pd.DataFrame, share: float, column: str = "T") -> float:
    """Size [mm] from which on T is above this share, between classes linear in the size; nan where classes do not enclose it.

    Where T of finer classes crosses the share too, the coarsest crossing counts for every share and column, so that
    d25 <= d50 <= d75 and the size is between those of `column` T_high and T_low, the ends of its interval.

    >>> size_at(pd.DataFrame({"diameter_mm": [1.0, 3.0], "T": [0.0, 1.0]}), 0.25)
    1.5
    """
    d, t = curve["diameter_mm"].to_numpy(dtype=float), curve[column].to_numpy(dtype=float)
    finer = np.flatnonzero(t <= share + TIE)
    if not len(finer):
        return math.nan
    k = finer[-1]
    if k == len(d) - 1:
        return float(d[k]) if t.min() < share - TIE <= t[k] else math.nan
    return float(d[k] + (share - t[k]) / (t[k + 1] - t[k]) * (d[k + 1] - d[k]))


WITHIN, LEFT_NONE = "within the sizes", "no sphere left"
"""Position of a cut size that sizes on both sides enclose; why there is none without spheres in the products."""


def position(curve: pd.DataFrame, size_mm: float, share: float = 0.5) -> str:
    """Describe where a size found by `size_at` is among the sizes, or, if it is nan, why there is none.

    >>> curve = pd.DataFrame({"diameter_mm": [1.0, 3.0], "T": [0.5, 1.0]})
    >>> position(curve, size_at(curve, 0.5)), position(curve, size_at(curve, 0.4), 0.4)
    ('at the smallest size', 'below the smallest size')
    """
    d, t = (curve[column].to_numpy(dtype=float) for column in ("diameter_mm", "T"))
    if not len(t):
        return LEFT_NONE
    found = {
        "at the smallest size": math.isclose(size_mm, d[0]),
        "at the largest size": math.isclose(size_mm, d[-1]),
        WITHIN: not math.isnan(size_mm),
        "below the smallest size": bool((t > share + TIE).all()),
        "above the largest size": bool((t < share - TIE).all()),
        f"T does not stay above {share:g}": True,
    }
    return next(words for words, so in found.items() if so)


@dataclass(frozen=True)
class Separation:
    """Results of a separation; nan if undefined. Sizes in mm, all else shares of 1."""

    d25_mm: float
    d50_mm: float
    """Cut size: size of which half of the mass goes to the overs."""
    d50_position: str
    """Where it is among the sizes, or why there is none: see `position`."""
    d75_mm: float
    ecart_probable_mm: float
    """Ecart probable (d75 - d25)/2."""
    imperfection: float
    """Imperfection: ecart probable over d50."""
    reference_mm: float
    """Size that separates undersize from oversize: the aperture, else the cut size."""
    undersize_in_feed: float
    undersize_recovery: float
    """Mass of undersize in the unders over that in both products."""
    oversize_recovery: float
    """Mass of oversize in the overs over that in both products."""
    unders_purity: float
    """Share of undersize in the unders."""
    overs_purity: float
    """Share of oversize in the overs."""
    efficiency: float
    """Undersize recovery + oversize recovery - 1 (Newton, Hancock)."""
    efficiency_product: float
    """Undersize recovery times oversize recovery."""
    misplaced: float
    """Undersize in the overs and oversize in the unders, over both products."""


def separation(curve: pd.DataFrame, aperture_mm: float | None = None) -> Separation:
    """Compute cut size, sharpness, recoveries, purities and efficiencies of a partition curve.

    A class is undersize if its diameter is below `aperture_mm`, or, if that is None, below the cut size. The
    recovery of an absent fraction is 1; the purity of an absent product is nan; for an empty feed nothing is defined.
    """
    d25, d50, d75 = (size_at(curve, share) for share in (0.25, 0.5, 0.75))
    reference = d50 if aperture_mm is None else aperture_mm
    under = curve["diameter_mm"].to_numpy(dtype=float) < reference
    feed, overs, unders = (curve[f"{c}_kg"].to_numpy(dtype=float) for c in ("feed", "overs", "unders"))
    known = not math.isnan(reference) and feed.sum() > 0.0

    def share(part: float, whole: float, otherwise: float = 1.0) -> float:
        if not known:
            return math.nan
        return float(part / whole) if whole > 0.0 else otherwise

    recovery_u = share(unders[under].sum(), feed[under].sum())
    recovery_o = share(overs[~under].sum(), feed[~under].sum())
    misplaced = overs[under].sum() + unders[~under].sum()
    return Separation(
        d25, d50, position(curve, d50), d75, 0.5 * (d75 - d25), 0.5 * (d75 - d25) / d50, reference,
        share(feed[under].sum(), feed.sum()), recovery_u, recovery_o,
        share(unders[under].sum(), unders.sum(), math.nan), share(overs[~under].sum(), overs.sum(), math.nan),
        recovery_u + recovery_o - 1.0, recovery_u * recovery_o, share(misplaced, feed.sum()),
    )  # fmt: skip


def mean_and_half_width(values: Sequence[float]) -> tuple[float, float]:
    """Mean of independent values and half of its 95 % interval by Student's t; nan for one alone.

    >>> "{:.2f} {:.4f}".format(*mean_and_half_width([1.0, 2.0, 3.0]))
    '2.00 2.4841'
    """
    given = np.asarray(values, dtype=float)
    n = len(given)
    if n < 2:
        return float(given.mean()), math.nan
    return float(given.mean()), quantile(n) * float(given.std(ddof=1)) / math.sqrt(n)
