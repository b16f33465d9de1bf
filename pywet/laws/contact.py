"""Quantities of two bodies in contact, and of a film on one: radii and mass of a pair, damping from restitution, film thickness.

They are plain functions, which compiled laws use through `helper`. At a wall radius_j and mass_j are infinite.
Equation numbers are those of Elskamp & Kruggel-Emden 2018.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

S_MIN = 1e-3
"""Smallest gap of the viscous laws over r_eff (after 29; r_eff = r_i at a wall)."""


def reduced_radius(radius_i: float, radius_j: float) -> float:
    """Return r_red = r_i r_j/(r_i + r_j) [m]; its limit r_i at a wall."""
    return radius_i if math.isinf(radius_j) else radius_i * radius_j / (radius_i + radius_j)


def effective_radius(radius_i: float, radius_j: float) -> float:
    """Return the harmonic mean r_eff = 2 r_i r_j/(r_i + r_j) [m]; its limit 2 r_i at a wall."""
    return 2.0 * radius_i if math.isinf(radius_j) else 2.0 * radius_i * radius_j / (radius_i + radius_j)


def bridge_radius(radius_i: float, radius_j: float) -> float:
    """Return the radius by which the paper scales a bridge, V* = V/r³ [m]: the harmonic mean of two spheres, r_i at a wall."""
    return radius_i if math.isinf(radius_j) else 2.0 * radius_i * radius_j / (radius_i + radius_j)


def effective_mass(mass_i: float, mass_j: float) -> float:
    """Return m_i m_j/(m_i + m_j) [kg]; its limit m_i at a wall."""
    return mass_i if math.isinf(mass_j) else mass_i * mass_j / (mass_i + mass_j)


class Body(Protocol):
    """Size class with mass [kg] and radius [m]."""

    @property
    def radius_m(self) -> float: ...
    @property
    def mass_kg(self) -> float: ...


class Types(Protocol):
    """Two types in contact, 1, 2, …; b is 0 for a wall."""

    @property
    def a(self) -> int: ...
    @property
    def b(self) -> int: ...


def pair_mass(classes: Sequence[Body], pair: Types) -> float:
    """Return the effective mass of a pair of types [kg]."""
    return effective_mass(classes[pair.a - 1].mass_kg, classes[pair.b - 1].mass_kg if pair.b else math.inf)


def pair_radii(classes: Sequence[Body], pair: Types) -> tuple[float, float]:
    """Return the radii of a pair of types [m], the second infinite at a wall."""
    return classes[pair.a - 1].radius_m, classes[pair.b - 1].radius_m if pair.b else math.inf


def damping_ratio(restitution: float) -> float:
    """ζ = −ln e/√(π² + ln² e) of a linear spring that returns e.

    >>> f"{damping_ratio(0.5):.6f}"
    '0.215454'
    """
    log_e = math.log(restitution)
    return -log_e / math.hypot(log_e, math.pi)


def damping(restitution: float, mass: float, stiffness: float) -> float:
    """γ = −2 ln e √(m k)/√(π² + ln² e) [kg/s] of a linear spring k [N/m] that returns e to a mass [kg] (after 4).

    >>> f"{damping(0.5, 1e-3, 1e3):.6f}"
    '0.430908'
    """
    log_e = math.log(restitution)
    return -2.0 * log_e * math.sqrt(mass * stiffness) / math.hypot(math.pi, log_e)


def leapfrog_damping(restitution: float, mass: float, stiffness: float, step: float) -> float:
    """Return the damping [kg/s] that gives a pair its restitution at this time step [s] in engines with leapfrog integration.

    γ₀ = −2 ln e √(m_eff k_n)/√(π² + ln² e) (E after 4) is exact for Δt → 0. An engine computes the damping from
    the velocity half a step earlier and detects a contact up to a step late, which makes e too low by up to 1.6 %
    at twenty steps a collision (e = 0.44); `at_step` removes this in the mean over the instant of touch (left:
    0.3 %).
    """
    return at_step(damping(restitution, mass, stiffness), mass, step)


def at_step(gamma: float, m: float, step: float) -> float:
    """Return γ₀/(1 + γ₀ Δt/(4 m)), the dashpot coefficient for an engine."""
    return gamma / (1.0 + gamma * step / (4.0 * m))


def film_volume(thickness: float, radius: float) -> float:
    """Return the liquid of a film of given thickness on a sphere [m3]: 4/3 π ((r + h)³ − r³) without cancellation."""
    h, r = thickness, radius
    return 4.0 / 3.0 * math.pi * h * (3.0 * r**2 + 3.0 * r * h + h**2)


def film_thickness(volume: Any, radius: Any) -> Any:
    """h = (3L/(4π) + r³)^(1/3) − r [m] of a film L [m3] on a sphere (34), without cancellation; numbers or arrays.

    >>> f"{film_thickness(film_volume(1e-9, 1e-3), 1e-3):.12e}"
    '1.000000000000e-09'
    """
    return radius * np.expm1(np.log1p(3.0 * volume / (4.0 * np.pi * radius**3)) / 3.0)


def sliding_drag(m_eff: float, time_step: float) -> float:
    """Return the drag [kg/s] of history-free friction: force min(c v, mu F_n) against the slip v.

    c = m_eff/(28 dt) is half of the stable value for a dense packing at that step, with spin (c < 2/7 m_eff/(4 dt));
    a sphere at rest on a slope then creeps at about mu g 28 dt, some tenths of a millimetre per second.
    """
    return m_eff / (28.0 * time_step)
