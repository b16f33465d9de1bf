"""Bodies and materials shared by the two-body checks inside the engine."""

from __future__ import annotations

import math

from pywet.cases.small import bodies, small
from pywet.scene import ContactPair, SphereClass

WATER = bodies.water(1e-4, density=998.2)
THROWN = [
    small.Sphere(1, (0.0, 0.0, 0.0), (0.1, 0.0, 0.02)),
    small.Sphere(2, (0.0051, 0.0, 0.0), (-0.1, 0.03, 0.0), (30.0, 0.0, 10.0)),
    small.Sphere(1, (0.0, 0.0051, 0.001), (0.0, -0.1, 0.0)),
]
"""Three wet spheres that meet, bounce and part."""


def spheres_of(*radii: float, density: float = 2500.0, angle_deg: float = 15.0) -> list[SphereClass]:
    """One class per radius."""
    return list(bodies.sphere_classes(*radii, density=density, angle_rad=math.radians(angle_deg)))


def contacts(n: int, restitution: float = 0.8, stiffness: float = 1e5, friction: float = 0.2) -> list[ContactPair]:
    """Return one dry contact law for every pair of `n` types and the wall."""
    return list(bodies.contacts(n, stiffness, friction=friction, restitution=restitution))
