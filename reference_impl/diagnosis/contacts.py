"""Equations of the contact log, each with the faults that would violate it (see diagnosis.py)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
import pandas as pd

from reference_impl.diagnosis import chain as links_chain
from reference_impl.diagnosis import viscous as links_viscous
from reference_impl.diagnosis.diagnosis import Link, Suspect, length
from reference_impl.diagnosis.suspects import Formula, factor, formulas, gaps, middle
from reference_impl.replay import active_bridges, capillary, coverage, forces, laws
from reference_impl.replay.arrays import Floats, vectors
from reference_impl.replay.forces import Contacts
from reference_impl.replay.io import Run


def marks(c: Contacts) -> dict[str, Floats]:
    """Group the rows of the contact log by kind of partner and other properties."""
    kind = c.table["partner_kind"].to_numpy()
    unlike = ~c.wall & (c.ri != c.rj)
    return {
        "between spheres": ~c.wall, "between unequal spheres": unlike, "at walls": c.wall,
        "at large walls": kind == laws.LARGE_WALL, "at wires": kind == laws.SMALL_WALL,
        "apart (S > 0)": c.gap > 0.0, "in overlap (S < 0)": c.gap < 0.0,
    }  # fmt: skip


def separation(c: Contacts) -> Link:
    """Check S = |x_i - x_j| - r_i - r_j; at a wall without r_j."""
    logged = c.column("separation")
    suspects = partial(gaps, logged, c.gap, c.ri, np.where(c.wall, 0.0, c.rj))
    return Link("separation", "gap", c.table, logged, c.gap, c.ri, suspects, marks=marks(c))


def limit(run: Run, c: Contacts, formed: pd.DataFrame) -> Link:
    """Compare the rupture distance with the static distance of the event log times the dynamic factor."""
    static, logged = formed["rupture_distance"].to_numpy(float), c.column("rupture_distance")
    on, eta, sigma = coverage.law(run, "dynamic_rupture"), run.meta["viscosity"], run.meta["surface_tension"]

    def of(speed: Floats) -> Floats:
        return static * laws.pitois_factor(speed, eta, sigma)

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield Suspect("dynamic rupture is ignored", static)
        yield Suspect("dynamic rupture counts though it is off", of(c.speed))
        yield Suspect("dynamic rupture takes the speed along n only", of(np.abs(c.vn)))
        yield Suspect("the dynamic factor is applied twice", static * laws.pitois_factor(c.speed, eta, sigma) ** 2)
        yield Suspect(links_chain.MISSING_FORMATION, np.where(np.isfinite(static), np.nan, logged))
        times = middle((((logged / static - 1.0) ** 2) * sigma / (c.speed * eta))[rows])
        words = f"viscosity over surface tension is {times:.6g} times what it should be"
        yield Suspect(words, of(times * c.speed), times)
        yield from factor(logged, expected, rows)

    expected = of(c.speed) if on else static
    name, excuses = coverage.law(run, "rupture"), []
    if name in laws.RUPTURE:
        mine = laws.RUPTURE[name](c.volume, c.ri, c.rj, c.wall, c.ti, c.tj)
        excuses = [mine * expected / static]
    return Link("rupture_limit", "rupture limit", c.table, logged, expected, expected, suspects, excuses=tuple(excuses),
                marks=marks(c))  # fmt: skip


def volume(c: Contacts, formed: pd.DataFrame, drawn: Floats) -> Link:
    """Check that a bridge has the volume of its formation; `drawn` are the correct volumes."""
    expected = formed["volume"].to_numpy(float)

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield Suspect(links_chain.MISSING_FORMATION, np.where(np.isfinite(expected), np.nan, c.volume))
        # if the volume changes by a constant factor in each step, log(V/V0) is proportional to the age of the bridge
        age = c.table["step"].to_numpy(float) - formed["formed"].to_numpy(float)
        rate = middle((np.log(c.volume / expected) / age)[rows & (age > 0)])
        if len(np.unique(age[rows & (age > 0)])) > 1:
            grown = expected * np.exp(rate * age)
            # the logarithm of a ratio near one is inaccurate
            steady = np.where(np.abs(c.volume - grown) < 1e-6 * expected, c.volume, np.nan)
            yield Suspect(links_chain.CHANGES, steady, rate, "of itself a step")
        yield from factor(c.volume, expected, rows)
        yield Suspect(links_chain.CHANGES, np.where(c.volume != expected, c.volume, np.nan), general=True)

    return Link("contact_volume", "volume of an active bridge", c.table, c.volume, expected, expected, suspects, 0.0,
                excuses=(np.where(np.abs(drawn - expected) > 1e-9 * expected, drawn, np.nan),), marks=marks(c))  # fmt: skip


def beyond(c: Contacts, static: Floats, limits: Floats) -> Link:
    """Check that no active bridge exceeds both its limits."""
    far = np.fmax(static, limits)
    exists = (c.gap >= far * (1.0 + 1e-9)).astype(float)

    def suspects(rows: Floats) -> Iterator[Suspect]:
        ratio = float((c.gap / far)[rows].max())
        yield Suspect(f"it is made too late (a bridge still exists at {ratio:.4g} of its limit)", exists, ratio)

    one = np.ones(len(exists))

    def says(rows: Floats) -> str:
        at = float(np.median((c.gap / far)[rows]))
        return f"it is made too late: a bridge is still active at {at:.4g} of its limit in the median"

    return Link(
        "standing_beyond_limit", "rupture", c.table, exists, 0.0 * one, one, suspects, marks=marks(c), says=says
    )


def inputs(c: Contacts, formed: pd.DataFrame) -> list[Contacts]:
    """Yield the contacts with the logged gap first, then with gap and volume from the log's other columns."""
    same = replace(c, gap=c.column("separation"))
    expected = formed["volume"].to_numpy(float)
    return [same, c, replace(same, volume=expected), replace(c, volume=expected)]


