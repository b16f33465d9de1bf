"""Partition curve for flowsheet simulation: grade efficiency by size, and Dyssol's screen models fitted to it.

G(x) is the share of the mass of size x that goes to the overs, X the cut size, q = x/X. Each curve is a half at x = X, without
offset. Equations as the documentation of Dyssol's screen gives them.

| curve | G | source |
|---|---|---|
| Plitt | 1 - exp(-ln 2 q^Alpha) | Plitt 1971 |
| Molerus & Hoffmann | 1/(1 + q^-2 exp(Alpha (1 - q^2))) | Molerus & Hoffmann 1969 |
| Teipel & Hennig | Offset + (1 - Offset) (1 - (1 + 3 q^(Beta (q + Alpha)))^(-1/2)) | Hennig & Teipel 2016 |

Parameters have the names and units that Dyssol's screen has, of which 0.693 for ln 2 in Plitt's is the one difference (2e-4).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from pywet.geometry.surface import Floats
from pywet.products.partition import NORMAL_95, size_at

MM = 1e-3
STEEPEST = 100.0
"""Largest sharpness that Dyssol accepts."""


@dataclass(frozen=True)
class Curve:
    """Grade efficiency over size/cut size: further parameters, initial values, upper bounds, function."""

    name: str
    parameters: tuple[str, ...]
    start: tuple[float, ...]
    bounds: tuple[float, ...]
    function: Callable[..., Floats]

    def __call__(self, size: Floats, cut: float, *values: float) -> Floats:
        """Evaluate G at sizes in the unit of `cut`."""
        return np.asarray(self.function(np.asarray(size, dtype=float) / cut, *values))


def _plitt(q: Floats, alpha: float) -> Floats:
    return 1.0 - np.exp(-np.log(2.0) * q**alpha)


def _molerus(q: Floats, alpha: float) -> Floats:
    return 1.0 / (1.0 + np.exp(np.minimum(alpha * (1.0 - q**2), 700.0)) / q**2)


def _teipel(q: Floats, alpha: float, beta: float, offset: float) -> Floats:
    with np.errstate(over="ignore"):
        return offset + (1.0 - offset) * (1.0 - (1.0 + 3.0 * q ** (beta * (q + alpha))) ** -0.5)


CURVES = (
    Curve("Plitt", ("Alpha",), (5.0,), (STEEPEST,), _plitt),
    Curve("Molerus & Hoffmann", ("Alpha",), (5.0,), (STEEPEST,), _molerus),
    Curve("Teipel & Hennig", ("Alpha", "Beta", "Offset"), (1.0, 3.0, 0.02), (STEEPEST, STEEPEST, 1.0), _teipel),
)


def grade_efficiency(curve: pd.DataFrame) -> pd.DataFrame:
    """Return size x_m and share to the overs G of each size of a partition curve, with the 95 % interval, in SI units."""
    names = {"T": "G", "T_low": "G_low", "T_high": "G_high"}
    return curve.assign(x_m=MM * curve["diameter_mm"])[["x_m", *names]].rename(columns=names)


def fitted(curve: pd.DataFrame) -> pd.DataFrame:
    """The curves through a partition curve, by least squares, each size weighted by its 95 % interval.

    Parameters
    ----------
    curve : DataFrame
        Of `partition.partition_curve`.

    Returns
    -------
    DataFrame
        A row for each curve: model, Xcut_m, Alpha, Beta, Offset, rms (of G, all sizes alike) and why, where it could not be
        fitted, in `note`. A curve needs as many sizes that part (0 < T < 1) as it has parameters: what is all or nothing tells
        where the cut is, not how sharp.
    """
    d, t = (curve[c].to_numpy(dtype=float) for c in ("diameter_mm", "T"))
    sigma = np.maximum((curve["T_high"] - curve["T_low"]).to_numpy(dtype=float) / (2.0 * NORMAL_95), 1e-9)
    parted, cut = int(((t > 0.0) & (t < 1.0)).sum()), size_at(curve, 0.5)
    rows = []
    for model in CURVES:
        needed = 1 + len(model.parameters)
        row: dict[str, object] = {"model": model.name}
        if np.isnan(cut) or parted < needed:
            row["note"] = f"{parted} of {len(d)} sizes go both ways; {needed} are needed, on both sides of the cut size"
        else:
            row |= _fit(model, d, t, sigma, cut)
        rows.append(row)
    return pd.DataFrame(rows, columns=["model", "Xcut_m", "Alpha", "Beta", "Offset", "rms", "note"])


def _fit(model: Curve, d: Floats, t: Floats, sigma: Floats, cut: float) -> dict[str, object]:
    from scipy.optimize import curve_fit

    low, high = np.zeros(1 + len(model.parameters)), (10.0, *model.bounds)  # the cut size over that of the curve itself
    low[0] = 0.1
    try:
        values, _ = curve_fit(model, d / cut, t, (1.0, *model.start), sigma, bounds=(low, high), max_nfev=20_000)
    except RuntimeError as error:
        return {"note": f"no fit: {error}"}
    if not d.min() < cut * values[0] < d.max():
        return {"note": "no fit: its cut size is outside the sizes"}
    rms = float(np.sqrt(np.mean((model(d / cut, *values) - t) ** 2)))
    return {"Xcut_m": MM * cut * values[0], **dict(zip(model.parameters, values[1:].tolist(), strict=True)), "rms": rms}
