"""Shapes of walls: closed, of the right volume, at the right place."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pywet.cases.custom.walls import Removed, Wall
from pywet.geometry.surface import enclosed
from tests.cases.custom.conftest import EXAMPLES


def polygon_area(apothem: float, sides: int) -> float:
    return sides * apothem**2 * math.tan(math.pi / sides)


@pytest.mark.parametrize(
    ("shape", "volume_mm3"),
    [
        ({"block": {"low_mm": (0, 0, 0), "high_mm": (2, 3, 4)}}, 24.0),
        ({"disc": {"diameter_mm": 10, "thickness_mm": 2, "sides": 16}}, 2 * polygon_area(5, 16)),
        ({"disc": {"diameter_mm": 10, "thickness_mm": 2}}, 2 * polygon_area(5, 32)),
        (
            {"tube": {"inner_diameter_mm": 10, "length_mm": 7, "thickness_mm": 1, "sides": 12}},
            7 * (polygon_area(6, 12) - polygon_area(5, 12)),
        ),
        (
            {"vessel": {"inner_width_mm": 10, "height_mm": 5, "thickness_mm": 1}},
            6 * 144 - 5 * 100,
        ),
        (
            {"bars": {"diameter_mm": 2, "pitch_mm": 5, "length_mm": 30, "count": 3, "sides": 8}},
            3 * 30 * 0.5 * 8 * math.sin(2 * math.pi / 8),
        ),
    ],
)
def test_a_solid_has_its_volume(shape: dict[str, Any], volume_mm3: float) -> None:
    """Coordinates are rounded to single precision: 1e-7 of a length."""
    surface = Wall(name="w", **shape).surface(Path())
    assert enclosed(surface.corners) == pytest.approx(1e-9 * volume_mm3, rel=1e-5)


@pytest.mark.parametrize(("axis", "along"), [("x", 0), ("y", 1), ("z", 2)])
def test_a_tube_lies_along_its_axis(axis: str, along: int) -> None:
    """From its origin on, and closed outwards: a turn that mirrored it would have been refused."""
    tube = {"inner_diameter_mm": 10, "length_mm": 30, "axis": axis, "origin_mm": (1, 2, 3), "sides": 32}
    at = 1e3 * Wall(name="t", tube=tube).surface(Path()).vertices
    low, high = at.min(axis=0), at.max(axis=0)
    assert [low[along], high[along]] == pytest.approx([(1, 2, 3)[along], (1, 2, 3)[along] + 30], abs=1e-4)
    middle = 0.5 * (low + high)
    others = [k for k in range(3) if k != along]
    assert middle[others] == pytest.approx(np.array((1, 2, 3))[others], abs=0.05)


@pytest.mark.parametrize("shape", [{}, {"crimp_mm": 0.5}])
@pytest.mark.parametrize(("axis", "across"), [("x", 1), ("y", 0)])
def test_bars_lie_about_their_origin(axis: str, across: int, shape: dict[str, float]) -> None:
    """From end to end the length, and two pitches and a diameter across."""
    bars = {"diameter_mm": 2, "pitch_mm": 5, "length_mm": 30, "count": 3, "axis": axis, "origin_mm": (1, 2, 3), **shape}
    at = 1e3 * Wall(name="deck", bars=bars).surface(Path()).vertices
    size = np.ptp(at, axis=0)
    assert size[[1 - across, across]] == pytest.approx([30.0, 12.0], abs=1e-4)
    assert 0.5 * (at.min(axis=0) + at.max(axis=0)) == pytest.approx((1, 2, 3), abs=1e-4)


def test_an_stl_file_is_read_in_its_unit() -> None:
    """The hopper of the examples, in mm: 24 high, its volume that of its cones' difference."""
    surface = Wall(name="hopper", stl="hopper.stl").surface(EXAMPLES)
    assert np.ptp(surface.vertices[:, 2]) == pytest.approx(0.024)
    cone = [24.0 / 3.0 * 24 * math.tan(math.pi / 24) * (a * a + a * b + b * b) for a, b in ((10, 24), (12, 26))]
    assert enclosed(surface.corners) == pytest.approx(1e-9 * (cone[1] - cone[0]), rel=1e-5)
    metres = Wall(name="hopper", stl="hopper.stl", stl_unit="m").surface(EXAMPLES)
    assert enclosed(metres.corners) == pytest.approx(1e9 * enclosed(surface.corners), rel=1e-5)


def test_a_removed_wall_leaves_its_initial_position() -> None:
    corners = np.array([[0.0, 0, 0], [0.03, 0, 0], [0.03, 0.01, 0]])
    slide = Removed(at_s=0.1, towards=(2, 0, 0), speed_m_per_s=0.5).engine_motion(corners)
    assert slide.velocity_m_per_s == (0.5, 0.0, 0.0) and slide.opens_at_s == 0.1
    assert slide.travel_s * 0.5 == pytest.approx(0.06)
