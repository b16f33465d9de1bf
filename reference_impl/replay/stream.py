"""A log of a run read in parts, in the order of its steps, so that memory is needed for one part only."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
from pyarrow import parquet

from reference_impl.replay.arrays import Columns, Floats, joined
from reference_impl.replay.io import NEEDED, ReplayError, complete, numbers, readable

BATCH = 1 << 17
"""Number of rows that are decoded at once."""
END = np.iinfo(np.int64).max
"""Step after the last."""


def _columns(rows: pa.RecordBatch | pa.Table) -> Columns:
    """Collect the decoded columns, without the index that pandas writes."""
    there = zip(rows.schema.names, rows.columns, strict=True)
    return Columns({name: _array(values) for name, values in there if not name.startswith("__index_level_")})


def _array(values: Any) -> Floats:
    return np.asarray(
        values.to_numpy() if isinstance(values, pa.ChunkedArray) else values.to_numpy(zero_copy_only=False)
    )


class Rows:
    """One table, read from start to end; every row is returned once."""

    def __init__(self, path: Path, name: str, columns: list[str] | None = None, batch: int = BATCH) -> None:
        self.path, self.taken, self._last = path, 0, -1
        self._ready: list[Columns] = []
        with readable(path):
            file = parquet.ParquetFile(path)
            complete(path, file.schema_arrow.names, NEEDED[name])
            self.rows = int(file.metadata.num_rows)
            # one row group at a time: a reader caches the row groups it was asked for
            groups = range(file.num_row_groups)
            self._batches = (b for k in groups for b in file.iter_batches(batch, [k], columns, use_threads=False))
            self.none = _columns(file.schema_arrow.empty_table().select(columns or file.schema_arrow.names))

    def _more(self) -> bool:
        """Decode the next batch; return False at the end."""
        with readable(self.path):
            batch = next(self._batches, None)
        if batch is None:
            return False
        rows = _columns(batch)
        numbers(self.path, rows)
        steps = rows["step"]
        if len(rows) and (steps[0] < self._last or (np.diff(steps) < 0).any()):
            raise ReplayError(f"{self.path} is not in the order of its steps; expected what the driver wrote: "
                              "run the case again")  # fmt: skip
        self._last = int(steps[-1]) if len(rows) else self._last
        self._ready += [rows] if len(rows) else []
        return True

    def ahead(self, count: int) -> int:
        """Return the step of the `count`-th of the next rows, `END` if there are fewer; no row is consumed."""
        while sum(map(len, self._ready)) <= count and self._more():
            pass
        for rows in self._ready:
            if count <= len(rows):
                last = int(rows["step"][count - 1])
                return last if last < self._last or self._more_after(last) else END
            count -= len(rows)
        return END

    def _more_after(self, step: int) -> bool:
        """Return whether a row of a later step follows."""
        while self._last <= step and self._more():
            pass
        return self._last > step

    def parts(self, step: int, most: int) -> Iterator[Columns]:
        """Yield the rows up to a step, at most `most` at once."""
        while True:
            while not self._ready and self._more():
                pass
            if not self._ready:
                return
            rows = self._ready[0]
            end = min(int(np.searchsorted(rows["step"], step, "right")), most)
            if end == 0:
                return
            if end == len(rows):
                self._ready.pop(0)
            else:
                self._ready[0] = rows.cut(end, len(rows))
            self.taken += end
            yield rows.cut(0, end)

    def columns(self, step: int) -> Columns:
        """Read all rows up to a step, as arrays."""
        return joined(list(self.parts(step, BATCH)) or [self.none])

    def until(self, step: int) -> pd.DataFrame:
        """Read all rows up to a step."""
        return self.columns(step).frame()


def taken(path: Path, name: str, rows: Floats) -> pd.DataFrame:
    """Return some rows of a table by their numbers, in that order."""
    with readable(path):
        file = parquet.ParquetFile(path)
        sizes = [file.metadata.row_group(k).num_rows for k in range(file.num_row_groups)]
        start, found = 0, []
        order = np.argsort(rows, kind="stable")
        for k, size in enumerate(sizes):
            inside = rows[order][(rows[order] >= start) & (rows[order] < start + size)]
            if len(inside):
                found.append(file.read_row_group(k).take(pa.array(inside - start)))
            start += size
        table: Any = pa.concat_tables(found) if found else file.schema_arrow.empty_table()
    back = np.argsort(order, kind="stable")
    return numbers(path, table.to_pandas(ignore_metadata=True)).iloc[back].reset_index(drop=True)
