"""Definition of a collision: spheres, films, liquid, contact, and the scales of the solution; any consistent units."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field

from pywet.collisions.spheres.state import System
from pywet.errors import PywetError

MOST_SPHERES = 60
"""Largest number of spheres, since every pair is checked in every step."""
LEAST, MOST = 1e-30, 1e12
"""Range of numbers, in SI units or of order one, whose squares and quotients stay within double precision."""


def _sized(value: float) -> float:
    if value != 0.0 and not LEAST <= abs(value) <= MOST:
        raise ValueError(f"0 or a number of size {LEAST:g} to {MOST:g}")
    return value


Number = Annotated[float, AfterValidator(_sized)]
Positive = Annotated[Number, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[Number, Field(ge=0, allow_inf_nan=False)]


@dataclass(frozen=True)
class Problem:
    """Spheres in a plane and the liquid between them; any consistent units.

    Shapes: radius, mass, omega (n,); position, velocity (n, 2). `film` is the gap at which the films of a pair
    touch, δ_i + δ_j, and `gap` contains gaps that are more accurate than differences of positions; both by pair
    (i, j), i < j, from 0.
    """

    radius: np.ndarray
    mass: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    omega: np.ndarray
    film: dict[tuple[int, int], float]
    viscosity: float
    surface_tension: float
    h_min: float
    e_dry: float
    mu_f: float
    t_end: float
    gravity: tuple[float, float] = (0.0, 0.0)
    gap: dict[tuple[int, int], float] = field(default_factory=dict)
    rtol: float = 1e-9
    speed: float | None = None
    """Reference of the rest speed; by default the largest initial normal approach of a pair whose paths cross."""
    reference_speed: float | None = None
    """Reference speed of e_wet, by default `speed`. No result but e_wet depends on it."""
    rest_speed: float = 1e-5
    """Rebound speed, over `speed`, below which a compressed contact comes to rest."""
    slip_scale: float = 1e-3
    """Slip, times `speed`, over which the friction of resting contacts builds up."""

    def __post_init__(self) -> None:
        check(self)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Return all pairs (i, j), i < j."""
        n = len(self.radius)
        return [(i, j) for i in range(n) for j in range(i + 1, n)]

    def gap_of(self, i: int, j: int) -> float:
        """Return the initial gap of a pair."""
        apart = float(np.hypot(*(self.position[j] - self.position[i])))
        return self.gap.get((i, j), apart - float(self.radius[i] + self.radius[j]))

    def with_(self, **changes: object) -> Problem:
        """Return a copy of the problem with some entries changed."""
        return replace(self, **changes)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Scales:
    """Units in which the equations are solved: length (largest film gap), speed, mass (smallest)."""

    length: float
    speed: float
    mass: float

    @property
    def time(self) -> float:
        """Scale of time: length over speed."""
        return self.length / self.speed

    @property
    def energy(self) -> float:
        """Scale of energy: mass times speed squared."""
        return self.mass * self.speed**2


def approach_speed(problem: Problem) -> float:
    """Return the largest normal speed at which a pair meets if undeflected (touching films count); 0 if none does."""
    best = 0.0
    for i, j in problem.pairs:
        d = problem.position[j] - problem.position[i]
        v = problem.velocity[i] - problem.velocity[j]
        reach, v2, along = float(problem.radius[i] + problem.radius[j] + problem.film[i, j]), float(v @ v), float(v @ d)
        if along <= 0.0 or v2 == 0.0:
            continue
        if float(np.hypot(*d)) <= reach * (1 + 1e-12):
            best = max(best, along / float(np.hypot(*d)))
        else:
            miss2 = float(d @ d) - along**2 / v2
            best = max(best, math.sqrt(max(v2 * (1.0 - miss2 / reach**2), 0.0)))
    return best


def scales(problem: Problem) -> Scales:
    """Return the scales of a problem.

    If no pair approaches, the speed is that which capillarity or gravity causes over a film's thickness.
    """
    length = max(problem.film.values())
    mass = float(problem.mass.min())
    speed = problem.speed or approach_speed(problem)
    if speed == 0.0:
        a = 0.5 * float(problem.radius.min())
        pull = 8.0 * math.pi * a * problem.surface_tension / mass + math.hypot(*problem.gravity)
        speed = max(math.sqrt(pull * length), float(np.abs(problem.velocity).max()))
        speed = speed or float(np.abs(problem.omega).max() * problem.radius.max()) or 1.0
    return Scales(length, speed, mass)


