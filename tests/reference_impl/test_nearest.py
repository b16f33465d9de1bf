"""Closest points of wall parts: of two triangles as near to nine digits the least distance counts, whichever is named;
and where a closest point can have been one look before."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from reference_impl.motion import nearest
from reference_impl.replay import formations


def closest_to(corners: np.ndarray, x: list[float]) -> nearest.Closest:
    """Return the closest points of one fixed part with these triangles."""
    setup: Any = SimpleNamespace(
        corners=corners, part=np.zeros(len(corners), np.int64), step=1e-6,
        scene={"time_step_s": 1e-6, "duration_s": 1e-6, "walls": []},
        walls=[SimpleNamespace(first=0, last=len(corners), motion="fixed", name="all")],
    )  # fmt: skip
    none = np.zeros(1, np.int64)
    return nearest.Parts(setup).closest(none, np.array([x]), none)


@pytest.mark.parametrize("offset", [5e-8, -5e-8])
def test_the_point_is_that_of_the_least_distance(offset: float) -> None:
    """A sphere of 2.5 mm over a square, 50 nm next to the edge of its two triangles, which are as near to 5e-13 m."""
    a, b, c, d = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    x = [offset, -offset, 2.5e-3]
    assert closest_to(np.array([[a, b, c], [a, c, d]]), x).point[0] == pytest.approx([offset, -offset, 0.0], abs=1e-15)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_distance_is_the_least_of_triangles_as_near(order: tuple[int, int]) -> None:
    """Two triangles one above the other by 2e-12 m, a sphere of 5 mm over both: 4e-10 of the distance apart."""
    low = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    corners = np.array([low, low + np.array([0.0, 0.0, 2e-12])])[list(order)]
    found = closest_to(corners, [0.0, 0.0, 5e-3])
    assert found.triangle[0] == 0
    assert found.distance[0] == pytest.approx(5e-3 - 2e-12, abs=1e-15)


@pytest.mark.parametrize("every", [1, 4])
def test_a_triangle_is_in_reach_of_the_look_before_an_output(tmp_path: Path, every: int) -> None:
    """A formation at an output's step: its closest point was elsewhere one look before (met once in 4 million events)."""
    (tmp_path / "trajectory.parquet").touch()
    at_edge = {"step": 5650, "id": 411, "x": 0.0, "y": 0.0, "z": 0.0, "vx": 0.3, "vy": 0.0, "vz": 0.0}
    farther = 1.77e-5 * 0.3 * every * np.array([0.0, 1.0, 20.0])  # additional distance of three triangles of one part
    parts = SimpleNamespace(
        setup=SimpleNamespace(part=np.zeros(3, int)),
        closest=lambda step, x, part: SimpleNamespace(distance=np.full(len(x), 1e-4)),
        to=lambda step, x, triangles: (1e-4 + farther[triangles], None),
    )
    run: Any = SimpleNamespace(
        folder=tmp_path,
        known={"parts": parts},
        meta={"time_step": 1.77e-5, "bridges_every": every},
        table=lambda name: pd.DataFrame([at_edge]),
    )
    event = pd.Series({"i": 411, "step": 5650, "speed": 0.1})
    assert formations._in_reach(run, event, np.arange(3)).tolist() == [True, True, False]


def test_closest_points_of_a_triangle() -> None:
    """Face, edge and corner of a right triangle, worked out by hand."""
    triangle = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    for point, closest in [
        ((0.2, 0.3, 5.0), (0.2, 0.3, 0.0)),
        ((0.5, -1.0, 1.0), (0.5, 0.0, 0.0)),
        ((1.0, 1.0, 0.0), (0.5, 0.5, 0.0)),
        ((-1.0, -1.0, 2.0), (0.0, 0.0, 0.0)),
        ((3.0, -1.0, 0.0), (1.0, 0.0, 0.0)),
    ]:
        assert nearest.closest_point(np.array([point]), triangle)[0] == pytest.approx(closest, abs=1e-15)


def test_within_is_what_all_triangles_one_by_one_say() -> None:
    """Spheres about two parts of ten triangles: pairs, distance, triangle and least value of those as near."""
    random = np.random.default_rng(5)
    corners, part = random.uniform(0.0, 1.0, (20, 3, 3)), np.arange(20) % 2
    corners[4] = corners[2] + 1e-12  # two triangles of one part at equal distance to nine digits
    setup: Any = SimpleNamespace(
        corners=corners, part=part, step=1e-6, scene={"time_step_s": 1e-6, "duration_s": 1e-6, "walls": []},
        walls=[SimpleNamespace(first=0, last=20, motion="fixed", way=None, name="all")],
    )  # fmt: skip
    x, reach, values = random.uniform(-0.5, 1.5, (300, 3)), random.uniform(0.1, 0.6, 300), random.uniform(0.0, 0.2, 20)
    a, of, near = nearest.Parts(setup).within(0, x, reach, values)
    every = np.stack(
        [np.linalg.norm(nearest.closest_point(x, np.repeat(t[None], 300, 0)) - x, axis=1) for t in corners]
    )
    wanted = {}
    for n, p in np.ndindex(300, 2):
        of_part = np.flatnonzero(part == p)
        least = every[of_part, n].min()
        if least < reach[n] + values[of_part].max():
            same = of_part[every[of_part, n] <= least * (1.0 + nearest.SAME)]
            wanted[n, p] = (least, same[0], values[same].min())
    found = dict(zip(zip(a.tolist(), of.tolist(), strict=True), zip(*near, strict=True), strict=True))
    assert len(found) == len(a) > 100 and found.keys() == wanted.keys()
    assert np.array(list(found.values())) == pytest.approx(np.array([wanted[k] for k in found]), rel=1e-12)
    assert any(row[1] == 2 and row[2] == values[[2, 4]].min() for row in found.values())
