"""Spheres, contacts and liquids of the study's scenes, and their first arrangements."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pywet import advisor
from pywet.effects import Surroundings
from pywet.geometry.surface import Surface
from pywet.scene import ContactPair, Effects, Liquid, Rotation, Scene, SphereClass
from pywet.screening.amounts import common_film_thickness
from pywet.small import Sphere

Vector = tuple[float, float, float]
STEP_FRACTION = 0.2
"""Time step over the dry contact's stable one in a dense packing: about ten in a collision of two."""


@dataclass(frozen=True)
class Setup:
    """One scene ready to be prepared with any choice of effects; `speed` and `surroundings` are for the plan."""

    classes: tuple[SphereClass, ...]
    pairs: tuple[ContactPair, ...]
    liquid: Liquid | None
    speed: float
    surroundings: Surroundings
    spheres: tuple[Sphere, ...]
    seconds: float
    walls: tuple[Surface, ...] = ()
    gravity: Vector = (0.0, 0.0, -9.81)
    rotation: Rotation | None = None
    outputs: int = 20
    build: Callable[[Effects, Path], Scene] | None = None
    """Prepares the run directory where the scene is not of spheres and walls given here."""


def spheres_of(
    radii_mm: Sequence[float], counts: Sequence[int], density: float, angle_deg: float
) -> tuple[SphereClass, ...]:
    """One class per radius."""
    return tuple(
        SphereClass(
            name=f"{2 * r:g} mm",
            type=k,
            radius_m=1e-3 * r,
            density_kg_per_m3=density,
            contact_angle_rad=math.radians(angle_deg),
            count=n,
        )
        for k, (r, n) in enumerate(zip(radii_mm, counts, strict=True), start=1)
    )


def contacts(
    types: int, stiffness: float, friction: float = 0.4, rolling_m: float = 2e-5, restitution: float = 0.8
) -> tuple[ContactPair, ...]:
    """The same dry contact between all types and with walls; tangential springs of 2/7."""
    return tuple(
        ContactPair(
            a=a,
            b=b,
            normal_stiffness_N_per_m=stiffness,
            tangential_stiffness_N_per_m=2.0 / 7.0 * stiffness,
            friction=friction,
            rolling_friction_m=rolling_m,
            restitution=restitution,
        )
        for a in range(1, types + 1)
        for b in (0, *range(a, types + 1))
    )


def wetted(
    classes: tuple[SphereClass, ...], moisture_percent: float, viscosity: float = 1e-3, tension: float = 0.0728
) -> Liquid:
    """Liquid of 1000 kg/m3, so many per cent of the spheres' mass, as the same film on all."""
    mass = sum(c.mass_kg * c.count for c in classes)
    return Liquid(
        surface_tension_N_per_m=tension,
        viscosity_Pa_s=viscosity,
        density_kg_per_m3=1000.0,
        initial_film_thickness_m=common_film_thickness(classes, 1e-5 * moisture_percent * mass),
    )


def time_step(setup: Setup) -> float:
    """The same step for all choices of effects, so that their times can be compared; two digits. Drag is semi-implicit."""
    steps = []
    for pair in setup.pairs:
        m = setup.classes[pair.a - 1].mass_kg * (0.5 if pair.b else 1.0)
        log_e = math.log(pair.restitution)
        gamma = -2.0 * log_e * math.sqrt(m * pair.normal_stiffness_N_per_m) / math.hypot(math.pi, log_e)
        steps.append(advisor.largest_step(m, pair.normal_stiffness_N_per_m, gamma, 0.0, False, advisor.PACKED))
    step = STEP_FRACTION * min(steps)
    digit = 10.0 ** (math.floor(math.log10(step)) - 1)
    return math.floor(step / digit) * digit


SHAKEN = 0.04
"""How far a sphere of a lattice is moved at most, over the pitch."""


def lattice(kinds: Sequence[int], across: int, pitch: float, low: float, seed: int) -> tuple[Sphere, ...]:
    """Layers of across x across spheres from height `low` up, shaken by SHAKEN of the pitch."""
    random = np.random.default_rng(seed)
    order = random.permutation(np.asarray(kinds))
    spheres = []
    for k, kind in enumerate(order):
        z, y, x = k // across**2, k // across % across, k % across
        at = (
            np.array([x - 0.5 * (across - 1), y - 0.5 * (across - 1), z]) + random.uniform(-SHAKEN, SHAKEN, 3)
        ) * pitch
        spheres.append(Sphere(int(kind), (float(at[0]), float(at[1]), float(at[2] + low))))
    return tuple(spheres)


def pyramid(side: int, radius: float, seed: int) -> tuple[Sphere, ...]:
    """Cannonballs in a square tray: each sphere rests on the four below; the seed moves them by 1e-4 of the radius."""
    random = np.random.default_rng(seed)
    spheres = []
    for layer in range(side):
        n = side - layer
        for i in range(n):
            for j in range(n):
                at = np.array([2 * i - (n - 1), 2 * j - (n - 1), 1.0 + math.sqrt(2.0) * layer]) * radius
                at += 1e-4 * radius * random.uniform(-1.0, 1.0, 3) * [1.0, 1.0, 0.0]
                spheres.append(Sphere(1, (float(at[0]), float(at[1]), float(at[2]))))
    return tuple(spheres)


def jets(count: int, radius: float, speed: float, pitch: float, seed: int) -> tuple[Sphere, ...]:
    """Two clouds that fly through each other along x, each at half the speed; places at random on a lattice."""
    random = np.random.default_rng(seed)
    across = max(3, round((count / 2) ** (1.0 / 3.0)))
    spheres = []
    for side in (-1, 1):
        cells = np.array(list(np.ndindex(across + 1, across, across)), dtype=float)
        cells = cells[random.permutation(len(cells))[: count // 2]]
        at = (cells - [0.0, 0.5 * (across - 1), 0.5 * (across - 1)]) * pitch
        at += random.uniform(-0.5, 0.5, at.shape) * (pitch - 2.4 * radius)
        at[:, 0] = side * (at[:, 0] + 0.6 * pitch)
        spheres += [Sphere(1, (float(x), float(y), float(z)), (-0.5 * side * speed, 0.0, 0.0)) for x, y, z in at]
    return tuple(spheres)
