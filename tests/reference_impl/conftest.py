"""One engine run that several modules replay; nobody writes into it but the replay itself."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.reference_impl import planted_log, yard


@pytest.fixture(scope="session")
def heap_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Twelve wet spheres of two sizes falling on a floor, every step logged."""
    return planted_log.heap(tmp_path_factory.mktemp("heap"))


@pytest.fixture(scope="session")
def yard_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A heap on a shaken screen, a drawn plate, a floor, pairs in flight."""
    return yard.yard(tmp_path_factory.mktemp("yard"))
