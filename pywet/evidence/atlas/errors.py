"""Errors of the laws on the atlas's bridges, as tables: force, rupture distance, transfer ratio, misprints."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pywet.evidence.atlas.points import SIGMA
from pywet.laws import registry
from pywet.schema import LARGE_WALL, SPHERE

CAPILLARY = ["separation", "volume", "radius_i", "radius_j", "contact_angle_i", "contact_angle_j"]
RUPTURE = CAPILLARY[1:]
REGIONS = {
    "equal spheres": lambda t: t["ratio"] == 1.0,
    "unequal spheres": lambda t: (t["ratio"] > 0.0) & (t["ratio"] < 1.0),
    "wall": lambda t: t["ratio"] == 0.0,
}
GAPS = {"touch": (0.0, 0.0), "gap": (0.01, 0.8), "near rupture": (0.85, 1.0)}
"""Ranges of S/S_rup."""
PRINTED = {
    "capillary": {
        "rabinovich_as_printed": "rabinovich",
        "rabinovich_small_gap": "rabinovich",
        "willett_simple_as_printed": "willett_simple",
        "weigert_as_printed": "weigert",
    },
    "rupture": {"willett_unequal_as_printed": "willett_unequal"},
}
"""Law as printed -> the law it is set against."""


def force_errors(forces: pd.DataFrame, own: Iterable[str] = ()) -> pd.DataFrame:
    """Relative error F/F_exact − 1 of every built-in capillary law and a user's `own`, one column per law, rows as `forces`."""
    arguments = [forces[name].to_numpy(float) for name in CAPILLARY]
    errors = {}
    for name in (*registry.BUILT_IN["capillary"], *own):
        values = registry.get("capillary", name).functions[0](*arguments, SIGMA)
        errors[name] = values / forces["exact"].to_numpy() - 1.0
    return pd.DataFrame(errors, index=forces.index)


def by_bodies(points: pd.DataFrame) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """Name of the bodies and which rows are theirs; only those that are there."""
    for name, chosen in REGIONS.items():
        own = chosen(points).to_numpy()
        if own.any():
            yield name, own


def force_table(forces: pd.DataFrame, errors: pd.DataFrame) -> pd.DataFrame:
    """Median, 95 % and worst |error| per law, bodies and gap, and where the worst is."""
    rows, share = [], forces["share"]
    for law in map(str, errors.columns):
        for bodies, own in by_bodies(forces):
            for gap, (low, high) in GAPS.items():
                size = errors.loc[own & (share >= low) & (share <= high), law].abs().dropna()
                if len(size) == 0:
                    continue
                worst = forces.loc[size.index[int(size.to_numpy().argmax())]]
                where = (
                    f"V* {worst['v_star']:.0e}, θ {worst['angle_i_deg']:g}/{worst['angle_j_deg']:g}°, "
                    f"S/S_rup {worst['share']:g}, q {worst['ratio']:g}"
                )
                row = {"law": law, "bodies": bodies, "gap": gap, "median": size.median(), "p95": size.quantile(0.95)}
                rows.append({**row, "worst": size.max(), "where": where, "bridges": len(size)})
    return pd.DataFrame(rows)


def rupture_table(limits: pd.DataFrame, own: Iterable[str] = ()) -> pd.DataFrame:
    """Error of the rupture laws against the limit of stability, per law and bodies."""
    arguments = [limits[name].to_numpy(float) for name in RUPTURE]
    rows = []
    for name in (*registry.BUILT_IN["rupture"], *own):
        error = registry.get("rupture", name).functions[0](*arguments) / limits["rupture"].to_numpy() - 1.0
        for bodies, own in by_bodies(limits):
            part, size = error[own], np.abs(error[own])
            row = {"law": name, "bodies": bodies, "median": np.median(size), "p95": np.quantile(size, 0.95)}
            rows.append({**row, "worst": part[size.argmax()]})
    return pd.DataFrame(rows)


def transfer_table(limits: pd.DataFrame) -> pd.DataFrame:
    """Transfer ratio of the smaller body: parabola and exact, for every pair and volume of the atlas."""
    rows = []
    for _, pair in limits.groupby(["ratio", "angle_i_deg", "angle_j_deg"]):
        first = pair.iloc[0]
        wall = math.isinf(first["radius_j"])
        r = first["radius_i"] if wall else 2 * first["radius_i"] / (1 + first["ratio"])
        reduced = pair["volume"].to_numpy() / r**3
        size, kind = (first["radius_i"], LARGE_WALL) if wall else (first["radius_j"], SPHERE)
        values = registry.transfer_model("parabola")(
            first["radius_i"], size, first["contact_angle_i"], first["contact_angle_j"], kind, reduced
        )
        rows.append(pair.assign(parabola=values, difference=values - pair["transfer_i"]))
    return pd.concat(rows, ignore_index=True)


def misprint_table(forces: pd.DataFrame, limits: pd.DataFrame) -> pd.DataFrame:
    """What a misprint does, in per cent of the mended law: smallest, median and largest difference per bodies."""
    rows = []
    for kind, names in PRINTED.items():
        points = forces if kind == "capillary" else limits
        arguments = [points[n].to_numpy(float) for n in (CAPILLARY if kind == "capillary" else RUPTURE)]
        arguments += [np.full(len(points), SIGMA)] if kind == "capillary" else []
        for printed, mended in names.items():
            wrong, right = (registry.get(kind, n).functions[0](*arguments) for n in (printed, mended))
            change = 100.0 * (wrong / right - 1.0)
            for bodies, own in by_bodies(points):
                part = change[own]
                row = {"printed": printed, "mended": mended, "bodies": bodies, "smallest": part.min()}
                rows.append({**row, "median": np.median(part), "largest": part.max()})
    return pd.DataFrame(rows)
