"""The simulated box holds every moving wall at all times, for any axis and motion, and the spheres that walls throw."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import pywet
from pywet import scene as typed
from pywet.cases.custom import extent
from pywet.cases.custom.building import Building
from tests.cases.custom.conftest import beads

SIZE = st.floats(-60.0, 60.0).map(lambda v: round(v, 9))
VECTOR = st.tuples(SIZE, SIZE, SIZE)
AXIS = VECTOR.filter(lambda v: math.hypot(*v) > 1.0)
SPAN = st.floats(0.01, 2.0)


def times(v: Any, factor: float) -> Any:
    return tuple(factor * x for x in v)


MOTIONS = st.one_of(
    st.builds(
        lambda axis, at, rpm: {"turns": {"turns_per_minute": rpm, "axis": axis, "origin_mm": at}},
        AXIS, VECTOR, st.floats(1.0, 300.0),
    ),
    st.builds(
        lambda a, p, f: {"vibrates": {"amplitude_mm": times(a, 0.1), "phase_deg": times(p, 3), "frequency_Hz": f}},
        VECTOR, VECTOR, st.floats(1.0, 80.0),
    ),
    st.builds(
        lambda v, a, d: {"moves": {"velocity_m_per_s": times(v, 0.01), "from_s": a, "for_s": d}}, VECTOR, SPAN, SPAN
    ),
    st.builds(lambda v, a: {"removed": {"at_s": a, "towards": v}}, AXIS, SPAN),
)  # fmt: skip


def positions(at: np.ndarray, wall: dict[str, Any], t: float) -> np.ndarray:
    """Corners [mm] at a time by the definitions in the docs, on their own."""
    if "turns" in wall:
        w = wall["turns"]
        unit = np.array(w["axis"]) / math.hypot(*w["axis"])
        turn = Rotation.from_rotvec(unit * 2 * math.pi * w["turns_per_minute"] / 60 * t)
        return turn.apply(at - w["origin_mm"]) + w["origin_mm"]
    if "vibrates" in wall:
        w = wall["vibrates"]
        phase = np.radians(w["phase_deg"])
        return at + np.array(w["amplitude_mm"]) * (np.sin(2 * math.pi * w["frequency_Hz"] * t + phase) - np.sin(phase))
    if "moves" in wall:
        w = wall["moves"]
        return at + 1e3 * np.array(w["velocity_m_per_s"]) * min(max(t - w["from_s"], 0.0), w["for_s"])
    w = wall["removed"]
    unit = np.array(w["towards"]) / math.hypot(*w["towards"])
    return at + unit * min(1e3 * max(t - w["at_s"], 0.0), 2.0 * np.ptp(at @ unit))


@settings(max_examples=60, deadline=None)
@given(wall=MOTIONS, low=VECTOR, size=st.tuples(*[st.floats(5.0, 80.0)] * 3))
def test_the_box_holds_every_moving_wall_at_all_times(wall: dict[str, Any], low: Any, size: Any) -> None:
    """With a sphere's diameter to spare, at 40 times of 3 s; the beads hover far above."""
    block = {"low_mm": low, "high_mm": tuple(a + b for a, b in zip(low, size, strict=True))}
    spheres = [{"name": "beads", "material": "glass", "diameter_mm": 3, "at_mm": [(0, 0, 900)]}]
    walls = [{"name": "w", "block": block, **wall}]
    made = Building(pywet.Scene(**beads(spheres=spheres, walls=walls, duration_s=3.0)))
    box_low, box_high = (1e3 * corner for corner in made.box)
    at = 1e3 * made.surfaces[0].vertices
    for t in np.linspace(0.0, 3.0, 41):
        there = positions(at, wall, t)
        assert (there >= box_low + 3.0).all() and (there <= box_high - 3.0).all()


def test_a_paddle_about_a_tilted_axis_reaches_as_far_as_it_is_long_over_the_root_of_two() -> None:
    """About (0, 1, 1) a half length of 60 mm reaches 42.4 mm along y and z, not 17.6 mm."""
    axis = (0.0, math.sqrt(0.5), math.sqrt(0.5))
    ends = np.array([[-0.06, 0.0, 0.0], [0.06, 0.0, 0.0]])
    reached = np.concatenate(extent.moved(ends, typed.Rotation(origin_m=(0, 0, 0), axis=axis, period_s=0.3)))
    assert reached.max(axis=0) == pytest.approx([0.06, 0.0424264, 0.0424264], rel=1e-5)


def test_a_wall_that_moves_longer_than_the_run_reaches_as_far_as_in_the_run() -> None:
    """At 0.5 m/s from 0.2 s on: 0.4 m in a run of 1 s, however long it would go on."""
    slide = typed.Slide(velocity_m_per_s=(0.5, 0.0, 0.0), opens_at_s=0.2, travel_s=100.0)
    assert extent.moved(np.zeros((1, 3)), slide, 1.0)[0][0] == pytest.approx([0.4, 0.0, 0.0])


@settings(max_examples=60, deadline=None)
@given(
    v=st.tuples(*[st.floats(-1.0, 1.0)] * 3), speed=st.floats(0.01, 5.0), gravity=st.tuples(*[st.floats(-9.81, 9.81)] * 3),
    duration=st.floats(0.01, 2.0),
)  # fmt: skip
def test_margin_for_thrown_spheres(v: Any, speed: float, gravity: Any, duration: float) -> None:
    """Thrown anywhere at twice the wall's speed or slower, a sphere stays within until it is as low as it began."""
    start = 2.0 * speed * np.array(v) / max(1.0, math.hypot(*v))
    below, above = extent.thrown(speed, gravity, duration)
    for t in np.linspace(0.0, duration, 50):
        way = start * t + 0.5 * np.array(gravity) * t * t
        if way @ np.array(gravity) <= 0.0:  # not lower than the start
            assert (way >= -below * (1 + 1e-9) - 1e-12).all() and (way <= above * (1 + 1e-9) + 1e-12).all()


def test_margin_for_thrown_spheres_is_bounded_by_the_cells_of_the_box() -> None:
    """A wall of 100 m/s would throw 2 km high."""
    below, above = extent.thrown(100.0, (0.0, 0.0, -9.81), 1e3)
    low, high = extent.with_margin(np.zeros(3), np.full(3, 0.05), below, above, 0.003)
    assert np.prod((high - low) / 0.003) <= extent.CELLS * (1 + 1e-9)
    assert low[2] == 0.0 and high[2] > 0.05


def test_the_box_leaves_a_centimetre_and_the_largest_diameter_around_all_spheres() -> None:
    """Of the largest class, whichever it is listed as."""
    classes = [
        {"name": f"beads {k}", "material": "glass", "diameter_mm": size, "at_mm": [[10.0 * k, 0, 0]]}
        for k, size in enumerate((3, 8, 2))
    ]
    low, high = Building(pywet.Scene(**beads(spheres=classes))).extent
    assert 1e3 * low == pytest.approx([-18.0] * 3) and 1e3 * high == pytest.approx([38.0, 18.0, 18.0])
