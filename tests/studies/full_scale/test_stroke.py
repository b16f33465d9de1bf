"""Fig. 9: the path of the screen, against the words of section 5.1."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pywet import config as settings
from studies.full_scale.stroke import fig9, path_mm

CONFIG = settings.load(Path(__file__).parents[3] / "config")


@pytest.mark.parametrize(("set_amplitude_mm", "vertical_mm"), [(1.0, 0.9), (0.8, 0.72)])
def test_mainly_vertical_and_an_ellipse(set_amplitude_mm: float, vertical_mm: float) -> None:
    """ "About 0.9 mm and 0.72 mm" in z, x and y "with maximum amplitudes of A < 0.1 mm"; a closed path around an area."""
    path = path_mm(CONFIG, set_amplitude_mm)
    x, y, z = np.abs(path).max(axis=0)
    assert z == pytest.approx(vertical_mm, rel=1e-3) and max(x, y) < 0.1
    assert path[-1] == pytest.approx(path[0], abs=1e-9)
    area = 0.5 * np.sum(path[:-1, 0] * np.diff(path[:, 2]) - path[:-1, 2] * np.diff(path[:, 0]))
    assert abs(area) == pytest.approx(np.pi * x * z, rel=1e-2)


def test_the_picture_has_both_amplitudes() -> None:
    drawn = fig9(CONFIG)
    assert drawn.startswith("<svg") or "<svg" in drawn
    for words in ("set amplitude 1 mm", "set amplitude 0.8 mm", "z in mm"):
        assert words in drawn
