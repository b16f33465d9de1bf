"""What every capillary and rupture law must obey wherever its range of validity reaches; hypothesis chooses the bridges."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pywet.laws import exact_bridge as young_laplace
from pywet.laws import registry

STATIC_LAWS = [name for name in registry.BUILT_IN["capillary"] if name not in ("buck", "davis")]
"""Laws of this kind of bridge; those of the collision models have tests of their own."""
REAL = [name for name in STATIC_LAWS if not name.endswith("as_printed")]
RUPTURE = [name for name in registry.BUILT_IN["rupture"] if name not in ("buck", "davis")]
ANGLES = {"young_laplace": st.sampled_from([(0.0, 0.0), (1.0471975511965977462, 1.0471975511965977462)])}
"""Contact angles for which the table of a law is at hand; others take any up to 40°."""
ANY = st.tuples(st.floats(0.0, 0.69), st.floats(0.0, 0.69))
RATIO = st.one_of(st.floats(0.2, 5.0), st.just(1.0))
VOLUME = st.floats(-3.0, -1.0).map(lambda x: 10.0**x)
"""V*, in the range in which all fits are made."""
SHARE = st.floats(0.0, 0.99)
few = settings(max_examples=40, deadline=None)
SIGMA = 0.07


def bodies(ratio: float, wall: bool) -> tuple[float, float, float]:
    """Radii and the harmonic mean."""
    ri = 2e-3
    rj = math.inf if wall else ri * ratio
    return ri, rj, 2 * ri if wall else 2 * ri * rj / (ri + rj)


def function(kind: str, name: str):  # type: ignore[no-untyped-def]
    return registry.get(kind, name).functions[0]


@pytest.mark.parametrize("name", REAL)
def test_attraction_up_to_rupture(name: str) -> None:
    """F > 0 at every separation up to the exact rupture distance (as-printed forms do not claim it)."""
    law = function("capillary", name)

    @few
    @given(RATIO, st.booleans(), VOLUME, ANGLES.get(name, ANY), SHARE)
    def holds(ratio: float, wall: bool, v: float, angles: tuple[float, float], share: float) -> None:
        ri, rj, r = bodies(ratio, wall)
        limit = young_laplace.rupture(v * r**3, ri, rj, *angles).separation
        assert law(share * limit, v * r**3, ri, rj, *angles, SIGMA) > 0.0

    holds()


@pytest.mark.parametrize("name", STATIC_LAWS)
def test_continuous_at_touch_and_constant_in_overlap(name: str) -> None:
    """F(S) → F(0); slopes are of the order F/d with d the ring's height, so 1e-9 r is 1e-6 of F and less."""
    law = function("capillary", name)

    @few
    @given(RATIO, st.booleans(), VOLUME, ANGLES.get(name, ANY))
    def holds(ratio: float, wall: bool, v: float, angles: tuple[float, float]) -> None:
        ri, rj, r = bodies(ratio, wall)
        touch = law(0.0, v * r**3, ri, rj, *angles, SIGMA)
        near = law(1e-9 * r, v * r**3, ri, rj, *angles, SIGMA)
        # willett's power of S* is the steepest: exp(f3 ln S*) with f3 near 0.9 is 1e-5
        assert near == pytest.approx(touch, rel=3e-5, abs=1e-6 * SIGMA * r)
        assert law(-1e-3 * r, v * r**3, ri, rj, *angles, SIGMA) == touch

    holds()


@pytest.mark.parametrize("name", STATIC_LAWS)
def test_scaling_symmetry_and_tension(name: str) -> None:
    """F(kS, k³V, k r) = k F; exchanging the bodies changes nothing; F is linear in the surface tension."""
    law = function("capillary", name)

    @few
    @given(RATIO, VOLUME, ANGLES.get(name, ANY), SHARE, st.floats(1e-3, 10.0))
    def holds(ratio: float, v: float, angles: tuple[float, float], share: float, k: float) -> None:
        ri, rj, r = bodies(ratio, False)
        s, volume = share * v ** (1 / 3) * r, v * r**3
        force = law(s, volume, ri, rj, *angles, SIGMA)
        tight = {"rel": 1e-9, "abs": 1e-12 * SIGMA * r}  # differences of nearly equal terms (weigert's pressures)
        assert law(k * s, k**3 * volume, k * ri, k * rj, *angles, SIGMA) == pytest.approx(
            k * force, rel=1e-6 if name == "young_laplace" else 1e-9, abs=1e-12 * SIGMA * r * k
        )  # its splines are stored in single precision
        assert law(s, volume, rj, ri, angles[1], angles[0], SIGMA) == pytest.approx(force, **tight)
        assert law(s, volume, ri, rj, *angles, 3.0 * SIGMA) == pytest.approx(3.0 * force, **tight)

    holds()


@pytest.mark.parametrize("name", ["lambert", "willett", "willett_simple", "weigert", "bagheri", "young_laplace"])
def test_a_wall_is_a_huge_sphere(name: str) -> None:
    """Laws of the harmonic mean claim it (rabinovich's second term and soulie do not)."""
    law = function("capillary", name)

    @few
    @given(VOLUME, ANGLES.get(name, ANY), SHARE)
    def holds(v: float, angles: tuple[float, float], share: float) -> None:
        ri, r = 2e-3, 4e-3
        s, volume = 0.8 * share * v ** (1 / 3) * r, v * r**3
        wall, huge = (law(s, volume, ri, rj, *angles, SIGMA) for rj in (math.inf, 1e7 * ri))
        assert wall == pytest.approx(huge, rel=1e-5)  # first order in r_i/r_j

    holds()


@pytest.mark.parametrize("name", ["rabinovich", "rabinovich_small_gap", "lambert", "willett_simple", "young_laplace"])
def test_small_volume_limit(name: str) -> None:
    """F → π r_eff σ (cos θ_i + cos θ_j) as V → 0 at touch; the deviation falls as φ ~ V*^(1/4)."""
    law = function("capillary", name)

    @few
    @given(RATIO, st.booleans(), ANGLES.get(name, ANY))
    def holds(ratio: float, wall: bool, angles: tuple[float, float]) -> None:
        ri, rj, r = bodies(ratio, wall)
        limit = math.pi * r * SIGMA * (math.cos(angles[0]) + math.cos(angles[1]))
        for v in (1e-8, 1e-9):
            # rabinovich: 2 sin φ sin(φ + θ)/(cosines) ≤ 4 φ, φ ≤ (4 V*)^(1/4)
            assert law(0.0, v * r**3, ri, rj, *angles, SIGMA) == pytest.approx(limit, rel=6 * v**0.25)

    holds()


@pytest.mark.parametrize("name", RUPTURE)
def test_rupture_distance_grows_with_volume(name: str) -> None:
    """Monotone in V, symmetric, and a length: S(k³V, k r) = k S."""
    law = function("rupture", name)

    @few
    @given(RATIO, st.booleans(), VOLUME, ANGLES.get(name, ANY), st.floats(1.01, 5.0))
    def holds(ratio: float, wall: bool, v: float, angles: tuple[float, float], more: float) -> None:
        ri, rj, r = bodies(ratio, wall)
        distance = law(v * r**3, ri, rj, *angles)
        assert law(min(more * v, 0.4) * r**3, ri, rj, *angles) > distance
        assert law(8 * v * r**3, 2 * ri, 2 * rj, *angles) == pytest.approx(2 * distance, rel=1e-9)
        if not wall:
            assert law(v * r**3, rj, ri, angles[1], angles[0]) == pytest.approx(distance, rel=1e-12)

    holds()
