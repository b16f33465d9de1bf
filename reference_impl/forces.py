"""Forces and torques of every logged bridge from positions, velocities and spins alone."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl import laws
from reference_impl.compare import Floats, Quantity, compare
from reference_impl.io import Run, vectors
from reference_impl.liquid import Bodies, bodies

SPHERE = laws.SPHERE
KNOWN = {
    "capillary": "rabinovich",
    "viscous_normal": "pitois",
    "viscous_tangential": "goldman",
    "rupture": "willett_unequal",
    "dynamic_rupture": "pitois",
}
"""The laws this reference knows, by effect; an effect that is off is named null in meta.json."""


def _bodies_of(table: pd.DataFrame, fixed: Bodies) -> tuple[Floats, Floats, Floats, Floats]:
    """Radii and contact angles of both partners; at a wall radius_j is a dummy."""
    wall = (table["partner_kind"] != SPHERE).to_numpy()
    angle = {i: fixed.angle(i) for i in fixed.radius}
    rj = np.where(wall, 1.0, table["j"].map(fixed.radius).fillna(1.0).to_numpy(float))
    tj = np.where(wall, table["j"].map(fixed.wall_angle).fillna(0.0), table["j"].map(angle).fillna(0.0)).astype(float)
    return table["i"].map(fixed.radius).to_numpy(float), rj, table["i"].map(angle).to_numpy(float), tj


def check(run: Run) -> list[Quantity]:
    """Separation, rupture distance, each force, total, torques."""
    table = run.table("contacts")
    effects = run.meta["effects"]
    sigma, eta = run.meta["surface_tension"], run.meta["viscosity"]
    wall = (table["partner_kind"] != SPHERE).to_numpy()
    ri, rj, ti, tj = _bodies_of(table, bodies(run))
    volume = table["volume"].to_numpy(float)

    apart = vectors(table, "xi") - vectors(table, "xj")
    distance = np.sqrt((apart**2).sum(axis=1))
    n = apart / distance[:, None]
    gap = distance - ri - np.where(wall, 0.0, rj)
    relative = vectors(table, "vi") - vectors(table, "vj")
    vn = (relative * n).sum(axis=1)
    sideways = relative - vn[:, None] * n
    spin = ri[:, None] * vectors(table, "wi") + np.where(wall, 0.0, rj)[:, None] * vectors(table, "wj")
    spin_slip = -np.cross(spin, n)

    zero = np.zeros(len(table))
    capillary, viscous, tangential = zero, zero, np.zeros((len(table), 3))
    slide, roll = laws.goldman(gap, ri, rj, wall, eta)
    if effects.get("capillary"):
        capillary = laws.rabinovich(gap, volume, ri, rj, wall, ti, tj, sigma)
    if effects.get("viscous_normal"):
        viscous = laws.pitois(gap, volume, ri, rj, wall, vn, eta)
    if effects.get("viscous_tangential"):
        tangential = -slide[:, None] * sideways - roll[:, None] * spin_slip
    force = (viscous - capillary)[:, None] * n + tangential
    torque = -ri[:, None] * np.cross(n, tangential)
    torque_j = np.where(wall, 0.0, -rj)[:, None] * np.cross(n, tangential)

    limit = laws.willett_rupture(volume, ri, rj, wall, ti, tj)
    if effects.get("dynamic_rupture"):
        limit = limit * laws.pitois_factor(np.sqrt((relative**2).sum(axis=1)), eta, sigma)

    # S is a difference of lengths and loses digits near contact, v_n is a scalar product: errors are taken against the size
    # that the inputs give, |v| for viscous terms, and against the whole force for its components.
    speed = np.sqrt((relative**2).sum(axis=1))
    normal_size = np.abs(laws.pitois(gap, volume, ri, rj, wall, np.maximum(speed, 1e-300), eta))
    spin_size = np.sqrt((spin**2).sum(axis=1))
    tangential_size = np.abs(slide) * speed + np.abs(roll) * spin_size
    whole = np.maximum(capillary + normal_size + tangential_size, 1e-300)
    arms = np.where(wall, 1.0, rj)

    def column(name: str) -> Floats:
        return table[name].to_numpy(float)

    return [
        compare("separation", "radius of i", column("separation"), gap, ri, table),
        compare("rupture_limit", "itself", column("rupture_distance"), limit, limit, table),
        compare("capillary", "itself", column("capillary"), capillary, np.maximum(capillary, 1e-300), table),
        compare("viscous_normal", "its value at |v|", column("viscous_normal"), viscous, normal_size, table),
        compare(
            "viscous_tangential",
            "its value at |v|",
            vectors(table, "viscous_tangential"),
            tangential,
            tangential_size,
            table,
        ),
        compare("force", "sum of the terms' sizes", vectors(table, "force_i"), force, whole, table),
        compare(
            "torque_i", "r times the tangential size", vectors(table, "torque_i"), torque, ri * tangential_size, table
        ),
        compare(
            "torque_j",
            "r times the tangential size",
            vectors(table, "torque_j"),
            torque_j,
            arms * tangential_size,
            table,
        ),
    ]


def unknown_laws(run: Run) -> list[str]:
    """Effects whose law this reference does not know."""
    effects = run.meta["effects"]
    return [f"{kind}={effects[kind]}" for kind, name in KNOWN.items() if effects.get(kind) not in (None, name)]
