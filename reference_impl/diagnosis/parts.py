"""Forces on each sphere by part and kind of contact, and the description of the residuals of Newton's law."""

from __future__ import annotations

import re

import numpy as np

from reference_impl.diagnosis.diagnosis import length
from reference_impl.diagnosis.residual import alone, follows
from reference_impl.diagnosis.suspects import middle
from reference_impl.motion import newton
from reference_impl.motion.newton import Forces
from reference_impl.motion.touching import Touches
from reference_impl.motion.window import Setup
from reference_impl.replay.arrays import Floats

Part = tuple[Floats, Floats]
"""Force and torque on the sphere of each record."""
EVERY = ("every force of bridges", "every force but weight", "every force of bridges on their second sphere (j)")
"""Sums of the parts before them; a factor on the last corresponds to a wrong mass."""
DRY = "dry contacts"
ALONG, ACROSS = 0.9, 0.1
"""Share of a residual's square along the normal above which it is called normal, and below which tangential."""


def whole(name: str) -> str:
    """Strip the kind of contact from the name of a force."""
    return re.split(r" (?:between|at) ", name)[0]


def rows(setup: Setup, f: Forces) -> tuple[Floats, Floats, Floats]:
    """Return step and sphere of each record of `newton.law`, and the sphere's mass."""
    k, who = newton.records(setup, f)
    return k, who, f.window.mass[k, who]


def kinds(setup: Setup, t: Touches) -> dict[str, Floats]:
    """Return masks of the dry contacts between spheres and at each wall."""
    walls = {f"at {v.name}": t.wall & (t.b >= v.first) & (t.b < v.last) for v in setup.walls}
    every = {"at walls": t.wall} if len(walls) > 1 else {}
    return {"between spheres": ~t.wall, **walls, **every}


def of(setup: Setup, f: Forces) -> dict[str, Part]:
    """Return force and torque of each part on the spheres of `newton.law`'s records, averaged over both ends of the step."""
    t, c, w = f.touches, f.contacts, f.bridges
    zero = np.zeros((len(t.k), 3))
    side_a, side_b = (-arm[:, None] * np.cross(t.n, c.tangential) for arm in (c.arm_a, c.arm_b))
    of_contacts = {
        "the springs of the dry contacts": (c.elastic[:, None] * t.n, zero, zero),
        "the damping of the dry contacts": (c.damping[:, None] * t.n, zero, zero),
        "the friction of the dry contacts": (c.tangential, side_a, side_b),
        "the rolling resistance": (zero, c.rolling, -c.rolling),
    }
    found = {name: mean(setup, f, t.k, t.a, t.b, t.wall, *value) for name, value in of_contacts.items()}
    for words, mark in kinds(setup, t).items():
        found |= {
            f"{name} {words}": mean(setup, f, t.k, t.a, t.b, t.wall, *(mark[:, None] * v for v in value))
            for name, value in of_contacts.items()
        }
    if w is not None:
        none = np.zeros((len(w.k), 3))
        ta, tb = w.torques(setup)
        wet = {
            "the capillary force": (-w.capillary[:, None] * w.n * w.acting["capillary"], none, none),
            "the normal viscous force": (w.normal[:, None] * w.n * w.acting["viscous_normal"], none, none),
            "the tangential viscous force": (w.tangential * w.acting["viscous_tangential"], ta, tb),
        }
        wet = {name: tuple(w.weight[:, None] * part for part in parts) for name, parts in wet.items()}
        of_bridges = {name: mean(setup, f, w.k, w.a, w.b, w.wall, *value) for name, value in wet.items()}
        found |= of_bridges
        for words, mark in (("between spheres", ~w.wall), ("at walls", w.wall)):
            found |= {
                f"{name} {words}": mean(setup, f, w.k, w.a, w.b, w.wall, *(mark[:, None] * v for v in value))
                for name, value in wet.items()
            }
        force, (_, tb) = w.weight[:, None] * w.force(), w.torques(setup)
        p, alone = np.flatnonzero(~w.wall), np.ones(int((~w.wall).sum()), dtype=bool)
        spin, rest = w.weight[p, None] * tb[p], np.zeros((len(p), 3))
        found[EVERY[2]] = mean(setup, f, w.k[p], w.b[p], w.b[p], alone, -force[p], spin, rest)
        found[EVERY[0]] = _total(of_bridges)
    found[EVERY[1]] = _total({n: p for n, p in found.items() if n not in EVERY and whole(n) == n})
    return found


