"""Grids, the page and a figure: the numbers in them are those of single collisions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pywet.collisions.spheres.command import run, three_equal_spheres, wet_restitution
from studies.davis2023 import davis_figures, davis_numbers, davis_page, maps
from studies.items import Item


def test_plane_holds_single_collisions() -> None:
    angles, stokes = np.array([30.0, 45.0]), np.array([2.0, 12.0])
    found = maps.plane(angles, stokes)
    one = run(three_equal_spheres(12.0, theta12_deg=30.0, t_end=maps.window(30.0)))
    assert found.e12[1, 0] == wet_restitution(one, (0, 1)) == pytest.approx(0.168, abs=5e-4)  # as printed in Fig. 11
    assert found.outcome.tolist() == [[0, 2], [4, 4]]  # FA, reverse Newton's cradle (Fig. 14); FS
    assert found.slow.tolist() == [[False, True], [False, False]]


def test_window_is_t_star() -> None:
    """t* = v_10 t/4a: 2.59 at St 2 is t̂ = 183 (both printed)."""
    assert maps.window(45.0, 0.01, 2.59) == pytest.approx(183.0, abs=0.3)


def test_table_of_the_page(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(davis_numbers, "APPROXIMATE", [])
    monkeypatch.setattr(davis_numbers, "NOT_REPRODUCED", [])
    snapshots = davis_figures.snapshots([("St 10", {"St_n": 10.0}, (0.0, 1.0))])
    table = davis_page.numbers()
    assert len(table) == len(davis_numbers.NUMBERS)
    assert table["difference_percent"].abs().max() < 0.7  # 0.60 is printed with two digits
    monkeypatch.setattr(davis_page, "ITEMS", {"figure": Item("Fig. 0: snapshots", draw=lambda: snapshots)})
    text = davis_page.write_page(tmp_path).read_text()
    assert "0.16782" in (tmp_path / "numbers.csv").read_text() and "data:image/svg+xml" in text
    assert "25 of 27" in text and "0.16782" in text
