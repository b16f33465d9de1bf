"""Two solvers of the exact bridge that share no code and no method: closed form with Newton's method, and collocation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pywet.laws.exact_bridge import rupture, solve
from reference_impl.bridge import bridge as reference

ASKED = 1e-6
"""Agreement that is asked for; found on these cases: forces within 1e-12, rupture distances within 3e-10."""
Case = tuple[float, float, float, float, float]


def random_case(seed: int) -> tuple[float, Case]:
    """Share of the rupture distance, and volume, radii, angles: every 4th a plate, every 5th equal bodies."""
    rng = np.random.default_rng([20, seed])
    ti, tj = rng.uniform(0.0, math.radians(80.0), 2)
    ri, rj = 1e-3 * 10 ** rng.uniform(-0.5, 0.5, 2)
    if seed % 4 == 0:
        rj = math.inf
    elif seed % 5 == 0:
        rj, tj = ri, ti
    r = 2 * ri if math.isinf(rj) else 2 * ri * rj / (ri + rj)
    volume = 10 ** rng.uniform(-6.0, math.log10(0.3)) * r**3
    return float(rng.uniform(0.0, 0.99)), (float(volume), float(ri), float(rj), float(ti), float(tj))


def compare(seed: int) -> None:
    share, case = random_case(seed)
    end, other_end = rupture(*case), reference.rupture(*case)
    assert end.separation == pytest.approx(other_end.separation, rel=ASKED)
    assert end.transfer_ratio == pytest.approx(other_end.transfer_ratio_i, abs=ASKED)
    assert {"fold": "fold", "asymmetry": "instability"}[end.kind] == other_end.kind
    gap = share * end.separation
    mine, other = solve(gap, *case), reference.solve(gap, *case)
    assert mine is not None
    # where suction and tension nearly cancel the force is small against its parts; these set the scale
    scale = 2 * math.pi * other.neck_radius
    assert mine.force(1.0) == pytest.approx(other.force, rel=ASKED, abs=ASKED * scale)
    assert mine.half_filling_angles == pytest.approx(
        (other.half_filling_i, other.half_filling_j), rel=ASKED, nan_ok=True
    )
    assert mine.contact_radii == pytest.approx((other.wetted_radius_i, other.wetted_radius_j), rel=ASKED)
    assert mine.neck_radius == pytest.approx(other.neck_radius, rel=ASKED)
    assert mine.mean_curvature == pytest.approx(other.curvature, rel=ASKED, abs=ASKED / other.neck_radius)
    assert mine.parts[0] / case[0] == pytest.approx(other.share_i, abs=ASKED)


@pytest.mark.parametrize("seed", range(25))
def test_random_bridge(seed: int) -> None:
    compare(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(25, 125))
def test_more_random_bridges(seed: int) -> None:
    compare(seed)