def pull(run: Run, sets: list[Contacts]) -> Link | None:
    """Return the link of the capillary force of a closed form."""
    c, name, sigma = sets[0], coverage.law(run, "capillary"), run.meta["surface_tension"]
    if name is not None and name not in capillary.LAWS:
        return None
    logged, zero = c.column("capillary"), np.zeros(len(c.table))

    def formula(law: str | None) -> Formula:
        def of(k: Contacts) -> Floats:
            if law is None:
                return zero
            return capillary.LAWS[law](k.gap, k.volume, k.ri, k.rj, k.wall, k.ti, k.tj, sigma)

        return of

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield from formulas(c, formula(name), {n: formula(n) for n in capillary.LAWS}, str(name))
        yield from factor(logged, expected, rows)

    with np.errstate(all="ignore"):
        expected, *rest = (formula(name)(k) for k in sets)
        least = 1e-3 * capillary.limit_at_touch(c.ri, c.rj, c.wall, c.ti, c.tj, sigma)
    size = np.maximum(np.abs(expected), least)
    return Link(
        "capillary", "capillary force", c.table, logged, expected, size, suspects, excuses=tuple(rest), marks=marks(c)
    )


def total(c: Contacts, recomputed_terms: list[Floats]) -> Link:
    """Compare the force on i with the sum of the logged terms; a term that is wrong only in the log has its own link."""
    names, logged = ("capillary", "normal viscous", "tangential viscous"), vectors(c.table, "force_i")
    terms = [-c.column("capillary")[:, None] * c.n, c.column("viscous_normal")[:, None] * c.n]
    terms.append(vectors(c.table, "viscous_tangential"))
    expected = terms[0] + terms[1] + terms[2]
    size = length(terms[0]) + length(terms[1]) + length(terms[2])

    def suspects(rows: Floats) -> Iterator[Suspect]:
        for name, term in zip(names, terms, strict=True):
            yield Suspect(f"the {name} term is left out", expected - term)
            yield Suspect(f"the {name} term has the wrong sign", expected - 2.0 * term)
            yield Suspect(f"the {name} term counts twice", expected + term)
        yield from factor(logged, expected, rows)

    mixed = [a + b + d for a, b, d in product(*zip(terms, recomputed_terms, strict=True))][1:]
    return Link("force", "total force", c.table, logged, expected, size, suspects, excuses=tuple(mixed), marks=marks(c))


