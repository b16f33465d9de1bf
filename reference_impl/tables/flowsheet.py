"""Tables for process models: the partition curve in SI units, and Dyssol's curves fitted to it.

The parameters of a fit are taken from the file. They must give its rms, and no parameter that is changed by a hundredth may
fit better.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import pandas as pd
from scipy.special import expit, ndtri

from reference_impl.diagnosis.held import MISSING, NONE, Held
from reference_impl.tables import plant

SHIFT, FLAT = 0.01, 1e-6
"""Relative change of a parameter; relative decrease of the squares that ends a fit before its minimum."""
SOURCE = "results/partition"


def plitt(q: float, alpha: float) -> float:
    """Return 1 - 2^(-q^alpha)."""
    return -math.expm1(-math.log(2.0) * q**alpha)


def molerus(q: float, alpha: float) -> float:
    """Return q^2/(q^2 + exp(alpha (1 - q^2)))."""
    return float(expit(2.0 * math.log(q) - alpha * (1.0 - q * q)))


def teipel(q: float, alpha: float, beta: float, offset: float) -> float:
    """Return 1 - (1 - offset)/sqrt(1 + 3 q^(beta (q + alpha)))."""
    power = beta * (q + alpha) * math.log(q)
    return 1.0 - (1.0 - offset) * (
        math.exp(-0.5 * power) / math.sqrt(3.0) if power > 700.0 else (1.0 + 3.0 * math.exp(power)) ** -0.5
    )


CURVES: dict[str, tuple[Callable[..., float], tuple[str, ...], tuple[float, ...]]] = {
    "Plitt": (plitt, ("Alpha",), (100.0,)),
    "Molerus & Hoffmann": (molerus, ("Alpha",), (100.0,)),
    "Teipel & Hennig": (teipel, ("Alpha", "Beta", "Offset"), (100.0, 100.0, 1.0)),
}
"""Name -> function of size over cut size, further parameters, their largest values."""


def grade_efficiency(partition: pd.DataFrame) -> pd.DataFrame:
    """Return size [m] and share to the overs with its interval."""
    table = partition[["diameter_mm", "T", "T_low", "T_high"]].set_axis(["x_m", "G", "G_low", "G_high"], axis=1)
    return table.assign(x_m=table["x_m"] / 1e3)


def held(name: str, given: pd.DataFrame | None, partition: pd.DataFrame) -> Iterator[Held]:
    """Compare which curves are fitted and why others are not, the rms of each, and that it is a best fit."""
    if given is None:
        yield Held(name, MISSING, "there", "docs/results.md")
        return
    yield Held(f"{name}: curves", ", ".join(map(str, given["model"])), ", ".join(CURVES), SOURCE)
    sizes = [
        (float(d), float(o), float(u)) for d, o, u in partition[["diameter_mm", "overs_kg", "unders_kg"]].to_numpy()
    ]
    cut, both = plant.size_of(sizes, 0.5), sum(o > 0.0 and u > 0.0 for _, o, u in sizes)
    for row in given.to_dict("records"):
        model = str(row["model"])
        if model not in CURVES:
            continue
        _, names, _ = CURVES[model]
        values = [float(row[key]) for key in ("Xcut_m", *names)]
        fitted = not math.isnan(values[0])
        if cut is None or both < 1 + len(names):
            why = (
                f"{both} of {len(sizes)} sizes go both ways; {1 + len(names)} are needed, on both sides of the cut size"
            )
            yield Held(f"{name}: {model}", "fitted" if fitted else row["note"], why, SOURCE)
        elif fitted:
            yield Held(f"{name}: {model}: note", row["note"] if isinstance(row["note"], str) else NONE, NONE, SOURCE)
            yield from _fit(f"{name}: {model}", values, float(row["rms"]), partition, cut)
        else:
            yield Held(f"{name}: {model}: note", str(row["note"])[:6], "no fit", SOURCE)


def _fit(name: str, values: Sequence[float], rms: float, partition: pd.DataFrame, cut: float) -> Iterator[Held]:
    function, names, largest = CURVES[name.rpartition(": ")[2]]
    rows = partition[["diameter_mm", "T", "T_low", "T_high"]].to_numpy(float).tolist()

    def off(at: Sequence[float]) -> list[float]:
        return [function(d / (1e3 * at[0]), *at[1:]) - t for d, t, _, _ in rows]

    def squares(at: Sequence[float]) -> float:
        sides = [max((high - low) / (2.0 * float(ndtri(0.975))), 1e-9) for _, _, low, high in rows]
        return math.fsum((o / side) ** 2 for o, side in zip(off(at), sides, strict=True))

    mine = math.sqrt(math.fsum(o * o for o in off(values)) / len(rows))
    yield Held(f"{name}: rms", rms, mine, "its parameters", 1.0)
    inside = rows[0][0] < 1e3 * values[0] < rows[-1][0]
    yield Held(f"{name}: cut size", "inside" if inside else "outside", "inside", "the sizes")
    low, high = [1e-4 * cut, *(0.0 for _ in largest)], [1e-2 * cut, *largest]
    best = squares(values)
    for k in range(len(values)):
        for factor in (1.0 - SHIFT, 1.0 + SHIFT):
            at = [*values]
            at[k] = min(max(at[k] * factor, low[k]), high[k])
            if squares(at) < best * (1.0 - FLAT) - FLAT:
                yield Held(
                    f"{name}: {('Xcut_m', *names)[k]}", values[k], at[k], "by least squares that one fits better"
                )
                return
    yield Held(f"{name}: fit", "best", "best", "its parameters")
