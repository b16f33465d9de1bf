"""Newton's law put to the diagnosis: which of the forces on a sphere does not act as the reference says.

The change of speed (or spin) of each sphere is held against the sum of its forces; for each force it is asked whether one factor
on it, or a constant acceleration, brings the records back. Tried only where the equations of the log hold, for a wrong force
in the log is a wrong force here too. See diagnosis.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import replace
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.diagnosis.diagnosis import Link, Suspect, length
from reference_impl.diagnosis.suspects import PLAIN, middle
from reference_impl.motion import dry, newton
from reference_impl.motion.newton import Forces
from reference_impl.motion.window import Setup, dry_contacts
from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import masses

Part = tuple[Floats, Floats]
"""Force and torque on the sphere of each record."""
EVERY = ("every force of bridges", "every force but weight", "every force of bridges on their second sphere (j)")
"""Sums of the parts before them; a factor on the last is what a wrong mass looks like."""
KINDS = ("between spheres", "at walls")
"""Kinds of contact by which forces of bridges are distinguished."""
MOST = 2000
"""Records from which factors on two parts are estimated."""


def links(setup: Setup, found: list[Forces], failed: list[str]) -> Iterator[Link]:
    """The laws of motion and the closest points, those beyond their limits."""
    laws = [{**newton.law(setup, f), **(newton.against_log(setup, f) if f.bridges is not None else {})} for f in found]
    if "wall_closest_point" in failed:
        logged, own, size, rows = _joined([law["wall_closest_point"] for law in laws if "wall_closest_point" in law])
        yield Link("wall_closest_point", "closest point of a wall", rows, logged, own, size, _shift(logged, own))
        return  # forces at a wrong place follow from it
    yield from _pushes(found, failed)
    parts = [_parts(setup, f) for f in found]
    for name, what, kind in (("newton_force", "force that acts", 0), ("newton_torque", "torque that acts", 1)):
        if name in failed:
            logged, own, size, rows = _joined([law[name] for law in laws])
            terms = {n: np.concatenate([p[n][kind] for p in parts]) for n in parts[0]}
            weight = np.concatenate([_rows(setup, f)[2] for f in found])
            of_terms = _suspects(logged, own, terms, weight if kind == 0 else None)

            def suspects(
                broken: Floats, kind: int = kind, logged: Floats = logged, own: Floats = own, of_terms: Any = of_terms
            ) -> Iterator[Suspect]:
                yield from _numbers(setup, found, kind, logged, own, broken)
                yield from of_terms(broken)

            yield Link(name, what, rows, logged, own, size, suspects, newton.limit(setup), marks=_marks(terms))


PUSHES = {
    "window_push": "what other forces change of the speed, as semi-implicit drag takes it",
    "window_spin_push": "what other torques change of the spin, as semi-implicit drag takes it",
    "window_sharing": "number of bridges that share a sphere, as semi-implicit drag takes it",
}


def _pushes(found: list[Forces], failed: list[str]) -> Iterator[Link]:
    """What semi-implicit drag starts from, where that is beyond its limits: a term lost or with another sign, a factor."""
    for name, what in PUSHES.items():
        parts = [f.checks[name] for f in found if name in f.checks]
        if name not in failed or not parts:
            continue
        logged, own, size, rows = _joined(parts)
        second = np.concatenate([p[4] for p in parts])

        def suspects(
            broken: Floats, logged: Floats = logged, own: Floats = own, second: Floats = second
        ) -> Iterator[Suspect]:
            yield Suspect("that of the second sphere is left out", own - second)
            yield Suspect("that of the second sphere has the other sign", own - 2.0 * second)
            yield Suspect("that of the first sphere is left out", second)
            by = fitted(lambda factor: factor * own, logged, broken)
            yield Suspect(f"it is {by:.6g} times what it should be", by * own, by)

        yield Link(name, what, rows, logged, own, size, suspects)


NUMBERS: dict[str, dict[str, float]] = {
    "normal stiffness of the dry contacts (with the dashpot that follows from it)": {"normal": 1.0, "damping": 0.5},
    "damping of the dry contacts": {"damping": 1.0, "damping_side": 1.0},
    "friction of the dry contacts": {"friction": 1.0},
    "tangential stiffness of the dry contacts": {"tangential": 1.0, "damping_side": 0.5},
    "rolling friction": {"rolling": 1.0},
}
"""What of the dry contacts may have another value: numbers that go with which power of it."""
MODULI = {"youngs_modulus_Pa": "Young's modulus", "poissons_ratio": "Poisson's ratio"}
"""What a body of a Hertz contact is made of."""


def _numbers(
    setup: Setup, found: list[Forces], kind: int, logged: Floats, own: Floats, rows: Floats
) -> Iterator[Suspect]:
    """A number of the dry contacts times a factor: where contacts slide, no force is the same factor times another."""

    def changed(powers: dict[str, float], by: float) -> Floats:
        numbers = {name: getattr(setup.dry, name) * by**power for name, power in powers.items()}
        other = replace(setup, dry=replace(setup.dry, **numbers))
        return own + np.concatenate([_dry(other, f)[kind] - _dry(setup, f)[kind] for f in found])

    for name, powers in NUMBERS.items():
        by = fitted(partial(changed, powers), logged, rows)
        if by > 0.0:
            yield Suspect(f"the {name} is {by:.6g} times what it should be", changed(powers, by), by)
    yield from _moduli(setup, found, kind, logged, own, rows)


def _moduli(
    setup: Setup, found: list[Forces], kind: int, logged: Floats, own: Floats, rows: Floats
) -> Iterator[Suspect]:
    """Young's modulus or Poisson's ratio of one body of the Hertz contacts times a factor; nothing for linear springs."""
    hertz = setup.scene.get("hertz") or {"spheres": []}
    names = [f"class {c['name']}" for c in setup.scene["classes"]]
    bodies: dict[str, tuple[str, int | None]] = {
        name: ("spheres", k) for k, name in enumerate(names[: len(hertz["spheres"])])
    }
    bodies |= {"the walls": ("walls", None)} if setup.scene["walls"] and bodies else {}

    def changed(body: tuple[str, int | None], key: str, by: float) -> Floats:
        other = deepcopy(hertz)
        one = other["walls"] if body[1] is None else other["spheres"][body[1]]
        one[key] *= by
        numbers = dry_contacts({**setup.scene, "hertz": other}, masses(setup.scene))
        return own + np.concatenate([_dry(replace(setup, dry=numbers), f)[kind] - _dry(setup, f)[kind] for f in found])

    for name, body in bodies.items():
        for key, what in MODULI.items():
            value = partial(changed, body, key)
            by = fitted(value, logged, rows)
            if by > 0.0 and by != 1.0:
                yield Suspect(f"the {what} of {name} is {by:.6g} times what it should be", value(by), by)


def _dry(setup: Setup, f: Forces) -> Part:
    """Force and torque of the dry contacts of a window with the numbers of `setup`."""
    t = f.touches
    c = dry.contacts(setup, f.window, t, f.start, f.known)
    return _mean(setup, f, t.k, t.a, t.b, t.wall, c.force(t.n), c.torque_a(t.n), c.torque_b(t.n))


def fitted(value: Callable[[float], Floats], logged: Floats, rows: Floats) -> float:
    """The factor that brings a value closest to what was logged: some steps of Newton's method."""
    by, use = 1.0, rows
    for n in range(8):
        now = value(by)
        if n > 3:  # where a second fault is in some of the records, those that it spares decide
            off = length(logged - now)
            use = rows & (off <= np.median(off[rows]))
        slope = (value(by * (1.0 + 1e-5)) - now)[use] / (1e-5 * by)
        weight = float((slope**2).sum())
        if weight == 0.0:
            break
        by = max(by + float(((logged - now)[use] * slope).sum()) / weight, 0.1 * by)
    return by


