"""Random extreme cases: pairs, clusters and walls over the whole range of parameters, fifty in each engine run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pywet.cases.small import small
from pywet.cases.small.bodies import contact, sphere_classes, water
from pywet.cases.small.small import Sphere
from pywet.geometry.solids import plate, square, wire
from pywet.laws.contact import film_thickness
from pywet.scene import Effects, Liquid, SphereClass
from studies.stability import cells
from studies.stability.cells import FCC, Batch, Cell, Part, ball, reduced_mass
from studies.stability.maps import DRAWN

Floats = NDArray[np.float64]
PER_BATCH = 50
KINDS = (
    "approach", "graze", "part", "spin", "touch", "chain", "star", "tetrahedron", "dense", "one film", "no film", "plate", "edge",
    "wire", "between wires", "crossing",
)  # fmt: skip
OTHER_LAWS: tuple[dict[str, str | None], ...] = (
    {"capillary": "willett", "rupture": "willett"},
    {"capillary": "lambert", "rupture": "lian", "viscous_normal": "adams_perchard"},
    {"capillary": "willett_simple", "viscous_tangential": "lian", "dynamic_rupture": None},
    {"capillary": "weigert"},
    {"capillary": "soulie", "rupture": "willett"},
    {"capillary": "rabinovich", "viscous_normal": None},
    {"capillary": None, "viscous_normal": "pitois"},
)
EXACT_ANGLES = ((0.0, 0.0), (0.2, 0.5), (math.pi / 3.0, math.pi / 3.0))
"""Pairs of contact angles of the exact preset: a table is solved for each."""


def log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    """Return a number whose logarithm is uniform."""
    return float(math.exp(random.uniform(math.log(low), math.log(high))))


def direction(random: np.random.Generator) -> Floats:
    """Return a unit vector with uniform distribution of directions."""
    v = random.normal(size=3)
    return np.asarray(v / np.linalg.norm(v))


@dataclass(frozen=True)
class Setting:
    """Properties that are drawn once per batch and shared by its cells."""

    radii: tuple[float, ...]
    speed: float
    random: np.random.Generator

    def film(self, kind: int) -> float:
        """Return a film [m3]: none for one in twelve, else with V* of an equal pair from 1e-9 to 0.5."""
        if self.random.uniform() < 1.0 / 12.0:
            return 0.0
        v_star = log_uniform(self.random, 1e-9, 0.5)
        return v_star / DRAWN * self.radii[kind - 1] ** 3

    def thickness(self, kind: int, film: float) -> float:
        """Return the thickness of a film of that volume [m]."""
        return film_thickness(film, self.radii[kind - 1])

    def gap(self, reach: float) -> float:
        """Return a gap between two spheres: exactly zero for one in five, else within or just beyond the reach of their films."""
        return 0.0 if self.random.uniform() < 0.2 else reach * float(self.random.uniform(0.02, 1.1))

    def fast(self) -> float:
        """Return a speed [m/s], down to a thousandth of the batch's."""
        return self.speed * 10.0 ** float(self.random.uniform(-3.0, 0.0))


def pair(s: Setting, how: str) -> tuple[Sphere, ...]:
    """Return two spheres that approach, graze, separate, spin, or just touch."""
    a, b = (int(k) for k in s.random.integers(1, len(s.radii) + 1, 2))
    film_a, film_b = s.film(a), s.film(b)
    if how == "one film":
        film_b = 0.0
    if how == "no film":
        film_a = film_b = 0.0
    n = direction(s.random)
    gap = 0.0 if how == "touch" else s.gap(s.thickness(a, film_a) + s.thickness(b, film_b))
    at = (s.radii[a - 1] + s.radii[b - 1] + gap) * n
    side = np.cross(n, direction(s.random))
    v = {"approach": -1.0, "part": 1.0, "one film": -1.0, "no film": -1.0, "graze": -0.2}.get(how, 0.0) * s.fast() * n
    if how == "graze":
        v = v + s.fast() * side / np.linalg.norm(side)
    spin = np.zeros((2, 3))
    if how == "spin":
        spin = s.fast() / min(s.radii[a - 1], s.radii[b - 1]) * s.random.normal(size=(2, 3)) / 2.0
    return (
        ball(a, (0.0, 0.0, 0.0), -0.5 * v, spin[0], film_a),
        ball(b, at, 0.5 * v, spin[1], film_b),
    )


def chain(s: Setting) -> tuple[Sphere, ...]:
    """Return three to six spheres in a row, with random velocities."""
    bodies: list[Sphere] = []
    x = 0.0
    for _ in range(int(s.random.integers(3, 7))):
        kind = int(s.random.integers(1, len(s.radii) + 1))
        film, r = s.film(kind), s.radii[kind - 1]
        if bodies:
            last = bodies[-1]
            reach = s.thickness(kind, film) + s.thickness(last.kind, last.film or 0.0)
            x += s.radii[last.kind - 1] + r + s.gap(reach)
        bodies.append(ball(kind, (x, 0.0, 0.0), 0.5 * s.fast() * direction(s.random), (0.0, 0.0, 0.0), film))
    return tuple(bodies)


