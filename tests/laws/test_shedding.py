"""Drops: the law against Harkins and Brown's table, against pendant drops solved exactly, and its limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pywet.laws.shedding import rayleigh_time, tate_drop

RHO, SIGMA, R = 998.2, 0.0728, 2.5e-3
HARKINS_BROWN = {0.3: 0.7256, 0.4: 0.6828, 0.5: 0.6515, 0.6: 0.6250, 0.7: 0.6093, 0.8: 0.6000, 0.9: 0.5998, 1.0: 0.6098}
"""r/V^(1/3) -> part of Tate's weight that falls: their measurements as handbooks give them."""


@pytest.mark.parametrize(("phi", "part"), HARKINS_BROWN.items())
def test_part_that_falls(phi: float, part: float) -> None:
    """The acceleration at which a drop of V = (r/phi)³ falls: within 1 % up to phi 0.8, 3 % at 0.9, 7 % at 1.0."""
    volume = (R / phi) ** 3
    acceleration = part * 2.0 * math.pi * R * SIGMA / (RHO * volume)
    ideal = 2.0 * math.pi * R * SIGMA / (RHO * acceleration)
    fell = tate_drop(1.0001 * ideal, R, acceleration, RHO, SIGMA)
    assert fell / ideal == pytest.approx(part, rel=0.011 if phi < 0.85 else 0.07)


def largest_pendant(radius: float) -> float:
    """Largest volume that hangs on a circle, in capillary lengths: Bashforth and Adams' profiles from every tip curvature."""

    def slope(_: float, y: np.ndarray, pressure: float) -> list[float]:
        r, z, angle, _volume = y
        bend = 0.5 * pressure if r < 1e-9 else math.sin(angle) / r
        return [math.cos(angle), math.sin(angle), pressure - z - bend, math.pi * r * r * math.sin(angle)]

    best, size = 0.0, (1.5 * radius) ** (1.0 / 3.0)  # radius of the sphere with Tate's weight
    for pressure in np.geomspace(1.3 / size, 3.2 / size, 30):  # 2/R of the tip
        r, z, angle, volume = solve_ivp(
            slope, [0.0, 7.0], [1e-6, 0.0, 0.0, 0.0], args=(pressure,), max_step=0.03, rtol=1e-6
        ).y
        for k in np.flatnonzero(np.diff(np.sign(r - radius))):
            if abs(angle[k]) < math.pi and z[k] < 3.5:
                best = max(best, float(np.interp(radius, *(c[k : k + 2] for c in (r, volume)))))
    return best


@pytest.mark.parametrize("radius", [0.5, 2.4])
def test_what_hangs(radius: float) -> None:
    """Tate's weight is an upper estimate of the largest drop that can hang: 0.75 to 1.05 of it, here for Bo 0.25 and 5.8."""
    assert 0.74 < largest_pendant(radius) / (2.0 * math.pi * radius) < 1.06


def test_limits() -> None:
    """Expect that a film without force keeps all liquid, one without surface tension none, and that no drop exceeds the film."""
    assert tate_drop(1e-6, R, 0.0, RHO, SIGMA) == 0.0
    assert tate_drop(1e-9, R, 9.81, RHO, 0.0) == 1e-9
    films, felt = np.meshgrid(np.geomspace(1e-12, 1e-5, 40), np.geomspace(0.01, 1e5, 40))
    fell = tate_drop(films, R, felt, RHO, SIGMA)
    assert (fell >= 0.0).all() and (fell <= films).all()
    held = 2.0 * math.pi * R * SIGMA / (RHO * felt)
    assert (fell[films <= held] == 0.0).all() and (fell[films > 1.001 * held] > 0.4 * held[films > 1.001 * held]).all()


def test_time_is_that_of_rayleigh() -> None:
    """A water drop of 1 mm radius swings with omega² = 8 sigma/(rho R³), 121 Hz."""
    time = rayleigh_time(4.0 / 3.0 * math.pi * 1e-9, RHO, SIGMA)
    assert 1.0 / (2.0 * math.pi * time) == pytest.approx(
        math.sqrt(8.0 * SIGMA / (RHO * 1e-9)) / (2.0 * math.pi), rel=1e-12
    )
    assert 1.0 / (2.0 * math.pi * time) == pytest.approx(121.6, abs=0.1)
