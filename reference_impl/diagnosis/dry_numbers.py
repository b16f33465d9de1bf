"""Diagnosis of the dry contacts' parameters: which of them has another value, for all contacts or for one kind."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import replace
from functools import partial

import numpy as np

from reference_impl.diagnosis import parts
from reference_impl.diagnosis.diagnosis import Suspect, length
from reference_impl.diagnosis.suspects import fitted
from reference_impl.motion import dry
from reference_impl.motion.newton import Forces
from reference_impl.motion.window import Dry, Setup, dry_contacts
from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import masses

NUMBERS: dict[str, dict[str, float]] = {
    "springs of the dry contacts": {"normal": 1.0},
    "damping of the dry contacts": {"damping": 1.0, "damping_side": 1.0},
    "friction of the dry contacts": {"friction": 1.0},
    "tangential stiffness of the dry contacts": {"tangential": 1.0, "damping_side": 0.5},
    "rolling friction": {"rolling": 1.0},
}
"""Parameter of the dry contacts that may have another value -> numbers proportional to a power of it."""
GIVEN = {
    "normal stiffness of the dry contacts (with the dashpot that follows from it)": "normal_stiffness_N_per_m",
    "restitution of the dry contacts": "restitution",
}
"""Parameter from which several numbers follow -> key of a pair in scene.json."""
FROM = (1.0, 0.5, 0.1)
"""Trial values for a parameter that should be zero: no force depends on a friction at which nothing slides."""
MODULI = {"youngs_modulus_Pa": "Young's modulus", "poissons_ratio": "Poisson's ratio"}
"""Material parameters of a Hertz contact."""


def suspects(
    setup: Setup, found: list[Forces], kind: int, logged: Floats, expected: Floats, rows: Floats, at: str
) -> Iterator[Suspect]:
    """Suspect that a parameter of the dry contacts is multiplied by a factor.

    If contacts slide, no force is that factor times another. The parameter is that of all contacts, or only of
    those `at` the wall or `between spheres` that have the residuals.
    """
    for where in dict.fromkeys(("", at)):
        now = np.concatenate([_dry(setup, f, where)[kind] for f in found])

        def changed(of: Callable[[float], Dry], by: float, where: str = where, now: Floats = now) -> Floats:
            other = replace(setup, dry=of(by))
            return expected + np.concatenate([_dry(other, f, where)[kind] for f in found]) - now

        for name, (of, none) in _others(setup).items():
            value = partial(changed, of)
            tried = [fitted(value, logged, rows, begin) for begin in (FROM if none else FROM[:1])]
            off = [float(np.median(length(logged - value(by))[rows])) for by in tried] if none else [0.0]
            by = tried[int(np.argmin(off))]
            if by > 0.0:
                words = f"{by:.6g} where there should be none" if none else f"{by:.6g} times what it should be"
                yield Suspect(f"the {f'{name} {where}'.rstrip()} is {words}", value(by), by)
        if where.startswith("at "):
            still = [replace(f, touches=replace(f.touches, vb=0.0 * f.touches.vb)) for f in found]
            then = np.concatenate([_dry(setup, f, where)[kind] for f in still])
            yield Suspect(f"the wall's velocity does not count {where}", expected + then - now)
    yield from _moduli(setup, found, kind, logged, expected, rows)


def _others(setup: Setup) -> dict[str, tuple[Callable[[float], Dry], bool]]:
    """Return name -> dry contacts with that number times a factor, or with a value if it is zero, and whether it is."""

    def times(powers: dict[str, float], none: bool, by: float) -> Dry:
        numbers = {n: np.full_like(v, by) if none else v * by**power
                   for n, power in powers.items() for v in [getattr(setup.dry, n)]}  # fmt: skip
        return replace(setup.dry, **numbers)

    def given(key: str, by: float) -> Dry:
        pairs = [{**pair, key: pair[key] * by} for pair in setup.scene["pairs"]]
        return dry_contacts({**setup.scene, "pairs": pairs}, masses(setup.scene))

    found: dict[str, tuple[Callable[[float], Dry], bool]] = {}
    for name, powers in NUMBERS.items():
        none = not any(getattr(setup.dry, n).any() for n in powers)
        if not none or len(powers) == 1:
            found[name] = partial(times, powers, none), none
    for name, key in GIVEN.items():
        if all(pair.get(key) for pair in setup.scene["pairs"]) and (key == "restitution" or not setup.dry.power):
            found[name] = partial(given, key), False
    return found


def _moduli(
    setup: Setup, found: list[Forces], kind: int, logged: Floats, expected: Floats, rows: Floats
) -> Iterator[Suspect]:
    """Suspect Young's modulus or Poisson's ratio of one body of the Hertz contacts times a factor; none for linear springs."""
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
        return expected + np.concatenate(
            [_dry(replace(setup, dry=numbers), f)[kind] - _dry(setup, f)[kind] for f in found]
        )

    for name, body in bodies.items():
        for key, what in MODULI.items():
            value = partial(changed, body, key)
            by = fitted(value, logged, rows)
            if by > 0.0 and by != 1.0:
                yield Suspect(f"the {what} of {name} is {by:.6g} times what it should be", value(by), by)


def _dry(setup: Setup, f: Forces, where: str = "") -> parts.Part:
    """Return force and torque of the dry contacts of a window, or of those of one kind, with the numbers of `setup`."""
    t = f.touches
    c = dry.contacts(setup, f.window, t, f.start, f.known)
    some = parts.kinds(setup, t)[where][:, None] if where else np.ones((len(t), 1))
    forces = (some * of for of in (c.force(t.n), c.torque_a(t.n), c.torque_b(t.n)))
    return parts.mean(setup, f, t.k, t.a, t.b, t.wall, *forces)
