"""Equations of the viscous terms in the contact log, each with the faults that would violate it (see diagnosis.py)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from reference_impl.diagnosis.diagnosis import Link, Suspect, length
from reference_impl.diagnosis.suspects import Formula, factor, formulas
from reference_impl.replay import coverage, forces, laws
from reference_impl.replay.arrays import Floats, vectors
from reference_impl.replay.forces import Contacts
from reference_impl.replay.implicit import relative_kick
from reference_impl.replay.io import Run

Marks = dict[str, Floats]


def normal_law(run: Run, sets: list[Contacts], marks: Marks) -> Link | None:
    """Compare the normal viscous force with its law at the logged speeds."""
    c, name, eta = sets[0], coverage.law(run, "viscous_normal"), run.meta["viscosity"]
    if name is None or name not in laws.VISCOUS_NORMAL:
        return None
    logged = c.column("viscous_law")

    def formula(law: str) -> Formula:
        return lambda k: laws.VISCOUS_NORMAL[law](k.gap, k.volume, k.ri, k.rj, k.wall, k.vn, eta)

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield from formulas(c, formula(name), {n: formula(n) for n in laws.VISCOUS_NORMAL}, name)
        yield Suspect("the full relative speed is used for that along n", formula(name)(replace(c, vn=c.speed)))
        yield from factor(logged, expected, rows)

    with np.errstate(all="ignore"):
        expected, *rest = (formula(name)(k) for k in sets)
    size = np.abs(formula(name)(replace(c, vn=np.maximum(c.speed, forces.TINY))))
    return Link("viscous_law", "normal viscous force", c.table, logged, expected, size, suspects, excuses=tuple(rest),
                marks=marks)  # fmt: skip


def acting(run: Run, c: Contacts, marks: Marks) -> Link | None:
    """Compare the acting normal viscous force: the law, or semi-implicit with the velocity change by all other forces."""
    name = coverage.law(run, "viscous_normal")
    if name is None or name not in laws.VISCOUS_NORMAL:
        return None
    law, bare = c.column("viscous_law"), c.column("factor_normal")
    one, push = np.ones(len(c.table)), (vectors(c.table, "push") * c.n).sum(axis=1)
    drag = -laws.VISCOUS_NORMAL[name](c.gap, c.volume, c.ri, c.rj, c.wall, one, run.meta["viscosity"])
    with np.errstate(all="ignore"):
        used = np.where(c.vn != 0.0, -law / c.vn, drag)  # as used by the engine
    expected = -drag * (c.vn + push) * bare if coverage.semi_implicit(run) else law
    logged = c.column("viscous_normal")

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield Suspect("the semi-implicit factor is left out", -drag * (c.vn + push))
        yield Suspect("the push of the other forces is left out", -drag * c.vn * bare)
        yield Suspect("the drag is explicit", law)
        yield from factor(logged, expected, rows)

    recomputed_law = -drag * c.vn
    size = drag * np.maximum(c.speed + np.abs(push), forces.TINY)
    return Link("viscous_normal", "normal viscous force as it acts", c.table, logged, expected, size, suspects,
                excuses=(-used * (c.vn + push) * bare, recomputed_law * bare), marks=marks)  # fmt: skip


def shares(run: Run, c: Contacts, marks: Marks) -> Iterator[Link]:
    """Check the semi-implicit factors 1/(1 + c dt (n_i/m_i + n_j/m_j))."""
    eta, one, t = run.meta["viscosity"], np.ones(len(c.table)), c.table
    others = {
        "the semi-implicit factor is left out": 0.0 * one,
        "a sphere's mass is not shared by its bridges": relative_kick(
            run, t.assign(sharing_i=np.minimum(t["sharing_i"], 1), sharing_j=np.minimum(t["sharing_j"], 1))
        ),
        "the mass of j is left out": relative_kick(run, t.assign(sharing_j=0)),
        "half the time step counts": relative_kick(run, t) / 2.0,
        "the time step counts twice": relative_kick(run, t) * 2.0,
    }
    drags: dict[str, Floats] = {}
    name, side = coverage.law(run, "viscous_normal"), coverage.law(run, "viscous_tangential")
    with np.errstate(all="ignore"):
        if name in laws.VISCOUS_NORMAL:
            drags["normal"] = -laws.VISCOUS_NORMAL[name](c.gap, c.volume, c.ri, c.rj, c.wall, one, eta)
        if side in laws.VISCOUS_TANGENTIAL:
            slide, roll = laws.VISCOUS_TANGENTIAL[side](c.gap, c.ri, c.rj, c.wall, eta)
            drags["tangential"] = slide + 2.5 * roll
    for which, drag in drags.items():
        logged = c.column(f"factor_{which}")

        def suspects(rows: Floats, drag: Floats = drag) -> Iterator[Suspect]:
            for fault, kick in others.items():
                yield Suspect(fault, 1.0 / (1.0 + drag * kick))

        expected = 1.0 / (1.0 + drag * relative_kick(run, t))
        yield Link(
            f"factor_{which}", f"factor of the {which} drag", t, logged, expected, expected, suspects, marks=marks
        )


def _spins(c: Contacts) -> dict[str, Contacts]:
    """Return the contacts with faults of the motion across n."""
    wi, wj = vectors(c.table, "wi"), vectors(c.table, "wj")
    ri, rj = c.ri[:, None], np.where(c.wall, 0.0, c.rj)[:, None]
    along = c.vn[:, None] * c.n
    return {
        "the spin is left out": replace(c, spin=0.0 * c.spin),
        "the spin of j is left out": replace(c, spin=ri * wi),
        "the spin of i is left out": replace(c, spin=rj * wj),
        "the sign of the spin is turned": replace(c, spin=-c.spin),
        "the spins are subtracted": replace(c, spin=ri * wi - rj * wj),
        "the radii of the spins are exchanged": replace(c, spin=np.where(c.wall, c.ri, c.rj)[:, None] * wi + ri * wj),
        "the sliding is left out": replace(c, sideways=0.0 * c.sideways),
        "the speed along n counts too": replace(c, sideways=c.sideways + along),
    }


def tangential(run: Run, sets: list[Contacts], marks: Marks) -> Link | None:
    """Check sliding and spin part, with the factor as logged."""
    c, name, eta = sets[0], coverage.law(run, "viscous_tangential"), run.meta["viscosity"]
    if name is None or name not in laws.VISCOUS_TANGENTIAL:
        return None
    logged, push, spin_push = (vectors(c.table, n) for n in ("viscous_tangential", "push", "spin_push"))
    bare = c.column("factor_tangential")[:, None]
    pushed = push - (push * c.n).sum(axis=1)[:, None] * c.n

    def parts(law: str, k: Contacts, pushes: float = 1.0) -> tuple[Floats, Floats]:
        slide, roll = laws.VISCOUS_TANGENTIAL[law](k.gap, k.ri, k.rj, k.wall, eta)
        turn = np.cross(k.spin + pushes * spin_push, k.n)
        return -bare * slide[:, None] * (k.sideways + pushes * pushed), bare * roll[:, None] * turn

    def formula(law: str, pushes: float = 1.0) -> Formula:
        return lambda k: np.add(*parts(law, k, pushes))

    def suspects(rows: Floats) -> Iterator[Suspect]:
        for fault, other in _spins(c).items():
            yield Suspect(fault, formula(name)(other))
        yield Suspect("the push of the other forces is left out", formula(name, 0.0)(c))
        with np.errstate(all="ignore"):
            yield Suspect("the semi-implicit factor is left out", expected / bare)
        yield from formulas(c, formula(name), {n: formula(n) for n in laws.VISCOUS_TANGENTIAL}, name)
        yield from factor(logged, expected, rows)

    with np.errstate(all="ignore"):
        expected, *rest = (formula(name)(k) for k in sets)
        slide, roll = laws.VISCOUS_TANGENTIAL[name](c.gap, c.ri, c.rj, c.wall, eta)
    size = bare[:, 0] * (np.abs(slide) * (c.speed + length(push)) + np.abs(roll) * (length(c.spin) + length(spin_push)))
    terms = dict(zip(("the part of sliding", "the part of spin"), parts(name, c), strict=True))
    return Link("viscous_tangential", "tangential viscous force", c.table, logged, expected, size, suspects,
                excuses=tuple(rest), marks=marks, terms=terms)  # fmt: skip
