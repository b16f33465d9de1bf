"""Sizes that can hardly be meant, and files that cut through themselves, are said before the engine says "Too many … bins"."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pywet.cases.custom.building import Building
from pywet.cases.custom.description import Scene
from pywet.errors import PywetError
from pywet.geometry.crossing import crossing
from tests.error_codes import raises_code
from tests.geometry.test_cad import CUBE, CUP, text


def scene(folder: Path, corners: np.ndarray | None = None, at: float = 10.0, **more: Any) -> Building:
    """A bead of 3 mm above a wall from a file, or above a block."""
    wall: dict[str, Any] = {"name": "part", "block": {"low_mm": (-10, -10, -5), "high_mm": (10, 10, 0)}}
    if corners is not None:
        (folder / "part.stl").write_text(text(corners))
        wall = {"name": "part", "stl": "part.stl"}
    bead = {"name": "beads", "material": "glass", "diameter_mm": 3, "at_mm": [(0, 0, at)]}
    return Building(
        Scene(
            name="vast", duration_s=0.01, materials={"glass": {"density_kg_per_m3": 2500}}, spheres=[bead],
            walls=[{**wall, **more}], folder=folder,
        )
    )  # fmt: skip


@pytest.mark.parametrize(("size", "unit"), [(1e-3, "mm"), (0.08, "mm"), (1.0, "m")])
def test_the_other_unit_is_asked_back(size: float, unit: str, tmp_path: Path) -> None:
    """A cup of 36 mm, or one of 2.9 m, in metres read as millimetres; the first in millimetres read as metres."""
    other = "m" if unit == "mm" else "mm"
    with raises_code("scene.stl_unit", expected=other):
        _ = scene(tmp_path, size * CUP, stl_unit=unit).surfaces


def test_a_box_that_the_engine_cannot_list_is_refused(tmp_path: Path) -> None:
    """A cup of 3.6 mm read as one of 3.6 m takes 1.4e9 cubes of 3 mm; a wall that flies 30 m along x, y, z takes more.

    A block 30 m long takes 5.5e5 of them.
    """
    with raises_code("scene.box", says=r"box of 3626 x 3626 x 2826 mm, 1\.4e\+09 cells"):
        scene(tmp_path, 0.1 * CUP, stl_unit="m").scene()
    with raises_code("scene.box", says=r"1e\+12 cells"):
        scene(tmp_path, moves={"velocity_m_per_s": (3e3, 3e3, 3e3), "for_s": 0.01}).scene()
    long = {"low_mm": (-15000, -10, -5), "high_mm": (15000, 10, 0)}
    assert scene(tmp_path, block=long).scene().box_high_m[0] == pytest.approx(15.0, abs=0.1)


def test_where_a_file_cuts_through_itself(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A cube of 20 mm whose top corner at (5, 5) is pushed through its bottom: the notice names a place on the bottom.

    A sound cup and two cubes that overlap are not reported: crossing wires are bodies of their own.
    """
    pushed = np.where((CUBE == [10.0, 10.0, 20.0]).all(axis=2)[..., None], [3.0, 3.0, -15.0], CUBE)
    with caplog.at_level("WARNING"):
        _ = scene(tmp_path, CUP).surfaces
        _ = scene(tmp_path, np.concatenate([CUBE, CUBE + np.array([5.0, 4.0, 3.0])])).surfaces
        assert "cuts through itself" not in caplog.text
        _ = scene(tmp_path, pushed, at=40.0).surfaces
    assert "wall part: part.stl cuts through itself at (" in caplog.text


def test_a_crossing_is_found_at_its_place() -> None:
    """A tetrahedron whose edge along z passes through another one below z = 0; lifted by 2, it passes through none."""
    flat = np.array([[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [-1.0, 2.0, 0.0], [0.0, 0.0, -3.0]])
    high = np.array([[0.1, 0.2, -1.0], [0.1, 0.2, 2.0], [3.0, 0.0, 2.0], [0.0, 3.0, 2.0]])
    faces = np.array([[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]])
    both = np.concatenate([faces, faces + 4])
    at = crossing(np.concatenate([flat, high]), both)
    assert at is not None and at[:2] == pytest.approx([0.1, 0.2], abs=1.0) and -3.0 < at[2] <= 0.0
    assert crossing(flat, faces) is None and crossing(high, faces) is None
    assert crossing(np.concatenate([flat, high + np.array([0.0, 0.0, 2.0])]), both) is None


@pytest.mark.parametrize("corner", [-1e12, -1e308, -1.1e5])
def test_a_corner_that_is_far_away_is_refused_at_once(tmp_path: Path, corner: float) -> None:
    """A block that long cannot be divided into triangles in a lifetime; one 99 m long is built."""
    block = {"low_mm": (corner, -10, -5), "high_mm": (10, 10, 0)}
    with pytest.raises(PywetError) as caught:
        scene(tmp_path, block=block).scene()
    assert caught.value.code in ("surface.large", "config.implausible")
    long = {"low_mm": (-99e3, -10, -5), "high_mm": (10, 10, 0)}
    assert scene(tmp_path, block=long).scene().box_low_m[0] == pytest.approx(-99.0, abs=0.1)
