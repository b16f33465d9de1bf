"""The replay of a real engine run agrees; injected faults are the business of test_diagnosis.py and tests/engine."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from reference_impl.replay import io
from reference_impl.replay.replay import replay
from reference_impl.replay.stored_tables import added_up

pytestmark = pytest.mark.engine


def test_agrees(heap_dir: Path) -> None:
    """Volumes, shares, films, forces and torques within 1e-9, the ledger within 1e-12, ruptures as the papers say."""
    result = replay(heap_dir)
    assert result["events"] > 20 and result["contacts"] > 1000
    assert (pd.read_parquet(heap_dir / "history" / "events.parquet")["kind"] == 1).any()
    bad = {n: q["largest"] for n, q in result["quantities"].items() if not q["ok"]}
    assert result["ok"], bad
    q = result["quantities"]
    assert q["formation_missed"]["count"] > 100  # pairs of spheres whose films touch at an output
    assert q["snapshot_volume"]["count"] == len(pd.read_parquet(heap_dir / "history" / "bridges.parquet"))
    assert q["transfer_interpolation"]["count"] > 3
    assert result["contacts_per_s"] > 0.0


def test_missing_history_is_one_sentence(tmp_path: Path) -> None:
    """A folder without logs is refused by name."""
    with pytest.raises(io.ReplayError, match=r"scene\.json is missing; expected the folder of a run"):
        replay(tmp_path)


def test_liquid_of_a_large_bed_is_added_up_to_round_off() -> None:
    """A hundred thousand equal bridges added one after the other are off by 1e-12; in whatever order they come, they are not."""
    volume, count = 3.7e-11, 200_000
    group = np.arange(2 * count) % 2
    sums = added_up(np.full(2 * count, volume), group, 3)
    assert sums[:2] == pytest.approx(math.fsum([volume] * count), rel=1e-15) and sums[2] == 0.0
    assert added_up(np.zeros(0), np.zeros(0, np.intp), 2).tolist() == [0.0, 0.0]
