"""Errors of the laws on the comparison's bridges, as tables: force, rupture distance, transfer ratio, misprints."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pywet.laws import registry
from pywet.schema import LARGE_WALL, SPHERE
from studies.law_comparison.points import SIGMA

CAPILLARY = ["separation", "volume", "radius_i", "radius_j", "contact_angle_i", "contact_angle_j"]
RUPTURE = CAPILLARY[1:]
BODIES = ("equal spheres", "unequal spheres", "wall")
GAPS = ("touch", "gap", "near rupture")
"""Ranges of S/S_rup: 0, up to 0.8, beyond."""
PRINTED = {
    "capillary": {
        "rabinovich_as_printed": "rabinovich",
        "rabinovich_small_gap": "rabinovich",
        "willett_simple_as_printed": "willett_simple",
        "weigert_as_printed": "weigert",
    },
    "rupture": {"willett_unequal_as_printed": "willett_unequal"},
}
"""Law as printed -> law with which it is compared."""


def force_errors(forces: pd.DataFrame, custom: Iterable[str] = ()) -> pd.DataFrame:
    """Return the relative error F/F_exact − 1 of every built-in capillary law and of `custom` ones, one column per law."""
    arguments = [forces[name].to_numpy(float) for name in CAPILLARY]
    errors = {}
    for name in (*registry.BUILT_IN["capillary"], *custom):
        values = registry.get("capillary", name).functions[0](*arguments, SIGMA)
        errors[name] = values / forces["exact"].to_numpy() - 1.0
    return pd.DataFrame(errors, index=forces.index)


def bodies(points: pd.DataFrame) -> NDArray[np.str_]:
    """Return the entry of `BODIES` to which each row belongs."""
    return np.select([points["ratio"] == 1.0, points["ratio"] > 0.0], BODIES[:2], BODIES[2])


def force_table(forces: pd.DataFrame, errors: pd.DataFrame) -> pd.DataFrame:
    """Return median, 95 % and worst |error| per law, bodies and gap, and the location of the worst."""
    gap = np.select([forces["share"] == 0.0, forces["share"] <= 0.8], GAPS[:2], GAPS[2])
    placed = forces.assign(bodies=bodies(forces), gap=gap)
    each = placed.join(errors.abs()).melt(list(placed), var_name="law", value_name="error").dropna(subset="error")
    by = each.groupby(["law", "bodies", "gap"], sort=False)["error"]
    where = [
        f"V* {w.v_star:.0e}, θ {w.angle_i_deg:g}/{w.angle_j_deg:g}°, S/S_rup {w.share:g}, q {w.ratio:g}"
        for w in each.loc[by.idxmax()].itertuples()
    ]
    table = by.agg(median="median", p95=lambda e: e.quantile(0.95), worst="max", bridges="size")
    return table.reset_index().assign(where=where)


def rupture_table(limits: pd.DataFrame, custom: Iterable[str] = ()) -> pd.DataFrame:
    """Return the error of the rupture laws against the limit of stability, per law and bodies."""
    arguments = [limits[name].to_numpy(float) for name in RUPTURE]
    laws = {name: registry.get("rupture", name).functions[0] for name in (*registry.BUILT_IN["rupture"], *custom)}
    errors = pd.DataFrame({name: law(*arguments) / limits["rupture"].to_numpy() - 1.0 for name, law in laws.items()})
    each = errors.assign(bodies=bodies(limits)).melt("bodies", var_name="law", value_name="error")
    return each.groupby(["law", "bodies"], sort=False)["error"].agg(
        median=lambda e: e.abs().median(), p95=lambda e: e.abs().quantile(0.95), worst=lambda e: e[e.abs().idxmax()]
    ).reset_index()  # fmt: skip


def transfer_table(limits: pd.DataFrame) -> pd.DataFrame:
    """Return the transfer ratio of the smaller body, by the parabola and exact, for every pair and volume."""
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
    """Tabulate the effect of a misprint in per cent of the corrected law: smallest, median and largest difference per bodies."""
    parts = []
    for kind, names in PRINTED.items():
        points = forces if kind == "capillary" else limits
        arguments = [points[n].to_numpy(float) for n in (CAPILLARY if kind == "capillary" else RUPTURE)]
        arguments += [np.full(len(points), SIGMA)] if kind == "capillary" else []
        for printed, mended in names.items():
            wrong, right = (registry.get(kind, n).functions[0](*arguments) for n in (printed, mended))
            change = pd.DataFrame({"bodies": bodies(points), "change": 100.0 * (wrong / right - 1.0)})
            parts.append(change.assign(printed=printed, mended=mended))
    by = pd.concat(parts).groupby(["printed", "mended", "bodies"], sort=False)["change"]
    return by.agg(smallest="min", median="median", largest="max").reset_index()
