"""What the semi-implicit treatment does to a drag: how much one step of a force changes the relative speed."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl import impulses
from reference_impl.compare import Floats
from reference_impl.io import Run
from reference_impl.laws import SPHERE


def relative_kick(run: Run, table: pd.DataFrame) -> Floats:
    """Change of the relative speed in one step per force, with each sphere's mass shared by its bridges; 0 when explicit.

    dt (n_i/m_i + n_j/m_j) for each step that the force acts for, with n the logged number of bridges that share a sphere (0 for a
    driven sphere and for a wall).
    """
    if run.meta.get("viscous_integration", "explicit") == "explicit":
        return np.zeros(len(table))
    mass = {t["type"]: t["density"] * 4.0 / 3.0 * np.pi * t["radius"] ** 3 for t in run.meta["types"]}
    spheres = run.table("spheres")
    weight = dict(zip(spheres["id"], spheres["type"].map(mass), strict=True))
    wall = (table["partner_kind"] != SPHERE).to_numpy()
    mi = table["i"].map(weight).to_numpy(float)
    mj = np.where(wall, 1.0, table["j"].map(weight).fillna(1.0).to_numpy(float))
    shared_j = np.where(wall, 0.0, table["sharing_j"].to_numpy(float))
    step = float(run.meta["time_step"]) * impulses.weights(run, table)
    return step * np.asarray(table["sharing_i"].to_numpy(float) / mi + shared_j / mj)