def star(s: Setting) -> tuple[Sphere, ...]:
    """Return a large sphere among six others that all draw from its film in the first step; some then separate."""
    big, kind = len(s.radii), int(s.random.integers(1, len(s.radii) + 1))
    film, r = s.film(big), s.radii[big - 1] + s.radii[kind - 1]
    v = s.fast()
    bodies = [ball(big, (0.0, 0.0, 0.0), film=film)]
    for axis in range(3):
        for sign in (-1.0, 1.0):
            n = sign * np.eye(3)[axis]
            bodies.append(ball(kind, r * n, v * n, film=s.film(kind) if axis else 0.0))
    return tuple(bodies)


def lattice(s: Setting, how: str) -> tuple[Sphere, ...]:
    """Return equal spheres that touch exactly: a tetrahedron, or thirteen of a face-centred cubic packing."""
    kind = int(s.random.integers(1, len(s.radii) + 1))
    points = ((0, 0, 0), *FCC) if how == "dense" else ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
    side = s.radii[kind - 1] * (math.sqrt(2.0) if how == "dense" else 1.0 / math.sqrt(2.0))
    film = s.film(kind)
    return tuple(
        ball(kind, side * np.array(p), 0.3 * s.fast() * direction(s.random), (0.0, 0.0, 0.0), film) for p in points
    )


def slab(half: float) -> list[Part]:
    """Return a large flat plate with its upper face at z = 0."""
    return [(corners, None) for corners, _ in plate(square(half), -half / 2.0, 0.0)]


def bar(half: float, radius: float, axis: int, offset: float = 0.0) -> Part:
    """Return a wire along x (axis 0) or y (axis 1); those along y are longer and lower, so that no two nodes coincide."""
    start, end = np.zeros(3), np.zeros(3)
    start[axis], end[axis] = -half * (1.0 + 0.07 * axis), half * (1.0 + 0.07 * axis)
    start[2] = end[2] = -0.13 * radius * axis
    start[1 - axis] = end[1 - axis] = offset
    return wire(start, end, radius, 8, 3.0), radius


def at_wall(s: Setting, how: str) -> tuple[tuple[Sphere, ...], tuple[Part, ...]]:
    """Return a sphere at a plate, at its edge, on a wire, or on two or three wires at once."""
    kind = int(s.random.integers(1, len(s.radii) + 1))
    r, film = s.radii[kind - 1], s.film(kind)
    # walls are rounded to single precision, so an exact touch is impossible
    gap = max(s.gap(s.thickness(kind, film)), 1e-4 * r)
    half, thin = 5.0 * r, 0.4 * s.radii[0]
    v = s.fast() * direction(s.random) * [1.0, 1.0, 0.3]
    spin = tuple(s.fast() / r * direction(s.random))
    if how == "plate":
        place, walls = (0.0, 0.0, r + gap), slab(half)
    elif how == "edge":
        place, walls = (half - 0.3 * r, 0.2 * r, r + gap), slab(half)
        v = s.fast() * np.array([1.0, 0.1, -0.1])
    elif how == "wire":
        place, walls = (0.1 * r, 0.0, r + thin + gap), [bar(half, thin, 0)]
    elif how == "crossing":
        place, walls = (0.0, 0.0, r + thin + gap), [bar(half, thin, 0), bar(half, thin, 1), bar(half, thin, 1, 1.5 * r)]
        v = s.fast() * np.array([1.0, 0.2, 0.0])
    else:
        apart = 0.6 * (r + thin)  # the sphere is in the gap between two wires
        height = math.sqrt((r + thin + gap) ** 2 - apart**2)
        place, walls = (0.0, 0.0, height), [bar(half, thin, 0, -apart), bar(half, thin, 0, apart)]
    return (ball(kind, place, v, spin, film),), tuple(walls)


def draw_cell(s: Setting, name: str, how: str) -> Cell:
    walls: tuple[Part, ...] = ()
    if how in ("plate", "edge", "wire", "between wires", "crossing"):
        bodies, walls = at_wall(s, how)
    elif how == "chain":
        bodies = chain(s)
    elif how == "star":
        bodies = star(s)
    elif how in ("tetrahedron", "dense"):
        bodies = lattice(s, how)
    else:
        bodies = pair(s, how)
    fastest = max(float(np.linalg.norm(b.velocity)) for b in bodies)
    films = [(b.film or 0.0) / s.radii[b.kind - 1] ** 3 for b in bodies]
    says: dict[str, Any] = {
        "kind": how, "spheres": len(bodies), "smallest_m": min(s.radii[b.kind - 1] for b in bodies),
        "largest_m": max(s.radii[b.kind - 1] for b in bodies), "fastest_m_per_s": fastest,
        "film_over_r3_low": min(films), "film_over_r3_high": max(films),
    }  # fmt: skip
    return Cell(name, bodies, walls, says)


