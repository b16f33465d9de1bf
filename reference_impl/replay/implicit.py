"""What the semi-implicit treatment does to a drag: how much one step of a force changes the relative speed."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl.motion import impulses, weight
from reference_impl.replay import coverage
from reference_impl.replay.compare import Floats
from reference_impl.replay.io import Run, scene
from reference_impl.replay.laws import SPHERE


def relative_kick(run: Run, table: pd.DataFrame) -> Floats:
    """Change of the relative speed in one step per force, with each sphere's mass shared by its bridges; 0 when explicit.

    dt (n_i/m_i + n_j/m_j) for each step that the force acts for, with n the logged number of bridges that share a sphere (0 for a
    driven sphere and for a wall).
    """
    if not coverage.semi_implicit(run):
        return np.zeros(len(table))
    mass = {t["type"]: t["density"] * 4.0 / 3.0 * np.pi * t["radius"] ** 3 for t in run.meta["types"]}
    spheres = run.table("spheres")
    of_sphere = dict(zip(spheres["id"], spheres["type"].map(mass), strict=True))
    wall = (table["partner_kind"] != SPHERE).to_numpy()
    mi = table["i"].map(of_sphere).to_numpy(float)
    mj = np.where(wall, 1.0, table["j"].map(of_sphere).fillna(1.0).to_numpy(float))
    if run.meta["effects"].get("liquid_weight"):
        carried, density = weight.carried(run), float(scene(run.folder)["liquid"]["density_kg_per_m3"])
        step, i = table["step"].to_numpy(), table["i"].to_numpy()
        mi = mi + density * carried.of(step, i)
        mj = mj + density * carried.of(step, np.where(wall, i, table["j"].to_numpy()))
    shared_j = np.where(wall, 0.0, table["sharing_j"].to_numpy(float))
    step = float(run.meta["time_step"]) * impulses.weights(run, table)
    return step * np.asarray(table["sharing_i"].to_numpy(float) / mi + shared_j / mj)
