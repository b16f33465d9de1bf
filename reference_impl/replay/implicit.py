"""Effect of semi-implicit drag: how much one step of a force changes the relative speed."""

from __future__ import annotations

import numpy as np

from reference_impl.motion import impulses, weight
from reference_impl.replay import coverage
from reference_impl.replay.arrays import Floats, Table, column
from reference_impl.replay.bodies import bodies, pairs
from reference_impl.replay.io import Run, scene


def relative_kick(run: Run, table: Table) -> Floats:
    """Change of the relative speed in one step per force, with each sphere's mass shared by its bridges; 0 when explicit.

    dt (n_i/m_i + n_j/m_j) for each step that the force acts for, with n the logged number of bridges that share a sphere (0 for a
    driven sphere and for a wall).
    """
    if not coverage.semi_implicit(run):
        return np.zeros(len(table))
    mass = {t["type"]: t["density"] * 4.0 / 3.0 * np.pi * t["radius"] ** 3 for t in run.meta["types"]}
    fixed = bodies(run)
    p, of_type = pairs(table, fixed), np.array([mass.get(k, np.nan) for k in range(max(mass) + 1)])
    mi, mj = of_type[fixed.type_of[p.i]], np.where(p.wall, 1.0, of_type[fixed.type_of[p.sphere_j]])
    if run.meta["effects"].get("liquid_weight"):
        carried, density = weight.carried(run), float(scene(run.folder)["liquid"]["density_kg_per_m3"])
        step, j = np.asarray(table["step"]), np.asarray(table["j"])
        mi = mi + density * carried.of(step, p.i)
        mj = mj + density * carried.of(step, np.where(p.wall, p.i, j))
    shared_j = np.where(p.wall, 0.0, column(table, "sharing_j"))
    step = float(run.meta["time_step"]) * impulses.weights(run, table)
    return step * np.asarray(column(table, "sharing_i") / mi + shared_j / mj)
