"""95 % intervals of the efficiency and of the moisture of products within one run; `runs/spread.py` has those over seeds."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from pywet.products.partition import mean_and_half_width
from pywet.products.steady import BLOCKS


def of_efficiency(curve: pd.DataFrame, reference_mm: float) -> tuple[float, float]:
    """Ends of the 95 % interval of undersize recovery + oversize recovery - 1, with spheres as independent trials.

    Parameters
    ----------
    curve : DataFrame
        As `partition_curve` returns it; the intervals of T are Wilson's.
    reference_mm : float
        Size that parts undersize from oversize.

    Returns
    -------
    tuple of float
        Lower and upper end, nan where the efficiency is not defined.

    Notes
    -----
    The efficiency is a sum of the shares of the sizes, each with the size's part of the undersize or oversize as weight. Its
    deviations are the roots of the weighted squares of the distances from each share to the end of its interval (MOVER).

    References
    ----------
    Zou, G. Y., & Donner, A. (2008). Statistics in Medicine, 27, 1693-1702.
    """
    if math.isnan(reference_mm) or curve.empty:
        return math.nan, math.nan
    feed, t, low, high = (curve[c].to_numpy(dtype=float) for c in ("feed_kg", "T", "T_low", "T_high"))
    under = curve["diameter_mm"].to_numpy(dtype=float) < reference_mm
    value, below, above = -1.0, 0.0, 0.0
    for part, share, down, up in ((under, 1.0 - t, high - t, t - low), (~under, t, t - low, high - t)):
        weight = feed[part] / feed[part].sum()
        value += float((weight * share[part]).sum()) if part.any() else 1.0
        below += float(((weight * down[part]) ** 2).sum())
        above += float(((weight * up[part]) ** 2).sum())
    return value - math.sqrt(below), value + math.sqrt(above)


def of_moisture(spheres: pd.DataFrame, density: float, continuous: bool) -> float:
    """Return half the 95 % interval of liquid over dry mass [%] by a ratio estimator; nan for fewer than `BLOCKS` spheres.

    For a continuous run it is computed from `BLOCKS` groups of equal numbers of spheres, in the order in which
    they left (the first are up to one larger), for a batch from single spheres. With groups of mass m and liquid
    l, deviations l - M m from the ratio M of the sums.
    """
    if len(spheres) < BLOCKS:
        return math.nan
    rows = spheres.sort_values(["left_s", "id"])
    groups = BLOCKS if continuous else len(rows)
    mass, liquid = (
        np.array([part.sum() for part in np.array_split(values, groups)])
        for values in (rows["mass_kg"].to_numpy(dtype=float), density * rows["liquid_m3"].to_numpy(dtype=float))
    )
    off = (liquid - liquid.sum() / mass.sum() * mass) / mass.mean()
    return 100.0 * mean_and_half_width(off.tolist())[1]
