"""Every fault injected in YADE's host is found by the replay, in the quantity that it spoils."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from reference_impl.replay.replay import replay
from tests.engines import injected_yade

pytestmark = [
    pytest.mark.engine,
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("yade") is None, reason="YADE is not installed: make peers"),
]


@pytest.fixture(scope="module")
def foundry(tmp_path_factory: pytest.TempPathFactory) -> Iterator[injected_yade.Foundry]:
    """One build and one process for all faults."""
    made = injected_yade.Foundry(tmp_path_factory.mktemp("injected"))
    yield made
    made.close()


def test_nothing_injected_nothing_found(foundry: injected_yade.Foundry, tmp_path: Path) -> None:
    """The patched host with all switches off agrees, and what the faults spoil is looked at."""
    injected_yade.scene(tmp_path)
    foundry.run(tmp_path, "none")
    found = replay(tmp_path)
    assert found["ok"], [name for name, q in found["quantities"].items() if not q["ok"]]
    assert min(found["quantities"][name]["count"] for name in injected_yade.FAULTS.values()) > 0


@pytest.mark.parametrize("fault", injected_yade.FAULTS)
def test_fault_is_found(foundry: injected_yade.Foundry, tmp_path: Path, fault: str) -> None:
    injected_yade.scene(tmp_path)
    foundry.run(tmp_path, fault)
    found = replay(tmp_path)
    assert not found["ok"]
    assert injected_yade.FAULTS[fault] in [name for name, q in found["quantities"].items() if not q["ok"]]
