"""Tables that other programs wrote back with an index of pandas: the same tables, wherever they are read."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pywet.util.files import read_parts, read_table
from reference_impl.replay import io


@pytest.mark.parametrize("index", [["step"], ["step", "id"], ["id"]])
def test_an_index_is_a_column_as_others(tmp_path: Path, index: list[str]) -> None:
    """`table.set_index("step").to_parquet(…)` takes no column away from the program or from the reference."""
    path = tmp_path / "history" / "films.parquet"
    path.parent.mkdir()
    table = pd.DataFrame({"step": [0, 0, 10], "id": [1, 2, 1], "film": [1e-12, 2e-12, 3e-12]})
    table.set_index(index).to_parquet(path)
    names = list(table.columns)
    found = [
        read_table(path),
        pd.concat(list(read_parts(path, names))),
        io.table(path, "films"),
        io.columns(path, names),
    ]
    for one in found:
        pd.testing.assert_frame_equal(one[names].reset_index(drop=True), table)
    assert list(read_table(path, step=10)["id"]) == [1]
