"""What is measured of a loaded run: the slope of a heap, the angle of a drum's bed, the rate of discharge."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pywet import stages
from pywet.runs.loaded import Run, unit
from pywet.runs.measures import bed_angle, heap_angle, steady_rate, upward
from pywet.runs.retired import taken_out
from pywet.runs.rundir import bridge_ends
from pywet.scene import Rotation
from tests.cases.screening import synthetic
from tests.error_codes import raises_code


@pytest.mark.parametrize("angle", [15.0, 30.0, 45.0])
def test_a_cone_of_spheres_has_the_slope_of_the_cone(angle: float) -> None:
    """Spheres on a fine lattice inside a cone: the surface is known; a ring of two radii allows some degrees."""
    r, height = 1e-3, 0.02 * math.tan(math.radians(angle))
    grid = np.mgrid[-0.02:0.02:0.5e-3, -0.02:0.02:0.5e-3, 0.0:0.02:0.5e-3].reshape(3, -1).T
    inside = grid[grid[:, 2] < height - np.hypot(grid[:, 0], grid[:, 1]) * math.tan(math.radians(angle))]
    assert heap_angle(inside + np.array([0.01, 0.0, r]), np.full(len(inside), r)) == pytest.approx(angle, abs=2.0)


def test_a_layer_has_no_slope() -> None:
    flat = np.column_stack([np.mgrid[0:5, 0:5].reshape(2, -1).T * 2e-3, np.zeros(25)])
    assert math.isnan(heap_angle(flat, np.full(25, 1e-3)))


def test_units_are_read_from_the_end_of_a_name() -> None:
    assert [unit(c) for c in ("wall_tray_m3", "time_s", "largest_speed_m_per_s", "mean_overlap")] == [
        "m3",
        "s",
        "m/s",
        "-",
    ]


def test_a_table_that_is_loaded_tells_its_units(tmp_path: Path) -> None:
    """Compare units and codes in the attributes of a table with those of the schema."""
    run = Run(synthetic.make(tmp_path / "run"))
    events, places = run.events.attrs, run.trajectory.attrs["units"]
    assert (events["units"]["volume"], places["vx"], places["id"]) == ("m3", "m/s", "-")
    assert "volume" in events["meanings"] and "kind" in events["codes"]


DRUM = Rotation(origin_m=(0.01, 0.0, 0.02), axis=(0.0, 2.0, 0.0), period_s=2.0)


@pytest.mark.parametrize("angle", [0.0, 25.0, 40.0])
def test_a_segment_has_the_angle_of_its_surface(angle: float) -> None:
    """Points on a lattice of 0.5 % of the radius below a plane through the drum: the lattice's edge allows 0.3 degrees."""
    x, z = np.mgrid[-1:1:0.005, -1:1:0.005].reshape(2, -1)
    slope = math.tan(math.radians(angle))
    inside = (x * x + z * z < 1.0) & (z < slope * x - 0.2 * math.hypot(1.0, slope))
    at = 0.05 * np.column_stack([x, np.ones_like(x), z])[inside] + np.array(DRUM.origin_m)
    up = np.array([0.0, 0.0, 1.0])
    assert bed_angle(at, np.ones(len(at)), DRUM, up) == pytest.approx(angle, abs=0.3)


def test_a_flat_bed_has_an_angle_whatever_rounds() -> None:
    """A sphere right below the axis, in any direction: the cosine of its angle may be rounded to more than 1."""
    for up in np.random.default_rng(1).normal(size=(100, 3)):
        up /= np.linalg.norm(up)
        turning = DRUM.model_copy(update={"axis": (up[1], -up[0], 0.0)})
        at = np.array([DRUM.origin_m]) - 0.03 * up
        assert bed_angle(at, np.ones(1), turning, up) == pytest.approx(0.0, abs=1e-5)


