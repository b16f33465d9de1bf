"""Single laws: numbers in their docstrings (evaluated elsewhere with 40 digits), the bridge's volume by quadrature, limits."""

from __future__ import annotations

import doctest
import itertools
import math

import pytest
from scipy.integrate import quad

from pywet.collisions.wall import contact, drag
from pywet.laws import toroid

LAWS = [
    getattr(module, name)
    for module, names in (
        (contact, "damping_constant effective_modulus effective_shear normal_force tangential_force"),
        (drag, "unbounded near_wall goldman_force goldman_moment"),
        (toroid, "radii attraction volume pieces rupture_length"),
    )
    for name in names.split()
]
ANGLES = [(1, 0), (10, 15), (35, 15), (55, 15), (74.9, 15), (75, 15), (80, 15), (90, 15), (90, 79.9)]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
def test_numbers_in_docstrings(law: object) -> None:
    name = law.__name__  # type: ignore[attr-defined]
    test = doctest.DocTestParser().get_doctest(law.__doc__ or "", {name: law}, name, None, None)
    assert len(test.examples) == 1
    assert doctest.DocTestRunner(verbose=False).run(test).failed == 0


def rotated(height: float, radius: float, phi: float, angle: float) -> float:
    """Volume between film and sphere, by quadrature over the height of the solid that the meridian's arc sweeps out."""
    r_m = height / (1.0 + math.cos(angle))
    axis = radius * math.sin(phi) + r_m * math.sin(angle)

    def area(turn: float) -> float:  # the arc is parametrised by its angle, without a singularity at its ends
        radius_here = axis - r_m * math.sin(turn)
        return math.pi * radius_here * radius_here * r_m * math.sin(turn)

    swept = quad(area, 0.0, math.pi - angle, epsabs=0.0, epsrel=1e-13)[0]
    cap = quad(lambda z: math.pi * (2.0 * radius * z - z * z), 0.0, radius * (1.0 - math.cos(phi)))[0]
    return swept - cap


@pytest.mark.parametrize(("phi_deg", "theta_deg"), ANGLES)
@pytest.mark.parametrize("stretch", [1.0, 1.7, 4.0])
def test_volume_is_that_of_the_solid_of_revolution(phi_deg: float, theta_deg: float, stretch: float) -> None:
    """1e-12 of the largest piece: what round-off of four pieces that cancel leaves; beyond a = 90° as well."""
    radius, phi, angle = 8.7e-4, math.radians(phi_deg), math.radians(phi_deg + theta_deg)
    height = stretch * radius * (1.0 - math.cos(phi))
    largest = max(toroid.pieces(height, radius, phi, angle, False))
    got = toroid.volume(height, radius, phi, angle, False, False)
    assert got == pytest.approx(rotated(height, radius, phi, angle), rel=0, abs=1e-12 * largest)


def test_volume_as_printed_lacks_pi() -> None:
    args = (3e-4, 8.7e-4, 0.6, 0.86)
    assert toroid.volume(*args, False, True) * math.pi == pytest.approx(toroid.volume(*args, False, False), rel=1e-14)


def test_printed_neck_only_differs_from_90_degrees_on() -> None:
    for angle, same in ((1.5, True), (1.6, False)):
        assert (toroid.radii(3e-4, 5e-4, angle, True) == toroid.radii(3e-4, 5e-4, angle, False)) is same


def test_attraction_of_a_short_bridge_is_that_of_its_suction() -> None:
    """r_m → 0: F → π r_c² σ/r_m; 1e-4 since the next terms are smaller by r_m/r_c."""
    height, rim, angle = 1e-8, 5e-4, 0.8
    r_m = height / (1.0 + math.cos(angle))
    assert toroid.attraction(height, rim, angle, 0.07, False, False) == pytest.approx(
        math.pi * rim**2 * 0.07 / r_m, rel=1e-4
    )


def test_suction_as_printed_pushes() -> None:
    args = (3e-4, 5e-4, 1.0, 0.0728, False)
    line = 2.0 * math.pi * 0.0728 * 5e-4 * math.sin(1.0)
    assert toroid.attraction(*args, False) + toroid.attraction(*args, True) == pytest.approx(2.0 * line, rel=1e-14)


def test_rupture_length_without_surface_tension() -> None:
    assert math.isinf(toroid.rupture_length(1e-10, 1e-3, 0.2, 1e-3, 0.0))
    assert toroid.rupture_length(1e-9, 0.0, 0.2, 1e-3, 0.0) == pytest.approx(1.1e-3, rel=1e-14)


def test_drag_is_stokes_law_for_slow_flow_and_quadratic_for_fast() -> None:
    """Re/60 of the law is a drag coefficient of 0.4 on the frontal area, White's value."""
    stokes = 6.0 * math.pi * 1e-3 * 5e-4 * 1e-12
    assert drag.unbounded(1e-12, 5e-4, 1e-3, 998.0) == pytest.approx(stokes, rel=1e-8)
    newton = 0.4 * 0.5 * 998.0 * 1e6**2 * math.pi * 5e-4**2
    assert drag.unbounded(1e6, 5e-4, 1e-3, 998.0) == pytest.approx(newton, rel=1e-3)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_tangential_viscous_forces_dissipate_at_every_gap(sign: float) -> None:
    for log_gap, (v, w) in itertools.product((0.0, 0.5, 2.0, 8.0), ((1, 0), (0, 1), (1, -1), (1, 1), (1, -2), (2, -1))):
        force = drag.goldman_force(v, w, log_gap, 1e-3, 1e-3, sign)
        moment = drag.goldman_moment(v, w, log_gap, 1e-3, 1e-3, sign)
        assert force * v + moment * w < 0.0


def test_mended_goldman_is_reciprocal() -> None:
    """Force by spin equals moment by translation (Lorentz), to the four digits of the coefficients; the print's signs keep it."""
    force = drag.goldman_force(0.0, 1.0, 3.0, 1e-3, 1e-3, -1.0)
    moment = drag.goldman_moment(1.0, 0.0, 3.0, 1e-3, 1e-3, -1.0)
    assert force == pytest.approx(moment, rel=1e-3)


def test_contact_is_elastic_without_damping_and_never_pulls_sideways() -> None:
    assert contact.damping_constant(1.0) == 0.0
    assert contact.damping_constant(0.0) == pytest.approx(math.sqrt(5.0), rel=1e-15)
    assert contact.tangential_force(1e-6, 1.0, 1.0, 1e9, 0.1, 0.3) == -0.3
    assert contact.tangential_force(1e-6, 1.0, 1.0, 1e9, 0.1, 0.0) == 0.0
    assert contact.normal_force(-1e-9, 1.0, 1e9, 0.1) == 0.0


def test_shear_modulus_of_both_readings() -> None:
    """Ratio for equal bodies: (2 − ν²)/(2 − ν)."""
    mended, printed = (contact.effective_shear(63e9, 0.23, 63e9, 0.23, p) for p in (False, True))
    assert mended / printed == pytest.approx((2 - 0.23**2) / (2 - 0.23), rel=1e-14)
