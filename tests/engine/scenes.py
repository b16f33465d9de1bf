"""Bodies and materials shared by the two-body checks inside the engine."""

from __future__ import annotations

import math

from pywet.scene import ContactPair, Liquid, SphereClass

WATER = Liquid(
    surface_tension_N_per_m=0.07275,
    viscosity_Pa_s=1.0e-3,
    density_kg_per_m3=998.2,
    initial_film_thickness_m=1e-4,
)


def spheres_of(*radii: float, density: float = 2500.0, angle_deg: float = 15.0) -> list[SphereClass]:
    """One class per radius."""
    return [
        SphereClass(
            name=f"class{k}",
            type=k,
            radius_m=r,
            density_kg_per_m3=density,
            contact_angle_rad=math.radians(angle_deg),
            count=1,
        )
        for k, r in enumerate(radii, start=1)
    ]


def contacts(n: int, restitution: float = 0.8, stiffness: float = 1e5, friction: float = 0.2) -> list[ContactPair]:
    """The same dry contact for every pair of `n` types and the wall."""
    return [
        ContactPair(
            a=a,
            b=b,
            normal_stiffness_N_per_m=stiffness,
            tangential_stiffness_N_per_m=2 / 7 * stiffness,
            friction=friction,
            rolling_friction_m=0.0,
            restitution=restitution,
        )
        for a in range(1, n + 1)
        for b in [0, *range(a, n + 1)]
    ]
