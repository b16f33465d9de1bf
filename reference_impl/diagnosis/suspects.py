"""Errors in formulas that may occur in more than one equation: inputs exchanged, a part omitted, a factor.

Each is one line: a change of the inputs (`CHANGES`), or of one function that the reference's laws call (`PIECES`).
The laws themselves are unchanged. Errors specific to one equation are in contacts.py and liquid.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from reference_impl.diagnosis.diagnosis import Suspect, length
from reference_impl.replay import capillary, laws
from reference_impl.replay.arrays import Floats
from reference_impl.replay.forces import Contacts

Formula = Callable[[Contacts], Floats]


def like_sphere(c: Contacts) -> Contacts:
    """Replace a wall by a sphere of the particle's size."""
    return replace(c, wall=np.zeros_like(c.wall), rj=np.where(c.wall, c.ri, c.rj))


CHANGES: dict[str, Callable[[Contacts], Contacts]] = {
    "a wall is treated as a sphere of the particle's size": like_sphere,
    "a sphere is treated as a wall": lambda c: replace(c, wall=np.ones_like(c.wall)),
    "the radius is halved": lambda c: replace(c, ri=c.ri / 2.0, rj=c.rj / 2.0),
    "the radius is doubled (a diameter)": lambda c: replace(c, ri=c.ri * 2.0, rj=c.rj * 2.0),
    "the radius of i is used for that of the pair": lambda c: replace(c, rj=np.where(c.wall, c.rj, c.ri)),
    "the radius of j is used for that of the pair": lambda c: replace(c, ri=np.where(c.wall, c.ri, c.rj)),
    "the contact angle of i is used on both sides": lambda c: replace(c, tj=c.ti),
    "the contact angle of j is used on both sides": lambda c: replace(c, ti=c.tj),
    "the contact angles are left out": lambda c: replace(c, ti=0.0 * c.ti, tj=0.0 * c.tj),
    "the sum of the contact angles is used for their mean": lambda c: replace(c, ti=c.ti + c.tj, tj=c.ti + c.tj),
    "the contact angles are in degrees": lambda c: replace(c, ti=np.degrees(c.ti), tj=np.degrees(c.tj)),
    "the volume counts twice": lambda c: replace(c, volume=c.volume * 2.0),
    "half the volume counts": lambda c: replace(c, volume=c.volume / 2.0),
    "the volume is in mm³": lambda c: replace(c, volume=c.volume * 1e9),
    "the gap is in mm": lambda c: replace(c, gap=c.gap * 1e3),
    "half the gap counts": lambda c: replace(c, gap=c.gap / 2.0),
    "the gap counts twice": lambda c: replace(c, gap=c.gap * 2.0),
    "the gap is left out": lambda c: replace(c, gap=0.0 * c.gap),
    "S_min is added to the gap": lambda c: replace(c, gap=laws.least_gap(c.gap, c.ri, c.rj, c.wall)),
}
"""Changed inputs of a law of radii, angles, volume and gap."""


def _cosines(times: Callable[[Floats, Floats], Floats]) -> Callable[..., Floats]:
    def limit(ri: Floats, rj: Floats, wall: Floats, ti: Floats, tj: Floats, sigma: float) -> Floats:
        return np.pi * sigma * capillary.limit_radius(ri, rj, wall) * times(ti, tj)

    return limit


def _floor(part: float, added: bool) -> Callable[..., Floats]:
    def gap(s: Floats, ri: Floats, rj: Floats, wall: Floats) -> Floats:
        least = part * laws.harmonic_radius(ri, rj, wall)
        return np.maximum(s, 0.0) + least if added else np.maximum(s, least)

    return gap


PIECES: dict[str, list[tuple[Any, str, Any]]] = {
    "the cosines of the contact angles are multiplied": [
        (capillary, "limit_at_touch", _cosines(lambda ti, tj: np.cos(ti) * np.cos(tj)))
    ],
    "the cosines of the contact angles are multiplied, times 2": [
        (capillary, "limit_at_touch", _cosines(lambda ti, tj: 2.0 * np.cos(ti) * np.cos(tj)))
    ],
    "the cosine of the sum of the contact angles is used": [
        (capillary, "limit_at_touch", _cosines(lambda ti, tj: 2.0 * np.cos(ti + tj)))
    ],
    "S_min is left out": [(laws, "least_gap", lambda s, ri, rj, wall: np.maximum(s, 0.0))],
    "S_min is not added, it is only the lower bound of the gap": [(laws, "least_gap", _floor(1e-3, False))],
    "S_min is ten times as large": [(laws, "least_gap", _floor(1e-2, True))],
    "S_min is a tenth": [(laws, "least_gap", _floor(1e-4, True))],
    "r_eff is used in place of r_red": [(laws, "reduced_radius", laws.harmonic_radius)],
    "r_red is used in place of r_eff": [
        (laws, "harmonic_radius", laws.reduced_radius),
        (capillary, "harmonic_radius", laws.reduced_radius),
    ],
    "the surface-tension term is left out": [(capillary, "_line", lambda r, *_: 0.0 * r)],
    "the neck's term is left out": [(capillary, "limit_at_touch", lambda ri, *_: 0.0 * ri)],
}
"""Changed functions of the reference's own laws: (module, name, replacement)."""


