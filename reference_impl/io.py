"""Reads the logs of a run and writes the replay's result. The column names are those of the written schema (docs/replay.md)."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Floats = NDArray[Any]


class ReplayError(Exception):
    """The logs are missing or do not go together; one sentence."""


@dataclass(frozen=True)
class Run:
    """The logs of one run."""

    folder: Path
    meta: dict[str, Any]
    tables: dict[str, pd.DataFrame]

    def table(self, name: str) -> pd.DataFrame:
        """One table of the history."""
        return self.tables[name]


TABLES = ("spheres", "transfer", "events", "contacts", "ledger", "bridges", "films", "wall_films")
WALL_TABLES = ("triangles", "parts")


def read(folder: Path) -> Run:
    """Read history/ of a run directory."""
    history = Path(folder) / "history"
    if not (history / "meta.json").exists():
        raise ReplayError(f"{history} holds no meta.json; expected the history of a moist run: run the case first")
    tables = {}
    for name in (*TABLES, *WALL_TABLES):
        path = history / f"{name}.parquet"
        if path.exists():
            tables[name] = pd.read_parquet(path)
        elif name in TABLES:
            raise ReplayError(f"{path} is missing; expected the complete history of a moist run: run the case again")
    return Run(Path(folder), json.loads((history / "meta.json").read_text()), tables)


def vectors(table: pd.DataFrame, name: str) -> Floats:
    """Three columns of a vector as an array (n, 3)."""
    return np.asarray(table[[f"{name}_x", f"{name}_y", f"{name}_z"]], dtype=np.float64)


def write_json(path: Path, value: dict[str, Any]) -> None:
    """Write under a temporary name, then rename."""
    temporary = path.with_suffix(f".{os.getpid()}.partial")
    temporary.write_text(json.dumps(value, indent=1, allow_nan=False))
    temporary.replace(path)