def laws_of(number: int) -> tuple[str, Effects]:
    """Return the laws of a batch: of eight, four have preset paper, three other laws, one preset exact, whose replay is slow."""
    turn = number % 8
    if turn == 2:
        return "exact", small.EXACT
    if turn in (0, 1, 4, 5):
        return "paper", small.PAPER
    other = OTHER_LAWS[(number // 8 * 3 + (3, 6, 7).index(turn)) % len(OTHER_LAWS)]
    return " ".join(str(v) for v in other.values()), small.PAPER.model_copy(update=other)


def draw_liquid(random: np.random.Generator) -> Liquid:
    """Return a liquid: surface tension 0 to 0.1 N/m, viscosity 0 to 10 Pa s; each exactly zero for one batch in twelve."""
    sigma = 0.0 if random.uniform() < 1.0 / 12.0 else log_uniform(random, 1e-3, 0.1)
    eta = 0.0 if random.uniform() < 1.0 / 12.0 else log_uniform(random, 1e-5, 10.0)
    return water(0.0, eta, sigma)


def stiffness(classes: Sequence[SphereClass], a: int, b: int, speed: float, sigma: float) -> float:
    """Return the stiffness [N/m] for an overlap of 3 % of the smaller radius at the batch's speed, or 1 % under the bridge."""
    one, other = classes[a - 1].radius_m, classes[b - 1].radius_m if b else math.inf
    reduced = one if b == 0 else 2.0 * one * other / (one + other)
    r, m = min(one, other), reduced_mass(classes, a, b)
    return max(m * (speed / (0.03 * r)) ** 2, 2.0 * math.pi * reduced * sigma * 2.0 / (0.01 * r))


def draw_batch(seed: int, number: int, count: int = PER_BATCH) -> Batch:
    """Return batch `number` of the campaign of a seed; the same numbers give the same cases."""
    random = np.random.default_rng([seed, number])
    ratio = log_uniform(random, 1.0, 10.0)
    smallest = log_uniform(random, 20e-6, 10e-3 / ratio)
    radii = (smallest, smallest * ratio)
    preset, effects = laws_of(number)
    angles = tuple(math.radians(a) for a in random.uniform(0.0, 89.0, 3))
    if preset == "exact":
        one, two = EXACT_ANGLES[number // 8 % len(EXACT_ANGLES)]
        angles = (one, two, two)
    liquid = draw_liquid(random)
    speed = log_uniform(random, 1e-3, 5.0)
    spare, e = log_uniform(random, 1.0, 30.0), float(random.choice([1.0, 0.9, 0.6, 0.1]))
    density = [log_uniform(random, 500.0, 8000.0) for _ in radii]
    classes = sphere_classes(*radii, density=density, angle_rad=angles[:2], name="size{k}")
    sigma, both = liquid.surface_tension_N_per_m, ((1, 0), (1, 1), (1, 2), (2, 0), (2, 2))
    pairs = tuple(
        contact(a, b, stiffness(classes, a, b, speed, sigma) * spare, friction=0.3, restitution=e) for a, b in both
    )
    s = Setting(radii, speed, random)
    order = [KINDS[k % len(KINDS)] for k in range(count)]
    drawn = tuple(draw_cell(s, f"{seed}-{number:03d}-{k:02d}", how) for k, how in enumerate(order))
    how = "semi_implicit" if number % 3 == 1 or (liquid.viscosity_Pa_s > 1.0 and random.uniform() < 0.7) else "explicit"
    batch = Batch(
        name=f"cases-{seed}-{number:03d}", classes=classes, pairs=pairs, liquid=liquid, effects=effects, time_step=1e-12,
        steps=1500, cells=drawn, how=how, wall_angle=angles[2], ranks=2 if number % 8 == 5 else 1,
    )  # fmt: skip
    return with_step(batch, log_uniform(random, 0.05, 0.25), preset, e)


def with_step(batch: Batch, part: float, preset: str, e: float) -> Batch:
    """Return the batch at a part of the smallest step that the advisor allows, with all parameters in the cells' tables."""
    limit = allowed_step(batch)
    step = part * limit
    shared = {
        "preset": preset, "integration": batch.how, "ranks": batch.ranks, "time_step_s": step, "of_advised": part,
        "surface_tension_N_per_m": batch.liquid.surface_tension_N_per_m, "viscosity_Pa_s": batch.liquid.viscosity_Pa_s,
        "restitution": e, "stiffness_N_per_m": max(p.normal_stiffness_N_per_m for p in batch.pairs),
        "contact_angles_deg": "/".join(f"{math.degrees(c.contact_angle_rad):.0f}" for c in batch.classes)
        + f"/{math.degrees(batch.wall_angle):.0f}",
    }  # fmt: skip
    return replace(batch, time_step=step, cells=tuple(replace(c, says={**c.says, **shared}) for c in batch.cells))


def allowed_step(batch: Batch) -> float:
    """Return the smallest stability limit [s] of the advisor for the batch's spheres; each dense cluster is a packing."""
    return min(m.time_step_s for m in cells.advised(batch, cells.thickest_film(batch)) if m.stability)