def torque(c: Contacts, side: str, recomputed_drag: Floats) -> Link:
    """Check that the torque is the lever arm times n x F_t, with F_t as logged."""
    drag, ri, rj = vectors(c.table, "viscous_tangential"), c.ri, np.where(c.wall, 0.0, c.rj)
    logged, turn = vectors(c.table, f"torque_{side}"), -np.cross(c.n, drag)
    mine, other = (ri, rj) if side == "i" else (rj, ri)
    both, none = c.gap + ri + rj, c.wall if side == "j" else np.zeros_like(c.wall)
    arms = {
        "the arm reaches to the middle of the gap": mine + c.gap / 2.0,
        "the arm reaches across the gap": mine + c.gap,
        "the arm is half the distance of the centres": both / 2.0,
        "the arm is the radius of the other sphere": other,
        "the arm is r_eff": laws.harmonic_radius(ri, c.rj, c.wall),
        "the arm is r_red": laws.reduced_radius(ri, c.rj, c.wall),
        "the arm is a diameter": 2.0 * mine,
        "a wall is treated as a sphere of the particle's size": np.where(c.wall, ri, mine),
    }

    def suspects(rows: Floats) -> Iterator[Suspect]:
        for fault, arm in arms.items():
            yield Suspect(fault, np.where(none & ("wall" not in fault), 0.0, arm)[:, None] * turn)
        yield from factor(logged, mine[:, None] * turn, rows)

    expected, size = mine[:, None] * turn, np.maximum(ri, rj) * np.maximum(length(drag), forces.TINY)
    excuse = -mine[:, None] * np.cross(c.n, recomputed_drag)
    return Link(f"torque_{side}", f"torque on {side}", c.table, logged, expected, size, suspects, excuses=(excuse,),
                marks=marks(c))  # fmt: skip


def expected_or_logged(link: Link | None, logged: Floats) -> Floats:
    """Return the correct value of a term; the logged one if its law is not known here."""
    return logged if link is None else link.expected


def links(run: Run, drawn: Floats) -> Iterator[Link]:
    """Yield all equations of the contact log, causes before consequences; `drawn`: correct volume of each event."""
    c, formed = forces.contacts(run), active_bridges.formed(run)
    if len(c.table) == 0:
        return
    sets = inputs(c, formed)
    same = sets[0]
    yield separation(c)
    event = formed["event"].fillna(-1).to_numpy(int)
    yield volume(c, formed, np.where(event >= 0, np.append(drawn, np.nan)[event], np.nan))
    limits = c.column("rupture_distance")
    if coverage.known(run, "dynamic_rupture"):
        yield (link := limit(run, c, formed))
        limits = link.expected
    yield beyond(c, formed["rupture_distance"].to_numpy(float), limits)
    terms = {
        "capillary": pull(run, sets),
        "viscous_law": links_viscous.normal_law(run, sets, marks(c)),
        "viscous_normal": links_viscous.acting(run, same, marks(c)),
        "viscous_tangential": links_viscous.tangential(run, sets, marks(c)),
    }
    yield from links_viscous.shares(run, same, marks(c))
    yield from (link for link in terms.values() if link is not None)
    pulls = expected_or_logged(terms["capillary"], c.column("capillary"))
    normal = expected_or_logged(terms["viscous_normal"], c.column("viscous_normal"))
    drag = expected_or_logged(terms["viscous_tangential"], vectors(c.table, "viscous_tangential"))
    yield total(c, [-pulls[:, None] * c.n, normal[:, None] * c.n, drag])
    yield torque(same, "i", drag)
    yield torque(same, "j", drag)
