"""Laws of stock LIGGGHTS and YADE, measured from their programs on a few of the comparison's bridges."""

from __future__ import annotations

from collections.abc import Callable

import pandas as pd

from pywet.errors import PywetError
from studies.law_comparison.points import SIGMA
from studies.stock.liggghts import LIGGGHTS_MODELS, liggghts_force
from studies.stock.yade import YADE_LAWS, yade_force

SHARES = (0.0, 0.3, 0.8)
VOLUMES = (1e-3, 1e-2)
RATIOS = (1.0, 0.5, 0.0)
ANGLES = (0.0, 20.0, 40.0)


def chosen(forces: pd.DataFrame) -> pd.DataFrame:
    """Return the bridges that are measured: same angle on both bodies."""
    same = (forces["angle_i_deg"] == forces["angle_j_deg"]) & forces["angle_i_deg"].isin(ANGLES)
    near = forces["v_star"].map(lambda v: any(abs(v / w - 1) < 1e-6 for w in VOLUMES))
    picked = forces[same & near & forces["share"].isin(SHARES) & forces["ratio"].isin(RATIOS)].reset_index(drop=True)
    return picked.assign(contact_angle=picked["contact_angle_i"], surface_tension=SIGMA)


def measure(forces: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """Return the relative error per program and law, and what was not measured.

    Columns are ratio, angle, v_star, share, program, law, error.
    """
    points = chosen(forces)
    rows, missing = [], []
    programs: list[tuple[str, str, Callable[..., pd.DataFrame]]] = [
        ("LIGGGHTS", law, liggghts_force) for law in LIGGGHTS_MODELS
    ]
    programs += [("YADE", law, yade_force) for law in YADE_LAWS]
    for program, law, force in programs:
        try:
            values = force(points, law)
        except PywetError as error:
            missing.append(f"{program} {law}: {error}")
            continue
        off = values["force"].to_numpy(float) / points["exact"].to_numpy() - 1.0
        rows.append(points[["ratio", "angle_i_deg", "v_star", "share"]].assign(program=program, law=law, error=off))
    return pd.concat(rows, ignore_index=True) if rows else pd.DataFrame(), missing


def summary(errors: pd.DataFrame) -> pd.DataFrame:
    """Return the smallest and largest error per program, law, bodies and gap."""
    if errors.empty:
        return errors
    names = {1.0: "equal spheres", 0.5: "radii 1:2", 0.0: "wall"}
    grouped = errors.dropna(subset="error").assign(bodies=errors["ratio"].map(names))
    table = grouped.groupby(["program", "law", "bodies", "share"], sort=False)["error"]
    return table.agg(low="min", high="max", bridges="size").reset_index()
