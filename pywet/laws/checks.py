"""Checks of `pywet laws --check NAME`: sign, dimensions, symmetry, continuity, limits, and the exact bridge.

Sign and finiteness are checked on the probe grid, as before every run. The others are evaluated on bridges between
equal spheres, unequal spheres, and a sphere and a wall. The deviation from the exact bridge is a result, not an
error.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from pywet.errors import LawError
from pywet.laws import custom_laws, exact_bridge, registry
from pywet.laws.force_law import ForceLaw
from pywet.laws.kinds import KINDS
from pywet.util.notices import notice

PAIRS = {"equal spheres": (1e-3, 1e-3), "unequal spheres": (1e-3, 3e-3), "sphere and wall": (1e-3, math.inf)}
VOLUMES = (1e-3, 1e-2, 1e-1)
"""Volumes V/r_i³ of the tested bridges."""
ANGLE = math.radians(20.0)
SHARES = (0.0, 0.1, 0.3, 0.6, 0.9)
"""Gap over the exact rupture distance."""
LIQUID: dict[str, float] = {
    "surface_tension": 0.0728, "viscosity": 1e-3, "normal_velocity": 0.1, "speed": 0.1, "acceleration": 100.0,
    "density": 1000.0, "contact_angle_i": ANGLE, "contact_angle_j": ANGLE, "half_width": 5e-4, "film_thickness": 2e-5,
    "film_volume_i": 2e-10, "volume": 1e-11, "separation": 2e-5,
}  # fmt: skip
UNITS = {  # powers of metre, second and kilogram
    "separation": (1, 0, 0), "volume": (3, 0, 0), "film_volume_i": (3, 0, 0), "radius_i": (1, 0, 0), "radius_j": (1, 0, 0),
    "half_width": (1, 0, 0), "film_thickness": (1, 0, 0), "contact_angle_i": (0, 0, 0), "contact_angle_j": (0, 0, 0),
    "surface_tension": (0, -2, 1), "viscosity": (-1, -1, 1), "normal_velocity": (1, -1, 0), "speed": (1, -1, 0),
    "acceleration": (1, -2, 0), "density": (-3, 0, 1),
}  # fmt: skip
RESULT = {
    "capillary": ((1, -2, 1),), "viscous_normal": ((1, -2, 1),), "viscous_tangential": ((0, -1, 1), (0, -1, 1)),
    "rupture": ((1, 0, 0),), "dynamic_rupture": ((0, 0, 0),), "formation": ((3, 0, 0),) * 4,
    "shedding": ((3, 0, 0), (0, 1, 0)),
}  # fmt: skip
OTHER_UNITS = np.array([0.1, 3.0, 0.7])
"""Units of length, time and mass in which a law must give the same quantity as in SI units."""
ROUND_OFF = 1e-6
"""Relative difference, between two systems of units or two exchanged bodies, that is attributed to rounding."""
FLAT = 1e6
"""Radius over that of the other body of a sphere that is as good as a wall."""
STEPS = 400
"""Number of gaps between touch and the longest bridge at which continuity is tested."""
JUMP = 0.5
"""Share of a step's height that remains if it is divided into ten smaller ones, above which it is a jump."""
VISIBLE = 1e-3
"""Smallest height of a jump over the largest value that counts."""
OTHER_UNIT = 100.0
"""Factor from its limit beyond which a force is taken for one in another unit."""


@dataclass(frozen=True)
class Finding:
    """One check: what was tested, its result, and whether it passed; None: a value without a limit."""

    check: str
    found: str
    ok: bool | None


@dataclass(frozen=True)
class Compared:
    """Value of a law and of the exact bridge for one bridge; gap [m], None for a rupture distance."""

    bodies: str
    reduced_volume: float
    gap_m: float | None
    value: float
    exact: float

    @property
    def deviation(self) -> float:
        return self.value / self.exact - 1.0


def kind_of(name: str) -> str:
    """Return the kind of a law: of a custom law from its arguments, of a built-in one from the registry."""
    if custom_laws.is_custom(name):
        return custom_laws.kind_of(name)
    for kind in KINDS:
        if name in registry.names(kind) and KINDS[kind].parts:
            return kind
    raise LawError(
        f"there is no law {name}; expected FILE:NAME or one that `pywet laws` lists", law=name, code="law.unknown"
    )