def system(problem: Problem, unit: Scales, polar: bool) -> System:
    """Return the constants of the equations in the scales `unit`."""
    pairs = problem.pairs
    first, second = (np.array([p[k] for p in pairs], dtype=np.int64) for k in (0, 1))
    radius = problem.radius / unit.length
    reduced = radius[first] * radius[second] / (radius[first] + radius[second])
    viscosity = problem.viscosity * unit.length**2 / (unit.mass * unit.speed)
    tension = problem.surface_tension * unit.length**2 / unit.energy
    g = np.array(problem.gravity) * unit.time / unit.speed
    return System(
        radius=radius,
        mass=problem.mass / unit.mass,
        first=first,
        second=second,
        film=np.array([problem.film[p] for p in pairs]) / unit.length,
        normal=6.0 * np.pi * viscosity * reduced**2,
        tangential=2.0 * np.pi * viscosity * reduced,
        capillary=8.0 * np.pi * tension * reduced,
        h_min=problem.h_min / unit.length,
        e_dry=float(problem.e_dry),
        mu_f=float(problem.mu_f),
        slip_scale=float(problem.slip_scale),
        gx=float(g[0]),
        gy=float(g[1]),
        polar=polar,
    )


def refuse(condition: bool, what: str, key: str, code: str = "spheres.value") -> None:
    """Raise a `PywetError` where a condition on the input is not met."""
    if not condition:
        raise PywetError(what, code=code, key=key)


def check(problem: Problem) -> None:
    """Refuse in one sentence what the model cannot describe."""
    n = len(problem.radius)
    refuse(
        2 <= n <= MOST_SPHERES, f"{n} spheres were given; expected 2 to {MOST_SPHERES}", "spheres", code="spheres.count"
    )
    numbers = np.concatenate(
        [x.ravel() for x in (problem.radius, problem.mass, problem.position, problem.velocity, problem.omega)]
    )
    finite = bool(np.isfinite(numbers).all())
    what = "radii, masses, positions and velocities hold a value that is not finite; expected numbers"
    refuse(finite, what, "spheres", code="spheres.not_finite")
    for name, value in (("radii", problem.radius.min()), ("masses", problem.mass.min())):
        refuse(value > 0.0, f"the {name} hold {value:g}; expected positive numbers", name)
    for name in ("viscosity", "h_min", "t_end"):
        value = getattr(problem, name)
        refuse(math.isfinite(value) and value > 0.0, f"{name} is {value:g}; expected a positive number", name)
    refuse(
        problem.surface_tension >= 0.0,
        f"surface_tension is {problem.surface_tension:g}; expected 0 or more",
        "surface_tension",
    )
    refuse(0.0 < problem.e_dry <= 1.0, f"e_dry is {problem.e_dry:g}; expected more than 0 and at most 1", "e_dry")
    refuse(problem.mu_f >= 0.0, f"mu_f is {problem.mu_f:g}; expected 0 or more", "mu_f")
    refuse(1e-12 <= problem.rtol <= 1e-2, f"rtol is {problem.rtol:g}; expected 1e-12 to 1e-2", "rtol")
    for i, j in problem.pairs:
        gap, film = problem.gap_of(i, j), problem.film[i, j]
        name = f"spheres {i + 1} and {j + 1}"
        refuse(
            film > problem.h_min,
            f"the films of {name} touch at a gap of {film:g}, not above h_min = {problem.h_min:g}; "
            "expected thicker films or a smaller h_min",
            name,
            code="spheres.thin_films",
        )
        refuse(
            gap >= problem.h_min * (1.0 - 1e-9),
            f"{name} start with a gap of {gap:g}; expected at least h_min = {problem.h_min:g}: move them apart",
            name,
            code="spheres.close",
        )
        refuse(
            film < min(problem.radius[i], problem.radius[j]),
            f"the films of {name} together are {film:g} thick; expected less than the smaller radius (thin films)",
            name,
            code="spheres.thick_films",
        )
