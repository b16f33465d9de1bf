"""The replay of runs whose liquid weighs and drips: it agrees, and what is wrong in them shows."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from pywet.cases.small import small
from reference_impl.replay import spans
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER
from tests.engines.liggghts.test_shedding import SOAPY
from tests.reference_impl.test_stream import at_size

pytestmark = pytest.mark.engine
STEPS = 1000


def bed(run_dir: Path, **effects: object) -> Path:
    """A bed of 168 spheres on a vibrating floor whose films are thicker than what hangs at rest."""
    spheres = beds.bed((6, 6, 6))
    liquid = SOAPY if "shedding" in effects else WATER
    beds.prepare(run_dir, spheres, STEPS, effects=small.PAPER.model_copy(update=effects), liquid=liquid)
    small.run(run_dir, spheres)
    return run_dir


@pytest.fixture(scope="module")
def dripping(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With both effects."""
    return bed(tmp_path_factory.mktemp("dripping"), liquid_weight=True, shedding="tate")


def test_a_heavy_and_dripping_bed_agrees(dripping: Path) -> None:
    """Newton's law with the liquid's mass, films with the drops, places of landing; drops of water are met."""
    result = replay(dripping)
    assert result["ok"], [name for name, q in result["quantities"].items() if not q["ok"]]
    count = {name: q["count"] for name, q in result["quantities"].items()}
    assert count["drop_volume"] > 100 and count["drop_landing"] > 30 and count["newton_force"] > 5000
    assert any("which bridges are missing at output steps only" in sentence for sentence in result["not_checked"])
    share = json.loads((dripping / "contributions.json").read_text())["effects"]["shedding"]["liquid_share"]
    drops = beds.table(dripping, "history/drops")["volume"].sum()
    assert share == pytest.approx(drops / beds.table(dripping, "history/spheres")["film"].sum(), rel=1e-12)


def test_a_dripping_bed_in_parts(dripping: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts of some 50 events: what falls, lands and is carried goes from one to the next, to the last bit."""
    assert at_size(dripping, 50, monkeypatch) == at_size(dripping, spans.SIZE, monkeypatch)


def test_share_of_the_liquids_weight(tmp_path: Path) -> None:
    """No liquid meets a wall: the impulse of its weight over that of the spheres is the ratio of the masses, on or off."""
    run_dir = bed(tmp_path, liquid_weight=True, wall_films=False)
    scene = json.loads((run_dir / "scene.json").read_text())
    spheres = beds.table(run_dir, "history/spheres")
    density = {c["type"]: c["density_kg_per_m3"] for c in scene["classes"]}
    dry = (spheres["type"].map(density) * 4.0 / 3.0 * 3.141592653589793 * spheres["radius"] ** 3).sum()
    for on in (True, False):
        scene["effects"]["liquid_weight"] = on
        (run_dir / "scene.json").write_text(json.dumps(scene))
        result = replay(run_dir)
        assert result["quantities"]["newton_force"]["ok"] == on  # a liquid of 5 % of the mass shows
        effects = json.loads((run_dir / "contributions.json").read_text())["effects"]
        assert effects["liquid_weight"]["acting"] == on
        ratio = effects["liquid_weight"]["impulse_Ns"] / effects["weight"]["impulse_Ns"]
        assert ratio == pytest.approx(998.2 * spheres["film"].sum() / dry, rel=1e-9)


def test_mass_of_the_liquid_in_semi_implicit_drag(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The step's drag knows what the spheres carry, also in parts: its factors agree, and do not with the dry masses."""
    spheres = beds.bed((4, 4, 4))
    heavy = small.PAPER.model_copy(update={"liquid_weight": True})
    scene = beds.prepare(tmp_path, spheres, 400, effects=heavy).model_copy(
        update={"viscous_integration": "semi_implicit"}
    )
    (tmp_path / "scene.json").write_text(scene.model_dump_json())
    small.run(tmp_path, spheres)
    found = at_size(tmp_path, 20, monkeypatch)
    assert found["ok"] and found == at_size(tmp_path, spans.SIZE, monkeypatch)
    meta = json.loads((tmp_path / "history" / "meta.json").read_text())
    meta["effects"]["liquid_weight"] = False
    (tmp_path / "history" / "meta.json").write_text(json.dumps(meta))
    assert not replay(tmp_path)["quantities"]["factor_normal"]["ok"]


def _less(drops: pd.DataFrame) -> pd.DataFrame:
    return drops.assign(volume=drops["volume"].where(drops.index != 20, 0.999 * drops["volume"]))


def _elsewhere(drops: pd.DataFrame) -> pd.DataFrame:
    at_output = drops[(drops["step"] % 100 == 0) & (drops["partner_kind"] == 0)].index[0]
    return drops.assign(j=drops["j"].where(drops.index != at_output, drops["j"] % 5 + 1))


def _lost(drops: pd.DataFrame) -> pd.DataFrame:
    return drops.drop(index=20)


@pytest.mark.parametrize(
    ("change", "shows"),
    [
        (_less, {"drop_volume"}),
        (_elsewhere, {"drop_landing", "snapshot_films"}),
        (_lost, {"snapshot_films"}),
    ],
)
def test_what_is_wrong_with_a_drop_shows(
    dripping: Path, tmp_path: Path, change: Callable[[pd.DataFrame], pd.DataFrame], shows: set[str]
) -> None:
    """A drop smaller than it should be, one that is booked elsewhere, one that is missing."""
    folder = tmp_path / "run"
    shutil.copytree(dripping, folder)
    change(beds.table(folder, "history/drops")).to_parquet(folder / "history" / "drops.parquet")
    result = replay(folder)
    assert shows <= {name for name, q in result["quantities"].items() if not q["ok"]}
