"""Raw record files of the plugin -> Parquet tables (schema.py). Reading the tables back is left to pandas."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.errors import NotWhole
from pywet.files import write_table
from pywet.history.schema import RAW

SORT = {
    "events": ["step", "kind", "partner_kind", "i", "j"],
    "contacts": ["step", "partner_kind", "i", "j"],
    "ledger": ["step"],
    "bridges": ["step", "partner_kind", "i", "j"],
    "films": ["step", "id"],
    "wall_films": ["step", "triangle"],
    "energy": ["step"],
    "drops": ["step", "i"],
}


OUTPUT = (
    "trajectory.parquet", "mesh_motion.parquet", *(f"history/{name}.parquet" for name in (*RAW, "window_*")), "replay.json",
    "contributions.json", "audit.json", "summary.json", "picture.png", "results", "vtk", "engine.partial.new",
    *(f"status/{stage}.json" for stage in ("simulate", "replay", "results", "vtk")),
)  # fmt: skip
"""All that follows from a run, by its path in the run directory."""


def forget(run_dir: Path) -> None:
    """Remove what an earlier run left in the directory, the sign that it is whole first."""
    (run_dir / "engine" / "tables.json").unlink(missing_ok=True)
    for path in [run_dir / "engine", *(path for name in OUTPUT for path in run_dir.glob(name))]:
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def read_raw(folder: Path, name: str) -> np.ndarray:
    """All records of one table, of all ranks."""
    parts = []
    for path in sorted(folder.glob(f"{name}.*.bin")):
        if path.stat().st_size % RAW[name].itemsize:
            raise NotWhole(f"{path} ends in the middle of a record; the run was cut off: run the case again")
        parts.append(np.fromfile(path, dtype=RAW[name]))
    if not parts:
        raise NotWhole(f"no log {name}.*.bin in {folder}; expected the plugin's output: run the case again")
    return np.concatenate(parts)


def to_frame(records: np.ndarray) -> pd.DataFrame:
    """Records -> columns; vectors become three columns with the suffixes _x, _y, _z, padding is dropped."""
    columns = {}
    for field in records.dtype.names or ():
        values = records[field]
        if field == "pad":
            continue
        if values.ndim == 2:
            columns.update({f"{field}_{axis}": values[:, k].copy() for k, axis in enumerate("xyz")})
        else:
            columns[field] = values.copy()
    return pd.DataFrame(columns)


def convert(folder: Path, history: Path) -> None:
    """Turn every raw log in `folder` that SORT names into `history/<name>.parquet`, sorted as in SORT."""
    for name in SORT:
        frame = to_frame(read_raw(folder, name)).sort_values(SORT[name], kind="stable", ignore_index=True)
        write_table(frame, history / f"{name}.parquet")
