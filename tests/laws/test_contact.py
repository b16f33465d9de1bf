"""Two bodies in contact, and films: exact solutions, limits at a wall, inverses."""

from __future__ import annotations

import doctest
import math

import pytest

from pywet.laws import contact


def test_numbers_in_docstrings() -> None:
    assert doctest.testmod(contact) == doctest.TestResults(failed=0, attempted=3)


@pytest.mark.parametrize("e", [0.05, 0.44, 0.9, 1.0])
def test_the_damped_spring_returns_what_was_put_in(e: float) -> None:
    """m ẍ + γ ẋ + k x = 0 from x = 0: after half a period the speed is exp(−γ t/(2 m)) of the first one, exactly."""
    mass, stiffness = 3e-4, 2e4
    gamma = contact.damping(e, mass, stiffness)
    half_period = math.pi / math.sqrt(stiffness / mass - (gamma / (2.0 * mass)) ** 2)
    assert math.exp(-gamma * half_period / (2.0 * mass)) == pytest.approx(e, rel=1e-13)  # round-off of the exponent
    assert contact.damping_ratio(e) == pytest.approx(gamma / (2.0 * math.sqrt(mass * stiffness)), rel=1e-15)


def test_a_wall_is_the_limit_of_a_huge_sphere() -> None:
    """But for the radius that the paper scales bridges by, which is r_i there, half of the limit."""
    huge = 1e12  # of the first body: 1e-12 is left of it
    for of in (contact.reduced_radius, contact.effective_radius, contact.effective_mass):
        assert of(2e-3, math.inf) == pytest.approx(of(2e-3, 2e-3 * huge), rel=2e-12)
    assert contact.bridge_radius(2e-3, math.inf) == 0.5 * contact.effective_radius(2e-3, math.inf)
    assert (
        contact.bridge_radius(2e-3, 5e-3) == contact.effective_radius(2e-3, 5e-3) == 2.0 * (2e-3 * 5e-3) / (2e-3 + 5e-3)
    )


@pytest.mark.parametrize("share", [1e-12, 1e-4, 0.3, 10.0])
def test_thickness_and_volume_are_inverses(share: float) -> None:
    """From molecules to ten radii without loss of digits: a few roundings each way."""
    r = 2.5e-3
    assert contact.film_thickness(contact.film_volume(share * r, r), r) == pytest.approx(share * r, rel=4e-15)
