"""Typical errors between a log and its presentation: axes exchanged, signs reversed, units, another time."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations, product

import numpy as np

from reference_impl.diagnosis.diagnosis import Suspect
from reference_impl.replay.arrays import Floats

UNITS = {1e3: "mm for m", 1e-3: "m for mm", 1e6: "µm for m", 1e9: "mm³ for m³"}


def suspects(shown: Floats, expected: Floats, broken: Floats) -> Iterator[Suspect]:
    """Yield values as they would be shown with one fault, given shown and expected values, and the rows that disagree."""
    yield Suspect("it is not in the file", np.where(np.isnan(shown), shown, np.inf), general=True)
    if expected.ndim == 2:
        yield from _axes(expected)
    for factor, name in (
        (2.0, "twice the value (a diameter for a radius)"),
        (0.5, "half the value"),
        (-1.0, "the sign is turned"),
    ):
        yield Suspect(name, factor * expected)
    yield Suspect("it is zero", 0.0 * expected)
    yield Suspect("yes and no are exchanged", 1.0 - expected, general=True)
    yield from _moved(shown, expected, broken)


def _axes(expected: Floats) -> Iterator[Suspect]:
    """Test whether components are exchanged, or one has its sign changed or is missing."""
    for order in permutations(range(3)):
        if order != (0, 1, 2):
            moved = [k for k in range(3) if order[k] != k]
            names = " and ".join("xyz"[k] for k in moved)
            yield Suspect(f"components {names} are exchanged", expected[:, order])
    for k, (factor, name) in product(range(3), ((-1.0, "has the other sign"), (0.0, "is lost"))):
        sign = np.ones(3)
        sign[k] = factor
        yield Suspect(f"component {'xyz'[k]} {name}", expected * sign)


def _moved(shown: Floats, expected: Floats, broken: Floats) -> Iterator[Suspect]:
    """Test whether values are multiplied by one factor, shifted by one number, or assigned to other rows."""
    with np.errstate(all="ignore"):
        ratio = np.median((shown[broken] / expected[broken])[np.abs(expected[broken]) > 0])
        unit = next((f" ({name})" for value, name in UNITS.items() if abs(ratio / value - 1.0) < 1e-9), "")
        yield Suspect(f"it is {ratio:.9g} times what it should be{unit}", ratio * expected, float(ratio))
    by = np.atleast_1d(np.median(shown[broken] - expected[broken], axis=0))
    by = np.where(np.abs(by) > 1e-9 * np.abs(by).max(), by, 0.0)  # components changed by round-off only
    words = ", ".join(f"{v:.6g}" for v in by)
    yield Suspect(f"it is moved by {words}", expected + by)
    for rows, name in ((1, "the row before"), (-1, "the row after")):
        yield Suspect(f"it is that of {name}", np.roll(expected, rows, axis=0))
    yield Suspect("the order of rows is turned", expected[::-1])
