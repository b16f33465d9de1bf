"""The force balance as numbers: parameters, right-hand side and event functions of each phase, compiled for every integrator.

State, per unit of effective mass: h gap [m], u normal velocity [m/s], s slip of the contact point since touch [m], v tangential
velocity [m/s], w = ωR [m/s], and the energy removed so far by contact, viscous force, capillary force and gravity [J/kg].
"""

from __future__ import annotations

import math
from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from pywet.collisions.wall import contact, drag
from pywet.laws import toroid
from pywet.util.machine_code import njit as cached_njit

ENTRY, CONTACT, LEAVING, BRIDGE, DONE = 1, 2, 3, 4, 0
"""Phases I to IV, and the end."""
H, U, S, V, W, WORK = 0, 1, 2, 3, 4, 5
SIZE = 9
CREEP = 1e-3
"""Net force over the weight below which a sphere in the film creeps."""
REST = 1e-6
"""Velocity over the impact velocity below which a sphere without gravity counts as stopped; for energies its square."""


MISPRINTS = ("shear_modulus", "drag", "gap", "goldman_signs", "suction_sign", "neck_radius", "volume_factors")
READINGS: dict[str, tuple[str, str]] = {
    **dict.fromkeys(MISPRINTS, ("mended", "as_printed")),
    "bridge_volume": ("follows", "frozen"),
    "contact_end": ("overlap", "force"),
    "rupture_from": ("film", "wall"),
    "capillary": ("bridge", "film_and_bridge"),
}
"""Ambiguity of the paper (docs/wall_collision.md) -> the default reading, the other one."""
Other: Any = namedtuple("Other", READINGS)  # type: ignore[misc]
"""Flags of the ambiguities for which the other reading is selected."""


class Parameters(NamedTuple):
    """Parameters of one collision in SI units (docs/wall_collision.md).

    `mass` is that of the pair, `radius` the sphere's, `reduced` R*.
    """

    mass: float
    radius: float
    reduced: float
    stiffness: float
    damping: float
    shear: float
    friction: float
    gravity: float
    speed: float
    wet: bool
    layer: float
    density: float
    viscosity: float
    surface_tension: float
    contact_angle: float
    half_filling: float
    other: Any
    """Selected readings, see `Other`."""


@njit(error_model="numpy")
def contact_line(h: float, p: Parameters) -> tuple[float, float, float]:
    """Return the height of the contact line above the film, its radius, and the angle φ + θ, at gap h."""
    height = h + p.radius * (1.0 - math.cos(p.half_filling)) - p.layer
    return height, p.radius * math.sin(p.half_filling), p.half_filling + p.contact_angle


@njit(error_model="numpy")
def viscous_gap(h: float, p: Parameters) -> float:
    """Return the gap of the viscous laws, bounded below by the roughness; as printed: δ_l − y with y the centre's height."""
    return max(p.layer - h - p.radius if p.other.gap else h, drag.GAP_MIN)


@njit(error_model="numpy")
def viscous_normal(h: float, u: float, p: Parameters) -> float:
    """Return the larger of drag and lubrication [N], which acts against u."""
    speed = abs(u)
    sine = math.sin(p.half_filling)
    far = drag.unbounded(speed, p.radius * sine, p.viscosity, p.density)
    if p.other.drag:
        far /= sine
    return -math.copysign(max(far, drag.near_wall(speed, viscous_gap(h, p), p.reduced, p.viscosity)), u)


@cached_njit(error_model="numpy", cache=True)
def bridge_volume(h: float, p: Parameters) -> float:
    """Return the volume of the bridge at gap h [m3]; reading `frozen`: that at film exit."""
    height = (0.0 if p.other.bridge_volume else h - p.layer) + p.radius * (1.0 - math.cos(p.half_filling))
    angle = p.half_filling + p.contact_angle
    return toroid.volume(height, p.radius, p.half_filling, angle, p.other.neck_radius, p.other.volume_factors)


@njit(error_model="numpy")
def attraction(h: float, surface_tension: float, p: Parameters) -> float:
    """Return the capillary attraction at gap h [N]."""
    height, rim, angle = contact_line(h, p)
    return toroid.attraction(height, rim, angle, surface_tension, p.other.neck_radius, p.other.suction_sign)


@njit(error_model="numpy")
def contact_forces(state: np.ndarray, p: Parameters) -> tuple[float, float]:
    """Return the (normal, tangential) contact force [N]."""
    overlap = -state[H]
    normal = contact.normal_force(overlap, -state[U], p.stiffness, p.damping)
    limit = p.friction * max(normal, 0.0)
    tangential = contact.tangential_force(overlap, state[S], state[V] + state[W], p.shear, p.damping, limit)
    return normal, tangential


