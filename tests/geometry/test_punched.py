"""Punched plates and woven wires: closed surfaces whose volume and open area are those of closed forms."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest

from pywet.geometry.punched import SIDES, Punching
from pywet.geometry.solids import plate, woven
from pywet.geometry.surface import enclosed, make_surface
from pywet.products.apertures import holes
from reference_impl.tables import screen_wall

HOLE, PITCH = 5e-3, 7e-3


@pytest.mark.parametrize(("shape", "staggered"), [("round", True), ("round", False), ("square", False)])
@pytest.mark.parametrize("columns", [1, 4, 5])
def test_a_plate_is_closed_and_its_volume_is_that_of_what_is_left(
    shape: Literal["round", "square"], staggered: bool, columns: int
) -> None:
    """A regular polygon of 24 sides about a circle has the area 24 tan(pi/24) r^2; the number of holes follows from the mesh."""
    plate = Punching(0.06, 0.007 * columns, HOLE, PITCH, columns, shape, staggered)
    surface = make_surface("plate", "wall", plate.parts(-2e-3, 0.0))
    one = HOLE**2 if shape == "square" else SIDES * math.tan(math.pi / SIDES) * (0.5 * HOLE) ** 2
    assert plate.count == 8 and len(plate.centres) == 8 * columns
    assert enclosed(surface.corners) == pytest.approx(2e-3 * (0.06 * 0.007 * columns - 8 * columns * one), rel=1e-6)
    assert holes(surface.corners) == screen_wall.holes(surface.corners) == 8 * columns
    away = np.linalg.norm(plate.centres[:, None] - plate.centres, axis=2)
    assert columns == 1 or away[away > 0].min() >= (PITCH if not staggered else 0.0) - 1e-12


def test_triangles_around_a_hole_point_up_and_cover_the_land_once() -> None:
    surface = make_surface("plate", "wall", Punching(0.03, 0.014, HOLE, PITCH, 2).parts(-2e-3, 0.0))
    top = surface.normals[:, 2] > 0.5
    assert (surface.normals[np.abs(surface.normals[:, 2]) > 0.1][:, 2] ** 2 > 1 - 1e-9).all()
    polygon = SIDES * math.tan(math.pi / SIDES) * (0.5 * HOLE) ** 2
    assert surface.area[top].sum() == pytest.approx(0.03 * 0.014 - 6 * polygon, rel=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_woven_wire_has_the_volume_of_a_straight_one_and_waves(sign: float) -> None:
    """Sections across the axis are polygons; the axis is up by the crimp at one crossing and down at the next."""
    solid = woven(np.array([0.0, 0.0, 0.0]), np.array([0.049, 0.0, 0.0]), 1e-3, 8, 7e-3, sign * 1e-3, 3.5e-3)
    surface = make_surface("wire", "wall", [(solid, 1e-3)])
    assert enclosed(surface.corners) == pytest.approx(
        8 * math.sin(math.pi / 8) * math.cos(math.pi / 8) * 1e-6 * 0.049, rel=1e-4
    )
    for k in range(7):
        at = surface.vertices[np.abs(surface.vertices[:, 0] - 7e-3 * (k + 0.5)) < 1e-6]
        assert at[:, 2].mean() == pytest.approx(sign * (-1) ** k * 1e-3, abs=1e-8)
    assert holes(surface.corners) == screen_wall.holes(surface.corners) == 0


@pytest.mark.parametrize("other", [(1.0, 1.0, 1.0), (3.0, 0.0, 0.0)], ids=["touch in a corner", "apart"])
def test_two_blocks_have_no_hole_between_them(other: tuple[float, float, float]) -> None:
    block = make_surface("block", "wall", plate(1e-3 * np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]), 0.0, 1e-3)).corners
    both = np.concatenate([block, block + 1e-3 * np.array(other)])
    assert holes(both) == screen_wall.holes(both) == 0
