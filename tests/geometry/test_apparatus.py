"""Apertures, gaps and heights of the whole apparatus, and dimensions that are refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pywet.geometry import Apparatus, ApparatusSpec, Surface, build_apparatus
from pywet.geometry.screen import build_wires, wire_positions
from tests.error_codes import raises_code

SMALLEST_DIAMETER = 0.003
ROUNDING = 2e-8


def named(apparatus: Apparatus) -> dict[str, Surface]:
    return {s.name: s for s in apparatus.surfaces}


def wire_extents(wires: Surface, axis: int) -> np.ndarray:
    """Lowest and highest coordinate along `axis` of every wire that runs across it."""
    rows = []
    for part in range(len(wires.part_half_width)):
        points = wires.corners[wires.part == part].reshape(-1, 3)
        if np.ptp(points[:, axis]) < np.ptp(points[:, 1 - axis]):
            rows.append((points[:, axis].min(), points[:, axis].max()))
    return np.array(sorted(rows))


@pytest.mark.parametrize("axis", [0, 1])
def test_free_aperture_is_the_true_one(apparatus: Apparatus, spec: ApparatusSpec, axis: int) -> None:
    """Between neighbouring wires the shortest distance is the aperture; at the wall it is never more."""
    extents = wire_extents(named(apparatus)["wires"], axis)
    np.testing.assert_allclose(extents[1:, 0] - extents[:-1, 1], spec.aperture_m, atol=ROUNDING)
    np.testing.assert_allclose(extents[:, 1] - extents[:, 0], spec.wire_diameter_m, atol=ROUNDING)
    half = 0.5 * apparatus.feed_region.width_m
    assert half - extents[-1, 1] <= spec.aperture_m
    assert extents[0, 0] + half <= spec.aperture_m


@pytest.mark.parametrize("width", np.linspace(0.045, 0.075, 31))
def test_openings_at_the_wall_never_exceed_the_aperture(width: float) -> None:
    position = wire_positions(0.010, 0.001, 0.5 * width)
    np.testing.assert_allclose(position, -position[::-1], atol=1e-15)
    assert 0.5 * width - (position[-1] + 0.001) <= 0.008 + 1e-9


def test_square_screen_has_whole_apertures(apparatus: Apparatus, spec: ApparatusSpec) -> None:
    if spec.shape == "cylinder":
        return
    pitches = round(spec.width_m / (spec.aperture_m + spec.wire_diameter_m))
    assert len(wire_extents(named(apparatus)["wires"], 0)) == pitches + 1


def test_wires_lie_in_one_plane_and_end_inside_the_wall(apparatus: Apparatus, spec: ApparatusSpec) -> None:
    wires = named(apparatus)["wires"]
    top = 0.5 * spec.wire_diameter_m * (1.0 if spec.wire_sides % 4 == 0 else math.sin(math.pi / 3))
    assert wires.vertices[:, 2].max() == pytest.approx(top, abs=ROUNDING)
    assert wires.vertices[:, 2].min() == pytest.approx(-top, abs=ROUNDING)
    sides = 4 if spec.shape == "square" else spec.cylinder_sides
    facing = 2 * math.pi * np.arange(sides) / sides
    normals = np.column_stack([np.cos(facing), np.sin(facing)])
    apothem = 0.5 * apparatus.feed_region.width_m
    for part in range(len(wires.part_half_width)):
        points = wires.corners[wires.part == part].reshape(-1, 3)
        axis = int(np.argmax(np.ptp(points[:, :2], axis=0)))
        for end in (points[:, axis].min(), points[:, axis].max()):
            cap = points[points[:, axis] == end][:, :2]
            depth = (cap @ normals.T).max(axis=1) - apothem
            assert depth.min() > 0.0


def test_equal_area_of_the_round_sieve(spec: ApparatusSpec, apparatus: Apparatus) -> None:
    if spec.shape == "square":
        return
    apothem = 0.5 * apparatus.feed_region.width_m
    area = spec.cylinder_sides * math.tan(math.pi / spec.cylinder_sides) * apothem**2
    assert area == pytest.approx(math.pi * 0.1**2, rel=1e-12)


def test_gaps_between_moving_and_resting_walls_hold_the_smallest_sphere(apparatus: Apparatus) -> None:
    """Clearance plus 1 mm of vibration stays under a diameter of 3 mm, and the clearance outlasts the vibration."""
    s = named(apparatus)
    gaps = [
        s["feed_bin"].vertices[:, 2].min() - s["side_wall"].vertices[:, 2].max(),
        s["collecting_bin"].corners[s["collecting_bin"].part == 1][:, :, 0].max() - s["outlet"].vertices[:, 0].max(),
    ]
    for gap in gaps:
        assert 0.001 < gap < SMALLEST_DIAMETER - 0.001
    assert s["outlet"].vertices[:, 2].max() == s["side_wall"].vertices[:, 2].min()
    assert s["outlet"].vertices[:, 2].min() < s["collecting_bin"].vertices[:, 2].max() - 0.004
    assert apparatus.bin_z < s["outlet"].vertices[:, 2].min() - 0.0009
    assert apparatus.bin_z > s["collecting_bin"].vertices[:, 2].min() + 0.03


def test_impact_plate_leaves_the_opening_and_lies_in_the_outlet(apparatus: Apparatus, spec: ApparatusSpec) -> None:
    s = named(apparatus)
    plate = s["impact_plate"].vertices
    opening = 0.5 * apparatus.feed_region.width_m - plate[:, 0].max()
    assert opening == pytest.approx(max(0.4 * spec.width_m, 3 * spec.aperture_m), abs=ROUNDING)
    assert plate[:, 2].min() >= s["outlet"].vertices[:, 2].min()
    assert plate[:, 2].max() == pytest.approx(-spec.wire_diameter_m - 2 * spec.aperture_m, abs=ROUNDING)
    slope = s["impact_plate"].normals[0]
    assert math.atan2(slope[0], slope[2]) == pytest.approx(spec.impact_plate_angle_rad, rel=5e-6)  # single precision


def test_cover_closes_the_feed_bin_within_its_height(apparatus: Apparatus) -> None:
    """No sphere leaves through the top, the box is as high as with an open feed bin, and the fill is below the cover."""
    s = named(apparatus)
    cover, rim, half = s["cover"].vertices, s["feed_bin"].vertices[:, 2].max(), 0.5 * apparatus.feed_region.width_m
    assert np.abs(cover[:, :2]).min() > half and s["cover"].motion == "fixed"
    assert cover[:, 2].max() == pytest.approx(rim, abs=ROUNDING)
    assert cover[:, 2].min() == pytest.approx(apparatus.feed_region.z_high_m, abs=ROUNDING)
    assert apparatus.box_high[2] == pytest.approx(rim + 0.010, abs=ROUNDING)


def test_slide_closes_the_bin_and_clears_it_when_drawn_out(apparatus: Apparatus) -> None:
    s = named(apparatus)
    slide, half = s["slide"].vertices, 0.5 * apparatus.feed_region.width_m
    assert np.abs(slide[:, :2]).min() > half
    assert slide[:, 0].min() + apparatus.slide_travel > half
    assert slide[:, 2].max() == pytest.approx(apparatus.feed_region.z_low_m, abs=ROUNDING)
    assert slide[:, 2].min() >= s["feed_bin"].vertices[:, 2].min()
    assert slide[:, 0].max() + apparatus.slide_travel < apparatus.box_high[0]


def test_box_contains_all_walls_with_margin(apparatus: Apparatus) -> None:
    for surface in apparatus.surfaces:
        assert (surface.vertices.min(axis=0) >= np.array(apparatus.box_low) + 0.005).all()
        assert (surface.vertices.max(axis=0) <= np.array(apparatus.box_high) - 0.005).all()


def test_few_triangles(apparatus: Apparatus, spec: ApparatusSpec) -> None:
    """The run time is set by the walls: 400 to 570 for the smoke sieves, 3000 to 4200 for the full ones."""
    assert sum(len(s.triangles) for s in apparatus.surfaces) <= (600 if spec.shape == "square" else 4200)


SMOKE = ApparatusSpec(0.008, 0.002, "square", 0.050, wire_sides=6)


@pytest.mark.parametrize(
    ("change", "code", "key"),
    [
        ({"aperture_m": 0.0015}, "apparatus.aperture", "aperture_m"),
        ({"aperture_m": -0.008}, "apparatus.number", "aperture_m"),
        ({"width_m": math.inf}, "apparatus.number", "width_m"),
        ({"width_m": 0.03}, "apparatus.small", "width_m"),
        ({"wire_sides": 7}, "apparatus.wire_sides", "wire_sides"),
        ({"cylinder_sides": 3}, "apparatus.cylinder_sides", "cylinder_sides"),
        ({"shape": "oval"}, "apparatus.shape", "shape"),
        ({"slide_height_m": 0.02}, "apparatus.slide_height", "slide_height_m"),
        ({"outlet_height_m": 0.03}, "apparatus.small", "outlet_height_m"),
        ({"wall_thickness_m": 0.001}, "apparatus.wall_thickness", "wall_thickness_m"),
        ({"collecting_bin_height_m": 0.01}, "apparatus.small", "collecting_bin_height_m"),
    ],
)
def test_dimensions_that_do_not_go_together_are_refused(change: dict[str, object], code: str, key: str) -> None:
    with raises_code(code, key=key) as caught:
        build_apparatus(replace(SMOKE, **change))  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


@settings(max_examples=60, deadline=None)
@given(
    sides=st.sampled_from([4, 6, 8, 10, 12, 16]),
    pitches=st.integers(3, 12),
    aperture_mm=st.floats(3.0, 10.0),
    share=st.sampled_from([0.2, 0.25, 0.3, 0.5]),
)
@example(sides=12, pitches=4, aperture_mm=8.0, share=0.25)
@example(sides=4, pitches=10, aperture_mm=8.0, share=0.25)
@example(sides=8, pitches=14, aperture_mm=5.6, share=0.2857142857142857)
@example(sides=4, pitches=3, aperture_mm=8.0, share=0.5)
def test_no_two_wires_share_a_node(sides: int, pitches: int, aperture_mm: float, share: float) -> None:
    """The engine would take two wires that share a node for one body; square sieves of whole apertures have none."""
    aperture, diameter = 1e-3 * aperture_mm, 1e-3 * aperture_mm * share
    half = 0.5 * pitches * (aperture + diameter)
    reach = half + 0.6 * diameter  # not the radius: the ends would lie in the faces of the last wires across
    wall = reach * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    wires = build_wires(aperture, diameter, sides, half, wall)
    assert wires.components()[0] == len(wires.part_half_width) == 2 * (pitches + 1)
