"""One engine run that several modules replay; nobody writes into it but the replay itself."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pywet import config, stages
from pywet.cases.screening import cases
from pywet.shipped import place
from studies.subset import with_spheres
from tests.reference_impl import fixture_scene, injected_log


@pytest.fixture(scope="session")
def heap_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Twelve wet spheres of two sizes falling on a floor, every step logged."""
    return injected_log.heap(tmp_path_factory.mktemp("heap"))


def _screened(case: int, folder: Path, duration_s: float) -> Path:
    """Sixteen spheres of a screening case at smoke scale, from configuration to results and replay."""
    scene = cases.build(config.load(place("config")), case, "smoke", folder)
    spheres = pd.read_parquet(folder / scene.spheres_file)
    few = spheres[spheres.groupby("type").cumcount() < spheres["type"].map({1: 12, 2: 2, 3: 2})]
    with_spheres(scene, folder, few, duration_s=duration_s, output=scene.output.model_copy(update={"checkpoints": 0}))
    stages.simulate(folder, ranks=1, progress=False)
    stages.results(folder)
    stages.replay(folder)
    return folder


@pytest.fixture(scope="session")
def screened_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A moist one, long enough for spheres of both small classes to pass; nobody writes into it."""
    return _screened(2, tmp_path_factory.mktemp("screened"), 1.1)


@pytest.fixture(scope="session")
def dry_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dry one."""
    return _screened(1, tmp_path_factory.mktemp("dry"), 0.6)


@pytest.fixture(scope="session")
def fixture_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A heap on a shaken screen, a drawn plate, a floor, pairs in flight."""
    return fixture_scene.write(tmp_path_factory.mktemp("fixture"))
