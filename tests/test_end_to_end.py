"""One dry and one moist case from the configuration to results, with few spheres, long enough for all undersize to pass."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet import config, stages
from pywet.cases.screening import cases
from pywet.scene import EngineScene
from studies.subset import with_spheres

pytestmark = pytest.mark.engine
ROOT = Path(__file__).parents[1]
COUNTS = {1: 12, 2: 2, 3: 2}
"""Number of spheres of each class: so few that they do not hinder each other."""


def thinned(case: int, run_dir: Path, duration_s: float) -> EngineScene:
    """Build a smoke case and keep a few spheres of each class."""
    scene = cases.build(config.load(ROOT / "config"), case, "smoke", run_dir)
    spheres = pd.read_parquet(run_dir / scene.spheres_file)
    stored = spheres[spheres.groupby("type").cumcount() < spheres["type"].map(COUNTS)]
    output = scene.output.model_copy(update={"checkpoints": 0})
    return with_spheres(scene, run_dir, stored, duration_s=duration_s, output=output)


def test_dry_falls_to_the_share_of_the_coarse(tmp_path: Path) -> None:
    """Fraction retained never rises and ends at the coarse class' share of the mass; every sphere is still there."""
    scene = thinned(1, tmp_path, 12.0)
    stages.simulate(tmp_path, ranks=1, progress=False)
    stages.results(tmp_path)
    replayed = stages.replay(tmp_path)
    assert replayed is not None and replayed["scene"]["ok"] and replayed["results"]["ok"]
    retained = pd.read_parquet(tmp_path / "results" / "fraction_retained.parquet")
    y = retained["fraction_retained"].to_numpy()
    mass = {c.name: c.mass_kg * COUNTS[c.type] for c in scene.classes}
    assert y[0] == 1.0 and (np.diff(y) <= 0).all()
    assert y[-1] == pytest.approx(mass["large"] / sum(mass.values()), rel=1e-12)
    trajectory = pd.read_parquet(tmp_path / "trajectory.parquet")
    assert (trajectory.groupby("step")["id"].nunique() == sum(COUNTS.values())).all()
    assert not (tmp_path / "history" / "events.parquet").exists()  # the stock engine, no plugin
    assert json.loads((tmp_path / "engine" / "run.json").read_text())["plugin_hash"] is None


def test_moist_is_cross_checked(tmp_path: Path) -> None:
    """Ledger to 1e-12, replay within its tolerances, liquid by reservoir adds up at every output, files for ParaView."""
    scene = thinned(2, tmp_path, 0.9)
    stages.simulate(tmp_path, ranks=1, progress=False)
    stages.results(tmp_path)
    replayed = stages.replay(tmp_path)
    stages.vtk(tmp_path)
    assert replayed is not None and replayed["ok"]
    assert replayed["scene"]["ok"] and replayed["results"]["ok"]
    assert replayed["events"] > 100 and replayed["contacts"] > 100
    assert json.loads((tmp_path / "engine" / "run.json").read_text())["ledger_error"] <= 1e-12
    start = pd.read_parquet(tmp_path / "history" / "spheres.parquet")["film"].sum()
    reservoirs = pd.read_parquet(tmp_path / "results" / "liquid_by_holder.parquet")
    assert len(reservoirs) > 10
    assert scene.liquid is not None and start > 0
    assert {p.suffix for p in (tmp_path / "vtk").iterdir()} >= {".pvd"}
