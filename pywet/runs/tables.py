"""Convert the plugin's raw record files into Parquet tables (schema.py)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd

from pywet.errors import NotWhole
from pywet.schema import RAW
from pywet.util.files import write_parts, write_table

SORT = {
    "events": ["step", "kind", "partner_kind", "i", "j"],
    "contacts": ["step", "partner_kind", "i", "j"],
    "ledger": ["step"],
    "bridges": ["step", "partner_kind", "i", "j"],
    "films": ["step", "id"],
    "wall_films": ["step", "triangle"],
    "impulses": ["step", "id"],
    "energy": ["step"],
    "window_energy": ["step"],
    "drops": ["step", "i"],
    "felt": ["step", "id"],
}


Rows = pd.DataFrame | Iterable[pd.DataFrame] | Iterable[dict[str, np.ndarray]]
"""A table, or the parts of a long one."""
Added = Callable[[Iterator[np.ndarray]], Iterator[np.ndarray]]
QUICK = ("events", "contacts")
"""Tables of which most is read, compressed by lz4.

They are read in half the time of zstd and take an eighth more space (others, which are more repetitive, a third).
"""
CACHED = 1024
"""Number of records that are converted at once."""
BLOCK = 65_536
"""Number of records of a rank that are in memory at once."""


class _Log:
    """The records of one rank, read progressively in the order of their steps."""

    def __init__(self, path: Path, kind: np.dtype) -> None:
        self.path, self.kind, self.read = path, kind, 0
        self.count, rest = divmod(path.stat().st_size, kind.itemsize)
        if rest:
            raise NotWhole(
                f"{path} ends in the middle of a record; the run was cut off: run the case again",
                code="run.cut_off", where=path,
            )  # fmt: skip
        self.ready = np.zeros(0, kind)

    @property
    def ended(self) -> bool:
        """Return whether the raw file is complete."""
        return self.read == self.count

    def fill(self, block: int) -> None:
        """Read ahead until `block` records are available, or the file ends."""
        if self.ended or len(self.ready) >= block:
            return
        more = np.fromfile(self.path, self.kind, block - len(self.ready), offset=self.read * self.kind.itemsize)
        self.ready, self.read = _joined([self.ready, more]), self.read + len(more)
        if not len(more) or (np.diff(self.ready["step"]) < 0).any():
            raise NotWhole(
                f"{self.path} is not in the order of its steps; expected the plugin's output: run the case again",
                code="run.order", where=self.path,
            )  # fmt: skip

    def take(self, last: int) -> np.ndarray:
        """Take the records that are complete up to a step."""
        end = int(np.searchsorted(self.ready["step"], last, "right"))
        taken, self.ready = self.ready[:end], self.ready[end:]
        return taken


def _joined(parts: list[np.ndarray]) -> np.ndarray:
    """Join the records of all parts; they are not copied if one part has all."""
    some, kind = [part for part in parts if len(part)] or parts[:1], parts[0].dtype
    # as bytes: numpy copies records field by field
    return some[0] if len(some) == 1 else np.concatenate([p.view(f"V{kind.itemsize}") for p in some]).view(kind)


def raw_parts(folder: Path, name: str, block: int = BLOCK) -> Iterator[np.ndarray]:
    """Yield the records of one table of all ranks, complete steps at a time; at least one part."""
    logs = [_Log(path, RAW[name]) for path in sorted(folder.glob(f"{name}.*.bin"))]
    if not logs:
        raise NotWhole(
            f"no log {name}.*.bin in {folder}; expected the plugin's output: run the case again",
            code="run.no_log", key=name, where=folder,
        )  # fmt: skip
    given = False
    while True:
        for log in logs:
            log.fill(block)
        last = min((int(log.ready["step"][-1]) - 1 for log in logs if not log.ended), default=np.iinfo(np.int64).max)
        records = _joined([log.take(last) for log in logs])
        if len(records) or (all(log.ended for log in logs) and not given):
            given = True
            yield records
        elif all(log.ended for log in logs):
            return
        else:
            block *= 2  # a step of more records than that


def read_raw(folder: Path, name: str) -> np.ndarray:
    """Return all records of one table, of all ranks."""
    return np.concatenate(list(raw_parts(folder, name)))


def to_frame(records: np.ndarray) -> pd.DataFrame:
    """Convert raw records to a data frame with the columns of `to_columns`."""
    return pd.DataFrame(to_columns(records), copy=False)


def to_columns(records: np.ndarray) -> dict[str, np.ndarray]:
    """Convert records to columns; vectors become three columns with the suffixes _x, _y, _z, padding is dropped."""
    fields = {name: records[name] for name in records.dtype.names or () if name != "pad"}
    sources: dict[str, np.ndarray] = {}
    for name, values in fields.items():
        vector = {f"{name}_{axis}": values[:, k] for k, axis in enumerate("xyz")} if values.ndim == 2 else None
        sources |= {name: values} if vector is None else vector
    columns = {name: np.empty(len(records), values.dtype) for name, values in sources.items()}
    for first in range(0, len(records), CACHED):  # a record is in the cache for all of its fields
        some = slice(first, first + CACHED)
        for name, values in sources.items():
            columns[name][some] = values[some]
    return columns


def in_order(records: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """Sort records by some of their integer fields; equal ones remain in order."""
    code, combinations = np.zeros(len(records), np.int64), 1
    for name in names if len(records) else ():
        values = records[name].astype(np.int64)
        least = int(values.min())
        span = int(values.max()) - least + 1
        code, combinations = code * span + (values - least), combinations * span
    if combinations >= 1 << 63:  # too large for one number
        return records[np.lexsort([records[name] for name in reversed(names)])]
    return records if (code[1:] >= code[:-1]).all() else records[np.argsort(code, kind="stable")]


def ledger_error(ledger: pd.DataFrame) -> float:
    """Return the largest |films + bridges + walls + left + retired − initial| over all outputs.

    It is relative to the largest initial liquid, or in m3 without liquid. Spheres that are inserted later add
    their liquid, so that before the first one there is no reference. It is nan if a number is nan.
    """
    held = ledger["films"] + ledger["bridges"] + ledger["walls"] + ledger["left"] + ledger["retired"]
    most = float(ledger["initial"].max())
    return float((held - ledger["initial"]).abs().max(skipna=False)) / (most if most > 0.0 else 1.0)


def converted(
    folder: Path, block: int = BLOCK, more: Mapping[str, Added] = MappingProxyType({})
) -> Iterator[tuple[str, Iterator[dict[str, np.ndarray]]]]:
    """Yield name and parts of the table of every raw log in `folder` that SORT names, sorted as in SORT.

    `more`: for a table the function that adds records, complete steps at a time.
    """
    for name, order in SORT.items():
        records = more.get(name, iter)(raw_parts(folder, name, block))
        yield name, (to_columns(in_order(part, order)) for part in records)


def write(rows: Rows, path: Path) -> None:
    """Write a table of a run, or the parts of a long one."""
    if isinstance(rows, pd.DataFrame):
        write_table(rows, path)
    else:
        write_parts(rows, path, quick=path.stem in QUICK)
