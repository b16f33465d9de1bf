"""The notebook of the examples has ten cells, and each of them runs."""

from __future__ import annotations

from pathlib import Path

import nbformat
import pandas as pd
import pytest
from nbclient import NotebookClient

from tests.sweep.files import EXAMPLES


def test_ten_cells_from_a_file_to_points_where_the_map_is_least_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MPLBACKEND", "agg")
    notebook = nbformat.read(EXAMPLES / "sweep.ipynb", as_version=4)
    assert len(notebook.cells) == 10 and not any(cell.get("outputs") for cell in notebook.cells)
    (tmp_path / "examples").symlink_to(EXAMPLES)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    printed = "".join(o.get("text", "") for cell in notebook.cells for o in cell.get("outputs", []))
    assert "60 points, 60 runs" in printed and "64 of 64 runs have results" in printed
    made = pd.read_parquet(tmp_path / "results" / "sweeps" / "rebound" / "sweep.parquet")
    assert len(made) == 64 and made["e_n"].idxmax() == made[made["normal_velocity_m_per_s"] == 2.0]["e_n"].idxmax()
