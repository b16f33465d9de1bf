"""Reads the logs of a run and writes the replay's result. The column names are those of the written schema (docs/replay.md)."""

from __future__ import annotations

import json
import os
import sys
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
            tables[name] = _table(path, name)
        elif name in TABLES:
            raise ReplayError(f"{path} is missing; expected the complete history of a moist run: run the case again")
    try:
        meta = json.loads((history / "meta.json").read_text())
        _ = float(meta["surface_tension"]), float(meta["viscosity"]), meta["effects"].keys(), len(meta["types"])
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ReplayError(f"{history / 'meta.json'} cannot be read ({error!r}); expected what the driver wrote: "
                          "run the case again") from error  # fmt: skip
    return Run(Path(folder), meta, tables)


NEEDED: dict[str, tuple[str, ...]] = {
    "spheres": ("id", "type", "radius", "film"),
    "transfer": ("partner_kind", "type_i", "type_j", "part_class", "v_star", "transfer_i"),
    "events": ("step", "kind", "partner_kind", "i", "j", "triangle", "volume", "share_i", "share_j", "film_i_before",
               "film_i_after", "film_j_before", "film_j_after", "separation", "rupture_distance", "speed"),
    "contacts": ("step", "partner_kind", "i", "j", "triangle", "xi_x", "vi_x", "wi_x", "xj_x", "vj_x", "wj_x", "volume",
                 "separation", "rupture_distance", "capillary", "viscous_normal", "viscous_tangential_x", "force_i_x",
                 "torque_i_x", "torque_j_x", "viscous_law", "factor_normal", "push_x", "spin_push_x"),
    "ledger": ("step", "films", "bridges", "walls", "left"),
    "bridges": ("step", "partner_kind", "i", "j", "triangle", "volume", "share_i"),
    "films": ("step", "id", "film"),
    "wall_films": ("step", "triangle", "film"),
    "triangles": ("triangle", "area"),
    "parts": ("part", "half_width", "contact_angle", "part_class"),
}  # fmt: skip
"""Columns without which a table is not the one meant (of vectors the first component)."""


def _table(path: Path, name: str) -> pd.DataFrame:
    """One table, complete."""
    try:
        table = pd.read_parquet(path)
    except Exception as error:  # a cut or foreign file: pyarrow has many names for that
        raise ReplayError(f"{path} is not a readable Parquet table; expected the history of a moist run: "
                          "run the case again") from error  # fmt: skip
    lacking = [column for column in NEEDED[name] if column not in table]
    if lacking:
        raise ReplayError(
            f"{path} lacks {', '.join(lacking)}; expected the columns of docs/replay.md: run the case again"
        )
    return table


def note(text: str) -> None:
    """What is being done, on one line of a terminal."""
    if sys.stderr.isatty():
        print(f"\r\033[Kreplay: {text}", end="", file=sys.stderr, flush=True)


def clear() -> None:
    """Take the line of `note` away."""
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr, flush=True)


def vectors(table: pd.DataFrame, name: str) -> Floats:
    """Three columns of a vector as an array (n, 3)."""
    return np.asarray(table[[f"{name}_x", f"{name}_y", f"{name}_z"]], dtype=np.float64)


def write_json(path: Path, value: dict[str, Any]) -> None:
    """Write under a temporary name, then rename."""
    temporary = path.with_suffix(f".{os.getpid()}.partial")
    temporary.write_text(json.dumps(value, indent=1, allow_nan=False))
    temporary.replace(path)
