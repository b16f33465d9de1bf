"""Number of spheres, film thickness and time step, computed from the configuration.

Sources are Elskamp & Kruggel-Emden 2018: class masses and the volume of other materials (5.1), duration of a
collision (after 5).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from reference_impl.scene.configuration import near, number, reading, width_m

NAMES = ("small", "near_mesh", "large")
SMALLEST_GAP = 1e-3
"""Smallest gap S_min over the bridge's radius."""


@dataclass(frozen=True)
class Class:
    """Number, size and density of the spheres of one size class."""

    name: str
    radius: float
    density: float
    count: int
    passes: bool

    @property
    def mass(self) -> float:
        """Mass of one sphere of the class [kg]."""
        return self.density * math.pi / 6.0 * (2.0 * self.radius) ** 3


def classes(config: Mapping[str, Any]) -> tuple[Class, ...]:
    """Return the three classes with the numbers of spheres for the sieve's area.

    The amount of a class is the case's mass or solid volume, if given, else the class mass of the reference
    material.
    """
    case, data = config["case"], config["materials"]
    feed, width = data["feed"], width_m(config)
    round_sieve = 0.25 * math.pi if config["scale"]["shape"] == "cylinder" else 1.0
    share = round_sieve * width**2 / (0.25 * math.pi * (1e-3 * number(feed, "sieve_diameter_mm")) ** 2)
    mass, volume, found = case.get("class_mass_g"), case.get("class_volume_cm3"), []
    asked: list[float] = []
    for name in NAMES:
        diameter = float(case[f"{name}_mm"])
        of_size = near(data["spheres"][case["material"]]["sizes"], "diameter_mm", diameter)
        radius, dense = 0.5e-3 * number(of_size, "diameter_mm"), density(of_size, config)
        if volume is not None:
            amount = 1e-6 * float(volume) / (math.pi / 6.0 * (1e-3 * diameter) ** 3)
        elif mass is not None:
            amount = 1e-3 * float(mass) / Class(name, radius, dense, 1, True).mass
        else:
            other = near(data["spheres"][feed["reference_material"]]["sizes"], "diameter_mm", diameter)
            of_reference = Class(name, 0.5e-3 * number(other, "diameter_mm"), density(other, config), 1, True)
            amount = 1e-3 * number(feed, "class_mass_g") / of_reference.mass
        found.append(Class(name, radius, dense, 1, diameter < float(case["aperture_mm"])))
        asked.append(share * amount * found[-1].mass)
    return tuple(replace(c, count=n) for c, n in zip(found, whole(asked, [c.mass for c in found]), strict=True))


def density(size: Mapping[str, Any], config: Mapping[str, Any]) -> float:
    """Compute the density of a size of spheres [kg/m3]: as given or, by the reading `sphere_mass`, from the weighed mass."""
    if reading(config, "sphere_mass", "density") == "density":
        return number(size, "density_kg_per_m3")
    return 1e-3 * number(size, "mass_g") / (math.pi / 6.0 * (1e-3 * number(size, "diameter_mm")) ** 3)


def moisture(config: Mapping[str, Any]) -> float:
    """Return the liquid over the mass of the spheres: the case's per cent, or, by the reading of its amount, the remainder."""
    share = 0.01 * float(config["case"]["liquid_percent"])
    if reading(config, "liquid_amount", "full") == "full":
        return share
    lost = number(config["materials"]["spheres"][config["case"]["material"]], "residual_liquid_percent")
    return share * (100.0 - lost) / 100.0


def whole(asked: Sequence[float], one: Sequence[float]) -> list[int]:
    """Return the number of spheres of each size for requested masses [kg] (docs/configuration.md, Sizes).

    The nearest numbers are used if the total is within 0.5 % of the mass. Otherwise the coarsest size is rounded
    first, and each finer one after its mass has been multiplied by the mass still to be made over the mass still
    requested, within 5 %.
    """
    most, made = sum(asked), [max(1, math.floor(a / m + 0.5)) for a, m in zip(asked, one, strict=True)]
    if abs(sum(n * m for n, m in zip(made, one, strict=True)) - most) <= 0.005 * most:
        return made
    todo = sorted(range(len(asked)), key=lambda k: (one[k], -k))
    while todo:
        given = sum(made[k] * one[k] for k in range(len(asked)) if k not in todo)
        factor = (most - given) / sum(asked[k] for k in todo)
        coarsest = todo.pop()
        part = asked[coarsest] * max(0.95, min(1.05, factor)) / one[coarsest]
        made[coarsest] = max(1, math.floor(part + 0.5))
    return made


def film(of: Sequence[Class], config: Mapping[str, Any]) -> float:
    """Return the thickness [m] of the same film on every sphere, which contains the case's per cent of the spheres' mass."""
    liquid = number(config["materials"]["liquid"], "density_kg_per_m3")
    volume = moisture(config) * sum(c.count * c.mass for c in of) / liquid
    # Newton's method for 4/3 pi sum n ((r+h)^3 - r^3) = a h + b h^2 + c h^3, which is convex, from the flat film downward
    a, b, c = (k * math.pi * sum(o.count * o.radius**p for o in of) for k, p in ((4.0, 2), (4.0, 1), (4.0 / 3.0, 0)))
    h = volume / a
    for _ in range(60):
        h -= (((c * h + b) * h + a) * h - volume) / ((3.0 * c * h + 2.0 * b) * h + a)
    return h


def film_volume(thickness: float, radius: float) -> float:
    """Return the liquid of a film on a sphere [m3]."""
    return math.pi * thickness * (4.0 * radius * (radius + thickness) + 4.0 / 3.0 * thickness**2)


def time_step(of: Sequence[Class], pairs: Sequence[Mapping[str, Any]], fraction: float, viscosity: float) -> float:
    """Return a fraction of the shortest duration of a collision, or of the viscous damping time, truncated to three digits [s].

    The duration is half a period of the damped normal spring with m_eff, or of the tangential one with 2/7 of it;
    the damping time at the smallest gap is m_eff/(6 pi eta r_red^2/S_min) if a viscosity is given.
    """
    times = []
    for pair in pairs:
        a, b = of[pair["a"] - 1], of[pair["b"] - 1] if pair["b"] else None
        if a.count == 0 or (b is not None and b.count == 0):
            continue
        mass = a.mass if b is None else 1.0 / (1.0 / a.mass + 1.0 / b.mass)
        reduced = a.radius if b is None else 1.0 / (1.0 / a.radius + 1.0 / b.radius)
        ln = math.log(pair["restitution"])
        zeta = -ln / math.sqrt(math.pi**2 + ln**2)
        times.append(math.pi * math.sqrt(mass / pair["normal_stiffness_N_per_m"]) / math.sqrt(1.0 - zeta**2))
        times.append(math.pi * math.sqrt(2.0 / 7.0 * mass / pair["tangential_stiffness_N_per_m"]))
        if viscosity > 0.0:
            gap = SMALLEST_GAP * (reduced if b is None else 2.0 * reduced)
            times.append(mass * gap / (6.0 * math.pi * viscosity * reduced**2))
    step = fraction * min(times)
    digit = 10.0 ** (math.floor(math.log10(step)) - 2)
    return math.floor(step / digit * (1.0 + 1e-12)) * digit
