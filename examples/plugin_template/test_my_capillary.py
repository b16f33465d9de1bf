"""The law alone: a number worked out by hand, its limits, symmetry, the wall; and that pywet accepts it."""

import doctest
import math
from pathlib import Path

import my_capillary as module
import pytest
from my_capillary import my_capillary

from pywet.laws import custom_laws, registry

SIGMA = 0.07


def test_number_worked_out_by_hand() -> None:
    # r = 1 mm, V = 1e-11 m3, S = 10 µm: 2V/(π r) = 6.3662e-9 m2, √(1e-10 + 6.3662e-9) = 80.412 µm, 2π·0.07·1e-3·(1 − 10/80.412)
    assert my_capillary(1e-5, 1e-11, 1e-3, 1e-3, 0.0, 0.0, SIGMA) == pytest.approx(
        4.398230e-4 * (1 - 10 / 80.412), rel=1e-5
    )


def test_limits() -> None:
    limit = math.pi * SIGMA * 1e-3 * 2
    assert my_capillary(0.0, 1e-15, 1e-3, 1e-3, 0.0, 0.0, SIGMA) == pytest.approx(limit, rel=1e-15)
    assert my_capillary(-1e-5, 1e-11, 1e-3, 1e-3, 0.0, 0.0, SIGMA) == my_capillary(
        0.0, 1e-11, 1e-3, 1e-3, 0.0, 0.0, SIGMA
    )
    assert my_capillary(1e-5, 1e-11, 1e-3, math.inf, 0.2, 0.5, SIGMA) == pytest.approx(
        my_capillary(1e-5, 1e-11, 1e-3, 1e5, 0.2, 0.5, SIGMA), rel=1e-7
    )


def test_exchanging_the_bodies_changes_nothing() -> None:
    assert my_capillary(1e-5, 1e-11, 1e-3, 2e-3, 0.2, 0.5, SIGMA) == pytest.approx(
        my_capillary(1e-5, 1e-11, 2e-3, 1e-3, 0.5, 0.2, SIGMA), rel=1e-15
    )


def test_docstring_and_probe() -> None:
    test = doctest.DocTestParser().get_doctest(my_capillary.__doc__ or "", vars(module), "my_capillary", None, None)
    assert doctest.DocTestRunner().run(test).failed == 0
    name = f"{Path(__file__).with_name('my_capillary.py')}:my_capillary"
    custom_laws.trust([name])
    law = registry.get("capillary", name)  # tried on the probe grid
    assert law.functions[0](0.0, 1e-11, 1e-3, 1e-3, 0.0, 0.0, SIGMA) > 0
