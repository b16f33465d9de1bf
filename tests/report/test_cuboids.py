"""Cuboids of bridges: what is visible of one, counted point by point, is the bridge's volume."""

from __future__ import annotations

import numpy as np
import pytest

from pywet.report import cuboids

MM = 1e-3


@pytest.mark.parametrize(
    ("ri", "rj", "gap", "volume"),
    [(2.5, 2.5, 0.1, 0.3), (2.5, 5.0, 0.0, 0.5), (2.5, np.inf, 0.2, 1.0), (2.5, 3.5, -0.02, 0.2), (5.0, 2.5, 0.6, 2.0)],
)
def test_points_in_the_cuboid_and_in_no_body_count_to_the_volume(
    ri: float, rj: float, gap: float, volume: float
) -> None:
    """Counted in a million points at random: good to half a per cent."""
    radii = np.array([[ri], [rj]]) * MM
    wall = np.isinf(radii[1])
    first = np.array([[1.0, -2.0, 0.5]]) * MM
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    reach = radii[0] + gap * MM + np.where(wall, 0.0, radii[1])
    second = first + reach[:, None] * axis
    box = cuboids.corners(first, second, wall, np.array([volume]) * MM**3, np.array([gap]) * MM, *radii)[0]
    edges = np.array([box[1] - box[0], box[3] - box[0], box[4] - box[0]])
    points = box[0] + np.random.default_rng(1).uniform(size=(1_000_000, 3)) @ edges
    outside = np.linalg.norm(points - first, axis=1) > radii[0]
    if wall:
        outside &= (points - first) @ axis < reach
    else:
        outside &= np.linalg.norm(points - second, axis=1) > radii[1]
    assert outside.mean() * abs(np.linalg.det(edges)) == pytest.approx(volume * MM**3, rel=5e-3)
    # square, and as long as d_lb: the edges end on the spheres
    assert np.linalg.norm(edges[0]) == pytest.approx(np.linalg.norm(edges[1]), rel=1e-12)
    np.testing.assert_allclose(np.linalg.norm(box[:4] - first, axis=1), radii[0, 0], rtol=1e-12)
    if not wall:
        np.testing.assert_allclose(np.linalg.norm(box[4:] - second, axis=1), radii[1, 0], rtol=1e-12)


def test_a_bridge_too_large_for_its_spheres_is_as_wide_as_the_smaller_one_and_an_empty_one_has_no_width() -> None:
    radii = np.full(3, 2.5) * MM, np.array([5.0, np.inf, 2.5]) * MM
    volume, gap = np.array([1e6, 1e6, 0.0]) * MM**3, np.zeros(3)
    widths = cuboids.sides(volume, gap, *radii)
    np.testing.assert_allclose(widths, np.sqrt(2.0) * radii[0] * [1.0, 1.0, 0.0], rtol=1e-12)
    assert len(cuboids.sides(*(np.zeros(0),) * 4)) == 0
