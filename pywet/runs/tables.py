"""Raw record files of the plugin -> Parquet tables (schema.py). Reading the tables back is left to pandas."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.errors import NotWhole
from pywet.files import write_parts
from pywet.schema import RAW

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
    "contributions.json", "audit.json", "summary.json", "picture.png", "movie.mp4", "movie.webp", "results", "vtk",
    "engine.partial.new",
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


QUICK = ("events", "contacts")
"""Tables of which most is read: lz4 gives them back in half the time of zstd and takes an eighth more room (of the others, in
which more repeats, a third)."""
BLOCK = 200_000
"""Records of a rank that are in memory at once."""


class _Log:
    """The records of one rank, which are in the order of their steps, read on."""

    def __init__(self, path: Path, kind: np.dtype) -> None:
        self.path, self.kind, self.read = path, kind, 0
        self.count, rest = divmod(path.stat().st_size, kind.itemsize)
        if rest:
            raise NotWhole(f"{path} ends in the middle of a record; the run was cut off: run the case again")
        self.ready = np.zeros(0, kind)

    @property
    def ended(self) -> bool:
        """Whether all of it is ready."""
        return self.read == self.count

    def fill(self, block: int) -> None:
        """Have `block` records ready, if there are so many."""
        if self.ended or len(self.ready) >= block:
            return
        more = np.fromfile(self.path, self.kind, block - len(self.ready), offset=self.read * self.kind.itemsize)
        self.ready, self.read = np.concatenate([self.ready, more]), self.read + len(more)
        if not len(more) or (np.diff(self.ready["step"]) < 0).any():
            raise NotWhole(
                f"{self.path} is not in the order of its steps; expected the plugin's output: run the case again"
            )

    def take(self, last: int) -> np.ndarray:
        """What is ready up to a step."""
        end = int(np.searchsorted(self.ready["step"], last, "right"))
        taken, self.ready = self.ready[:end], self.ready[end:]
        return taken


def raw_parts(folder: Path, name: str, block: int = BLOCK) -> Iterator[np.ndarray]:
    """The records of one table of all ranks, whole steps at a time; at least one part."""
    logs = [_Log(path, RAW[name]) for path in sorted(folder.glob(f"{name}.*.bin"))]
    if not logs:
        raise NotWhole(f"no log {name}.*.bin in {folder}; expected the plugin's output: run the case again")
    given = False
    while True:
        for log in logs:
            log.fill(block)
        last = min((int(log.ready["step"][-1]) - 1 for log in logs if not log.ended), default=np.iinfo(np.int64).max)
        records = np.concatenate([log.take(last) for log in logs])
        if len(records) or (all(log.ended for log in logs) and not given):
            given = True
            yield records
        elif all(log.ended for log in logs):
            return
        else:
            block *= 2  # a step of more records than that


def read_raw(folder: Path, name: str) -> np.ndarray:
    """All records of one table, of all ranks."""
    return np.concatenate(list(raw_parts(folder, name)))


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


def ledger_error(ledger: pd.DataFrame) -> float:
    """Largest |films + bridges + walls + left − initial| / initial over all outputs; where there was no liquid, in m3."""
    held = ledger["films"] + ledger["bridges"] + ledger["walls"] + ledger["left"]
    initial = ledger["initial"].where(ledger["initial"] > 0, 1.0)
    return float(((held - ledger["initial"]).abs() / initial).max())


def convert(folder: Path, history: Path, block: int = BLOCK) -> None:
    """Turn every raw log in `folder` that SORT names into `history/<name>.parquet`, sorted as in SORT."""
    for name, order in SORT.items():
        parts = (
            to_frame(part).sort_values(order, kind="stable", ignore_index=True)
            for part in raw_parts(folder, name, block)
        )
        write_parts(parts, history / f"{name}.parquet", "lz4" if name in QUICK else "zstd")
