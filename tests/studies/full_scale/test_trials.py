"""Runs that test a reason: what is changed in the configuration, and the divisions of Fig. 14."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pywet import config as settings
from pywet import stages
from pywet.errors import PywetError
from pywet.runs.rundir import RunDir
from studies.full_scale import page, trials
from studies.full_scale.stored_runs import variants
from tests.cases.screening import synthetic
from tests.studies.full_scale.made import make

CONFIG = Path(__file__).parents[3] / "config"


def test_a_trial_changes_what_it_says(tmp_path: Path) -> None:
    """A sieve of 141.42 mm for the same feed has half the area: twice the mass of a class on the smoke scale's."""
    plain = settings.load(trials.configure(CONFIG, tmp_path / "as_is", "as_is"))
    deep = settings.load(trials.configure(CONFIG, tmp_path / "deep", "deep"))
    ratio = plain.materials.feed.sieve_diameter_mm.value / deep.materials.feed.sieve_diameter_mm.value
    assert ratio**2 == pytest.approx(2.0, rel=1e-4)
    assert plain.scale("smoke").duration_s.value == deep.scale("smoke").duration_s.value == 3.3
    shedding = settings.load(trials.configure(CONFIG, tmp_path / "shedding", "shedding"))
    assert (plain.settings.effects.shedding, shedding.settings.effects.shedding) == ("auto", True)
    with pytest.raises(PywetError, match="there is no trial flat, expected one of as_is"):
        trials.configure(CONFIG, tmp_path / "flat", "flat")


def test_the_divisions_of_figure_14_hold_all_liquid(tmp_path: Path) -> None:
    run = synthetic.make(tmp_path / "as_is-2", moist=True)
    stages.results(run)
    found = trials.divisions(RunDir(run))
    assert (found["case"], found["trial"]) == (2, "as_is")
    assert np.sum([found[title] for title in trials.FIG14]) == pytest.approx(1.0, rel=1e-9)


def test_an_effect_at_full_scale_is_set_against_seeds(tmp_path: Path) -> None:
    """Three seeds with 0.4, 0.41, 0.42 of the liquid on the fines; 0.5 with shedding is significant, 0.43 is not."""
    for seed, fines in enumerate((0.4, 0.41, 0.42), 1):
        make(tmp_path, 2, seed, fines=fines)
    runs = variants(tmp_path)[""]
    for fines, change in ((0.5, "**+0.0900 ± 0.0497**"), (0.43, "+0.0200 ± 0.0497")):
        shed = make(tmp_path / "other", 2, int(100 * fines), fines=fines)
        text = page._full_beyond(runs, {"shedding": {2: [shed]}})
        assert f"| fines and bin | 0.4100 | {change} |" in text
        assert "Cases 2 were run once at full scale with `shedding`." in text and text.endswith(
            "There is no run at full scale with `liquid_weight`."
        )
