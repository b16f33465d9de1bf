"""The runs that both engines start from."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from studies.engines import screening

CONFIG = Path(__file__).parents[3] / "config"


def test_seeds_give_different_arrangements_and_the_same_seed_the_same(tmp_path: Path) -> None:
    """Both engines start from the same places; another seed from others."""
    tables = []
    for name, seed in (("a", 10007), ("b", 10007), ("c", 10009)):
        assert screening.prepare(CONFIG, 1, "smoke", seed, tmp_path / name).effects.rolling is False
        tables.append(pd.read_parquet(tmp_path / name / "spheres.parquet"))
    assert tables[0].equals(tables[1])
    assert (tables[0][["x", "y", "z"]] - tables[2][["x", "y", "z"]]).abs().median().min() > 1e-3