def _joined(parts: list[tuple[Any, ...]]) -> tuple[Floats, Floats, Floats, pd.DataFrame]:
    logged, own, size = (np.concatenate([p[k] for p in parts]) for k in range(3))
    return logged, own, size, pd.concat([p[3] for p in parts], ignore_index=True)


def _rows(setup: Setup, f: Forces) -> tuple[Floats, Floats, Floats]:
    """Step and sphere of each record of `newton.law`, and the sphere's mass."""
    k, who = newton.records(setup, f)
    return k, who, f.window.mass[k, who]


def _parts(setup: Setup, f: Forces) -> dict[str, Part]:
    """Force and torque of each part on the spheres of `newton.law`'s records, mean of the step's two ends."""
    t, c, w = f.touches, f.contacts, f.bridges
    zero = np.zeros((len(t.k), 3))
    side_a, side_b = (-arm[:, None] * np.cross(t.n, c.tangential) for arm in (c.arm_a, c.arm_b))
    of_contacts = {
        "the springs of the dry contacts": (c.elastic[:, None] * t.n, zero, zero),
        "the damping of the dry contacts": (c.damping[:, None] * t.n, zero, zero),
        "the friction of the dry contacts": (c.tangential, side_a, side_b),
        "the rolling resistance": (zero, c.rolling, -c.rolling),
    }
    found = {name: _mean(setup, f, t.k, t.a, t.b, t.wall, *value) for name, value in of_contacts.items()}
    if w is not None:
        none = np.zeros((len(w.k), 3))
        ta, tb = w.torques(setup)
        wet = {
            "the capillary force": (-w.capillary[:, None] * w.n * w.acting["capillary"], none, none),
            "the normal viscous force": (w.normal[:, None] * w.n * w.acting["viscous_normal"], none, none),
            "the tangential viscous force": (w.tangential * w.acting["viscous_tangential"], ta, tb),
        }
        wet = {name: tuple(w.weight[:, None] * part for part in parts) for name, parts in wet.items()}
        of_bridges = {name: _mean(setup, f, w.k, w.a, w.b, w.wall, *value) for name, value in wet.items()}
        found |= of_bridges
        for words, mark in (("between spheres", ~w.wall), ("at walls", w.wall)):
            found |= {
                f"{name} {words}": _mean(setup, f, w.k, w.a, w.b, w.wall, *(mark[:, None] * v for v in value))
                for name, value in wet.items()
            }
        force, (_, tb) = w.weight[:, None] * w.force(), w.torques(setup)
        p, alone = np.flatnonzero(~w.wall), np.ones(int((~w.wall).sum()), dtype=bool)
        spin, rest = w.weight[p, None] * tb[p], np.zeros((len(p), 3))
        found[EVERY[2]] = _mean(setup, f, w.k[p], w.b[p], w.b[p], alone, -force[p], spin, rest)
        found[EVERY[0]] = _total(of_bridges)
    found[EVERY[1]] = _total({n: p for n, p in found.items() if n not in EVERY and not n.endswith(KINDS)})
    return found


