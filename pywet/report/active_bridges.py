"""Properties of an active bridge beyond its row in the log: radii and contact angles of its bodies, capillary force, age."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pywet.laws import custom_laws, registry
from pywet.report import cuboids
from pywet.runs.rundir import Bools, Floats, RunDir, bridge_ends
from pywet.schema import SPHERE


@dataclass(frozen=True)
class Bodies:
    """Both bodies of each bridge; a wall's radius_j is infinite [m, rad]."""

    at_wall: Bools
    radius_i: Floats
    radius_j: Floats
    angle_i: Floats
    angle_j: Floats


def bodies(run: RunDir, bridges: pd.DataFrame) -> Bodies:
    """Return the bodies of bridges from the ids in their rows."""
    at_wall = (bridges["partner_kind"] != SPHERE).to_numpy()
    ids, radius = (run.spheres[name].to_numpy() for name in ("id", "radius"))
    angle, of_part = run.contact_angles
    one, other = (bridges[end].to_numpy(dtype=np.int64) for end in "ij")
    i = np.searchsorted(ids, one)
    j = np.searchsorted(ids, np.where(at_wall, ids[:1], other))  # for a wall the number of its part
    angle_j = angle[j]
    angle_j[at_wall] = of_part[other[at_wall]]
    return Bodies(at_wall, radius[i], np.where(at_wall, np.inf, radius[j]), angle[i], angle_j)


def corners(run: RunDir, bridges: pd.DataFrame) -> Floats:
    """Return the corners (n, 8, 3) of the cuboids that represent bridges."""
    b = bodies(run, bridges)
    first, second = (bridges[[f"{end}_{axis}" for axis in "xyz"]].to_numpy(dtype=float) for end in ("xi", "xj"))
    volume, gap = (bridges[name].to_numpy(dtype=float) for name in ("volume", "separation"))
    return cuboids.corners(first, second, b.at_wall, volume, gap, b.radius_i, b.radius_j)


def capillary_force(run: RunDir, bridges: pd.DataFrame) -> Floats:
    """Return the attraction [N] of each bridge by the run's law; NaN for a law in a user's file, which is not run here."""
    name, liquid = run.scene.effects.capillary, run.scene.liquid
    if name is None or liquid is None:
        return np.zeros(len(bridges))
    if custom_laws.is_custom(name):
        return np.full(len(bridges), np.nan)
    b = bodies(run, bridges)
    law = registry.get("capillary", name).functions[0]
    gap, volume = (bridges[column].to_numpy(dtype=float) for column in ("separation", "volume"))
    tension = liquid.surface_tension_N_per_m
    return np.asarray(law(gap, volume, b.radius_i, b.radius_j, b.angle_i, b.angle_j, tension), dtype=float)


def age(run: RunDir, bridges: pd.DataFrame, step: int) -> Floats:
    """Return the time [s] since each bridge active at a step formed; NaN if the log does not contain its formation."""
    names, codes, span = run.formations
    if not len(names):
        return np.full(len(bridges), np.nan)
    ends = bridge_ends(bridges)
    row = np.minimum(np.searchsorted(names, ends), len(names) - 1)
    last = np.searchsorted(codes, row * span + step, side="right") - 1
    formed = codes[np.maximum(last, 0)] - row * span  # negative: belongs to another bridge
    known = (last >= 0) & (formed >= 0) & (names[row] == ends)
    return np.where(known, (step - formed) * run.scene.time_step_s, np.nan)
