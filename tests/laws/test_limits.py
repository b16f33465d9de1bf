"""What a law must obey whatever its numbers: limits, continuity at touch, units, symmetry, the wall as a huge sphere."""

import math

import numpy as np
import pytest
from numpy.random import default_rng

from pywet.laws.capillary import rabinovich
from pywet.laws.capillary_fits import willett
from pywet.laws.formation import formation_sphere
from pywet.laws.rupture import pitois_dynamic, willett_unequal
from pywet.laws.viscous import goldman_rotation, goldman_translation, lian_rotation, lian_translation, pitois
from reference_impl.bridge import bridge as reference
from reference_impl.replay import laws as replayed

SIGMA, ETA = 0.0728, 1e-3
PAIRS = [(2e-3, 2e-3), (3e-3, 2e-3), (5e-3, 1.5e-3), (2.5e-3, math.inf)]


@pytest.mark.parametrize(("ri", "rj"), PAIRS)
def test_small_volume_limit_at_touch(ri: float, rj: float) -> None:
    """F → π r_eff σ (cos θ_i + cos θ_j); at a wall 2π r_i σ (…): the meniscus term falls as φ ~ V*^(1/4)."""
    r = 2 * ri if math.isinf(rj) else 2 * ri * rj / (ri + rj)
    limit = math.pi * r * SIGMA * (math.cos(0.3) + math.cos(0.5))
    phi = (1e-24 / ri**3) ** 0.25  # 1e-4 and below; the second term is of order φ sin θ
    assert rabinovich(0.0, 1e-24, ri, rj, 0.3, 0.5, SIGMA) == pytest.approx(limit, rel=4 * phi)
    assert rabinovich(0.0, 0.0, ri, rj, 0.3, 0.5, SIGMA) == pytest.approx(limit, rel=1e-15)
    assert rabinovich(1e-5, 0.0, ri, rj, 0.3, 0.5, SIGMA) == 0.0  # without liquid there is no bridge after contact


def test_willetts_fit_ends_where_his_volumes_do() -> None:
    """At touch the force depends on V* alone, and V* counts as 1e-3 below and as 0.1 above his range."""
    for end, beyond, inside in ((0.1, 0.2, 0.099), (1e-3, 5e-4, 1.01e-3)):
        at_end, further, before = (willett(0.0, v * 8e-9, 2e-3, 2e-3, 0.3, 0.3, SIGMA) for v in (end, beyond, inside))
        assert further == pytest.approx(at_end, rel=1e-14)
        assert abs(before / at_end - 1.0) > 1e-5


@pytest.mark.parametrize(
    ("v", "angle", "above"),
    [(1.25e-3, 0, 10), (1.25e-3, 20, 18), (0.0125, 0, 24), (0.0125, 20, 38), (0.1, 0, 56), (0.1, 20, 81)],
)
def test_rabinovich_at_touch_is_above_the_exact_force_as_documented(v: float, angle: float, above: float) -> None:
    """In per cent, by the reference's own solution of the exact bridge."""
    given = v * 8e-9, 2e-3, 2e-3, math.radians(angle), math.radians(angle)
    exact = SIGMA * reference.solve(0.0, *given).force
    assert 100.0 * (rabinovich(0.0, *given, SIGMA) / exact - 1.0) == pytest.approx(above, abs=0.5)


@pytest.mark.parametrize(("ri", "rj"), PAIRS)
def test_constant_in_overlap(ri: float, rj: float) -> None:
    """The viscous laws; the capillary ones are in test_properties.py."""
    for law in (goldman_translation, goldman_rotation):
        assert law(-1e-4, ri, rj, ETA) == law(0.0, ri, rj, ETA)
    assert pitois(-1e-4, 1e-10, ri, rj, 0.1, ETA) == pitois(0.0, 1e-10, ri, rj, 0.1, ETA)


@pytest.mark.parametrize(("ri", "rj"), PAIRS)
def test_attraction_falls_with_separation_and_stays_positive_to_rupture(ri: float, rj: float) -> None:
    for theta in (0.0, 0.26, 0.7):
        gaps = np.linspace(0.0, willett_unequal(1e-10, ri, rj, theta, theta), 200)
        force = rabinovich(gaps, 1e-10, ri, rj, theta, theta, SIGMA)
        assert (force > 0).all()
        assert (np.diff(force) < 0).all()


def test_exchanging_the_spheres_changes_nothing() -> None:
    rng = default_rng(1)
    for _ in range(50):
        ri, rj = rng.uniform(5e-4, 5e-3, 2)
        s, v = rng.uniform(0, 1e-3), 10 ** rng.uniform(-13, -9)
        there, back = (
            (pitois(s, v, a, b, 0.1, ETA), goldman_translation(s, a, b, ETA), goldman_rotation(s, a, b, ETA))
            for a, b in ((ri, rj), (rj, ri))
        )
        assert there == pytest.approx(back, rel=1e-13)  # order of additions only


@pytest.mark.parametrize(("ri", "rj"), PAIRS)
def test_scaling_with_length(ri: float, rj: float) -> None:
    """Twice the size: Goldman's coefficients and Pitois' force double."""
    k, s, v = 2.0, 1e-4, 1e-10
    assert pitois(k * s, k**3 * v, k * ri, k * rj, 0.1, ETA) == pytest.approx(
        k * pitois(s, v, ri, rj, 0.1, ETA), rel=1e-12
    )
    for law in (goldman_translation, goldman_rotation):
        assert law(k * s, k * ri, k * rj, ETA) == pytest.approx(k * law(s, ri, rj, ETA), rel=1e-13)


