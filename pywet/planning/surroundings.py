"""Data that the estimates need in addition to spheres and liquid: motion, walls, and the quantities of interest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from pywet.errors import PywetError
from pywet.laws.contact import S_MIN, film_volume
from pywet.laws.viscous import lian_translation
from pywet.scene import ContactPair, Liquid, SphereClass

GRAVITY = 9.81
BRIDGE_SHARE = 0.5 * (1.0 - math.sqrt(0.75))
"""Share of its film that a sphere gives to a bridge with an equal sphere or a large wall, E (8), (9)."""


@dataclass(frozen=True)
class Surroundings:
    """State of the scene: `moving`, an agitated dense bed; `at_rest`, touching spheres at rest; `dilute`, single collisions.

    The default is the state that by itself permits no effect to be left out.
    """

    state: Literal["moving", "at_rest", "dilute"] = "moving"
    gravity_m_per_s2: float = GRAVITY
    duration_s: float = 1.0
    solid_fraction: float = 0.6
    """Volume fraction of solids; in a dilute scene it determines the collision frequency, 0: one collision."""
    wall_share: float = 1.0
    """Contacts with walls over all contacts; 0 without walls."""
    liquid_wanted: bool = True
    """Whether the distribution of liquid is of interest; if not, a liquid with negligible forces need not be simulated."""
    slow_m_per_s: float = math.inf
    """Speed of slow phases; of each number, the larger of its values at this and at the given speed is used."""
    films_m: Mapping[int, float] = field(default_factory=dict)
    """Type of a class -> thickness of its films, where this is not that of the liquid."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.wall_share <= 1.0 or not 0.0 <= self.solid_fraction < 0.75 or self.duration_s <= 0:
            raise PywetError(
                f"wall_share {self.wall_share:g} must be within 0 and 1, solid_fraction {self.solid_fraction:g} within 0 "
                f"and 0.75, duration_s {self.duration_s:g} above 0; fix the scene's surroundings",
                code="scene.surroundings",
                given=(self.wall_share, self.solid_fraction, self.duration_s),
            )


@dataclass(frozen=True)
class Groups:
    """Forces, lengths and speeds of two equal spheres of one class in one contact, the basis of all estimates; SI units."""

    radius: float
    mass: float
    weight: float
    grip: float
    """Friction force under the sphere's weight."""
    friction: float
    rolling_friction: float
    stiffness: float
    speed: float
    film: float
    film_volume: float
    surface_force: float
    """Capillary force at touch, 2 pi r sigma cos(theta)."""
    rupture: float
    """Rupture distance (1 + theta/2) V^(1/3)."""
    normal_drag_gap: float
    """Coefficient 6 pi eta r_red^2: the normal viscous force is this times v/S."""
    tangential_drag: float
    """Coefficient of sliding drag at the smallest gap (Lian, E 27)."""
    capillary_number: float
    liquid_mass: float
    surface_tension: float

    @property
    def smallest_gap(self) -> float:
        return S_MIN * self.radius

    @property
    def pass_impulse(self) -> float:
        """Return the normal viscous impulse of one approach [N s]: 6 pi eta r_red^2 (ln(1 + 2 h/S_min) + overlap/S_min).

        The second term is for the overlap, during which the law has its smallest gap; soft springs make it
        large.
        """
        return self.normal_drag_gap * (
            math.log1p(2.0 * self.film / self.smallest_gap) + self.overlap / self.smallest_gap
        )

    @property
    def overlap(self) -> float:
        """Return the overlap of an elastic impact, v sqrt(m_eff/k) [m]."""
        return self.speed * math.sqrt(0.5 * self.mass / self.stiffness)

    @property
    def speed_lost(self) -> float:
        """Return the speed lost in one approach over the speed: (ln(1 + 2 h/S_min) + overlap/S_min)/St, at most 1."""
        if self.pass_impulse == 0.0:
            return 0.0
        return min(self.pass_impulse / (0.5 * self.mass * self.speed), 1.0) if self.speed > 0 else 1.0

    @property
    def bridge_energy(self) -> float:
        """Return the work to stretch a bridge to rupture, at most surface_force S_rup/2 [J]."""
        return 0.5 * self.surface_force * self.rupture

    @property
    def slip_time(self) -> float:
        """Return the time of a passage, in and out, and of the contact between [s]."""
        contact = math.pi * math.sqrt(0.5 * self.mass / self.stiffness)
        return 4.0 * self.film / self.speed + contact if self.speed > 0 else math.inf


def groups(c: SphereClass, pair: ContactPair, liquid: Liquid | None, speed: float, gravity: float) -> Groups:
    """Compute forces, lengths and speeds of two equal spheres of a class with the friction and stiffness of one of its contacts.

    Liquid quantities are zero without liquid.
    """
    r, m = c.radius_m, c.mass_kg
    sigma, eta, h = 0.0, 0.0, 0.0
    if liquid is not None:
        sigma, eta, h = liquid.surface_tension_N_per_m, liquid.viscosity_Pa_s, liquid.initial_film_thickness_m
    film = film_volume(h, r)
    volume = 2.0 * BRIDGE_SHARE * film
    r_red = 0.5 * r
    return Groups(
        radius=r,
        mass=m,
        weight=m * gravity,
        grip=pair.friction * m * gravity,
        friction=pair.friction,
        rolling_friction=pair.rolling_friction_m,
        stiffness=pair.normal_stiffness_N_per_m,
        speed=speed,
        film=h,
        film_volume=film,
        surface_force=abs(2.0 * math.pi * r * sigma * math.cos(c.contact_angle_rad)) if h > 0 else 0.0,
        rupture=(1.0 + 0.5 * c.contact_angle_rad) * volume ** (1.0 / 3.0),
        normal_drag_gap=6.0 * math.pi * eta * r_red**2 if h > 0 else 0.0,
        tangential_drag=lian_translation(0.0, r, r, eta) if h > 0 else 0.0,
        capillary_number=speed * eta / sigma if sigma > 0 and h > 0 else 0.0,
        liquid_mass=film * liquid.density_kg_per_m3 if liquid is not None else 0.0,
        surface_tension=sigma,
    )


def collisions(g: Groups, s: Surroundings) -> float:
    """Return the collisions of one sphere in a dilute scene, at least one: v t 6 sqrt(2) phi/d (kinetic theory)."""
    return max(1.0, g.speed * s.duration_s * 6.0 * math.sqrt(2.0) * s.solid_fraction / (2.0 * g.radius))
