"""Rows of the small scenes: what the engines' own measurements say, where an exact value or a stated limit is known."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.errors import PywetError
from pywet.evidence.engines import bed, pulls, small_scenes

needs_yade = pytest.mark.skipif(shutil.which("yade") is None, reason="YADE cannot be installed on this machine")
needs_liggghts = pytest.mark.skipif(shutil.which("liggghts") is None, reason="LIGGGHTS is not installed")


@needs_yade
def test_limits_are_as_stated() -> None:
    """No force in overlap; a wall is an equal sphere; two angles are refused, with the reason."""
    overlap, wall, angles = pulls.limits()
    assert abs(overlap["value"]) < 1e-15 and overlap["reference_value"] > 4e-4
    assert wall["deviation"] == pytest.approx(0.0, abs=1e-9)
    assert math.isnan(angles["value"]) and "two contact angles" in angles["note"]


def test_reference_and_exact_forces_at_touch() -> None:
    """Small-volume limits at touch: 2 pi r sigma cos(theta) between spheres, twice that at a wall.

    Rabinovich's second term adds to it, about sin(alpha) sin(theta + alpha) with alpha = 0.29 here: 10 to 35 %.
    """
    limit = 2 * math.pi * pulls.RADIUS * pulls.TENSION * math.cos(math.radians(pulls.ANGLE_DEG))
    for name, factor in (("two equal spheres", 1.0), ("sphere and wall", 2.0)):
        force = pulls.PAIRS[name].paper(np.array([0.0]))[0]
        assert 1.1 < force / (factor * limit) < 1.35
        assert pulls.PAIRS[name].exact(np.array([1e-8]))[0] < force


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


def test_rows_of_beds() -> None:
    """Deviation and spread by hand, dry beds against the dry bed of LIGGGHTS."""
    base = {"contacts_per_sphere": 4.0, "bridges_per_sphere": math.nan}
    tables = []
    for shift in (-0.1, 0.1):
        heights = {bed.OURS: 5.0 + shift, "YADE": 4.5 + shift, bed.DRY: 4.0 + shift, "YADE, dry": 4.0 - shift}
        tables.append(pd.DataFrame([{"engine": e, "mean_height_over_radius": h, **base} for e, h in heights.items()]))
    found = {(r["engine"], r["quantity"]): r for r in bed.rows(tables)}
    assert found["YADE", "mean height over radius"]["deviation"] == pytest.approx(-0.1)
    # variances 0.02 each of two runs: 2 sqrt(0.02)/5
    assert found["YADE", "mean height over radius"]["spread"] == pytest.approx(2 * math.sqrt(0.02) / 5)
    assert found["YADE, dry", "mean height over radius"]["deviation"] == pytest.approx(0.0, abs=1e-12)
    assert ("YADE", "bridges per sphere") not in found


def test_unknown_names() -> None:
    """One sentence each."""
    with pytest.raises(PywetError, match="the small scene drum was asked for; expected pulls"):
        small_scenes.write("drum", [], [])
    scene = None
    with pytest.raises(PywetError, match="the model soulie was asked for; expected one of washino, easo"):
        bed.stock(Path(), scene, bed.Bed(), "soulie")  # type: ignore[arg-type]
