"""The bed with a stock cohesion model of LIGGGHTS."""

from __future__ import annotations

import shutil
from pathlib import Path

import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.errors import PywetError
from pywet.schema import FORMATION, RUPTURE
from studies.engines import bed

needs_liggghts = pytest.mark.skipif(shutil.which("liggghts") is None, reason="LIGGGHTS is not installed")


@needs_liggghts
def test_stock_model_changes_a_bed_deck_and_runs(tmp_path: Path) -> None:
    """Eight spheres with `easo`: the model's words are in the deck, and the spheres end on the floor."""
    given = bed.Bed(spheres=8, seconds=0.05)
    scene = bed.prepare(tmp_path, given, wet=False)
    bed.stock(tmp_path, scene, given, "easo")
    text = (tmp_path / "engine" / "setup.liggghts").read_text()
    assert text.count("cohesion easo/capillary/viscous") == 2 and "surfaceLiquidContent 0.025" in text
    end = pd.read_parquet(tmp_path / "trajectory.parquet").query("step == step.max()")
    r = scene.classes[0].radius_m
    assert len(end) == 8
    # on the floor or bouncing a little above it
    assert 0.9 * r < end["z"].min() < 1.2 * r


@needs_liggghts
def test_bridges_per_sphere_are_those_that_formed_and_did_not_rupture(tmp_path: Path) -> None:
    bed.prepare(tmp_path, bed.Bed(spheres=8, seconds=0.05))
    small.run(tmp_path, [])
    kinds = pd.read_parquet(tmp_path / "history" / "events.parquet")["kind"].value_counts()
    active = kinds[FORMATION] - kinds.get(RUPTURE, 0)
    assert active >= 8 and bed.measure(tmp_path)["bridges_per_sphere"] == 2.0 * active / 8


def test_an_unknown_model_is_one_sentence() -> None:
    """Expect a message that lists the known models."""
    scene = None
    with pytest.raises(PywetError, match="the model soulie was asked for; expected one of washino, easo"):
        bed.stock(Path(), scene, bed.Bed(), "soulie")  # type: ignore[arg-type]
