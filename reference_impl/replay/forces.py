"""Recompute forces and torques of every logged bridge from positions, velocities and spins alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from reference_impl.replay import active_bridges, capillary, coverage, images, laws
from reference_impl.replay.arrays import Floats, Table, apart, column, cross, dot, size, vectors
from reference_impl.replay.bodies import bodies, pairs
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.implicit import relative_kick
from reference_impl.replay.io import Run
from reference_impl.replay.lives import Lives

TINY = 1e-300
"""Scale of a term that is zero, so that any logged value is a deviation."""


@dataclass(frozen=True)
class Contacts:
    """The contact log as arrays: bodies (at a wall radius_j is a dummy), and motion along n and across."""

    table: Any
    """Rows as a frame or `Columns`."""
    wall: Floats
    ri: Floats
    rj: Floats
    ti: Floats
    tj: Floats
    volume: Floats
    n: Floats
    gap: Floats
    speed: Floats
    vn: Floats
    sideways: Floats
    spin: Floats

    @cached_property
    def push(self) -> tuple[Floats, Floats, Floats]:
        """Return the velocity change by all other forces in the step, as logged: of v_i - v_j, of its part along n, and its
        size.
        """
        push = vectors(self.table, "push")
        return push, dot(push, self.n), size(push)

    def column(self, name: str) -> Floats:
        """Return a column of the contact log."""
        return column(self.table, name)


@dataclass(frozen=True)
class Term:
    """A force as used in the totals, the scale of its errors, and its check (none for a law not known here)."""

    value: Floats
    size: Floats
    found: list[Quantity]


def contacts(run: Run, rows: Table | None = None) -> Contacts:
    """Compute geometry and motion of every logged contact, or of some rows of the log."""
    table = run.table("contacts") if rows is None else rows
    p = pairs(table, bodies(run))
    arm = np.where(p.wall, 0.0, p.rj)
    way = images.of(run.folder).nearest(apart(table, "xi", "xj"))
    distance = size(way)
    n = way / distance[:, None]
    relative = apart(table, "vi", "vj")
    vn = dot(relative, n)
    return Contacts(
        table, p.wall, p.ri, p.rj, p.ti, p.tj, column(table, "volume"), n, distance - p.ri - arm,
        speed=size(relative), vn=vn, sideways=relative - vn[:, None] * n,
        spin=p.ri[:, None] * vectors(table, "wi") + arm[:, None] * vectors(table, "wj"),
    )  # fmt: skip


def capillary_term(run: Run, c: Contacts) -> Term:
    """Return the recomputed value for a closed form; the logged one if the exact bridge was sampled or the law is not known."""
    name, sigma, logged = coverage.law(run, "capillary"), run.meta["surface_tension"], c.column("capillary")
    if coverage.solved(run, "capillary") or not coverage.known(run, "capillary"):
        return Term(logged, np.abs(logged), [])  # the exact bridge is checked in sampled.py
    expected = np.zeros(len(c.table))
    whole = expected + TINY
    if name is not None:
        expected = capillary.LAWS[name](c.gap, c.volume, c.ri, c.rj, c.wall, c.ti, c.tj, sigma)
        whole = np.abs(expected)
        # some fits have a zero; two cosines are computed only for small forces
        low = np.flatnonzero(~(whole > 2e-3 * np.pi * sigma * capillary.limit_radius(c.ri, c.rj, c.wall)))
        ri, rj, wall, ti, tj = (values[low] for values in (c.ri, c.rj, c.wall, c.ti, c.tj))
        whole[low] = np.maximum(whole[low], 1e-3 * capillary.limit_at_touch(ri, rj, wall, ti, tj, sigma))
    scale = "itself, or 1e-3 of the small-volume limit at touch"
    return Term(expected, np.abs(expected), [compare("capillary", scale, logged, expected, whole, c.table)])


def normal_term(run: Run, c: Contacts) -> Term:
    """v·n is a difference of products: errors are taken against the force at the full relative speed.

    A semi-implicit drag acts at the speed after all other forces (logged `push`) and is weakened by its own work in the step.
    """
    name, logged = coverage.law(run, "viscous_normal"), c.column("viscous_normal")
    if not coverage.known(run, "viscous_normal"):
        return Term(logged, np.abs(logged), [])
    zero = np.zeros(len(c.table))
    expected, bare, whole, bare_size, factor = zero, zero, zero + TINY, zero + TINY, 1.0 + zero
    if name is not None:
        law, eta, (_, along, pushed) = laws.VISCOUS_NORMAL[name], run.meta["viscosity"], c.push
        bare = law(c.gap, c.volume, c.ri, c.rj, c.wall, c.vn, eta)
        bare_size = np.abs(law(c.gap, c.volume, c.ri, c.rj, c.wall, np.maximum(c.speed, TINY), eta))
        drag = -law(c.gap, c.volume, c.ri, c.rj, c.wall, 1.0 + zero, eta)
        factor = 1.0 / (1.0 + drag * relative_kick(run, c.table))
        expected = -drag * (c.vn + along) * factor
        whole = drag * factor * np.maximum(c.speed + pushed, TINY)
    found = [
        compare("viscous_law", "its value at |v|", c.column("viscous_law"), bare, bare_size, c.table),
        compare("factor_normal", "itself", c.column("factor_normal"), factor, factor, c.table),
        compare("viscous_normal", "its value at |v|", logged, expected, whole, c.table),
    ]
    return Term(expected, whole, found)


def tangential_term(run: Run, c: Contacts) -> Term:
    """Return sliding and spin parts; errors are relative to their magnitudes at the full speeds.

    Semi-implicit drag is as in `normal_term`.
    """
    name, logged = coverage.law(run, "viscous_tangential"), vectors(c.table, "viscous_tangential")
    if not coverage.known(run, "viscous_tangential"):
        return Term(logged, size(logged), [])
    expected, whole, factor = np.zeros((len(c.table), 3)), np.full(len(c.table), TINY), np.ones(len(c.table))
    if name is not None:
        slide, roll = laws.VISCOUS_TANGENTIAL[name](c.gap, c.ri, c.rj, c.wall, run.meta["viscosity"])
        (push, along, pushed), spin_push = c.push, vectors(c.table, "spin_push")
        factor = 1.0 / (1.0 + (slide + 2.5 * roll) * relative_kick(run, c.table))
        slip = c.sideways + push - along[:, None] * c.n
        turn = cross(c.spin + spin_push, c.n)
        expected = -factor[:, None] * (slide[:, None] * slip - roll[:, None] * turn)
        pulled, turning = c.speed + pushed, size(c.spin) + size(spin_push)
        whole = factor * (np.abs(slide) * pulled + np.abs(roll) * turning)
    found = [
        compare("factor_tangential", "itself", c.column("factor_tangential"), factor, factor, c.table),
        compare("viscous_tangential", "its value at |v|", logged, expected, whole, c.table),
    ]
    return Term(expected, whole, found)


def rupture_terms(run: Run, c: Contacts, lives: Lives) -> list[Quantity]:
    """Check the limits of all bridges, and the contact log against the event log."""
    volume, static = lives.formed_with(*active_bridges.when(run, c.table))
    name, logged = coverage.law(run, "rupture"), c.column("rupture_distance")
    if name in laws.RUPTURE:
        static = laws.RUPTURE[name](c.volume, c.ri, c.rj, c.wall, c.ti, c.tj)
    limit, found = logged, []
    if coverage.known(run, "dynamic_rupture"):
        limit = static
        if coverage.law(run, "dynamic_rupture"):
            limit = static * laws.pitois_factor(c.speed, run.meta["viscosity"], run.meta["surface_tension"])
        found = [compare("rupture_limit", "itself", logged, limit, limit, c.table)]
    return [*found, *active_bridges.check(c.table, static, limit, c.gap, volume)]


def check(run: Run, c: Contacts, lives: Lives) -> list[Quantity]:
    """Check separation, rupture distance, each force, total and torques of a part of the contact log."""
    normal, pull, drag = normal_term(run, c), capillary_term(run, c), tangential_term(run, c)
    force = (normal.value - pull.value)[:, None] * c.n + drag.value
    turn = cross(c.n, drag.value)
    # S is a difference of lengths and loses digits near contact: components are compared with the whole force
    whole = np.maximum(pull.size + normal.size + drag.size, TINY)
    arm, scale = np.where(c.wall, 1.0, c.rj), "r times the tangential size"
    torque_i, torque_j = -c.ri[:, None] * turn, np.where(c.wall, 0.0, -c.rj)[:, None] * turn
    return [
        compare("separation", "radius of i", c.column("separation"), c.gap, c.ri, c.table),
        *rupture_terms(run, c, lives),
        *pull.found,
        *normal.found,
        *drag.found,
        compare("force", "sum of the terms' sizes", vectors(c.table, "force_i"), force, whole, c.table),
        compare("torque_i", scale, vectors(c.table, "torque_i"), torque_i, c.ri * drag.size, c.table),
        compare("torque_j", scale, vectors(c.table, "torque_j"), torque_j, arm * drag.size, c.table),
    ]
