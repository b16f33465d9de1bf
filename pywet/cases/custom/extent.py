"""Extent of moving walls, their speeds and the range of thrown spheres, which determine the simulated box."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from pywet.cases.custom.walls import EngineMotion
from pywet.errors import ConfigError
from pywet.geometry.motion import peak_speed
from pywet.geometry.surface import Floats
from pywet.scene import Rotation, Slide, Vector, Vibration

CELLS = 1_000_000
"""Largest number of cells, of a sphere's diameter, added for thrown spheres: the engine clears them at each neighbour list."""
MOST_CELLS = 1e8
"""Largest number of cells, of a sphere's diameter, in a box.

Beyond it the engine's lists take gigabytes, and at 2.7e8 it stops ("Too many atom sorting bins": an eighth of 2^31).
"""
IMPACT_SPEED_RATIO = 2.0
"""Speed of a thrown sphere over that of the wall, for an elastic impact."""


def moved(at: Floats, motion: EngineMotion | None, duration_s: float = math.inf) -> list[Floats]:
    """Return points that span, with `at` (n, 3), a box around all positions of the corners of a wall [m] in a run."""
    if isinstance(motion, Slide):
        travel_s = max(0.0, min(motion.travel_s, duration_s - motion.opens_at_s))
        return [at + travel_s * np.array(motion.velocity_m_per_s)]
    if isinstance(motion, Vibration):
        return [at + sign * 2.0 * np.array(motion.amplitude_m) for sign in (-1.0, 1.0)]
    if isinstance(motion, Rotation):
        # a circle of radius R about the axis a reaches R sqrt(1 - a_k^2) along k
        foot = _foot(at, motion)
        reach = np.linalg.norm(at - foot, axis=1)[:, None] * np.sqrt(np.maximum(1.0 - np.square(motion.axis), 0.0))
        return [foot + sign * reach for sign in (-1.0, 1.0)]
    return []


def speed(at: Floats, motion: EngineMotion | None) -> float:
    """Largest speed of the corners of a wall [m/s]."""
    if isinstance(motion, Slide):
        return math.hypot(*motion.velocity_m_per_s)
    if isinstance(motion, Vibration):
        return peak_speed(motion)
    if isinstance(motion, Rotation):
        return 2.0 * math.pi / motion.period_s * float(np.linalg.norm(at - _foot(at, motion), axis=1).max())
    return 0.0


def thrown(wall_speed: float, gravity: Vector, duration: float) -> tuple[Floats, Floats]:
    """Bound the distances [m] along −x, −y, −z and x, y, z that a thrown sphere travels until it returns to its height.

    With v = `IMPACT_SPEED_RATIO` times the wall's speed: v²/(2g) against gravity, v²/g across; at most v times the duration.
    """
    v, g = IMPACT_SPEED_RATIO * wall_speed, math.hypot(*gravity)
    if g == 0.0:
        return np.full(3, v * duration), np.full(3, v * duration)
    up = -np.array(gravity) / g
    across = min(v * v / g, v * duration) * np.sqrt(np.maximum(1.0 - up**2, 0.0))
    rise = min(0.5 * v * v / g, v * duration) * up
    return across + np.maximum(-rise, 0.0), across + np.maximum(rise, 0.0)


def refuse_vast(name: str, low: Floats, high: Floats, diameter: float) -> None:
    """Refuse a box of more cells than the engine can list its spheres by; `diameter` of the largest [m]."""
    sides = high - low
    cells = float(np.prod(sides / diameter))
    if cells > MOST_CELLS:
        size = " x ".join(f"{1e3 * x:.4g}" for x in sides)
        raise ConfigError(
            f"scene {name}: spheres and walls, wherever they move, take a box of {size} mm, {cells:.2g} cells of the largest "
            f"sphere's diameter ({1e3 * diameter:.3g} mm); expected at most {MOST_CELLS:.0e}: move them closer together, "
            "or fix lengths, speeds and stl_unit",
            code="scene.box",
            given=float(cells),
            expected=MOST_CELLS,
        )


def with_margin(low: Floats, high: Floats, below: Floats, above: Floats, cell: float) -> tuple[Floats, Floats]:
    """Enlarge the box for thrown spheres, as far as `CELLS` cells of this size [m] allow."""

    def excess(share: float) -> float:
        sides = high - low + share * (below + above)
        return float(np.prod(sides / cell)) - CELLS

    if excess(0.0) >= 0.0:
        return low, high
    share = 1.0 if excess(1.0) <= 0.0 else float(brentq(excess, 0.0, 1.0))
    return low - share * below, high + share * above


def _foot(at: Floats, rotation: Rotation) -> Floats:
    """The closest points of an axis."""
    origin, axis = np.array(rotation.origin_m), np.array(rotation.axis)
    return np.asarray(origin + ((at - origin) @ axis)[:, None] * axis)