def test_a_steady_flow_has_its_rate() -> None:
    """2 g/s between a slow start and a slow end, of which the slope of the middle knows nothing."""
    time = np.linspace(0.0, 2.0, 201)
    passed = np.clip(2e-3 * (time - 0.5), 0.0, 2e-3)
    assert steady_rate(time, passed) == pytest.approx(2e-3, rel=1e-9)
    with raises_code("discharge.none"):
        steady_rate(time, np.zeros(201))
    with raises_code("discharge.few_outputs"):
        steady_rate(time[::100], passed[::100])


def test_the_synthetic_case_has_its_fraction_retained_and_discharge(tmp_path: Path) -> None:
    """Two spheres of 2 mm (4/3 π r³ 1400 kg/m³ = 46.9 mg each) are below the bin's height, one from each later output on."""
    run = Run(synthetic.make(tmp_path / "run"))
    with raises_code("run.no_bin"):
        run.discharge()
    stages.results(tmp_path / "run")
    table = run.fraction_retained
    assert table.attrs["units"]["fraction_retained"] == "-" and table.attrs["units"]["time_s"] == "s"
    assert table["fraction_retained"].iloc[0] == 1.0
    one = 4 / 3 * math.pi * 2e-3**3 * 1400
    assert run.discharge()["passed_kg"].tolist() == pytest.approx([0.0, one, 2 * one], rel=1e-12)
    assert run.discharge(0.015)["passed_kg"].iloc[0] == pytest.approx(one + 4 / 3 * math.pi * 4e-3**3 * 1400, rel=1e-12)
    assert run.discharge().attrs["units"]["passed_kg"] == "kg"


def test_what_a_scene_does_not_have_is_refused(tmp_path: Path) -> None:
    """No fraction retained without a bin; no heap in a drum, no drum without a turning wall; each names the other measure."""
    run = Run(synthetic.make(tmp_path / "run"))
    with raises_code("run.no_fraction"):
        _ = run.fraction_retained
    with raises_code("run.no_drum"):
        run.drum_angle()
    walls = tuple(w.model_copy(update={"motion": "turns"}) for w in run.scene.walls)
    run.scene = run.scene.model_copy(update={"walls": walls, "rotation": DRUM})
    with raises_code("run.turns"):
        run.angle_of_repose()
    with raises_code("run.late"):
        run.drum_angle(from_s=9.0)
    assert 0.0 < run.drum_angle() < 180.0


def drum_of(axis: tuple[float, float, float], waiting: bool = False) -> Run:
    """A run of 2 s with a bed at 10 degrees up to 0.5 s and at 30 degrees from then on; spheres may wait outside."""
    x, z = np.mgrid[-1:1:0.02, -1:1:0.02].reshape(2, -1)
    frames = []
    for step in range(5):
        slope = math.tan(math.radians(10.0 if step < 2 else 30.0))
        inside = (x * x + z * z < 1.0) & (z < slope * x - 0.2 * math.hypot(1.0, slope))
        at = 0.05 * np.column_stack([x, np.ones_like(x), z])[inside] + np.array(DRUM.origin_m)
        frames.append(pd.DataFrame(at, columns=list("xyz")).assign(step=step, type=1, id=1))
        waits = [pd.DataFrame({"x": [0.3], "y": [0.0], "z": [0.3], "step": step, "type": 1, "id": 2})] * 5000
        frames += waits if waiting else []
    run = Run.__new__(Run)
    run.path = Path("drum")
    way = DRUM.model_copy(update={"axis": axis})
    line = SimpleNamespace(steps=np.arange(5), times=0.5 * np.arange(5))
    parts: dict[str, Any] = {
        "scene": SimpleNamespace(
            gravity_m_per_s2=(0.0, 0.0, -9.81), duration_s=2.0, classes=[SimpleNamespace(type=1, mass_kg=1.0)]
        ),
        "_run": SimpleNamespace(
            timeline=line,
            trajectory=pd.concat(frames),
            spheres=pd.DataFrame({"id": [1, 2]}),
            enters=np.array([0, 5]),
        ),
        "_turning": lambda: [way],
    }
    vars(run).update(parts)
    return run


