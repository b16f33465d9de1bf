"""Faults of the plugin between the sampling windows, for a while, at one kind of contact, in one effect's work: all are found."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from pywet.engines.liggghts import build
from pywet.scene import Output
from reference_impl.replay.replay import replay
from tests.engines.foundry import VARIABLE
from tests.engines.liggghts import injected, test_wires
from tests.engines.liggghts import injected_between as between

pytestmark = [pytest.mark.engine, pytest.mark.slow]


@pytest.fixture(scope="module")
def foundry(tmp_path_factory: pytest.TempPathFactory) -> Iterator[injected.Foundry]:
    """One build and one process for all faults."""
    made = injected.Foundry(tmp_path_factory.mktemp("injected"))
    yield made
    made.close()


@pytest.mark.parametrize("kind", [between.EXPLICIT, between.SEMI, between.WIRES, between.DRIPPING])
def test_sound_run_agrees(foundry: injected.Foundry, tmp_path: Path, kind: str) -> None:
    """Expect no finding without a fault, so that those below are not due to the patch; every kind of record is compared."""
    foundry.run(tmp_path, between.prepare(tmp_path, kind), "none")
    result = replay(tmp_path)
    assert result["ok"], {n: q["worst"] for n, q in result["quantities"].items() if not q["ok"]}
    if kind == between.DRIPPING:
        assert result["quantities"]["felt_force"]["count"] > 100 and result["quantities"]["drop_volume"]["count"] > 2
        return
    counts = {n: q["count"] for n, q in result["quantities"].items()}
    least = {"between_capillary": 1000, "between_momentum": 100, "energy_windows": 15, "between_range": 1000}
    assert {n: counts[n] for n in least if counts[n] < least[n]} == {}
    seen = result["seen"]
    assert all(0.0 < seen[n] < 1.0 for n in ("steps", "bridges", "impulse_in_windows", "impulse_by_bounds")), seen
    assert sum("checked step by step" in sentence for sentence in result["not_checked"]) == 1


@pytest.mark.parametrize("fault", between.FAULTS)
def test_fault_is_found_and_described(foundry: injected.Foundry, tmp_path: Path, fault: str) -> None:
    """In the quantity where it acts, by which factor and at which kind of contact."""
    kind, quantity, words = between.FAULTS[fault]
    foundry.run(tmp_path, between.prepare(tmp_path, kind), fault)
    result = replay(tmp_path)
    assert not result["quantities"][quantity]["ok"]
    findings = result["diagnosis"]["findings"]
    sentences = [sentence for f in findings for sentence in (f["sentence"], *f["consequences"])]
    assert any(words in sentence for sentence in sentences), sentences


@pytest.mark.parametrize("fault", ["none", *between.ON_RANKS])
def test_fault_between_ranks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str) -> None:
    """Spheres that roll over the boundary of two ranks, dry: the patched plugin lies in another cache, without laws."""
    (tmp_path / "cache").mkdir(mode=0o700)
    monkeypatch.setenv("PYWET_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv(VARIABLE, fault)
    library = build.cached()
    with monkeypatch.context() as patched:
        patched.setattr(build, "SOURCES", injected.patched_sources(tmp_path / "sources"))
        build._compile(library)
    steps = 4000
    output = Output(
        interval_s=steps // 4 * test_wires.STEP, contact_windows=1, contact_window_steps=steps, window_trajectories=True
    )
    test_wires.bed(tmp_path / "run", steps, ranks=2, output=output)
    result = replay(tmp_path / "run")
    if fault == "none":
        assert result["ok"] and result["quantities"]["contact_spring"]["count"] > 1000
        return
    quantity, words = between.ON_RANKS[fault]
    assert not result["quantities"][quantity]["ok"]
    sentences = [s for f in result["diagnosis"]["findings"] for s in (f["sentence"], *f["consequences"])]
    assert any(words in sentence for sentence in sentences), sentences
