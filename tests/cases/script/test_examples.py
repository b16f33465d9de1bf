"""The example scripts: dry as the stock program to the last bit with no liquid, wet with a replay that agrees."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest

from pywet import stages
from pywet.cases.script.scan import scan
from tests.cases.script.scripts import run
from tests.sound_runs import ROOT

EXAMPLES = ROOT / "examples" / "liggghts"
NAMES = ("packing", "chute", "drum", "stream", "mixer", "screen")
GOING = {"chute": 1, "stream": 20, "screen": 10}
"""Spheres that are deleted or lost at least."""

WEIGHED = ("chute", "drum", "mixer")
"""Those whose gravity the replay checks: every wall is wet, and nothing else acts on spheres."""


def prepare(folder: Path, name: str, percent: float | None = 1.0, line: str = "every 1000") -> None:
    """An example in a folder of its own; None: as it is, without the line."""
    folder.mkdir()
    shutil.copytree(EXAMPLES / "meshes", folder / "meshes")
    shutil.copy(EXAMPLES / "materials.in", folder)
    text, wet = ((EXAMPLES / f"{of}.{name}{end}").read_text() for of, end in (("in", ""), ("wet", ".yaml")))
    if percent is not None:
        text = text.replace("\nthermo  ", f"\nfix wet all pywet liquid wet.yaml {line}\nthermo  ")
    (folder / "in.script").write_text(text)
    (folder / "wet.yaml").write_text(wet.replace("percent: 1.0", f"percent: {percent}"))


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_in_the_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    prepare(tmp_path / "a", name)
    monkeypatch.chdir(tmp_path / "a")
    assert scan(Path("in.script")).problems == ()


@pytest.mark.engine
@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_no_liquid_is_the_stock_program(tmp_path: Path, name: str) -> None:
    prepare(tmp_path / "stock", name, None)
    prepare(tmp_path / "ours", name, 0.0)
    assert run(tmp_path / "stock", "liggghts").returncode == 0
    done = run(tmp_path / "ours")
    assert done.returncode == 0, done.stderr
    dumped = (tmp_path / "stock" / "dump.txt").read_text()
    assert dumped.count("ITEM: TIMESTEP") > 10 and (tmp_path / "ours" / "dump.txt").read_text() == dumped


@pytest.mark.engine
@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_replay_agrees(tmp_path: Path, name: str) -> None:
    """Of spheres that come and go, of meshes that move; what it cannot know of a stranger's script is named."""
    from reference_impl.replay.command import outcome

    prepare(tmp_path / "a", name)
    done = run(tmp_path / "a")
    assert done.returncode == 0, done.stderr
    found = outcome(tmp_path / "a" / "wet")
    assert found["status"] == "in part", [n for n, q in found.get("quantities", {}).items() if not q["ok"]]
    assert found["events"] > 200 and found["quantities"]["separation"]["count"] > 200
    weighed = name in WEIGHED
    assert any(sentence.startswith("gravity and Newton") for sentence in found["not_checked"]) == (not weighed)
    assert (found["quantities"]["between_momentum"]["count"] > 20) == weighed
    if name in ("mixer", "stream"):  # scenes with rotating meshes and with spheres inserted and deleted
        stages.vtk(tmp_path / "a" / "wet")
        assert len(list((tmp_path / "a" / "wet" / "vtk").glob("walls_*.vtu"))) > 10
    if name == "mixer":  # a wrong gravity is found
        scene = json.loads((tmp_path / "a" / "wet" / "scene.json").read_text())
        scene["gravity_m_per_s2"][2] *= 1.001
        (tmp_path / "a" / "wet" / "scene.json").write_text(json.dumps(scene))
        off = outcome(tmp_path / "a" / "wet")
        assert [n for n, q in off["quantities"].items() if not q["ok"]] == ["between_momentum"]
    history = tmp_path / "a" / "wet" / "history"
    gone, ledger = (pd.read_parquet(history / f"{n}.parquet") for n in ("retired", "ledger"))
    assert len(gone) >= GOING.get(name, 0) and ledger["retired"].iloc[-1] == pytest.approx(
        gone["film"].sum(), abs=1e-18
    )
    assert (name == "packing") == (not json.loads((tmp_path / "a" / "wet" / "scene.json").read_text())["walls"])
