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


def relative_kick(run: Run, table: pd.DataFrame) -> Floats:
    """Change of the relative speed in one step per force, with each sphere's mass shared by its bridges; 0 when explicit.

    dt (n_i/m_i + n_j/m_j), with n the logged number of bridges that share a sphere (0 for a driven sphere and for a wall).
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
    return float(run.meta["time_step"]) * np.asarray(table["sharing_i"].to_numpy(float) / mi + shared_j / mj)


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
    kick, push = relative_kick(run, table), vectors(table, "push")
    law, normal_factor, tangential_factor = zero, 1.0 + zero, 1.0 + zero
    if effects.get("viscous_normal"):
        law = laws.pitois(gap, volume, ri, rj, wall, vn, eta)
        drag = -laws.pitois(gap, volume, ri, rj, wall, 1.0 + zero, eta)
        normal_factor = 1.0 / (1.0 + drag * kick)
        viscous = -drag * (vn + (push * n).sum(axis=1)) * normal_factor
    if effects.get("viscous_tangential"):
        tangential_factor = 1.0 / (1.0 + (slide + 2.5 * roll) * kick)
        pushed = sideways + push - (push * n).sum(axis=1)[:, None] * n
        pushed_spin = spin_slip - np.cross(vectors(table, "spin_push"), n)
        tangential = -tangential_factor[:, None] * (slide[:, None] * pushed + roll[:, None] * pushed_spin)
    force = (viscous - capillary)[:, None] * n + tangential
    torque = -ri[:, None] * np.cross(n, tangential)
    torque_j = np.where(wall, 0.0, -rj)[:, None] * np.cross(n, tangential)

    limit = laws.willett_rupture(volume, ri, rj, wall, ti, tj)
    if effects.get("dynamic_rupture"):
        limit = limit * laws.pitois_factor(np.sqrt((relative**2).sum(axis=1)), eta, sigma)

    # S is a difference of lengths and loses digits near contact, v_n is a scalar product: errors are taken against the size
    # that the inputs give, |v| for viscous terms, and against the whole force for its components.
    speed = np.sqrt((relative**2).sum(axis=1))
    explicit_size = np.abs(laws.pitois(gap, volume, ri, rj, wall, np.maximum(speed, 1e-300), eta))
    pulled = np.maximum(speed + np.sqrt((push**2).sum(axis=1)), 1e-300)
    normal_size = np.abs(laws.pitois(gap, volume, ri, rj, wall, pulled, eta)) * normal_factor
    spin_size = np.sqrt((spin**2).sum(axis=1)) + np.sqrt((vectors(table, "spin_push") ** 2).sum(axis=1))
    tangential_size = (np.abs(slide) * pulled + np.abs(roll) * spin_size) * tangential_factor
    whole = np.maximum(capillary + normal_size + tangential_size, 1e-300)
    arms = np.where(wall, 1.0, rj)

    def column(name: str) -> Floats:
        return table[name].to_numpy(float)

    return [
        compare("separation", "radius of i", column("separation"), gap, ri, table),
        compare("rupture_limit", "itself", column("rupture_distance"), limit, limit, table),
        compare("capillary", "itself", column("capillary"), capillary, np.maximum(capillary, 1e-300), table),
        compare("viscous_law", "its value at |v|", column("viscous_law"), law, explicit_size, table),
        compare("factor_normal", "itself", column("factor_normal"), normal_factor, normal_factor, table),
        compare(
            "factor_tangential", "itself", column("factor_tangential"), tangential_factor, tangential_factor, table
        ),
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