@contextmanager
def exchanged(pieces: list[tuple[Any, str, Any]]) -> Iterator[None]:
    """Replace functions called by the reference's laws."""
    before = [(module, name, getattr(module, name)) for module, name, _ in pieces]
    try:
        for module, name, other in pieces:
            setattr(module, name, other)
        yield
    finally:
        for module, name, was in before:
            setattr(module, name, was)


def formulas(c: Contacts, formula: Formula, names: Mapping[str, Formula], used: str) -> Iterator[Suspect]:
    """Yield every changed input, every exchanged part, every other law of the same kind."""
    with np.errstate(all="ignore"):
        for fault, change in CHANGES.items():
            yield Suspect(fault, formula(change(c)))
        for fault, pieces in PIECES.items():
            with exchanged(pieces):
                value = formula(c)
            yield Suspect(fault, value)
        for name, other in names.items():
            if name != used:
                yield Suspect(f"the law is {name}, not {used}", other(c))


PLAIN = {
    -1.0: "the sign is turned", 0.0: "it is left out", 0.5: "half of it counts", 2.0: "it counts twice",
    1e3: "it is 1000 times too large (mm for m)", 1e-3: "it is 1000 times too small (m for mm)",
}  # fmt: skip
FEW = 3
"""Smallest number of records from which a factor is estimated; any factor fits fewer."""


def factor(logged: Floats, expected: Floats, rows: Floats) -> Iterator[Suspect]:
    """Yield one factor for all records: simple ones by name, any other estimated as the median of logged over expected."""
    for f, fault in PLAIN.items():
        yield Suspect(fault, f * expected, f)
    with np.errstate(all="ignore"):
        along = logged * expected if logged.ndim == 1 else (logged * expected).sum(axis=1)
        ratio = (along / length(expected) ** 2)[rows]
    f = middle(ratio)
    if np.isfinite(f) and not np.isclose(f, list(PLAIN), rtol=1e-9, atol=1e-12).any():
        words = f"{f:.6g}" if abs(f - 1.0) > 1e-6 else f"1 {'+' if f > 1 else '-'} {abs(f - 1.0):.2g}"
        fault = f"it is {words} times what it should be"
        yield Suspect(
            fault if len(ratio) >= FEW else f"single values are wrong ({words} times)", f * expected, f, general=True
        )


def gaps(logged: Floats, gap: Floats, ri: Floats, arm: Floats, rows: Floats) -> Iterator[Suspect]:
    """Yield faults of S = |x_i - x_j| - r_i - r_j; `arm` is r_j, at a wall 0."""
    yield Suspect("a wall is treated as a sphere of the particle's size", gap - np.where(arm == 0.0, ri, 0.0))
    yield Suspect("the radii are left out (distance of the centres)", gap + ri + arm)
    yield Suspect("the radius of j is left out", gap + arm)
    yield Suspect("diameters stand in place of radii", gap - (ri + arm))
    yield Suspect("the radius is halved", gap + 0.5 * (ri + arm))
    yield Suspect("overlaps are cut to zero", np.maximum(gap, 0.0))
    yield from factor(logged, gap, rows)


def middle(values: Floats) -> float:
    """Return the median of the finite values, NaN if there are none."""
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else float("nan")


def fitted(value: Callable[[float], Floats], logged: Floats, rows: Floats, begin: float = 1.0) -> float:
    """Return the factor that brings a value closest to the logged one, by some steps of Newton's method."""
    by, use = begin, rows
    for n in range(8):
        now = value(by)
        if n > 3:  # if some records contain a second fault, fit only the better half
            off = length(logged - now)
            use = rows & (off <= np.median(off[rows]))
        slope = (value(by * (1.0 + 1e-5)) - now)[use] / (1e-5 * by)
        weight = float((slope**2).sum())
        if weight == 0.0:
            break
        by = max(by + float(((logged - now)[use] * slope).sum()) / weight, 0.1 * by)
    return by