def findings(kind: str, name: str) -> list[Finding]:
    """Run all checks of a law; a law that fails on the probe grid has only that finding.

    Built-in laws that read tables are not evaluated on the grid, each of whose contact angles would need one.
    """
    try:
        functions = registry.get(kind, name).functions
        tabulated = any(law.tabulated for law in functions)
        if not tabulated:
            registry.checked(kind, name, functions)
    except LawError as error:
        return [Finding("sign and finite values", str(error), False)]
    found = [] if tabulated else [Finding("sign and finite values", "as expected on the probe grid", True)]
    for law, unit in zip(functions, RESULT[kind], strict=True):
        found += [_dimensions(law, unit), *_continuity(law)]
    if kind in ("capillary", "rupture", "viscous_normal"):
        found += [_symmetry(functions[0]), _wall(functions[0])]
    if kind == "capillary":
        found.append(_limit(functions[0]))
    if kind == "viscous_normal":
        found.append(_linear(functions[0]))
    return found


def warn(kind: str, name: str) -> None:
    """Warn once of each check that a custom law fails although it is finite and of the right sign, which is required."""
    _warn(kind, name, custom_laws.digest(name))


@cache
def _warn(kind: str, name: str, digest: str) -> None:
    for finding in findings(kind, name):
        if finding.ok is False:
            notice.warning("law %s: WRONG %s: %s (pywet laws --check %s)", name, finding.check, finding.found, name)


def compared(kind: str, name: str) -> Iterator[Compared]:
    """Yield the law compared with the exact bridge, if that has such a quantity: forces over the gap, rupture distances."""
    if kind not in ("capillary", "rupture"):
        return
    law = registry.get(kind, name).functions[0]
    for bodies, (r_i, r_j) in PAIRS.items():
        for reduced in VOLUMES:
            bridge = (reduced * r_i**3, r_i, r_j, ANGLE, ANGLE)
            longest = exact_bridge.rupture(*bridge).separation
            if kind == "rupture":
                yield Compared(bodies, reduced, None, law(*bridge), longest)
                continue
            gaps, sigma = [share * longest for share in SHARES], LIQUID["surface_tension"]
            for gap, exact in zip(gaps, exact_bridge.solve_many(gaps, *bridge), strict=True):
                if exact is not None:
                    yield Compared(bodies, reduced, gap, law(gap, *bridge, sigma), exact.force(sigma))


def judged(kind: str, rows: Sequence[Compared]) -> list[str]:
    """Return a description of the compared bridges and the verdict: the typical and the largest deviation."""
    r = 1e3 * np.array([pair for pair in PAIRS.values()])
    radii = "; ".join(
        f"{name} {r_i:g} mm" + (f" and {r_j:g} mm" if name == "unequal spheres" else "")
        for name, (r_i, r_j) in zip(PAIRS, r, strict=True)
    )
    tension = f", surface tension {LIQUID['surface_tension']:g} N/m" if kind == "capillary" else ""
    off = np.array([abs(row.deviation) for row in rows])
    worst = rows[int(off.argmax())]
    gap = "" if worst.gap_m is None else f", gap {1e6 * worst.gap_m:.4g} µm"
    of = "force" if kind == "capillary" else "rupture distance"
    return [
        f"radii: {radii}; both contact angles {math.degrees(ANGLE):g}°{tension}",
        f"verdict: passes the checks; {of} within {100 * float(np.median(off)):.2g} % of the exact bridge in half of the "
        f"{len(rows)} bridges, {100 * worst.deviation:+.2g} % at worst ({worst.bodies}, V/r³ {worst.reduced_volume:g}{gap})",
    ]


def _at(law: ForceLaw, bodies: str = "equal spheres", **given: Any) -> dict[str, Any]:
    r_i, r_j = PAIRS[bodies]
    known = {**LIQUID, "radius_i": r_i, "radius_j": r_j, **given}
    return {name: known[name] for name in law.arguments}


def _off(value: float, expected: float) -> float:
    """Return the relative difference; zero for two zeros."""
    return 0.0 if value == expected else abs(value - expected) / max(abs(expected), 1e-300)


