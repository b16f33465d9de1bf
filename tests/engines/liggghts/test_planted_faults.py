"""Every fault injected in the plugin is found by the replay and named; those that it cannot see are listed and shown."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from reference_impl.replay.replay import replay, table
from tests.engines.liggghts import beds, planted, planted_in_bin

pytestmark = pytest.mark.engine
SLOW = pytest.mark.slow
SECOND = {
    "gap left out", "volume twice in the force", "viscosity ten times", "half and half", "speed along n", "spin sign",
    "rupture of equal spheres", "drawn twice", "angle of i on both sides", "fast ones retired",
}  # fmt: skip
"""Each has a like among the others; run with `-m slow`."""


@pytest.fixture(scope="module")
def foundry(tmp_path_factory: pytest.TempPathFactory) -> Iterator[planted.Foundry]:
    """One build and one process for all faults."""
    made = planted.Foundry(tmp_path_factory.mktemp("planted"))
    yield made
    made.close()


def test_nothing_planted_nothing_found(foundry: planted.Foundry, tmp_path: Path) -> None:
    """The patched plugin with all switches off agrees: what is found below is the fault and not the patch."""
    foundry.run(tmp_path, planted.scene(tmp_path), "none")
    result = replay(tmp_path)
    assert result["ok"] and result["diagnosis"] is None
    assert result["events"] == 7 and result["contacts"] > 900
    assert "fault" not in table(result)


@pytest.mark.parametrize("fault", [pytest.param(f, marks=SLOW if f in SECOND else ()) for f in planted.NAMED])
def test_fault_is_found_and_named(foundry: planted.Foundry, tmp_path: Path, fault: str) -> None:
    """The first finding is the injected fault, in the equation where it was injected, and explains all that disagrees there."""
    quantity, words = planted.NAMED[fault]
    foundry.run(tmp_path, planted.scene(tmp_path), fault)
    result = replay(tmp_path)
    assert not result["ok"]
    first, *others = result["diagnosis"]["findings"]
    assert words in first["sentence"] and quantity in first["quantities"], first
    assert first["share"] == 1.0
    assert len(others) <= 1 and all(f["fault"] for f in others), others
    assert first["sentence"] in table(result)


@pytest.mark.parametrize("fault", planted.MOTION)
def test_fault_that_the_motion_shows(foundry: planted.Foundry, tmp_path: Path, fault: str) -> None:
    """The log holds; the speeds, or the reference's own walls, do not."""
    quantity, words = planted.MOTION[fault]
    foundry.run(tmp_path, planted.scene(tmp_path, motion=True), fault)
    result = replay(tmp_path)
    assert quantity in [n for n, q in result["quantities"].items() if not q["ok"]]
    found = [f["sentence"] for f in result["diagnosis"]["findings"] if quantity in f["quantities"]]
    assert found and words in found[0], result["diagnosis"]


@pytest.mark.parametrize("fault", planted.BESIDE)
def test_fault_that_outputs_and_events_show(foundry: planted.Foundry, tmp_path: Path, fault: str) -> None:
    """No motion is recorded; places at outputs and every rupture of the run tell."""
    contact_log, quantity, words = planted.BESIDE[fault]
    foundry.run(tmp_path, planted.scene(tmp_path, contact_log), fault)
    result = replay(tmp_path)
    output_text = [f["sentence"] for f in result["diagnosis"]["findings"] if quantity in f["quantities"]]
    assert not result["quantities"][quantity]["ok"] and words in output_text[0]


@pytest.mark.parametrize(
    "fault", [pytest.param(f, marks=SLOW if f in SECOND else ()) for f in planted_in_bin.IN_PLUGIN]
)
def test_fault_of_retirement(foundry: planted.Foundry, tmp_path: Path, fault: str) -> None:
    """The plugin retires the wrong spheres of a bed, or books their liquid wrongly."""
    quantity, words = planted_in_bin.IN_PLUGIN[fault]
    scene = beds.retiring(tmp_path, steps=1200, checkpoints=11, outputs=100)
    (tmp_path / "scene.json").write_text(scene.model_dump_json())
    foundry.run(tmp_path, [], fault)
    result = replay(tmp_path)
    output_text = [s for f in result["diagnosis"]["findings"] for s in (f["sentence"], *f["consequences"])]
    assert not result["quantities"][quantity]["ok"] and any(words in sentence for sentence in output_text), output_text


@pytest.mark.parametrize("what", planted.UNSEEN)
def test_what_the_replay_cannot_see(foundry: planted.Foundry, tmp_path: Path, what: str) -> None:
    """These agree although they are wrong; a change of this needs a change of docs/planted_faults.md."""
    fault, contact_log, _ = planted.UNSEEN[what]
    foundry.run(tmp_path, planted.scene(tmp_path, contact_log), fault)
    result = replay(tmp_path)
    assert result["ok"] and (result["contacts"] > 0) == contact_log
