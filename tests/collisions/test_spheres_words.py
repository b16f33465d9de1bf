"""What Davis 2023 says in words of the curves in his Figs. 6, 9, 10a, 12 and 13a, each as inequalities.

The ranges are of his words: "rapidly", "little effect" within 10 %, "negligible" within 2 %.
"""

from __future__ import annotations

from itertools import pairwise

import pytest

from pywet.collisions.spheres import command as spheres

FIRST, SECOND = (0, 1), (1, 2)


def wet(pair: tuple[int, int], stokes: float, **given: float | None) -> float | None:
    """Wet coefficient of restitution of a pair under the conditions of Fig. 5; None where it stays together."""
    return spheres.wet_restitution(spheres.run(spheres.three_equal_spheres(St_n=stokes, **given)), pair)


def parted(pair: tuple[int, int], stokes: float, **given: float | None) -> float:
    """Return the description of a pair that must separate."""
    value = wet(pair, stokes, **given)
    assert value is not None, (pair, stokes, given)
    return value


def test_fig_6_over_the_stokes_number() -> None:
    """e12 "is very small for St_n ≲ 5 and then rapidly increases", "non-zero even for small"; e23 small for St_n ≲ 8."""
    small = [parted(FIRST, stokes) for stokes in (2.0, 4.0, 5.0)]
    assert min(small) > 0.0 and max(small) < 0.15
    assert parted(FIRST, 8.0) > 3.0 * parted(FIRST, 5.0) and parted(FIRST, 20.0) > 0.7
    assert wet(SECOND, 4.0) is None and parted(SECOND, 8.0) < 0.1 < 0.4 < parted(SECOND, 20.0)


def test_fig_6_a_third_sphere_inhibits_parting_at_intermediate_stokes_numbers() -> None:
    """Two spheres keep more than three; for large Stokes numbers, rapid bounce, the difference goes."""
    gain = [parted(FIRST, stokes, h23_0=None) / parted(FIRST, stokes) for stokes in (6.0, 10.0, 20.0)]
    assert gain[0] > 1.5 and gain == sorted(gain, reverse=True) and gain[2] < 1.02


def test_fig_9_over_the_capillary_number() -> None:
    """Ca = 100 ends slow parting at small St_n and keeps 2–3 together up to 10; e falls with Ca; fast bounces keep theirs."""
    for stokes in (2.0, 3.0, 4.0):
        assert wet(FIRST, stokes) is not None and wet(FIRST, stokes, Ca=100.0) is None
    assert wet(SECOND, 8.0) is not None and wet(SECOND, 8.0, Ca=100.0) is None
    assert wet(SECOND, 12.0, Ca=100.0) is not None
    for pair in (FIRST, SECOND):
        over = [parted(pair, 12.0, Ca=ca) for ca in (10.0, 40.0, 100.0, None)]
        assert over == sorted(over)
        assert parted(pair, 100.0, Ca=10.0) == pytest.approx(parted(pair, 100.0), rel=0.02)


def test_fig_10a_over_the_impact_angle() -> None:
    """Collinear: 1–2 always stick. 15 and 22.5°: e12 small, not zero, as St_n rises; 60°: rapid rise; e23 the other way round."""
    assert all(wet(FIRST, stokes, theta12_deg=0.0) is None for stokes in (3.0, 6.0, 12.0, 20.0))
    for angle in (15.0, 22.5):
        assert all(0.0 < parted(FIRST, stokes, theta12_deg=angle) < 0.12 for stokes in (6.0, 12.0, 20.0))
    assert parted(FIRST, 8.0, theta12_deg=60.0) > 3.0 * parted(FIRST, 3.0, theta12_deg=60.0)
    angles = (15.0, 22.5, 30.0, 37.5, 45.0, 60.0)
    first = [parted(FIRST, 12.0, theta12_deg=a) for a in angles]
    second = [parted(SECOND, 12.0, theta12_deg=a) for a in angles]
    assert first == sorted(first) and second == sorted(second, reverse=True)


@pytest.mark.parametrize("stokes", [8.0, 12.0, 20.0])
@pytest.mark.parametrize("pair", [FIRST, SECOND])
def test_fig_12_thicker_films_and_smaller_gaps_reduce_restitution(pair: tuple[int, int], stokes: float) -> None:
    """(a) ĥ_a = 0.005, 0.01, 0.02 with h_min fixed, top to bottom; (b) ĥ_m = 0.02, 0.05, 0.1, bottom to top."""
    films = [
        parted(pair, stokes, h_a=h, h_min=gap, Ca=ca)
        for h, gap, ca in ((0.005, 0.1, 2000.0), (0.01, 0.05, 1000.0), (0.02, 0.025, 500.0))
    ]
    gaps = [wet(pair, stokes, h_min=gap, Ca=1000.0) or 0.0 for gap in (0.1, 0.05, 0.02)]
    for one in (films, gaps):
        assert all(a > 1.05 * b for a, b in pairwise(one))


def test_fig_13a_friction_slows_the_first_pair_and_speeds_the_second() -> None:
    """μ_f 0, 0.1, 0.2: "left to right for e12 and right to left for e23"; for St_n ≲ 4 little effect."""
    assert parted(FIRST, 3.0, mu_f=0.2) == pytest.approx(parted(FIRST, 3.0), rel=0.1)
    for stokes in (8.0, 12.0, 20.0):
        first, second = ([parted(pair, stokes, mu_f=mu) for mu in (0.0, 0.1, 0.2)] for pair in (FIRST, SECOND))
        assert first == sorted(first, reverse=True) and second == sorted(second)
