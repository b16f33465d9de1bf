"""What is measured of a loaded run: the slope of a heap."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from pywet.runs.loaded import Run, heap_angle, unit
from tests.screening import synthetic


@pytest.mark.parametrize("angle", [15.0, 30.0, 45.0])
def test_a_cone_of_spheres_has_its_own_slope(angle: float) -> None:
    """Spheres on a fine lattice inside a cone: the surface is known; a ring of two radii allows some degrees."""
    r, height = 1e-3, 0.02 * math.tan(math.radians(angle))
    grid = np.mgrid[-0.02:0.02:0.5e-3, -0.02:0.02:0.5e-3, 0.0:0.02:0.5e-3].reshape(3, -1).T
    inside = grid[grid[:, 2] < height - np.hypot(grid[:, 0], grid[:, 1]) * math.tan(math.radians(angle))]
    assert heap_angle(inside + np.array([0.01, 0.0, r]), np.full(len(inside), r)) == pytest.approx(angle, abs=2.0)


def test_a_layer_has_no_slope() -> None:
    flat = np.column_stack([np.mgrid[0:5, 0:5].reshape(2, -1).T * 2e-3, np.zeros(25)])
    assert math.isnan(heap_angle(flat, np.full(25, 1e-3)))


def test_units_are_told_by_the_end_of_a_name() -> None:
    assert [unit(c) for c in ("wall_tray_m3", "time_s", "largest_speed_m_per_s", "mean_overlap")] == [
        "m3",
        "s",
        "m/s",
        "-",
    ]


def test_a_table_that_is_loaded_tells_its_units(tmp_path: Path) -> None:
    """Those of the schema, in the attributes of the table; codes of its numbers as well."""
    run = Run(synthetic.make(tmp_path / "run"))
    events, places = run.events.attrs, run.trajectory.attrs["units"]
    assert (events["units"]["volume"], places["vx"], places["id"]) == ("m3", "m/s", "-")
    assert "volume" in events["meanings"] and "kind" in events["codes"]