def test_linear_in_material_and_speed() -> None:
    assert pitois(1e-4, 1e-10, 2e-3, 3e-3, -0.2, 3 * ETA) == pytest.approx(
        -6 * pitois(1e-4, 1e-10, 2e-3, 3e-3, 0.1, ETA), rel=1e-14
    )
    assert pitois(1e-4, 1e-10, 2e-3, 3e-3, 0.1, ETA) < 0  # moving apart is resisted
    assert pitois_dynamic(4.0, ETA, SIGMA) - 1 == pytest.approx(2 * (pitois_dynamic(1.0, ETA, SIGMA) - 1), rel=1e-14)


def test_a_wall_is_a_huge_sphere() -> None:
    """Rupture: the formulas coincide. Rabinovich: the wall sets φ on the sphere itself, so only its first term does; with
    θ_m = 0 and small φ its second term is twice that of the limit (r φ² with φ² doubled twice and r halved)."""
    ri, huge, v = 2e-3, 1e7, 1e-12
    for s in (0.0, 1e-5, 1e-4):
        wall, limit = (rabinovich(s, v, ri, rj, 0.0, 0.0, SIGMA) for rj in (math.inf, huge))
        d = v / (math.pi * ri) / (s + math.sqrt(s * s + v / (math.pi * ri)))
        first = 4 * math.pi * SIGMA * ri / (1 + s / d)
        assert wall - first == pytest.approx(2 * (limit - first), rel=0.01)  # sin²φ against φ², φ² ≤ 0.013
    assert willett_unequal(1e-10, ri, math.inf, 0.3, 0.5) == pytest.approx(
        willett_unequal(1e-10, ri, huge, 0.3, 0.5), rel=1e-9
    )
    # viscous: the same reduced radius, but S_min is 0.001 r_i at a wall and 0.002 r_i in the limit, so S is shifted here
    assert pitois(1e-3, 1e-9, ri, math.inf, 0.1, ETA) == pytest.approx(
        pitois(1e-3 - 2e-6, 1e-9, ri, huge, 0.1, ETA), rel=1e-6
    )
    for law in (goldman_translation, goldman_rotation):
        assert law(1e-3, ri, math.inf, ETA) == pytest.approx(law(1e-3 - 2e-6, ri, huge, ETA), rel=1e-6)


def test_rupture_distance_is_the_cube_root_for_little() -> None:
    little = 1e-21
    assert willett_unequal(little, 2e-3, 2e-3, 0.0, 0.0) == pytest.approx(
        little ** (1 / 3), rel=1e-4
    )  # next term 0.1 V*^(1/3)


def test_pitois_with_much_liquid_is_lubrication() -> None:
    """V → ∞: the Adams & Perchard form 6π η r² v/S; S = S_min at touch."""
    r, s = 1e-3, 2e-6
    full = -6 * math.pi * ETA * r**2 * 0.1 / s
    assert pitois(0.0, 1.0, 2e-3, 2e-3, 0.1, ETA) == pytest.approx(full, rel=1e-6)  # 2/√(V/(π r S²)) = 2e-7


def test_goldman_far_branch_and_its_step() -> None:
    """The branch changes at S = 0.1 r_red, where the two forms differ by 3.4 % (0.05441 and 0.05628 times 6π η r)."""
    r, unit = 1e-3, 6 * math.pi * ETA * 1e-3
    gap = 0.1 * r - 2e-6
    assert goldman_rotation(gap * (1 - 1e-9), 2e-3, 2e-3, ETA) / unit == pytest.approx(0.0544113, abs=1e-6)
    assert goldman_rotation(gap * (1 + 1e-9), 2e-3, 2e-3, ETA) / unit == pytest.approx(0.0562710, abs=1e-6)


@pytest.mark.parametrize(("ri", "rj"), PAIRS)
def test_tangential_drag_never_pushes(ri: float, rj: float) -> None:
    """Coefficients from touch to 1000 r_red, in pywet and in the reference; (8/15) ln(r/S) + 0.9588 = 0 at S = 6.04 r_red."""
    wall = math.isinf(rj)
    r = ri if wall else ri * rj / (ri + rj)
    gaps = np.concatenate([np.geomspace(1e-3, 6.0, 50), np.geomspace(6.05, 1e3, 50)]) * r
    one = np.ones(100)
    given = gaps, ri * one, (ri if wall else rj) * one, wall & (one > 0.0), ETA
    for slide in (
        goldman_translation(gaps, ri, rj, ETA), lian_translation(gaps, ri, rj, ETA), lian_rotation(gaps, ri, rj, ETA),
        replayed.goldman(*given)[0], *replayed.lian_drag(*given),
    ):  # fmt: skip
        assert (slide[:50] > 0.0).all() and (slide[50:] == 0.0).all()
    assert (goldman_rotation(gaps, ri, rj, ETA) > 0.0).all() and (replayed.goldman(*given)[1] > 0.0).all()


def test_drawn_volume_never_exceeds_the_film_and_splits_equal_twins_equally() -> None:
    rng = default_rng(2)
    for ri, rj in rng.uniform(5e-4, 5e-3, (50, 2)):
        assert 0 < formation_sphere(1.0, ri, rj) < 0.5
    assert formation_sphere(1.0, 1e-3, 1e-3) == pytest.approx(formation_sphere(1.0, 1e-3, math.inf), rel=1e-15)
