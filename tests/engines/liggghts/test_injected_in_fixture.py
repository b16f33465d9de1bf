"""Faults of the plugin in formations, walls, ends and forces that the replay once passed over: found, each by its name."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from reference_impl.replay.replay import replay
from tests.engines.liggghts import injected, injected_in_fixture
from tests.reference_impl import fixture_scene

pytestmark = [pytest.mark.engine, pytest.mark.slow]


@pytest.fixture(scope="module")
def foundry(tmp_path_factory: pytest.TempPathFactory) -> Iterator[injected.Foundry]:
    """One build and one process for all faults."""
    made = injected.Foundry(tmp_path_factory.mktemp("injected"))
    yield made
    made.close()


@pytest.mark.parametrize("scene", [fixture_scene.prepare, *injected_in_fixture.SCENES])
def test_nothing_injected_nothing_found(
    foundry: injected.Foundry, tmp_path: Path, scene: injected_in_fixture.Scene
) -> None:
    """Expect no finding without a fault, so that those below are not due to the patch."""
    foundry.run(tmp_path, scene(tmp_path), "none")
    result = replay(tmp_path)
    assert result["ok"], {n: q["worst"] for n, q in result["quantities"].items() if not q["ok"]}


FAULTS = {
    name: (scene, *shown)
    for scene, faults in (
        (fixture_scene.prepare, injected_in_fixture.IN_FIXTURE),
        *injected_in_fixture.SCENES.items(),
    )
    for name, shown in faults.items()
}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_is_found_and_named(foundry: injected.Foundry, tmp_path: Path, fault: str) -> None:
    """In the quantity where it was injected, and by its words."""
    scene, quantity, words = FAULTS[fault]
    foundry.run(tmp_path, scene(tmp_path), fault)
    result = replay(tmp_path)
    assert not result["quantities"][quantity]["ok"]
    findings = [f for f in result["diagnosis"]["findings"] if quantity in f["quantities"]]
    output_text = [sentence for f in findings for sentence in (f["sentence"], *f["consequences"])]
    assert any(words in sentence for sentence in output_text), output_text
