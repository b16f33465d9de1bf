"""Diagnosis by Newton's law: which of the forces on a sphere differs from the reference.

The change of speed (or spin) of each sphere is compared with the sum of its forces; for each force it is tested
whether one factor on it, or a constant acceleration, restores agreement. This is done only if the equations of the
log are satisfied, because a wrong force in the log is wrong here too. See diagnosis.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.diagnosis import dry_numbers, parts, sprung
from reference_impl.diagnosis.diagnosis import Link, Suspect, judge, length
from reference_impl.diagnosis.suspects import PLAIN, fitted, middle
from reference_impl.motion import newton
from reference_impl.motion.newton import Forces
from reference_impl.motion.window import Setup
from reference_impl.replay.arrays import Floats

MOST = 2000
"""Number of records from which factors on two parts are estimated."""


def links(setup: Setup, found: list[Forces], failed: list[str]) -> Iterator[Link]:
    """Yield the laws of motion and the closest points that are beyond their limits."""
    laws = [{**newton.law(setup, f), **(newton.against_log(setup, f) if f.bridges is not None else {})} for f in found]
    if "wall_closest_point" in failed:
        logged, expected, size, rows = _joined(
            [law["wall_closest_point"] for law in laws if "wall_closest_point" in law]
        )
        yield Link(
            "wall_closest_point", "closest point of a wall", rows, logged, expected, size, _shift(logged, expected)
        )
        return  # wrong forces at this point are a consequence
    yield from _pushes(found, failed)
    for link in sprung.links(setup, found, failed):
        # without a cause of its own, a wrong spring is a consequence of wrong forces
        if any(finding.fault for finding in judge(link)):
            yield link
    shares = [parts.of(setup, f) for f in found]
    for name, what, kind in (("newton_force", "force that acts", 0), ("newton_torque", "torque that acts", 1)):
        if name in failed:
            logged, expected, size, rows = _joined([law[name] for law in laws])
            terms = {n: np.concatenate([p[n][kind] for p in shares]) for n in shares[0]}
            normals = {
                what: np.concatenate([p[n][0] for p in shares]) for what, n in parts.normals(setup, shares).items()
            }
            weight = np.concatenate([parts.rows(setup, f)[2] for f in found])
            of_terms = _suspects(logged, expected, terms, weight if kind == 0 else None)

            def suspects(
                broken: Floats,
                kind: int = kind,
                logged: Floats = logged,
                expected: Floats = expected,
                of_terms: Any = of_terms,
                normals: Any = normals,
            ) -> Iterator[Suspect]:
                _, _, at = parts.kind(normals, broken).partition(f"{parts.DRY} ")
                yield from dry_numbers.suspects(setup, found, kind, logged, expected, broken, at)
                yield from of_terms(broken)

            def says(
                broken: Floats,
                off: Floats = logged - expected,
                size: Floats = size,
                terms: dict[str, Floats] = terms,
                normals: Any = normals,
            ) -> str:
                here = {n: term[broken] for n, term in terms.items()}
                return parts.described(off[broken], size[broken], here, normals, broken)

            marks = {f"where there are {n}": length(normal) > 0 for n, normal in normals.items()}
            yield Link(name, what, rows, logged, expected, size, suspects, newton.limit(setup), marks=marks, says=says)


PUSHES = {
    "window_push": "what other forces change of the speed, as semi-implicit drag takes it",
    "window_spin_push": "what other torques change of the spin, as semi-implicit drag takes it",
    "window_sharing": "number of bridges that share a sphere, as semi-implicit drag takes it",
}


def _pushes(found: list[Forces], failed: list[str]) -> Iterator[Link]:
    """Yield links of the forces from which semi-implicit drag starts, if beyond their limits: a term lost, its sign, a factor."""
    for name, what in PUSHES.items():
        checked = [f.checks[name] for f in found if name in f.checks]
        if name not in failed or not checked:
            continue
        logged, expected, size, rows = _joined(checked)
        second = np.concatenate([p[4] for p in checked])

        def suspects(
            broken: Floats, logged: Floats = logged, expected: Floats = expected, second: Floats = second
        ) -> Iterator[Suspect]:
            yield Suspect("that of the second sphere is left out", expected - second)
            yield Suspect("that of the second sphere has the other sign", expected - 2.0 * second)
            yield Suspect("that of the first sphere is left out", second)
            by = fitted(lambda factor: factor * expected, logged, broken)
            yield Suspect(f"it is {by:.6g} times what it should be", by * expected, by)

        terms = {"that of the first sphere": expected - second, "that of the second sphere": second}
        yield Link(name, what, rows, logged, expected, size, suspects, terms=terms)


def _joined(laws: list[tuple[Any, ...]]) -> tuple[Floats, Floats, Floats, pd.DataFrame]:
    logged, expected, size = (np.concatenate([p[k] for p in laws]) for k in range(3))
    return logged, expected, size, pd.concat([p[3] for p in laws], ignore_index=True)


def _suspects(
    logged: Floats, expected: Floats, terms: dict[str, Floats], mass: Floats | None
) -> Callable[[Floats], Iterator[Suspect]]:
    """Yield as suspects one factor on one term, and a constant acceleration."""

    def suspects(rows: Floats) -> Iterator[Suspect]:
        rest = logged - expected
        for name, term in terms.items():
            size = (term**2).sum(axis=1)
            there = rows & (size > 0)
            if parts.whole(name) != name and _alone(terms, name, rows):
                continue
            f = 1.0 + middle(((rest * term).sum(axis=1)[there]) / size[there])
            if np.isfinite(f):
                yield Suspect(_text(name, f), expected + (f - 1.0) * term, f)
        yield from _several(rest, expected, terms, rows)
        if mass is not None:
            g = np.median((rest / mass[:, None])[rows], axis=0)
            fault = f"an acceleration of ({g[0]:.4g}, {g[1]:.4g}, {g[2]:.4g}) m/s² acts besides"
            yield Suspect(fault, expected + mass[:, None] * g)

    return suspects


def _alone(terms: dict[str, Floats], name: str, rows: Floats) -> bool:
    """Return whether all force of this name acts at this kind of contact."""
    return bool((terms[name] == terms[parts.whole(name)])[rows].all())


def _several(rest: Floats, expected: Floats, terms: dict[str, Floats], rows: Floats) -> Iterator[Suspect]:
    """Suspect a factor on each of the two parts that together leave the smallest residual; one kind of contact is one part."""
    whole = {parts.whole(name) for name in terms if parts.whole(name) != name}
    some = np.flatnonzero(rows)[:MOST]
    there = [n for n in terms if n not in parts.EVERY and n not in whole and (terms[n][some] ** 2).sum() > 0.0]
    best: tuple[float, tuple[str, ...], Floats] = (np.inf, (), np.zeros(0))
    for pair in combinations(there, 2):
        columns = np.stack([terms[n][some].ravel() for n in pair], axis=1)
        scale = np.sqrt((columns**2).sum(axis=0))
        more, left, *_ = np.linalg.lstsq(columns / scale, rest[some].ravel(), rcond=1e-9)
        if len(left) and left[0] < best[0]:
            best = float(left[0]), pair, more / scale
    if best[1]:
        words = " and ".join(_text(n, 1.0 + f) for n, f in zip(best[1], best[2], strict=True))
        yield Suspect(words, expected + sum(f * terms[n] for n, f in zip(best[1], best[2], strict=True)))


def _text(name: str, f: float) -> str:
    if name == parts.EVERY[1] and f > 0:
        return f"{name} is {f:.6g} times what it should be, as if the mass were {1.0 / f:.6g} times its value"
    plain = next((words for value, words in PLAIN.items() if abs(f - value) < 1e-6), None)
    return f"{name}: {plain}" if plain else f"{name} is {f:.6g} times what it should be"


def _shift(logged: Floats, expected: Floats) -> Callable[[Floats], Iterator[Suspect]]:
    """Suspect that all values are shifted by the same amount."""

    def suspects(rows: Floats) -> Iterator[Suspect]:
        d = np.median((logged - expected)[rows], axis=0)
        yield Suspect(
            f"it is off by ({d[0]:.3g}, {d[1]:.3g}, {d[2]:.3g}) m", expected + d, general=bool(rows.sum() < 3)
        )

    return suspects