def test_drum_angle_is_that_of_the_second_half() -> None:
    """Expect 30 degrees from 1 s on, the mean of both from the start."""
    run = drum_of((0.0, 2.0, 0.0))
    assert run.drum_angle() == pytest.approx(30.0, abs=1.0)
    assert run.drum_angle(0.0) == pytest.approx((2 * 10.0 + 3 * 30.0) / 5, abs=1.0)


def test_spheres_that_wait_outside_are_not_of_the_bed() -> None:
    """Inserted spheres hang outside until they enter: neither the bed of a drum nor a heap contains them."""
    assert drum_of((0.0, 2.0, 0.0), waiting=True).drum_angle() == pytest.approx(30.0, abs=1.0)
    r, slope = 1e-3, math.tan(math.radians(30.0))
    x, y = 0.5e-3 * np.mgrid[-40:41, -40:41].reshape(2, -1)
    z = 0.02 * slope - np.hypot(x, y) * slope
    heap = pd.DataFrame({"x": x, "y": y, "z": z, "step": 9, "type": 1, "id": 1})[z > 0.0]
    outside = pd.DataFrame({"x": [0.003], "y": [0.0], "z": [0.5], "step": 9, "type": 1, "id": 2})
    angles = []
    for table in (heap, pd.concat([heap, outside])):
        run = drum_of((0.0, 2.0, 0.0))
        vars(run).update({"_turning": list, "scene": SimpleNamespace(classes=[SimpleNamespace(type=1, radius_m=r)])})
        vars(run)["_run"].trajectory, vars(run)["_run"].enters = table, np.array([0, 10])
        angles.append(run.angle_of_repose())
    assert angles[0] == angles[1] == pytest.approx(30.0, abs=2.0)


def test_a_drum_is_at_most_30_degrees_off_the_horizontal() -> None:
    for cosine, taken in ((0.498, True), (0.502, False)):
        run = drum_of((0.0, (1.0 - cosine**2) ** 0.5, cosine))
        if taken:
            assert math.isfinite(run.drum_angle())
        else:
            with raises_code("run.no_drum"):
                run.drum_angle()


def test_without_gravity_up_is_z() -> None:
    assert upward((0.0, 0.0, 0.0)).tolist() == [0.0, 0.0, 1.0]
    assert upward((0.0, -4.0, 0.0)).tolist() == [0.0, 1.0, 0.0]


def test_bridges_between_the_same_ends_have_the_same_number() -> None:
    """Expect six numbers for six pairs of ends that differ in one of kind, i and j."""
    ends = [(kind, i, j) for kind in (0, 1) for i, j in ((3, 4), (3, 5), (4, 5))]
    table = pd.DataFrame(ends * 2, columns=["partner_kind", "i", "j"])
    numbers = bridge_ends(table)
    assert len(set(numbers)) == 6 and (numbers[:6] == numbers[6:]).all()


def test_liquid_that_leaves_is_counted_at_its_outlet() -> None:
    """Spheres 1 and 3 leave through the first outlet at steps 10 and 20, sphere 2 through the second at 20."""
    table = pd.DataFrame({"step": [10, 20, 20], "id": [1, 2, 3], "outlet": [1, 2, 1], "film": [1.0, 2.0, 4.0]})
    line = SimpleNamespace(steps=np.array([0, 10, 20, 30]), ids=np.array([1, 2, 3]))
    run: Any = SimpleNamespace(timeline=line, scene=SimpleNamespace(outlets=("a", "b")), table=lambda name: table)
    gone, booked = taken_out(run)
    assert booked.tolist() == [[0.0, 0.0], [1.0, 0.0], [5.0, 2.0], [5.0, 2.0]]
    assert gone.tolist() == [[False] * 3, [False] * 3, [True, False, False], [True] * 3]
