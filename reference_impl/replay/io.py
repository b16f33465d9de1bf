"""Read the logs of a run and write the replay's result.

The column names are those of `pywet/schema.py`. Tables that grow with the length of a run are read in parts
(stream.py); `Run.table` reads whole tables.
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd
from pyarrow import parquet

from reference_impl.faults import Refused
from reference_impl.replay.arrays import Table

LINE_S = 10.0
"""Least time between two lines of progress where there is no terminal [s]."""
_latest = time.monotonic()


class ReplayError(Refused):
    """The logs are missing or inconsistent; one sentence."""


@dataclass(frozen=True)
class Run:
    """The logs of one run, or a part of them."""

    folder: Path
    meta: dict[str, Any]
    tables: dict[str, pd.DataFrame]
    """Tables in memory."""
    known: dict[str, Any] = field(default_factory=dict)
    """Derived data, shared by all parts of a run."""
    since: int = -1
    """Last step of events that are included only because later ones follow from them."""

    def table(self, name: str) -> pd.DataFrame:
        """Return one table; for logs the whole, unless a part of them is in memory."""
        if name not in self.tables:
            self.tables[name] = table(where(self.folder, name), name)
        return self.tables[name]

    @property
    def shed(self) -> pd.DataFrame:
        """Return the drops of the whole run; empty for a run without drops, which has no such table."""
        return self.tables.get(SHED, pd.DataFrame({name: np.zeros(0) for name in NEEDED[SHED]}))

    def rows(self, name: str, first: int, last: int) -> pd.DataFrame:
        """Return the rows of a log in steps first to last."""
        if name in self.tables:
            steps = self.tables[name]["step"]
            return self.tables[name][(steps >= first) & (steps <= last)].reset_index(drop=True)
        whole = self._small(name)
        if whole is not None:
            start, end = np.searchsorted(whole["step"].to_numpy(), [first, last + 1])
            return whole.iloc[start:end].reset_index(drop=True)
        return table(where(self.folder, name), name, filters=[("step", ">=", first), ("step", "<=", last)])

    def _small(self, name: str) -> pd.DataFrame | None:
        """Return a short log, sorted by step, which is read once; None for a longer one."""
        if (key := f"small {name}") not in self.known:
            whole = small(where(self.folder, name), name)
            steps = None if whole is None else whole["step"].to_numpy()
            self.known[key] = whole if steps is not None and (np.diff(steps) >= 0).all() else None
        found: pd.DataFrame | None = self.known[key]
        return found


FEW = 200_000
"""Largest number of rows of a short log."""
START = ("spheres", "transfer", "ledger")
WALL_TABLES = ("triangles", "parts")
LOGS = ("events", "contacts", "bridges", "films", "impulses", "wall_films")
TABLES = (*START, *LOGS)
SHED = "drops"


def refuse_special(folder: Path) -> None:
    """Refuse a run that contains a pipe or a device in place of a file, which may never end, or a table too large for memory."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    for path in (p for pattern in ("*", "history/*", "results/*", "engine/*", "stl/*") for p in folder.glob(pattern)):
        if path.exists() and not (path.is_file() or path.is_dir()):
            raise ReplayError(f"{path} is a pipe or a device; expected a regular file: run the case again")
        if path.suffix == ".parquet":
            with readable(path):
                about = parquet.read_metadata(path)
            if 8 * about.num_rows * about.num_columns > memory:
                raise ReplayError(
                    f"{path} says that it has {about.num_rows} rows, which no memory here holds: run the case again"
                )


def where(folder: Path, name: str) -> Path:
    """Return the path of the file of a table."""
    return folder / f"{name}.parquet" if name == "trajectory" else folder / "history" / f"{name}.parquet"


def read(folder: Path) -> Run:
    """Read the tables of history/ that a run starts from and its ledger; of the logs only their existence is checked."""
    history = Path(folder) / "history"
    if not (history / "meta.json").exists():
        raise ReplayError(f"{history} holds no meta.json; expected the history of a moist run: run the case first")
    tables = {}
    for name in (*TABLES, *WALL_TABLES):
        path = history / f"{name}.parquet"
        if path.exists():
            if name not in LOGS:
                tables[name] = table(path, name)
        elif name in TABLES:
            raise ReplayError(f"{path} is missing; expected the complete history of a moist run: run the case again")
    try:
        meta = json.loads((history / "meta.json").read_text())
        _ = float(meta["surface_tension"]), float(meta["viscosity"]), meta["effects"].keys()
        _ = [(int(t["type"]), float(t["radius"]), float(t["contact_angle"])) for t in meta["types"]]
        if meta["effects"].get("shedding"):
            drops = columns(history / f"{SHED}.parquet", [*NEEDED[SHED], "felt_y", "felt_z"])
            tables[SHED] = drops.sort_values("step", kind="stable", ignore_index=True)
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
    "ledger": ("step", "films", "bridges", "walls", "left", "retired"),
    "bridges": ("step", "partner_kind", "i", "j", "triangle", "volume", "share_i", "separation", "xi_x", "xj_x",
                "capillary_impulse", "viscous_impulse", "least_separation", "largest_separation"),
    "impulses": ("step", "id", "impulse_x", "impulse_y", "impulse_z"),
    "films": ("step", "id", "film"),
    "wall_films": ("step", "triangle", "film"),
    "drops": ("step", "partner_kind", "i", "j", "volume", "film_i_before", "film_j_before", "fallen", "felt_x"),
    "felt": ("step", "id", "film", "v_x", "v_y", "v_z", "felt_x", "felt_y", "felt_z"),
    "triangles": ("triangle", "area"),
    "parts": ("part", "half_width", "contact_angle", "part_class"),
    "trajectory": ("step", "id", "type", "x", "y", "z"),
    "window_states": ("step", "id", "x", "y", "z"),
}  # fmt: skip
"""Columns that a table must have (for vectors the first component)."""


def table(path: Path, name: str, filters: list[tuple[str, str, int]] | None = None) -> pd.DataFrame:
    """Read a table with all of its rows."""
    with readable(path):
        found = parquet_table(path, filters=filters)
    complete(path, found, NEEDED[name])
    return numbers(path, found)


def small(path: Path, name: str) -> pd.DataFrame | None:
    """Return one table, complete, if it has few rows."""
    with readable(path):
        few = parquet.read_metadata(path).num_rows <= FEW
    return table(path, name) if few else None


@contextmanager
def readable(path: Path, what: str = "the history of a moist run") -> Iterator[None]:
    """Report damage of a file that is being read in a sentence; `what` was expected."""
    try:
        yield
    except ReplayError:
        raise
    except Exception as error:  # a truncated or foreign file: pyarrow raises many types
        raise ReplayError(f"{path} is not a readable Parquet table; expected {what}: run the case again") from error


TEXT = ("mesh", "reservoir")
"""Columns that are not numerical."""
MAY_BE_INFINITE = ("half_width",)
WHOLE = ("step", "id", "type", "kind", "partner_kind", "i", "j", "triangle", "part", "part_class", "type_i", "type_j")
"""Columns of integers, by which rows and tables are found."""


AnyTable = TypeVar("AnyTable", bound=Table)


def numbers(path: Path, table: AnyTable) -> AnyTable:
    """Return the table; refused if a column contains anything but finite numbers."""
    for name in (str(column) for column in table if column not in TEXT):
        values = table[name]
        if values.dtype.kind not in "iuf" or (name not in MAY_BE_INFINITE and not np.isfinite(values).all()):
            raise ReplayError(
                f"{path}: column {name} holds what is no number; expected what the engine wrote: run the case again"
            )
        if name in WHOLE and values.dtype.kind == "f":
            raise ReplayError(f"{path}: column {name} holds fractions; expected whole numbers: run the case again")
    return table


def every(path: Path) -> pd.DataFrame:
    """Read all columns of a Parquet file."""
    with readable(path):
        return numbers(path, parquet_table(path))


def complete(path: Path, names: Any, needed: Sequence[str]) -> None:
    lacking = [column for column in needed if column not in names]
    if lacking:
        raise ReplayError(
            f"{path} lacks {', '.join(lacking)}; expected the columns of pywet/schema.py: run the case again"
        )


def names(path: Path) -> list[str]:
    """Return the columns of a table of a run."""
    with readable(path):
        return list(parquet.read_schema(path).names)


def parquet_table(path: Path, **how: Any) -> pd.DataFrame:
    """Read a Parquet table, `how`: options of pyarrow; an index stored by pandas is a normal column."""
    table: pd.DataFrame = parquet.read_table(path, **how).to_pandas(ignore_metadata=True)
    return table


def columns(path: Path, names: Sequence[str]) -> pd.DataFrame:
    """Return some columns of a table of a run."""
    if not path.exists():
        raise ReplayError(f"{path} is missing; expected all tables of a finished run: run the case again")
    with readable(path, "one of a finished run"):
        complete(path, parquet.read_schema(path).names, names)
        return numbers(path, parquet_table(path, columns=list(names)))


SCENE: dict[str, type | tuple[type, ...]] = {
    "output": dict, "effects": dict, "classes": list, "pairs": list, "walls": list, "gravity_m_per_s2": list,
    "spheres_file": str, "time_step_s": (int, float), "duration_s": (int, float),
}  # fmt: skip
"""Entries of scene.json that are read here, and their types."""


def masses(scene: Mapping[str, Any]) -> dict[int, float]:
    """Return the mass of a sphere of each type [kg]."""
    return {c["type"]: c["density_kg_per_m3"] * 4.0 / 3.0 * np.pi * c["radius_m"] ** 3 for c in scene["classes"]}


def scene(folder: Path) -> dict[str, Any]:
    """Return the scene of a run directory as plain values."""
    path = Path(folder) / "scene.json"
    if not path.exists():
        raise ReplayError(f"{path} is missing; expected the folder of a run: run the case first")
    try:
        found = json.loads(path.read_text())
        wrong = [name for name, kind in SCENE.items() if not isinstance(found[name], kind)]
        _ = float(found["output"]["interval_s"]), found["effects"]["bridges"], 1.0 / found["time_step_s"]
    except (OSError, ValueError, KeyError, TypeError, ZeroDivisionError, RecursionError) as error:
        raise ReplayError(f"{path} cannot be read ({error!r}); expected the scene of a run: build it again") from error
    if wrong:
        raise ReplayError(f"{path} holds no proper {', '.join(wrong)}; expected the scene of a run: build it again")
    return dict(found)


def origin(folder: Path) -> np.ndarray:
    """Return the origin of a user-defined scene's coordinates in those of the logs [m]: zero unless `origin_mm` is given."""
    path = Path(folder) / "description.json"
    if not path.exists():
        return np.zeros(3)
    try:
        x, y, z = json.loads(path.read_text()).get("origin_mm", (0.0, 0.0, 0.0))
        return np.array([x, y, z], dtype=float) / 1e3
    except (OSError, ValueError, TypeError, AttributeError, RecursionError) as error:
        raise ReplayError(
            f"{path} cannot be read ({error!r}); expected a scene's description: build it again"
        ) from error


def note(text: str) -> None:
    """Show the current stage on one line of a terminal; elsewhere, as in a log file, by a line at most every `LINE_S`."""
    global _latest
    if sys.stderr.isatty():
        print(f"\r\033[Kreplay: {text}", end="", file=sys.stderr, flush=True)
    elif time.monotonic() - _latest > LINE_S:
        _latest = time.monotonic()
        print(f"replay: {text}", file=sys.stderr, flush=True)


def clear() -> None:
    """Remove the line of `note`."""
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr, flush=True)


def finite(value: Any) -> Any:
    """Replace deviations that overflowed, as in damaged logs, by the largest number there is."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [finite(v) for v in value]
    return sys.float_info.max if isinstance(value, float) and not math.isfinite(value) else value


def write_json(path: Path, value: dict[str, Any]) -> None:
    """Write under a temporary name, then rename; nothing is left of a file that could not be written."""
    temporary = path.with_suffix(f".{os.getpid()}.partial")
    try:
        temporary.write_text(json.dumps(finite(value), indent=1, allow_nan=False))
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
