"""Large thin walls divide their own triangles: the same solid, none below the angle at which LIGGGHTS stops, taken by it."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pywet.cases.custom.walls import Wall
from pywet.geometry import Surface, make_surface, write_stl
from pywet.geometry.slivers import SMALLEST_ANGLE_DEG
from pywet.geometry.solids import plate, square
from pywet.geometry.surface import enclosed
from tests.error_codes import raises_code


def ring(inner: float, thickness: float, sides: int) -> float:
    return sides * math.tan(math.pi / sides) * ((0.5 * inner + thickness) ** 2 - (0.5 * inner) ** 2)


SHAPES: list[tuple[dict[str, Any], float]] = [
    ({"vessel": {"inner_width_mm": 400, "height_mm": 100}}, 3 * 406**2 + 100 * (406**2 - 400**2)),
    ({"block": {"low_mm": (0, 0, 0), "high_mm": (900, 800, 3)}}, 900 * 800 * 3.0),
    ({"tube": {"inner_diameter_mm": 50, "length_mm": 700}}, 700 * ring(50, 3, 32)),
]
"""Shapes with walls of 3 mm at real sizes, and their volumes [mm3]."""


@pytest.mark.parametrize(("shape", "volume_mm3"), SHAPES)
def test_a_shape_of_real_size_divides_its_triangles(shape: dict[str, Any], volume_mm3: float) -> None:
    """Expect the same volume within single precision, and the parts of the same small shape, which needs no division."""
    key, sizes = next(iter(shape.items()))
    thin = Wall(name="w", **shape).surface(Path())
    small = Wall(
        name="w", **{key: {**sizes, "thickness_mm": 40} if key != "block" else {**sizes, "high_mm": (9, 8, 3)}}
    )
    assert thin.angles_deg.min() >= SMALLEST_ANGLE_DEG
    assert enclosed(thin.corners) == pytest.approx(1e-9 * volume_mm3, rel=2e-5)
    assert len(thin.part_half_width) == len(small.surface(Path()).part_half_width)
    assert np.array_equal(np.unique(thin.part), np.arange(len(thin.part_half_width)))


@pytest.mark.skipif(shutil.which("liggghts") is None, reason="the engine is not installed")
def test_the_engine_takes_divided_walls_and_stops_where_they_are_not(
    tmp_path: Path, liggghts: Callable[[str], str]
) -> None:
    """Undivided, a plate 1 % above arccos(1 - 1e-5) = 0.2562 deg runs with a warning, 1 % below it stops."""
    thin = make_surface("thin", "wall", plate(square(0.4), 0.0, 0.0035))
    printed = liggghts(deck(thin, tmp_path))
    assert f"mesh thin containing {len(thin.triangles)} triangle(s) successful" in printed
    assert "highly skewed" not in printed and len(thin.triangles) > 12

    def raw(thickness: float) -> Surface:
        parts = plate(square(0.4), 0.0, thickness)
        corners = np.concatenate([c for c, _ in parts])
        vertices, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
        part = np.repeat(np.arange(len(parts)), [len(c) for c, _ in parts])
        return Surface("thin", "wall", vertices, index.reshape(-1, 3), part, tuple(h for _, h in parts))

    stops = math.degrees(math.acos(1.0 - 1e-5))
    assert "highly skewed" in liggghts(deck(raw(0.8 * math.tan(math.radians(1.01 * stops))), tmp_path))
    with pytest.raises(AssertionError, match="assert 1 == 0"):  # its exit status
        liggghts(deck(raw(0.8 * math.tan(math.radians(0.99 * stops))), tmp_path))


def deck(surface: Surface, folder: Path) -> str:
    write_stl(surface, folder / "thin.stl")
    return (
        "atom_style granular\nboundary f f f\nnewton off\ncommunicate single vel yes\nunits si\n"
        "region box block -0.5 0.5 -0.5 0.5 -0.1 0.1 units box\ncreate_box 1 box\nneighbor 0.001 bin\n"
        "fix m1 all property/global youngsModulus peratomtype 5.e6\nfix m2 all property/global poissonsRatio peratomtype 0.3\n"
        "fix m3 all property/global coefficientRestitution peratomtypepair 1 1.0\n"
        "fix m4 all property/global coefficientFriction peratomtypepair 1 0.0\n"
        "fix m5 all property/global characteristicVelocity scalar 1.0\npair_style gran model hooke\npair_coeff * *\n"
        "fix thin all mesh/surface file thin.stl type 1\nfix walls all wall/gran model hooke mesh n_meshes 1 meshes thin\n"
        "fix i all nve/sphere\ncreate_atoms 1 single 0 0 0.05 units box\nset group all diameter 0.003 density 1000.0\nrun 2\n"
    )


def test_a_point_that_no_division_makes_blunter_is_refused_with_its_place() -> None:
    """A wedge of 0.3 deg."""
    outline = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1 * math.tan(math.radians(0.3))]])
    with raises_code("surface.sharp"):
        make_surface("wedge", "wall", plate(outline, 0.0, 0.01))
