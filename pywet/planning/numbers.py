"""One number per effect: the relative change of a quantity of interest that leaving the effect out may cause.

Each is the ratio of two forces, lengths, speeds or energies, a conservative estimate for equal spheres of each class,
with each contact of the class, in the state of the scene; docs/effects.md documents formulas and tests. They only
decide what may be left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from pywet.errors import PywetError
from pywet.laws.kinds import FORCES
from pywet.planning.surroundings import BRIDGE_SHARE, Groups, Surroundings, collisions, groups
from pywet.scene import ContactPair, Liquid, SphereClass

Number = tuple[str, float]
"""Description of a compared ratio, and its value."""
WALL_TRANSFER = 0.25
"""Typical |T - 1/2| of a bridge with a wall (parabola model: 0.02 to 0.34 over the angles and volumes of screening)."""


def _capillary(g: Groups, s: Surroundings) -> Number:
    if s.state == "dilute":
        kinetic = 0.25 * g.mass * g.speed**2
        number = collisions(g, s) * g.bridge_energy / kinetic if kinetic > 0 else math.inf
        return "energy of the bridges over kinetic energy, all collisions", min(number, 1.0) if g.surface_force else 0.0
    if g.weight == 0.0:
        return "capillary force at touch, without weight", 1.0 if g.surface_force else 0.0
    return "capillary force at touch / weight (1/Bond number)", g.surface_force / g.weight


def _viscous_normal(g: Groups, s: Surroundings) -> Number:
    if g.normal_drag_gap == 0.0:
        return "speed lost in film and contact / speed (1/Stokes number)", 0.0
    if s.state == "at_rest":
        return "way that forces still move resting spheres / radius", _give(g)
    if s.state == "dilute":
        return "energy lost to lubrication / kinetic energy, all collisions", min(
            4.0 * collisions(g, s) * g.speed_lost, 1.0
        )
    return "speed lost in film and contact / speed (1/Stokes number)", g.speed_lost


def _viscous_tangential(g: Groups, s: Surroundings) -> Number:
    if g.tangential_drag == 0.0:
        return "tangential viscous force / friction under own weight", 0.0
    if s.state == "at_rest":
        return "way that forces still move resting spheres / radius", _give(g)
    if s.state == "dilute":
        slowed = 2.0 * collisions(g, s) * g.tangential_drag * g.slip_time / (2.0 / 7.0 * 0.5 * g.mass)
        return "slip stopped in the films, all collisions", min(slowed, 1.0)
    number = g.tangential_drag * g.speed / g.grip if g.grip > 0 else 1.0
    return "tangential viscous force / friction under own weight", number


def _dynamic_rupture(g: Groups, s: Surroundings) -> Number:
    stretch = 0.0 if s.state == "at_rest" else math.sqrt(g.capillary_number)
    if s.state == "dilute" and not s.liquid_wanted:
        return "stretch of the bridge x its number above", stretch * _capillary(g, s)[1]
    return "stretch of the bridge, sqrt(capillary number)", stretch


def _wall_films(g: Groups, s: Surroundings) -> Number:
    if g.film == 0.0:
        return "contacts with walls x share of a film drawn", 0.0
    forces = max(_capillary(g, s)[1], _viscous_normal(g, s)[1], _viscous_tangential(g, s)[1])
    drawn = BRIDGE_SHARE if s.liquid_wanted else 0.0
    if s.state == "dilute":
        drawn *= collisions(g, s)
    return "contacts with walls x (share of a film drawn, or force)", s.wall_share * min(max(drawn, forces), 1.0)


def _rolling(g: Groups, s: Surroundings) -> Number:
    if s.state == "dilute":
        turned = collisions(g, s) * 4.5 * g.rolling_friction / g.radius
        return "spin taken by rolling friction, 4.5 mu_r/r, all collisions", min(turned, 1.0)
    arm = g.rolling_friction / g.radius
    sliding = arm / g.friction if g.friction > 0 else 0.0
    if g.weight > 0 and arm * g.surface_force / g.weight > sliding:
        return "rolling torque under the bridge / torque of the weight", min(arm * g.surface_force / g.weight, 1.0)
    return "rolling friction / (friction x radius)", min(sliding, 1.0)


def _tangential_history(g: Groups, s: Surroundings) -> Number:
    times = collisions(g, s) if s.state == "dilute" else 1.0
    return "Coulomb friction (share of the contact force that slip can remember)", min(times * g.friction, 1.0)


def _gravity(g: Groups, s: Surroundings) -> Number:
    if g.weight == 0.0:
        return "no gravity in the scene", 0.0
    if s.state == "dilute":
        fall = g.weight / g.mass * s.duration_s
        return "speed of fall during the run / speed", min(fall / g.speed, 1.0) if g.speed > 0 else 1.0
    return "what lies on something does so by gravity", 1.0


def _give(g: Groups) -> float:
    """Return (10 weights + capillary force)/k over r: the relative elastic displacement of touching spheres."""
    return (10.0 * g.weight + g.surface_force) / (g.stiffness * g.radius)


OF_ONE_CLASS: dict[str, Callable[[Groups, Surroundings], Number]] = {
    number.__name__.lstrip("_"): number
    for number in (
        *(_capillary, _viscous_normal, _viscous_tangential, _dynamic_rupture, _wall_films),
        *(_rolling, _tangential_history, _gravity),
    )
}
"""Effect -> function for its number for one class; the largest over classes, their contacts and both speeds counts."""


def effect_numbers(
    classes: Sequence[SphereClass],
    pairs: Sequence[ContactPair],
    liquid: Liquid | None,
    speed_m_per_s: float,
    surroundings: Surroundings | None = None,
) -> dict[str, Number]:
    """Return effect -> compared ratio and its largest value over the contacts present; zero without liquid."""
    s = surroundings or Surroundings()
    speeds = sorted({speed_m_per_s, min(speed_m_per_s, s.slow_m_per_s)}, reverse=True)
    of = [g for speed in speeds for g in class_groups(classes, pairs, liquid, speed, s)]
    numbers = {
        effect: max((number(g, s) for g in of), key=lambda pair: pair[1]) for effect, number in OF_ONE_CLASS.items()
    }
    film = max(g.film / g.radius for g in of)
    forces = sum(numbers[effect][1] for effect in FORCES)
    numbers["bridges"] = ("film / radius", film) if s.liquid_wanted else ("sum of the numbers of its forces", forces)
    numbers["formation"] = ("share of a film drawn into a bridge", BRIDGE_SHARE if film > 0 else 0.0)
    numbers["sharing_by_size"] = _sharing([g.radius for g in of], s, film > 0)
    numbers["shedding"] = (
        "part of a film that cannot hang under g + v/t of the film",
        max(_dripping(g, s) for g in of),
    )
    numbers["liquid_weight"] = (
        "mass of film / mass of sphere",
        max(g.liquid_mass / g.mass for g in of),
    )
    return numbers


def class_groups(
    classes: Sequence[SphereClass], pairs: Sequence[ContactPair], liquid: Liquid | None, speed: float, s: Surroundings
) -> list[Groups]:
    """Return the groups of the classes that have spheres, for each contact of these with each other and with walls."""
    present = [c for c in classes if c.count > 0]
    if not present:
        raise PywetError(
            "the scene has no spheres, expected at least one; fix the case's amounts", code="case.no_spheres"
        )
    there = {c.type for c in present} | ({0} if s.wall_share else set())
    met = [p for p in pairs if {p.a, p.b} <= there]
    different = {  # a feed has thousands of contacts, most of them alike
        (c.type, p.friction, p.rolling_friction_m, p.normal_stiffness_N_per_m): (c, p)
        for c in present
        for p in met
        if c.type in (p.a, p.b)
    }
    return [groups(c, p, _of_class(liquid, c, s), speed, s.gravity_m_per_s2) for c, p in different.values()]


def _of_class(liquid: Liquid | None, c: SphereClass, s: Surroundings) -> Liquid | None:
    """Return the liquid with the film of a class."""
    if liquid is None or c.type not in s.films_m:
        return liquid
    return liquid.model_copy(update={"initial_film_thickness_m": s.films_m[c.type]})


def _dripping(g: Groups, s: Surroundings) -> float:
    """Return the part of the film that surface tension cannot support (Tate), if the acceleration outlasts its response."""
    surface = g.surface_tension
    if g.film_volume == 0.0 or surface == 0.0:
        return 0.0
    swing = math.sqrt(3.0 * g.liquid_mass / (32.0 * math.pi * surface))
    shaken = g.speed / swing if s.state == "moving" else 0.0
    weighs = g.liquid_mass * (s.gravity_m_per_s2 + shaken)
    return max(0.0, 1.0 - 2.0 * math.pi * g.radius * surface / weighs) if weighs > 0.0 else 0.0


def _sharing(radii: list[float], s: Surroundings, wet: bool) -> Number:
    """Compare the split of a rupturing bridge between unequal spheres, or with a wall, with equal shares."""
    size = (max(radii) - min(radii)) / (max(radii) + min(radii))
    return "difference of radii / sum, or contacts with walls x |T - 1/2|", (
        max(size, WALL_TRANSFER * s.wall_share) if wet else 0.0
    )
