"""Problems of the paper, shared by the tests."""

from __future__ import annotations

from typing import Any

from pywet.collisions.wall.wall import collide
from studies.buck2018.curves import problem

__all__ = ["normal", "problem", "run", "sticking_velocity"]


def run(particle: str = "glass_1.74mm", layer: tuple[str, int] | None = None, **given: Any) -> dict[str, Any]:
    """Its outcome."""
    return collide(problem(particle, layer, **given))


def normal(particle: str, layer: tuple[str, int] | None, velocity: float, **given: Any) -> float:
    """e_n at a velocity [m/s]."""
    return float(run(particle, layer, normal_velocity_m_per_s=velocity, **given)["e_n"])


def sticking_velocity(particle: str, layer: tuple[str, int], **given: Any) -> float:
    """Velocity [m/s] below which the sphere stays, by bisection to 1e-4 m/s."""
    low, high = 0.01, 5.0
    assert normal(particle, layer, low, **given) == 0.0 < normal(particle, layer, high, **given)
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if normal(particle, layer, middle, **given) == 0.0 else (low, middle)
    return high
