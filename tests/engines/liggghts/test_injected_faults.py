"""Every fault injected in the plugin is found by the replay and named; those that it cannot see are listed and shown."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from reference_impl.replay.replay import replay, table
from tests.engines.liggghts import beds, injected, injected_in_bin

pytestmark = pytest.mark.engine
SLOW = pytest.mark.slow
SECOND = {
    "gap left out", "volume twice in the force", "viscosity ten times", "half and half", "speed along n", "spin sign",
    "rupture of equal spheres", "drawn twice", "angle of i on both sides", "fast ones retired",
}  # fmt: skip
"""Each has a like among the others; run with `-m slow`."""


@pytest.fixture(scope="module")
def foundry(tmp_path_factory: pytest.TempPathFactory) -> Iterator[injected.Foundry]:
    """One build and one process for all faults."""
    made = injected.Foundry(tmp_path_factory.mktemp("injected"))
    yield made
    made.close()


def test_nothing_injected_nothing_found(foundry: injected.Foundry, tmp_path: Path) -> None:
    """The patched plugin with all switches off agrees: what is found below is the fault and not the patch."""
    foundry.run(tmp_path, injected.scene(tmp_path), "none")
    result = replay(tmp_path)
    assert result["ok"] and result["diagnosis"] is None
    assert result["events"] == 7 and result["contacts"] > 900
    assert "fault" not in table(result)


@pytest.mark.parametrize("fault", [pytest.param(f, marks=SLOW if f in SECOND else ()) for f in injected.NAMED])
def test_fault_is_found_and_named(foundry: injected.Foundry, tmp_path: Path, fault: str) -> None:
    """The first finding is the injected fault, in the equation where it was injected, and explains all that disagrees there."""
    quantity, words = injected.NAMED[fault]
    foundry.run(tmp_path, injected.scene(tmp_path), fault)
    result = replay(tmp_path)
    assert not result["ok"]
    first, *others = result["diagnosis"]["findings"]
    assert words in first["sentence"] and quantity in first["quantities"], first
    assert first["share"] == 1.0
    assert len(others) <= 1 and all(f["fault"] for f in others), others
    assert first["sentence"] in table(result)


@pytest.mark.parametrize("fault", injected.MOTION)
def test_fault_that_the_motion_shows(foundry: injected.Foundry, tmp_path: Path, fault: str) -> None:
    """The log holds; the speeds, or the reference's own walls, do not."""
    quantity, words = injected.MOTION[fault]
    foundry.run(tmp_path, injected.scene(tmp_path, motion=True), fault)
    result = replay(tmp_path)
    assert quantity in [n for n, q in result["quantities"].items() if not q["ok"]]
    found = [f["sentence"] for f in result["diagnosis"]["findings"] if quantity in f["quantities"]]
    assert found and words in found[0], result["diagnosis"]


@pytest.mark.parametrize("fault", injected.BESIDE)
def test_fault_that_outputs_and_events_show(foundry: injected.Foundry, tmp_path: Path, fault: str) -> None:
    """No motion is recorded; places at outputs and every rupture of the run tell."""
    contact_log, quantity, words = injected.BESIDE[fault]
    foundry.run(tmp_path, injected.scene(tmp_path, contact_log), fault)
    result = replay(tmp_path)
    output_text = [f["sentence"] for f in result["diagnosis"]["findings"] if quantity in f["quantities"]]
    assert not result["quantities"][quantity]["ok"] and words in output_text[0]


@pytest.mark.parametrize(
    "fault", [pytest.param(f, marks=SLOW if f in SECOND else ()) for f in injected_in_bin.IN_PLUGIN]
)
def test_fault_of_retirement(foundry: injected.Foundry, tmp_path: Path, fault: str) -> None:
    """The plugin retires the wrong spheres of a bed, or enters their liquid wrongly in the ledger."""
    quantity, words = injected_in_bin.IN_PLUGIN[fault]
    scene = beds.retiring(tmp_path, steps=1200, checkpoints=11, outputs=100)
    (tmp_path / "scene.json").write_text(scene.model_dump_json())
    foundry.run(tmp_path, [], fault)
    result = replay(tmp_path)
    output_text = [s for f in result["diagnosis"]["findings"] for s in (f["sentence"], *f["consequences"])]
    assert not result["quantities"][quantity]["ok"] and any(words in sentence for sentence in output_text), output_text


@pytest.mark.parametrize("what", injected.UNSEEN)
def test_what_the_replay_cannot_see(foundry: injected.Foundry, tmp_path: Path, what: str) -> None:
    """These agree although they are wrong; a change of this needs a change of docs/injected_faults.md."""
    fault, contact_log, _ = injected.UNSEEN[what]
    foundry.run(tmp_path, injected.scene(tmp_path, contact_log), fault)
    result = replay(tmp_path)
    assert result["ok"] and (result["contacts"] > 0) == contact_log
