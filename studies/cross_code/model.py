"""Result of a source: cells, and curves for the pictures; as JSON."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pywet.util.files import read_model, write_json

Floats = NDArray[np.float64]
State = Literal["measured", "truth", "basis", "impossible", "not run", "failed"]


@dataclass(frozen=True)
class Cell:
    """Cell of one program in one row. `deviation` is the largest over `count` comparisons, relative to the row's scale."""

    row: str
    column: str
    state: State
    deviation: float | None = None
    count: int = 0
    median: float | None = None
    worst_at: str = ""
    note: str = ""
    link: str = ""
    """Run directory or log, relative to the page."""
    within: bool | None = None
    """For groups of seeds, whether the difference is within their spread; None without seeds."""


@dataclass(frozen=True)
class Source:
    """Cells and curves of one source; `failed` is the reason if it could not be run."""

    name: str
    cells: list[Cell] = field(default_factory=list)
    curves: dict[str, Any] = field(default_factory=dict)
    failed: str = ""
    wall_s: float = 0.0

    def write(self, path: Path) -> None:
        """Write the cells of a source as JSON."""
        write_json(path, asdict(self))

    @classmethod
    def read(cls, path: Path) -> Source:
        """Read the cells of a source from JSON."""
        return read_model(path, cls, "remove it and make the table of agreement again")


def measured(
    row: str, column: str, values: Floats, truth: Floats, size: Floats | None = None, *, at: Sequence[str] = (),
    note: str = "", link: str = ""
) -> Cell:  # fmt: skip
    """Largest and median of |values − truth|/size (size: |truth|) over all values; `at` says where each one is.

    >>> measured("r", "yade", np.array([1.0, 2.2]), np.array([1.0, 2.0]), at=["near", "far"]).worst_at
    'far'
    """
    values, truth = np.asarray(values, dtype=float), np.asarray(truth, dtype=float)
    off = np.abs(values - truth) / (np.abs(truth) if size is None else np.asarray(size, dtype=float))
    if len(off) == 0 or not np.isfinite(off).all():
        bad = int(np.count_nonzero(~np.isfinite(off)))
        return Cell(row, column, "failed", note=f"{bad} of {len(off)} values are not finite; {note}", link=link)
    k = int(off.argmax())
    where = at[k] if len(at) else ""
    return Cell(row, column, "measured", float(off[k]), len(off), float(np.median(off)), where, note, link)


def truth(row: str, column: str, note: str, count: int = 0) -> Cell:
    """Return the cell with the true value of a row."""
    return Cell(row, column, "truth", 0.0, count, note=note)


def basis(row: str, column: str, note: str, count: int = 0, link: str = "") -> Cell:
    """Return the cell with which the others of the row are compared if no true value is known."""
    return Cell(row, column, "basis", 0.0, count, note=note, link=link)


def impossible(row: str, column: str, why: str) -> Cell:
    """Return a cell that this program cannot fill, with the reason."""
    return Cell(row, column, "impossible", note=why)


def empty(row: str, reasons: Mapping[str, str]) -> Iterator[Cell]:
    """Yield the empty cells of several programs, given the reason for each column."""
    return (impossible(row, column, why) for column, why in reasons.items())


def not_run(row: str, column: str, how: str) -> Cell:
    """Make a cell that shows the command that would fill it."""
    return Cell(row, column, "not run", note=how)


def deviation_text(deviation: float | None) -> str:
    """A deviation as printed in the table.

    >>> deviation_text(0.0), deviation_text(3.2e-16), deviation_text(0.0123), deviation_text(0.43)
    ('0', '3e-16', '1.2 %', '43 %')
    """
    if deviation is None or math.isnan(deviation):
        return "—"
    if deviation == 0.0:
        return "0"
    if deviation < 1e-3:
        return f"{deviation:.0e}".replace("e-0", "e-")
    if deviation >= 10.0:
        return f"{deviation:.0f} ×"
    return f"{100 * deviation:.0f} %" if deviation >= 0.095 else f"{100 * deviation:.2g} %"
