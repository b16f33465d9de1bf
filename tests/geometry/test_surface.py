"""Closedness, orientation and shape of surfaces; single solids against closed formulas."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pywet.geometry import Apparatus, Surface, check_surface, make_surface
from pywet.geometry.solids import bin_solid, plate, tube, wire
from pywet.geometry.surface import enclosed
from tests.error_codes import raises_code

SINGLE = 2e-6
"""Relative tolerance of a length of millimetres next to coordinates of 0.1 m in single precision (6e-9 m)."""


@pytest.fixture
def box() -> Surface:
    square = np.array([[0.0, 0.0], [0.02, 0.0], [0.02, 0.03], [0.0, 0.03]])
    return make_surface("box", "wall", plate(square, 0.0, 0.004))


def euler(surface: Surface) -> int:
    ends = np.sort(np.stack([surface.triangles, np.roll(surface.triangles, -1, axis=1)], axis=2), axis=2)
    edges = len(np.unique(ends.reshape(-1, 2), axis=0))
    return len(surface.vertices) - edges + len(surface.triangles)


def test_euler_characteristic_tells_bodies_and_holes(apparatus: Apparatus) -> None:
    """2 for every body without a hole (wires, plates, bins), 0 for a tube."""
    for surface in apparatus.surfaces:
        bodies = len(surface.part_half_width) if surface.name == "wires" else 1
        expected = 0 if surface.name in ("side_wall", "feed_bin", "outlet") else 2 * bodies
        assert euler(surface) == expected, surface.name
        assert surface.components()[0] == bodies


def test_every_surface_is_accepted_and_has_no_sliver(apparatus: Apparatus) -> None:
    for surface in apparatus.surfaces:
        check_surface(surface)
        assert surface.angles_deg.min() >= 1.0
        np.testing.assert_allclose(surface.angles_deg.sum(axis=1), 180.0, rtol=1e-12)
        np.testing.assert_array_equal(surface.vertices, surface.vertices.astype(np.float32))


@pytest.mark.parametrize("sides", [4, 6, 8, 12])
@pytest.mark.parametrize("length", [0.003, 0.056, 0.204])
def test_wire_volume_is_the_analytic_wires(sides: int, length: float) -> None:
    radius = 0.001
    corners = wire(np.array([-0.5 * length, 0.02, 0.0]), np.array([0.5 * length, 0.02, 0.0]), radius, sides, 1.02)
    surface = make_surface("w", "wires", [(corners, radius)])
    analytic_wire = 0.5 * sides * radius**2 * math.sin(2 * math.pi / sides) * length
    assert enclosed(surface.corners) == pytest.approx(analytic_wire, rel=SINGLE * 5)
    assert surface.area.sum() == pytest.approx(
        2 * sides * radius * math.sin(math.pi / sides) * length + 2 * analytic_wire / length, rel=SINGLE * 5
    )


def test_wire_is_cut_no_more_than_its_angle_needs() -> None:
    """One step of at most s/tan(angle): a face of n steps has n + 1 triangles, a cap two less than sides."""
    corners = wire(np.array([-0.1, 0.0, 0.0]), np.array([0.1, 0.0, 0.0]), 0.001, 8, 1.0)
    steps = math.ceil(0.2 / (0.002 * math.sin(math.pi / 8) / math.tan(math.radians(1.0))))
    assert len(corners) == 8 * (steps + 1) + 2 * 6


def test_tube_and_bin_volumes() -> None:
    apothem, t, low, high = 0.025, 0.004, -0.01, 0.05
    for sides in (4, 24):
        ring = sides * math.tan(math.pi / sides) * ((apothem + t) ** 2 - apothem**2)
        pipe = make_surface("tube", "wall", tube(apothem, t, sides, low, high))
        assert enclosed(pipe.corners) == pytest.approx(ring * (high - low), rel=SINGLE * 5)
        floor = sides * math.tan(math.pi / sides) * (apothem + t) ** 2 * t
        vessel = make_surface("bin", "wall", bin_solid(apothem, t, sides, low, high))
        assert enclosed(vessel.corners) == pytest.approx(ring * (high - low) + floor, rel=SINGLE * 5)


def test_normals_point_out_of_the_solid(apparatus: Apparatus) -> None:
    """The inner face of the side wall looks at the axis, the outer one away from it, rims up and down."""
    side_wall = next(s for s in apparatus.surfaces if s.name == "side_wall")
    centre = side_wall.corners.mean(axis=1)
    radial = np.einsum("ij,ij->i", side_wall.normals[:, :2], centre[:, :2]) / np.hypot(*centre[:, :2].T)
    part = side_wall.part
    faces = 4 if len(side_wall.part_half_width) == 10 else 1
    assert (radial[part < faces] < -0.5).all()
    assert (radial[(part >= faces) & (part < 2 * faces)] > 0.5).all()
    assert (side_wall.normals[part == 2 * faces][:, 2] > 0.999).all()
    assert (side_wall.normals[part == 2 * faces + 1][:, 2] < -0.999).all()


def test_large_and_small_parts(apparatus: Apparatus) -> None:
    """Wires have their radius, rims half their thickness, faces from 10 mm width are large walls."""
    surfaces = {s.name: s for s in apparatus.surfaces}
    assert len(set(surfaces["wires"].part_half_width)) == 1
    assert surfaces["wires"].part_half_width[0] in (0.001, 0.0008)
    assert surfaces["side_wall"].part_half_width[-1] == pytest.approx(0.002, rel=1e-6)
    assert surfaces["side_wall"].part_half_width[0] is None
    assert surfaces["impact_plate"].part_half_width[:2] == (None, None)


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda s: {"triangles": s.triangles[:-1], "part": s.part[:-1]}, "surface.open"),
        (lambda s: {"triangles": s.triangles[:, ::-1]}, "surface.inward"),
        (lambda s: {"triangles": np.vstack([s.triangles[:1, ::-1], s.triangles[1:]])}, "surface.open"),
        (lambda s: {"vertices": s.vertices * [1.0, 1.0, 0.01]}, "surface.sharp"),
        (lambda s: {"vertices": s.vertices * [1.0, 1.0, 0.0]}, "surface.close_vertices"),
        (lambda s: {"vertices": s.vertices * math.nan}, "surface.not_finite"),
        (lambda s: {"part": s.part[::-1]}, "surface.part_order"),
        (lambda s: {"part_half_width": (None,)}, "surface.part_order"),
    ],
)
def test_bad_surfaces_are_refused_in_one_sentence(box: Surface, change: object, code: str) -> None:
    with raises_code(code) as caught:
        check_surface(replace(box, **change(box)))  # type: ignore[operator]
    assert "\n" not in str(caught.value)
