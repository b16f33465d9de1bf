"""The processor grid follows the bed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pywet import config
from pywet.apparatus import build_apparatus
from pywet.engines.liggghts import grid
from pywet.scene import Scene
from pywet.screening import cases

CONFIG = config.load(Path(__file__).parents[3] / "config")


@pytest.fixture(scope="module")
def sieve() -> Scene:
    """Case 2 at smoke scale: the slide is drawn out along x, so that the box reaches far to one side."""
    case, scale = CONFIG.case(2), CONFIG.scale("smoke")
    spec = cases.apparatus_spec(CONFIG, case, scale)
    return cases.assemble(CONFIG, case, scale, cases.ingredients(CONFIG, 2, "smoke"), build_apparatus(spec))


def _on_the_screen(sieve: Scene) -> np.ndarray:
    """Places all over a sieve of 50 mm about the origin."""
    half = 0.024
    return np.stack(np.meshgrid(*[np.linspace(-half, half, 40)] * 2), axis=-1).reshape(-1, 2)


def test_two_ranks_share_the_sieve_across_the_slide(sieve: Scene) -> None:
    """The shortest cut, across the longer side of the box, leaves almost all spheres to one rank; along it both have half."""
    places = _on_the_screen(sieve)
    assert grid.fullest(sieve, places, (2, 1)) > 1.5
    assert grid.fullest(sieve, places, (1, 2)) == pytest.approx(1.0, abs=0.1)
    assert grid.chosen(sieve, places, 2) == (1, 2)


def test_of_equally_good_grids_the_one_with_the_shortest_cuts(sieve: Scene) -> None:
    """A square bed in the middle of its box: two halves, four quarters."""
    box = {"box_low_m": (-0.03, -0.02, 0.0), "box_high_m": (0.03, 0.02, 0.1)}
    scene = sieve.model_copy(update=box)
    places = 0.8 * _on_the_screen(sieve)
    assert [grid.chosen(scene, places, ranks) for ranks in (1, 2, 4)] == [(1, 1), (2, 1), (2, 2)]


def test_no_spheres_at_the_start_is_no_mistake(sieve: Scene) -> None:
    width, depth = (sieve.box_high_m[k] - sieve.box_low_m[k] for k in (0, 1))
    assert grid.chosen(sieve, np.zeros((0, 2)), 2) == ((2, 1) if width > depth else (1, 2))
