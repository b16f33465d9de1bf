"""Before numpy is imported: its matrices here are too small to share among threads, which on busy cores wait for each other.

Tests that slow.txt names are marked slow.
"""

import math
import os
from pathlib import Path

import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
SLOW = {line for line in (Path(__file__).parent / "slow.txt").read_text().splitlines() if not line.startswith("#")}


@pytest.fixture(autouse=True)
def no_progress_lines_of_the_replay(monkeypatch: pytest.MonkeyPatch) -> None:
    """They depend on how fast the machine is; what a command prints besides is compared as a whole."""
    monkeypatch.setattr("reference_impl.replay.io.LINE_S", math.inf)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of slow.txt before those that are slow are left out."""
    for item in items:
        if item.nodeid in SLOW:
            item.add_marker(pytest.mark.slow)
