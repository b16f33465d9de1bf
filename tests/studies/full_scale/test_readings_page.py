"""What each reading changes: the page shows what is stored, and the figures are those of a run's tables."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pywet import stages
from pywet.config.readings import Readings
from pywet.runs.rundir import RunDir
from studies.full_scale import readings
from tests.cases.screening import synthetic

ROOT = Path(__file__).parents[3]


def test_the_page_shows_what_is_stored() -> None:
    text = (ROOT / "docs" / "readings.md").read_text()
    for row in readings.rows(pd.read_csv(ROOT / readings.FILE)):
        assert row in text, row


def test_every_reading_is_on_the_page_and_is_measured() -> None:
    text, stored = (ROOT / "docs" / "readings.md").read_text(), set(pd.read_csv(ROOT / readings.FILE)["reading"])
    for key in Readings.model_fields:
        assert f"\n| `{key}` | " in text
        assert any(name.startswith(f"{key}=") for name in stored), key


def test_the_figures_of_a_run(tmp_path: Path) -> None:
    """The synthetic run, whose liquid all lies with spheres and walls; shares of walls and spheres add up."""
    run = synthetic.make(tmp_path / "small_wall=half_facet-2", moist=True)
    stages.results(run)
    found = readings.figures(RunDir(run))
    assert (found["case"], found["reading"]) == (2, "small_wall=half_facet")
    liquid = RunDir(run).table("results/liquid_by_holder").iloc[-1]
    on_spheres = (liquid["coarse_material_m3"] + liquid["fines_m3"] + liquid["left_m3"]) / liquid["initial_m3"]
    assert found["walls_share"] == pytest.approx(1.0 - on_spheres, abs=1e-12) and 0.0 < found["walls_share"] < 1.0
