"""How deep spheres are in walls: the thickness of shapes, overlaps in the tables, a warning where one is pressed through."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import pywet
from pywet.cases.custom import at_walls, results
from pywet.cases.custom.building import Building
from pywet.cases.custom.walls import Wall
from reference_impl.tables.at_walls import thickness as thickness_again
from tests.cases.custom.conftest import EXAMPLES, beads


@pytest.mark.parametrize(
    ("shape", "thickness_mm"),
    [
        ({"block": {"low_mm": (0, 0, 0), "high_mm": (20, 30, 4)}}, 4.0),
        ({"disc": {"diameter_mm": 30, "thickness_mm": 2}}, 2.0),
        ({"tube": {"inner_diameter_mm": 30, "length_mm": 40, "thickness_mm": 1.5}}, 1.5),
        ({"vessel": {"inner_width_mm": 20, "height_mm": 15, "thickness_mm": 2.5}}, 2.5),
        ({"stl": "hopper.stl"}, 2 * 24 / math.hypot(24, 14)),
    ],
)
def test_the_thickness_of_a_wall_is_that_of_its_thinnest_place(shape: dict[str, Any], thickness_mm: float) -> None:
    """To the single precision of an STL file; of the hopper's cone 2 mm across, slanted; the reference finds the same."""
    corners = Wall(name="w", **shape).surface(EXAMPLES).corners
    found = at_walls.thickness(corners)
    assert 1e3 * found == pytest.approx(thickness_mm, rel=0.01)
    assert thickness_again(corners) == pytest.approx(found, rel=1e-9)


@pytest.mark.engine
def test_a_ball_pressed_into_a_thin_plate_is_warned_of(tmp_path: Path) -> None:
    """10 mm of steel at 2.2 m/s onto 1 mm: d² + (d − 1 mm)² = v² m/k, as the underside pushes as well once the ball is there."""
    ball = {
        "name": "ball",
        "material": "steel",
        "diameter_mm": 10,
        "at_mm": [(0, 0, 5.5)],
        "velocity_m_per_s": (0, 0, -2.2),
    }
    walls = [
        {"name": "plate", "block": {"low_mm": (-20, -20, -1), "high_mm": (20, 20, 0)}},
        {"name": "cup", "vessel": {"inner_width_mm": 50, "height_mm": 30, "origin_mm": (0, 0, -40)}},
    ]
    steel = {"steel": {"density_kg_per_m3": 7850, "restitution": 1.0}}
    scene = pywet.Scene(**beads(materials=steel, spheres=[ball], walls=walls, duration_s=0.004))
    run = pywet.run(scene, tmp_path)
    table = run.contact_statistics
    mass = 7850 * 3.14159265 / 6 * 0.01**3
    deepest = 0.5e-3 * (1 + math.sqrt(2 * (1e3 * at_walls.expected(2.2, mass, 2000.0)) ** 2 - 1))
    assert 5e-3 * table["largest_wall_overlap"].max() == pytest.approx(deepest, rel=0.01)
    assert 1e-3 * table["largest_wall_penetration"].max() == pytest.approx(deepest, rel=0.01)
    assert table["walls_per_sphere"].max() == 1.0
    assert run.replay["quantities"]["results_contact_statistics"]["largest"] < 1e-9
    [sentence] = run.summary["warnings"]
    assert "overlaps a wall by 269 % of the wall's thickness" in sentence and "raise stiffness_N_per_m" in sentence


def test_what_is_not_deep_is_not_warned_of() -> None:
    table = pd.DataFrame({"time_s": [0.0, 1.0], "largest_wall_penetration": [0.0, 0.49]})
    assert results.warnings(table) == []


def test_a_scene_that_may_press_a_ball_through_a_plate_is_warned_of_before_it_runs() -> None:
    """Drop a ball 0.25 m onto a plate of 1 mm at 2000 N/m; if it is stiff, or the plate 8 mm thick, there is no warning."""

    def warnings_of(stiffness: float, thick_mm: float) -> list[str]:
        steel = {"steel": {"density_kg_per_m3": 7850, "stiffness_N_per_m": stiffness}}
        ball = {"name": "ball", "material": "steel", "diameter_mm": 10, "at_mm": [(0, 0, 255)]}
        plate = {"name": "plate", "block": {"low_mm": (-20, -20, -thick_mm), "high_mm": (20, 20, 0)}}
        return Building(pywet.Scene(**beads(materials=steel, spheres=[ball], walls=[plate]))).warnings

    [sentence] = warnings_of(2000.0, 1.0)
    assert "ball at up to 2.2 m/s may overlap wall plate by 3.2 mm, and the wall is 1 mm thick" in sentence
    assert "from stiffness_N_per_m 8.3e+04 on" in sentence
    assert warnings_of(1.1e5, 1.0) == warnings_of(2000.0, 8.0) == []
