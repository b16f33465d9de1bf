"""Hertz–Mindlin contacts: moduli of two bodies, overlap and duration of an impact, equivalent springs, Rayleigh time.

The force is the engine's own (`model hertz tangential history`):

F_n = 4/3 E* √(R* δ) δ − 2 √(5/6) β √(S_n m*) v_n S_n = 2 E* √(R* δ) F_t = −S_t ξ − 2 √(5/6) β √(S_t m*) v_t, or −μ
|F_n| S_t = 8 G* √(R* δ) β = −ln e/√(π² + ln² e)

with the overlap δ and the tangential displacement ξ, which is reduced if friction limits the force. An impact
rebounds with e times its speed if no other force acts (Tsuji et al. 1992, Powder Technol. 71, 239; Antypov & Elliott
2011, EPL 94, 50004).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

from pydantic import Field

from pywet.laws import contact
from pywet.strict import Strict

Modulus = Annotated[float, Field(ge=1e4, le=1e13)]
"""Young's modulus [Pa]; softer or harder solids are not plausible."""
Poisson = Annotated[float, Field(ge=0, le=0.5)]
LEAST_RESTITUTION = 0.05
"""Lower limit of the engine for a coefficient of restitution (exclusive)."""
HEAD_ON = 2.0
"""Closing speed of two bodies that each have the impact speed, over the impact speed."""
STIFFEST = 15.0 / 8.0 * HEAD_ON**0.4
"""Slope of the force at the largest overlap at the closing speed, over the equivalent stiffness at the impact speed."""
DURATION = 0.8 * math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9)
"""Duration of an elastic impact over its largest overlap and speed, 4/5 B(2/5, 1/2) = 2.943."""


class Elastic(Strict):
    """Elastic properties of a body."""

    youngs_modulus_Pa: Modulus
    poissons_ratio: Poisson

    @property
    def shear_modulus_Pa(self) -> float:
        """Return G = E/(2 (1 + ν))."""
        return self.youngs_modulus_Pa / (2.0 * (1.0 + self.poissons_ratio))


class Hertz(Strict):
    """Hertz–Mindlin contacts in place of linear springs: materials of spheres and walls, and the impact speed."""

    spheres: tuple[Elastic, ...]
    """Elastic properties of the types 1, 2, …"""
    walls: Elastic
    impact_speed_m_per_s: Annotated[float, Field(gt=0)]
    """Speed of the impact whose largest overlap determines the equivalent stiffness of the pairs."""

    def moduli(self, pair: contact.Types) -> tuple[float, float]:
        """Return E* and G* of a pair of types [Pa]."""
        one, two = self.spheres[pair.a - 1], self.spheres[pair.b - 1] if pair.b else self.walls
        return effective_modulus(one, two), effective_shear_modulus(one, two)

    def overlap(self, classes: Sequence[contact.Body], pair: contact.Types, speed: float) -> float:
        """Return the largest overlap [m] of an elastic impact of a pair of types."""
        radius = contact.reduced_radius(*contact.pair_radii(classes, pair))
        return impact_overlap(self.moduli(pair)[0], radius, contact.pair_mass(classes, pair), speed)

    def springs(self, classes: Sequence[contact.Body], pair: contact.Types) -> tuple[float, float]:
        """Return the equivalent linear stiffness [N/m], normal and tangential, for estimates.

        It has the same largest overlap at the impact speed, k = m* v²/δ² = 8/15 S_n, tangentially 8/15 S_t;
        the engine does not use it.
        """
        depth = self.overlap(classes, pair, self.impact_speed_m_per_s)
        normal = contact.pair_mass(classes, pair) * (self.impact_speed_m_per_s / depth) ** 2
        modulus, shear = self.moduli(pair)
        return normal, normal * 4.0 * shear / modulus


def effective_modulus(one: Elastic, two: Elastic) -> float:
    """1/E* = (1 − ν_i²)/E_i + (1 − ν_j²)/E_j.

    >>> glass = Elastic(youngs_modulus_Pa=6.3e10, poissons_ratio=0.23)
    >>> f"{effective_modulus(glass, glass):.5g}"
    '3.3259e+10'
    """
    return 1.0 / sum((1.0 - m.poissons_ratio**2) / m.youngs_modulus_Pa for m in (one, two))


def effective_shear_modulus(one: Elastic, two: Elastic) -> float:
    """Return G* from 1/G* = (2 − ν_i)/G_i + (2 − ν_j)/G_j."""
    return 1.0 / sum((2.0 - m.poissons_ratio) / m.shear_modulus_Pa for m in (one, two))


def impact_overlap(modulus: float, radius: float, mass: float, speed: float) -> float:
    """Return the largest overlap δ = (15 m* v²/(16 E* √R*))^(2/5) [m] of an elastic impact.

    Its energy m* v²/2 equals 8/15 E* √R* δ^(5/2).
    """
    return float((15.0 * mass * speed**2 / (16.0 * modulus * math.sqrt(radius))) ** 0.4)


def impact_duration(modulus: float, radius: float, mass: float, speed: float) -> float:
    """Duration of an elastic impact [s], 2.943 δ/v = 2.87 (m*²/(R* E*² v))^(1/5) (Hertz 1882).

    >>> f"{impact_duration(1e7, 1e-3, 1e-5, 1.0) / (1e-10 / (1e-3 * 1e14)) ** 0.2:.3f}"
    '2.868'
    """
    return DURATION * impact_overlap(modulus, radius, mass, speed) / speed


def rayleigh_time(radius: float, density: float, body: Elastic) -> float:
    """Return the time [s] in which a surface wave travels half around a sphere, π r √(ρ/G)/(0.1631 ν + 0.8766)."""
    return math.pi * radius * math.sqrt(density / body.shear_modulus_Pa) / (0.1631 * body.poissons_ratio + 0.8766)
