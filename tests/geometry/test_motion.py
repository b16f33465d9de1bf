"""Vibration: velocity is the derivative, the engine's sum is what its source says, the ellipse has the paper's size."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from pywet import config
from pywet.cases.screening import cases
from pywet.engines.liggghts.deck import viblin_words
from pywet.geometry.motion import engine_displacement, velocity
from pywet.scene import Vibration

CASES = config.load(Path(__file__).parents[2] / "config")


def position(vibration: Vibration, time: ArrayLike) -> np.ndarray:
    """Positions of the closed form about the centre of the motion [m]."""
    angle = 2.0 * math.pi * vibration.frequency_Hz * np.asarray(time)[..., None] + np.array(vibration.phase_rad)
    return np.array(vibration.amplitude_m) * np.sin(angle)


VIBRATION = Vibration(amplitude_m=(8e-5, 5e-5, 9e-4), phase_rad=(1.57, 0.8, 0.3), frequency_Hz=50.6)


def test_velocity_is_the_derivative() -> None:
    """Central difference of step h errs by (ωh)²/6 of aω: 1.7e-8 at h = 1 µs."""
    time, h = np.linspace(0.0, 0.05, 101), 1e-6
    difference = (position(VIBRATION, time + h) - position(VIBRATION, time - h)) / (2 * h)
    np.testing.assert_allclose(velocity(VIBRATION, time), difference, atol=3e-7 * 9e-4 * 318)


def test_engine_sum_is_that_of_the_mover() -> None:
    """Σ over movers of axis · (−A ω sin(ω n Δt + p)) Δt, added up step by step as mesh_mover_linear.cpp does."""
    step, steps = 2e-6, 5000
    shift = np.zeros(3)
    for words in (output_text.split() for output_text in viblin_words(VIBRATION)):
        axis, (amplitude, phase, period) = np.array(words[2:5], float), map(float, words[8::2])
        omega = 2.0 * math.pi / period
        for n in range(1, steps + 1):
            shift += axis * (-amplitude * omega * math.sin(omega * (n * step) + phase)) * step
    np.testing.assert_allclose(engine_displacement(VIBRATION, steps, step), shift, atol=1e-15)


def test_engine_sum_keeps_the_rounding_of_the_engines_clock() -> None:
    """Time is a sum of steps in the engine: after 20 s of the paper's steps it is nanoseconds late or early, and a screen
    of 0.3 m/s as many times 0.3 m next to the closed form sum over n Δt, 1e-9 of the slide's way or more."""
    step, steps = 6.43e-6, 3_000_000
    half = math.pi * VIBRATION.frequency_Hz * step
    z, phase = VIBRATION.amplitude_m[2], VIBRATION.phase_rad[2]
    time = shift = 0.0
    speed = z * 2.0 * math.pi * VIBRATION.frequency_Hz
    for _ in range(steps):
        time += step
        shift += speed * math.cos(2.0 * math.pi * VIBRATION.frequency_Hz * time + phase) * step
    found = engine_displacement(VIBRATION, [0, 7, steps], step)
    assert found[2, 2] == pytest.approx(shift, abs=1e-14)
    closed = z * (2.0 * half / math.sin(half)) * math.sin(half * steps) * math.cos(half * (steps + 1) + phase)
    late = time - steps * step
    assert abs(late) > 1e-10
    assert shift - closed == pytest.approx(0.0, abs=speed * abs(late)) and abs(shift - closed) > 1e-13


def test_engine_sum_follows_the_sine_within_one_step() -> None:
    step = 1e-6
    n = np.arange(0, 200_000, 37)
    difference = engine_displacement(VIBRATION, n, step) - position(VIBRATION, n * step) + position(VIBRATION, 0.0)
    bound = np.array(VIBRATION.amplitude_m) * 2 * math.pi * 50.6 * step
    assert (np.abs(difference) <= bound).all()
    np.testing.assert_array_equal(engine_displacement(VIBRATION, 0, step), 0.0)


@pytest.mark.parametrize(("case", "vertical"), [(1, 0.0009), (4, 0.00072)])
def test_ellipse_of_the_paper(case: int, vertical: float) -> None:
    """Fig. 9: 0.9 or 0.72 mm up and down, under 0.1 mm sideways; an ellipse, so x is not zero where z is."""
    vibration = cases.vibration_of(CASES, CASES.case(case))
    x, y, z = vibration.amplitude_m
    assert z == pytest.approx(vertical, rel=1e-12)
    assert 0 < x < 1e-4
    assert 0 < y < 1e-4
    assert vibration.frequency_Hz == 50.6
    turning = position(vibration, 0.0)
    assert turning[2] == 0.0
    assert turning[0] == pytest.approx(x)


def test_movers_leave_out_axes_at_rest_and_print_all_digits() -> None:
    vibration = Vibration(amplitude_m=(0.0, 0.0, 0.0009), phase_rad=(0.0, 0.0, 0.1), frequency_Hz=50.6)
    (output_text,) = viblin_words(vibration)
    words = output_text.split()
    assert words[:7] == ["viblin", "axis", "0", "0", "1", "order", "1"]
    assert float(words[8]) == 0.0009
    assert float(words[10]) == 0.1 - 0.5 * math.pi
    assert float(words[12]) == 1 / 50.6