@cached_njit(error_model="numpy", cache=True)
def rates(phase: int, state: np.ndarray, p: Parameters, out: np.ndarray) -> None:
    """Write the time derivative of the state to `out`; powers are per unit of effective mass, positive for energy loss."""
    h, u, v, w = state[H], state[U], state[V], state[W]
    normal = tangential = normal_viscous = along = moment = capillary = 0.0
    weight = p.mass * p.gravity
    if phase == CONTACT:
        normal, tangential = contact_forces(state, p)
    else:
        normal_viscous = viscous_normal(h, u, p)
        if phase == BRIDGE or p.other.capillary:
            capillary = -attraction(h, p.surface_tension, p)
        if phase == BRIDGE:
            weight += bridge_volume(h, p) * p.density * p.gravity
        else:
            log_gap = max(math.log(p.reduced / viscous_gap(h, p)), 0.0)
            sign = 1.0 if p.other.goldman_signs else -1.0
            along = drag.goldman_force(v, w, log_gap, p.reduced, p.viscosity, sign)
            moment = drag.goldman_moment(v, w, log_gap, p.reduced, p.viscosity, sign)
    inverse = 1.0 / p.mass
    out[H] = u
    out[U] = (normal + normal_viscous + capillary - weight) * inverse
    out[S] = v + w if phase == CONTACT else 0.0
    out[V] = (tangential + along) * inverse
    out[W] = 2.5 * (tangential + moment) * inverse
    out[WORK] = -(normal * u + tangential * (v + w)) * inverse
    out[WORK + 1] = -(normal_viscous * u + along * v + moment * w) * inverse
    out[WORK + 2] = -capillary * u * inverse
    out[WORK + 3] = weight * u * inverse


@cached_njit(error_model="numpy", cache=True)
def events(phase: int, state: np.ndarray, p: Parameters) -> tuple[float, float, float]:
    """Return (passage, stop, rest): each ends the phase when it rises through zero.

    A stop (the outward velocity falls to zero) or rest (reached only in the limit) means that the sphere cannot escape.
    """
    h, u = state[H], state[U]
    if phase == ENTRY:
        return -h, -1.0, entry_rest(h, u, p)
    if phase == CONTACT:
        return contact_end(state, p), -u, contact_rest(h, u, p)
    if phase == LEAVING:
        return h - p.layer, -u, leaving_rest(h, u, p)
    return rupture(h, u, p), -u, REST * p.speed - u if p.gravity == 0.0 else -1.0


@njit(error_model="numpy")
def lubrication_loss(h: float, to: float, p: Parameters) -> float:
    """Return the velocity that lubrication alone removes between gaps h and `to` [m/s]; drag and gravity add to it."""
    near, far = min(h, to), max(h, to)
    floor = drag.GAP_MIN
    path = math.log(max(far, floor) / max(near, floor)) + (min(far, floor) - min(max(near, 0.0), floor)) / floor
    return 6.0 * math.pi * p.viscosity * p.reduced * p.reduced / p.mass * path


@njit(error_model="numpy")
def entry_rest(h: float, u: float, p: Parameters) -> float:
    """Return the event of rest in phase I: too little energy to leave, too slow to reach the wall, and creeping or at rest."""
    slow = abs(u) / lubrication_loss(h, 0.0, p) - 1.0 if h > 0.0 else 1.0
    still = abs(u) / (REST * p.speed) - 1.0
    if p.gravity == 0.0:
        return -max(slow, still)
    captured = 0.5 * u * u / (p.gravity * p.layer) + h / p.layer - 1.0
    balance = abs(viscous_normal(h, u, p) / (p.mass * p.gravity) - 1.0) / CREEP - 1.0
    steady = u * u / (p.gravity * max(h, drag.GAP_MIN)) / (0.25 * CREEP) - 1.0
    return -max(max(captured, slow), min(still, max(balance, steady)))


@njit(error_model="numpy")
def leaving_rest(h: float, u: float, p: Parameters) -> float:
    """Return the event of rest in phase III without gravity: lubrication holds the sphere, and it is practically at rest."""
    if p.gravity > 0.0:
        return -1.0
    slow = u / max(lubrication_loss(h, p.layer, p), 1e-300) - 1.0
    return -max(slow, u / (REST * p.speed) - 1.0)


@njit(error_model="numpy")
def contact_end(state: np.ndarray, p: Parameters) -> float:
    """Return the event that ends phase II: zero overlap (or zero force, an option) during rebound."""
    if state[U] <= 0.0 or not p.other.contact_end:
        return state[H]
    return -contact_forces(state, p)[0] if state[H] < 0.0 else 1.0


@njit(error_model="numpy")
def contact_rest(h: float, u: float, p: Parameters) -> float:
    """Return the event of rest in phase II: the energy above that at static rest is dissipated."""
    depth = max(-h, 0.0)
    spring = p.stiffness / p.mass
    energy = 0.5 * u * u + 0.4 * spring * depth * depth * math.sqrt(depth)
    if p.gravity == 0.0:
        return REST * REST - energy / (0.5 * p.speed * p.speed)
    lying = (p.gravity / spring) ** (2.0 / 3.0)
    return REST - (energy - p.gravity * depth) / (p.gravity * lying) - 0.6


@cached_njit(error_model="numpy", cache=True)
def rupture(h: float, u: float, p: Parameters) -> float:
    """Return the event of phase IV: length beyond the rupture length [m], or zero attraction (the neck of the toroid closes)."""
    length = toroid.rupture_length(bridge_volume(h, p), abs(u), p.contact_angle, p.viscosity, p.surface_tension)
    beyond = h - (0.0 if p.other.rupture_from else p.layer) - length
    height, rim, angle = contact_line(h, p)
    neck = toroid.radii(height, rim, angle, p.other.neck_radius)[1]
    closing = 0.01 * rim - neck if p.other.suction_sign else max(-attraction(h, 1.0, p) / (2.0 * math.pi), -neck)
    return max(beyond, closing)
