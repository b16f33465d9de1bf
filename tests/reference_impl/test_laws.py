"""The reference's equations against numbers worked out by hand and against exact limits."""

from __future__ import annotations

import ast
import math
from pathlib import Path

import numpy as np
import pytest

from reference_impl.replay import capillary, laws, transfer

ROOT = Path(__file__).parents[2]
ONE = np.ones(1)
NO, YES = np.array([False]), np.array([True])


def test_imports_nothing_of_pywet() -> None:
    """Two implementations that share a helper are one implementation."""
    for path in (ROOT / "reference_impl").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [n for n in names if n.split(".")[0] == "pywet"], path


@pytest.mark.parametrize(("wall", "factor"), [(NO, 1.0), (YES, 2.0)])
def test_capillary_small_volume_limit(wall: np.ndarray, factor: float) -> None:
    """S → 0, V → 0: π r_eff σ (cos θ_i + cos θ_j) for spheres, twice that at a wall; the rest falls as √φ² ~ V^(1/4)."""
    force = capillary.rabinovich(0 * ONE, 1e-40 * ONE, 1e-3 * ONE, 1e-3 * ONE, wall, 0.3 * ONE, 0.5 * ONE, 0.07)
    exact = factor * math.pi * 1e-3 * 0.07 * (math.cos(0.3) + math.cos(0.5))
    assert force[0] == pytest.approx(exact, rel=1e-6)


def test_capillary_by_hand() -> None:
    """r = 1 mm, θ = 0, σ = 0.07, V = 2π·1e-12, S = 0: φ² = √(2V/(π r³)) = √0.004, F = 2πrσ(1 + sin²φ)."""
    phi = 0.004**0.25
    force = capillary.rabinovich(0 * ONE, 2 * math.pi * 1e-12 * ONE, 1e-3 * ONE, 1e-3 * ONE, NO, 0 * ONE, 0 * ONE, 0.07)
    assert force[0] == pytest.approx(2 * math.pi * 7e-5 * (1 + math.sin(phi) ** 2), rel=1e-12)


def test_pitois_without_limit_of_volume_is_lubrication() -> None:
    """V → ∞: −6π η r_red² v/S."""
    force = laws.pitois(1e-5 * ONE, 1e6 * ONE, 1e-3 * ONE, 1e-3 * ONE, NO, 0.1 * ONE, 1e-3)
    assert force[0] == pytest.approx(-6 * math.pi * 1e-3 * 0.25e-6 * 0.1 / (1e-5 + 1e-6), rel=1e-6)


def test_rupture_at_a_wall_is_the_limit_of_large_spheres() -> None:
    """r_j → ∞ leads to the wall's value."""
    angles = (0.3 * ONE, 0.8 * ONE)
    wall = laws.willett_rupture(1e-12 * ONE, 1e-3 * ONE, ONE, YES, *angles)
    large = laws.willett_rupture(1e-12 * ONE, 1e-3 * ONE, 1e6 * ONE, NO, *angles)
    assert wall[0] == pytest.approx(large[0], rel=1e-8)


def test_formation_by_hand() -> None:
    """Equal spheres and a large wall: L (1 − √0.75)/2; a wire of half the radius: L/12; walls: W π r²/4, W 2 r r_w."""
    equal = 0.5 * (1 - math.sqrt(0.75))
    assert laws.drawn_from_sphere(laws.SPHERE, 1.0, 2.0, 2.0, 0.0) == pytest.approx(equal, rel=1e-14)
    assert laws.drawn_from_sphere(laws.LARGE_WALL, 1.0, 2.0, 0.0, math.inf) == pytest.approx(equal, rel=1e-14)
    assert laws.drawn_from_sphere(laws.SMALL_WALL, 1.0, 2.0, 0.0, 1.0) == pytest.approx(1 / 12, rel=1e-14)
    assert laws.drawn_from_wall(laws.LARGE_WALL, 0.5, 2.0, math.inf) == pytest.approx(math.pi / 2, rel=1e-14)
    assert laws.drawn_from_wall(laws.SMALL_WALL, 0.5, 2.0, 1.0) == pytest.approx(2.0, rel=1e-14)


def test_transfer_of_twins_and_of_order() -> None:
    """Equal spheres share equally; the larger sphere keeps more; more as the size difference grows (the paper's Fig. 7)."""
    v = np.array([0.02, 0.1, 0.3])
    assert transfer.recomputed_ratio(laws.SPHERE, 1e-3, 1e-3, 0.2, 0.2, v) == pytest.approx([0.5] * 3)
    angle = math.radians(40.0)
    small = transfer.recomputed_ratio(laws.SPHERE, 7e-3, 5e-3, angle, angle, v)
    large = transfer.recomputed_ratio(laws.SPHERE, 10e-3, 5e-3, angle, angle, v)
    assert (small > 0.5).all() and (large > small).all()
    assert (np.diff(large) > 0).all()  # also increases with V*