def _dimensions(law: ForceLaw, unit: tuple[int, int, int]) -> Finding:
    """Check that a quantity does not depend on the system of units."""
    worst = 0.0
    for bodies in PAIRS:
        here = _at(law, bodies)
        there = {name: value * float(np.prod(OTHER_UNITS ** np.array(UNITS[name]))) for name, value in here.items()}
        worst = max(worst, _off(law(**there) / float(np.prod(OTHER_UNITS ** np.array(unit))), law(**here)))
    return Finding(f"{law.name}: dimensions", f"changes by {worst:.1g} with the units", worst < ROUND_OFF)


def _continuity(law: ForceLaw) -> Iterator[Finding]:
    """Find jumps over the first argument: a step of a continuous law becomes smaller when it is divided."""
    first = law.arguments[0]
    for bodies in PAIRS if "radius_j" in law.arguments else ("equal spheres",):
        at = _at(law, bodies)
        top = exact_bridge.rupture(LIQUID["volume"], *PAIRS[bodies], ANGLE, ANGLE).separation
        low, high = (-0.02 * top, 0.95 * top) if first == "separation" else (0.5 * at[first], 2.0 * at[first])

        def values(low: float, high: float, count: int, at: dict[str, Any] = at) -> tuple[np.ndarray, np.ndarray]:
            places = np.linspace(low, high, count + 1)
            return places, np.asarray(law(**{**at, first: places}), dtype=float)

        places, drawn = values(low, high, STEPS)
        k = int(np.argmax(np.abs(np.diff(drawn))))
        height = abs(float(np.diff(drawn)[k]))
        finer = float(np.abs(np.diff(values(places[k], places[k + 1], 10)[1])).max())
        share = height / max(float(np.abs(drawn).max()), 1e-300)
        jumps = share > VISIBLE and finer > JUMP * height
        text = f"{bodies}: jumps by {100 * share:.2g} % at {first} {places[k]:.4g}" if jumps else f"{bodies}: no jump"
        yield Finding(f"{law.name}: continuity over {first}", text, not jumps)


def _symmetry(law: ForceLaw) -> Finding:
    """Check that the exchange of the two spheres changes nothing."""
    at = _at(law, "unequal spheres", contact_angle_i=0.2, contact_angle_j=0.5)
    other = {
        **at,
        **{f"{n}_{a}": at[f"{n}_{b}"] for n in ("radius", "contact_angle") for a, b in ("ij", "ji") if f"{n}_i" in at},
    }
    off = _off(law(**other), law(**at))
    return Finding(f"{law.name}: exchange of the two bodies", f"changes by {off:.1g}", off < ROUND_OFF)


def _limit(law: ForceLaw) -> Finding:
    """Check that two touching spheres with little liquid attract each other with 4π σ r_red cos θ (Derjaguin)."""
    at = _at(law, volume=1e-9 * PAIRS["equal spheres"][0] ** 3, separation=0.0)
    expected = 4.0 * math.pi * LIQUID["surface_tension"] * 0.5 * PAIRS["equal spheres"][0] * math.cos(ANGLE)
    share = law(**at) / expected
    return Finding(
        f"{law.name}: little liquid, at touch",
        f"{share:.3g} of 4π σ r_red cos θ",
        None if 1.0 / OTHER_UNIT < share < OTHER_UNIT else False,
    )


def _wall(law: ForceLaw) -> Finding:
    """Compare a wall (`radius_j` infinite) with a sphere `FLAT` times as large as the other: a wrong radius at walls shows."""
    wall, sphere = (
        law(**_at(law, "sphere and wall", radius_j=r)) for r in (math.inf, FLAT * PAIRS["sphere and wall"][0])
    )
    share = f"{wall / sphere:.3g} of that" if sphere else f"{wall:.3g} in place of that ({sphere:g})"
    return Finding(f"{law.name}: a wall against a very large sphere", share, None)


def _linear(law: ForceLaw) -> Finding:
    """Check that lubrication is proportional to the velocity."""
    off = _off(law(**_at(law, normal_velocity=0.2)), 2.0 * law(**_at(law, normal_velocity=0.1)))
    return Finding(f"{law.name}: proportional to the velocity", f"off by {off:.1g}", None)