def _total(parts: dict[str, Part]) -> Part:
    forces, torques = zip(*parts.values(), strict=True)
    return np.sum(forces, axis=0), np.sum(torques, axis=0)


def mean(
    setup: Setup, f: Forces, k: Floats, a: Floats, b: Floats, wall: Floats, force: Floats, ta: Floats, tb: Floats
) -> Part:
    """Sum over each sphere, averaged over both ends of a step."""
    shape = (len(f.window.steps), len(setup.ids), 3)
    sums, turns, pair = np.zeros(shape), np.zeros(shape), ~wall
    np.add.at(sums, (k, a), force)
    np.add.at(turns, (k, a), ta)
    np.add.at(sums, (k[pair], b[pair]), -force[pair])
    np.add.at(turns, (k[pair], b[pair]), tb[pair])
    at, who, _ = rows(setup, f)
    return 0.5 * (sums[at, who] + sums[at + 1, who]), 0.5 * (turns[at, who] + turns[at + 1, who])


def normals(setup: Setup, found: list[dict[str, Part]]) -> dict[str, str]:
    """Kind of contact -> the part along its normal, of those kinds of which there is a contact."""
    words = ("between spheres", *(f"at {v.name}" for v in setup.walls), "at walls")
    names = {f"{DRY} {w}": f"the springs of the dry contacts {w}" for w in words}
    for w in ("between spheres", "at walls"):
        names[f"bridges {w}"] = f"the capillary force {w}"
    names |= {DRY: "the springs of the dry contacts", "bridges": "the capillary force"}
    return {what: n for what, n in names.items() if all(n in p for p in found) and any(p[n][0].any() for p in found)}


def kind(normals: dict[str, Floats], broken: Floats) -> str:
    """The kind of contact whose spheres fit the broken records best, of those that all have if there are some; nothing where a
    tenth of them has no such contact.
    """
    there = {name: length(n) > 0.0 for name, n in normals.items()}
    fits = {name: (at & broken).sum() / (at | broken).sum() for name, at in there.items()}
    best = max(fits, key=lambda name: ((there[name] | ~broken).all(), fits[name]), default="")
    return best if best and (there[best] & broken).sum() >= 0.9 * broken.sum() else ""


def described(rest: Floats, size: Floats, terms: dict[str, Floats], normals: dict[str, Floats], broken: Floats) -> str:
    """Describe a residual: its size, kind of contact, whether it is along the normal, and which force it follows by which factor.

    `size`: sum of the forces' sizes; `terms`: the forces by name in the broken records; `normals`: kind of contact -> a force
    along its normal in all records; `broken`: which of them are.
    """
    by = middle(length(rest) / size)
    words, use = [], {name: term for name, term in terms.items() if name not in EVERY}
    if at := kind(normals, broken):
        n = normals[at][broken]
        with np.errstate(all="ignore"):
            along = float(np.nanmedian(((rest * n).sum(axis=1) / length(n) / length(rest)) ** 2))
        way = "along" if along > ALONG else "across" if along < ACROSS else "aslant to"
        words.append(f"it is off {way} the normal of the {at}{alone(rest)}")
        dry = at.startswith(DRY)
        where = at.removeprefix(DRY).removeprefix("bridges")
        here = {n for n in use if (n.endswith(where) if where else whole(n) == n) and dry == ("force" not in n)}
        use = {n: term for n, term in use.items() if n in here}
    if share := follows(rest, use, 0.5):
        words.append(share)
    elif use:
        words.append("no single force times a factor gives half of it")
    return "; ".join([*(words or ["it is off where there is no contact"]), f"by {by:.2g} of the forces in the median"])