def _total(parts: dict[str, Part]) -> Part:
    forces, torques = zip(*parts.values(), strict=True)
    return np.sum(forces, axis=0), np.sum(torques, axis=0)


def _mean(
    setup: Setup, f: Forces, k: Floats, a: Floats, b: Floats, wall: Floats, force: Floats, ta: Floats, tb: Floats
) -> Part:
    """Sums over each sphere, mean of the two ends of a step."""
    shape = (len(f.window.steps), len(setup.ids), 3)
    sums, turns, pair = np.zeros(shape), np.zeros(shape), ~wall
    np.add.at(sums, (k, a), force)
    np.add.at(turns, (k, a), ta)
    np.add.at(sums, (k[pair], b[pair]), -force[pair])
    np.add.at(turns, (k[pair], b[pair]), tb[pair])
    at, who, _ = _rows(setup, f)
    return 0.5 * (sums[at, who] + sums[at + 1, who]), 0.5 * (turns[at, who] + turns[at + 1, who])


def _marks(terms: dict[str, Floats]) -> dict[str, Floats]:
    """Records in which a part acts, to say where."""
    return {f"with {name}": length(term) > 0 for name, term in terms.items()}


def _suspects(
    logged: Floats, own: Floats, terms: dict[str, Floats], mass: Floats | None
) -> Callable[[Floats], Iterator[Suspect]]:
    """One factor on one part; a constant acceleration."""

    def suspects(rows: Floats) -> Iterator[Suspect]:
        rest = logged - own
        for name, term in terms.items():
            size = (term**2).sum(axis=1)
            there = rows & (size > 0)
            if name.endswith(KINDS) and _alone(terms, name, rows):
                continue
            f = 1.0 + middle(((rest * term).sum(axis=1)[there]) / size[there])
            if np.isfinite(f):
                yield Suspect(_said(name, f), own + (f - 1.0) * term, f)
        yield from _several(rest, own, terms, rows)
        if mass is not None:
            g = np.median((rest / mass[:, None])[rows], axis=0)
            fault = f"an acceleration of ({g[0]:.4g}, {g[1]:.4g}, {g[2]:.4g}) m/s² acts besides"
            yield Suspect(fault, own + mass[:, None] * g)

    return suspects


