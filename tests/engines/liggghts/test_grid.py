"""The processor grid follows the bed."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from pywet import config
from pywet.cases.screening import cases
from pywet.cases.small import small
from pywet.engines.liggghts import grid
from pywet.engines.schedule import checkpoints
from pywet.geometry import build_apparatus
from pywet.scene import EngineScene, Output
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of

CONFIG = config.load(Path(__file__).parents[3] / "config")


@pytest.fixture(scope="module")
def sieve() -> EngineScene:
    """Case 2 at smoke scale: the slide is drawn out along x, so that the box reaches far to one side."""
    case, scale = CONFIG.case(2), CONFIG.scale("smoke")
    spec = cases.apparatus_spec(CONFIG, case, scale)
    return cases.assemble(CONFIG, case, scale, cases.ingredients(CONFIG, 2, "smoke"), build_apparatus(spec))


def _on_the_screen(sieve: EngineScene) -> np.ndarray:
    """Places all over a sieve of 50 mm about the origin."""
    half = 0.024
    return np.stack(np.meshgrid(*[np.linspace(-half, half, 40)] * 2), axis=-1).reshape(-1, 2)


def test_two_ranks_share_the_sieve_across_the_slide(sieve: EngineScene) -> None:
    """The shortest cut, across the longer side of the box, leaves almost all spheres to one rank; along it both have half."""
    places = _on_the_screen(sieve)
    assert grid.fullest(sieve, places, (2, 1)) > 1.5
    assert grid.fullest(sieve, places, (1, 2)) == pytest.approx(1.0, abs=0.1)
    assert grid.chosen(sieve, places, 2) == (1, 2)


def test_of_equally_good_grids_the_one_with_the_shortest_cuts(sieve: EngineScene) -> None:
    """A square bed in the middle of its box: two halves, four quarters."""
    box = {"box_low_m": (-0.03, -0.02, 0.0), "box_high_m": (0.03, 0.02, 0.1)}
    scene = sieve.model_copy(update=box)
    places = 0.8 * _on_the_screen(sieve)
    assert [grid.chosen(scene, places, ranks) for ranks in (1, 2, 4)] == [(1, 1), (2, 1), (2, 2)]


def test_no_spheres_at_the_start_is_no_mistake(sieve: EngineScene) -> None:
    width, depth = (sieve.box_high_m[k] - sieve.box_low_m[k] for k in (0, 1))
    assert grid.chosen(sieve, np.zeros((0, 2)), 2) == ((2, 1) if width > depth else (1, 2))


@pytest.mark.engine
def test_chosen_anew_at_a_checkpoint(tmp_path: Path) -> None:
    """Eight spheres in a row along x, next to y = 0, fly until they are a row along y next to x = 0: the cut turns with them."""
    steps, step = 2000, 2e-5
    half_time = steps // 2 * step
    spheres = [
        small.Sphere(1, (at, 0.02, 0.0), ((0.04 - 0.8 * at) / half_time, (at - 0.02) / half_time, 0.0))
        for at in (8e-3 * (np.arange(8) - 3.5)).tolist()
    ]
    output = Output(interval_s=steps * step, contact_windows=0, checkpoints=1)
    small.prepare(
        tmp_path, spheres_of(2.5e-3), spheres, contacts(1), liquid=WATER, effects=small.PAPER, time_step_s=step, steps=steps,
        box=0.1, output=output,
    )  # fmt: skip
    scene = EngineScene.read(tmp_path / "scene.json")
    small.run(tmp_path, spheres, 2)
    log = (tmp_path / "engine" / "log.liggghts").read_text()
    assert re.findall(r"(\d) by (\d) by 1 MPI processor grid", log) == [("2", "1"), ("1", "2")]
    assert checkpoints(scene) == [1000] and re.findall(r"Nlocal: +(\S+) ave (\S+) max", log) == [("4", "8"), ("4", "5")]
