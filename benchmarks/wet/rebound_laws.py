"""The three drags of the problem wet_rebound as custom laws, for `programs.py`: an example of `pywet` with a user's law.

The rigid bodies touch at S = 0, where the problem has the gap h = roughness; while they overlap nothing drags.
"""

from __future__ import annotations

import math

from pywet.laws.force_law import force_law, helper

SMOOTH, ROUGH = 1e-6, 5e-6
"""Roughness at the plate, and between the two spheres [m]."""
FILM = 1e-4
"""Films of the two spheres together [m]."""


@helper
def stokes(separation: float, roughness: float, radius_i: float, radius_j: float, viscosity: float) -> float:
    """6 pi mu a²/h; 0 in overlap."""
    if separation <= 0.0:
        return 0.0
    a = radius_i if math.isinf(radius_j) else radius_i * radius_j / (radius_i + radius_j)
    return 6.0 * math.pi * viscosity * a * a / (separation + roughness)


@force_law
def holds(
    separation: float, volume: float, radius_i: float, radius_j: float, normal_velocity: float, viscosity: float
) -> float:
    """The film acts alike both ways."""
    return -normal_velocity * stokes(separation, SMOOTH, radius_i, radius_j, viscosity)


@force_law
def cavitates(
    separation: float, volume: float, radius_i: float, radius_j: float, normal_velocity: float, viscosity: float
) -> float:
    """Nothing holds the sphere on its way out."""
    return -min(normal_velocity, 0.0) * stokes(separation, SMOOTH, radius_i, radius_j, viscosity)


@force_law
def thinning(
    separation: float, volume: float, radius_i: float, radius_j: float, normal_velocity: float, viscosity: float
) -> float:
    """The film thins at its rim (Davis 2023)."""
    h = min(separation + ROUGH, FILM)
    factor = 1.0 - h / (2.0 * FILM - h)
    return -normal_velocity * factor * factor * stokes(separation, ROUGH, radius_i, radius_j, viscosity)
