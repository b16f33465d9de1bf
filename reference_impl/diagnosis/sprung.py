"""Diagnosis of the tangential displacements of dry contacts: the initial one of a step, and contacts that are not logged."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.diagnosis.diagnosis import Link, Suspect, length
from reference_impl.motion import dry, newton
from reference_impl.motion.newton import Forces
from reference_impl.motion.window import Setup
from reference_impl.replay.arrays import Floats


def links(setup: Setup, found: list[Forces], failed: list[str]) -> Iterator[Link]:
    """Yield springs and contacts of the log that are beyond their limits."""
    for name, what in (
        ("contact_spring", "tangential spring of a dry contact"),
        ("contact_logged", "dry contact in the log"),
    ):
        if name not in failed:
            continue
        logged, expected, size, tables = zip(*(f.checks[name] for f in found), strict=True)
        rows = pd.concat(tables, ignore_index=True)
        wall, b = rows["wall"].to_numpy(bool), rows["b"].to_numpy()
        marks = {"between spheres": ~wall} | {f"at {v.name}": wall & (b >= v.first) & (b < v.last) for v in setup.walls}
        one, two, scale = (np.concatenate(v) for v in (logged, expected, size))

        def suspects(
            broken: Floats, name: str = name, one: Floats = one, two: Floats = two, marks: Any = marks
        ) -> Iterator[Suspect]:
            if name == "contact_logged":
                # otherwise the row is of a pair without contact
                if any((mark == broken).all() for mark in marks.values()):
                    yield Suspect("it is left out", 0.0 * two)
                return
            fresh, after, before = (
                np.concatenate([_moved(setup, f, of(f)) for f in found])
                for of in (lambda f: np.zeros_like(f.start), partial(_other, by=-1), partial(_other, by=1))
            )
            yield Suspect("it starts from zero, without that of the step before", fresh)
            nearer = length(one - after) < length(one - before)
            yield Suspect("it continues from that of another contact", np.where(nearer[:, None], after, before))

        yield Link(name, what, rows, one, two, scale, suspects, newton.SCALES[name][1], marks=marks)


def _moved(setup: Setup, f: Forces, start: Floats) -> Floats:
    """Return the recomputed springs of the contacts, had they started from others."""
    known = np.asarray(f.known, dtype=bool)
    return dry.contacts(setup, f.window, f.touches, np.where(known[:, None], f.start, start), known).spring[~known]


def _other(f: Forces, by: int) -> Floats:
    """Return, for contacts with a wall that started from a spring, the spring of the next contact in its step."""
    start, t = f.start.copy(), f.touches
    had = (f.start != 0.0).any(axis=1) & ~np.asarray(f.known, dtype=bool)
    for k in np.unique(t.k[had]):
        at = np.flatnonzero(had & t.wall & (t.k == k))
        at = at[np.lexsort((t.b[at], t.a[at]))]
        start[at] = np.roll(f.start[at], by, axis=0)
    return start
