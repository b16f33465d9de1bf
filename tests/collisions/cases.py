"""Problems of the paper, shared by the tests."""

from __future__ import annotations

from typing import Any

from pywet.collisions.wall import data
from pywet.collisions.wall.problem import Problem
from pywet.collisions.wall.wall import collide


def problem(particle: str = "glass_1.74mm", layer: tuple[str, int] | None = None, **given: Any) -> Problem:
    """A particle of table 1 on a dry wall or on a layer of table 5."""
    content = {
        "particle": data.PARTICLES[particle],
        "wall": data.GLASS_WALL,
        "liquid": data.layer(particle, *layer) if layer else None,
        "friction": data.FRICTION["dry"],
        "normal_velocity_m_per_s": 1.0,
        **given,
    }
    return Problem.model_validate(
        {key: value for key, value in content.items() if value is not None or key == "liquid"}
    )


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
