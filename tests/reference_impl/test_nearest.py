"""Closest points of wall parts: of two triangles as near to nine digits the least distance counts, whichever is named."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from reference_impl.motion import nearest


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_distance_is_the_least_of_triangles_as_near(order: tuple[int, int]) -> None:
    """Two triangles one above the other by 2e-12 m, a sphere of 5 mm over both: 4e-10 of the distance apart."""
    low = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    corners = np.array([low, low + np.array([0.0, 0.0, 2e-12])])[list(order)]
    setup: Any = SimpleNamespace(
        corners=corners, part=np.zeros(2, np.int64), step=1e-6, scene={"time_step_s": 1e-6, "duration_s": 1e-6, "walls": []},
        walls=[SimpleNamespace(first=0, last=2, motion="fixed")],
    )  # fmt: skip
    x = np.array([[0.0, 0.0, 5e-3]])
    found = nearest.Parts(setup).closest(np.zeros(1, np.int64), x, np.zeros(1, np.int64))
    assert found.triangle[0] == 0
    assert found.distance[0] == pytest.approx(5e-3 - 2e-12, abs=1e-15)