def _alone(terms: dict[str, Floats], name: str, rows: Floats) -> bool:
    """Whether the force of this kind of contact is all of it."""
    whole = next(name.removesuffix(kind).strip() for kind in KINDS if name.endswith(kind))
    return bool((terms[name] == terms[whole])[rows].all())


def _several(rest: Floats, own: Floats, terms: dict[str, Floats], rows: Floats) -> Iterator[Suspect]:
    """A factor on each of the two parts that together leave least; forces of one kind of contact stand for their sum."""
    whole = {name.removesuffix(kind).strip() for name in terms for kind in KINDS if name.endswith(kind)}
    some = np.flatnonzero(rows)[:MOST]
    there = [n for n in terms if n not in EVERY and n not in whole and (terms[n][some] ** 2).sum() > 0.0]
    best: tuple[float, tuple[str, ...], Floats] = (np.inf, (), np.zeros(0))
    for pair in combinations(there, 2):
        columns = np.stack([terms[n][some].ravel() for n in pair], axis=1)
        scale = np.sqrt((columns**2).sum(axis=0))
        more, left, *_ = np.linalg.lstsq(columns / scale, rest[some].ravel(), rcond=1e-9)
        if len(left) and left[0] < best[0]:
            best = float(left[0]), pair, more / scale
    if best[1]:
        words = " and ".join(_said(n, 1.0 + f) for n, f in zip(best[1], best[2], strict=True))
        yield Suspect(words, own + sum(f * terms[n] for n, f in zip(best[1], best[2], strict=True)))


def _said(name: str, f: float) -> str:
    if name == EVERY[1] and f > 0:
        return f"{name} is {f:.6g} times what it should be, as if the mass were {1.0 / f:.6g} times its value"
    plain = next((words for value, words in PLAIN.items() if abs(f - value) < 1e-6), None)
    return f"{name}: {plain}" if plain else f"{name} is {f:.6g} times what it should be"


def _shift(logged: Floats, own: Floats) -> Callable[[Floats], Iterator[Suspect]]:
    """Suspect that all values are shifted by the same amount."""

    def suspects(rows: Floats) -> Iterator[Suspect]:
        d = np.median((logged - own)[rows], axis=0)
        yield Suspect(f"it is off by ({d[0]:.3g}, {d[1]:.3g}, {d[2]:.3g}) m", own + d, general=bool(rows.sum() < 3))

    return suspects
