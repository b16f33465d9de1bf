"""Forces of YADE and of LIGGGHTS' stock models at all points of the force rows: a few calls of each program."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from pywet.engines.stock.liggghts import liggghts_force
from pywet.engines.stock.yade import yade_force
from pywet.errors import PywetError
from pywet.evidence.agreement.columns import EASO, WASHINO, YADE
from pywet.evidence.agreement.model import Floats

LAWS = {
    (YADE, "paper"): "Rabinovich",
    (YADE, "exact"): "Willett_numeric",
    (WASHINO, "paper"): "washino",
    (WASHINO, "exact"): "washino",
    (EASO, "paper"): "easo",
    (EASO, "exact"): "easo",
}
"""Column and preset -> the program's law that stands for it."""
SCAN = 61
"""Points of each of the two scans for the end of a force: found within 4e-4 of itself."""


@dataclass
class Stock:
    """Measured forces: ask with `force`; a program that is missing raises its `PywetError` there."""

    tables: dict[tuple[str, str], pd.DataFrame | PywetError] = field(default_factory=dict)

    def measure(self, points: pd.DataFrame) -> None:
        """Measure points (columns of engines.stock.points, `pair`, `what`) by every law; adds to what is there."""
        for column, law in dict.fromkeys((c, name) for (c, _), name in LAWS.items()):
            try:
                forces = self._program(column)(points, law)
            except PywetError as error:
                self.tables[column, law] = error
                continue
            before = self.tables.get((column, law))
            self.tables[column, law] = pd.concat([before, forces]) if isinstance(before, pd.DataFrame) else forces

    @staticmethod
    def _program(column: str) -> Callable[[pd.DataFrame, str], pd.DataFrame]:
        return yade_force if column == YADE else liggghts_force

    def force(self, column: str, preset: str, pair: str, what: str) -> tuple[Floats, Floats]:
        """Gaps [m] and forces [N] of a pair's points of one kind."""
        table = self.tables[column, LAWS[column, preset]]
        if isinstance(table, PywetError):
            raise table
        rows = table[(table["pair"] == pair) & (table["what"] == what)]
        return rows["separation"].to_numpy(float), rows["force"].to_numpy(float)

    def bracket(self, column: str, pair: str, what: str) -> tuple[float, float]:
        """The last scanned gap with a force and the next one; NaN where the scan does not hold the end."""
        gaps, force = self.force(column, "paper", pair, what)
        on = np.flatnonzero(np.nan_to_num(force) > 0.0)
        if len(on) == 0 or on[-1] == len(gaps) - 1:
            return np.nan, np.nan
        return float(gaps[on[-1]]), float(gaps[on[-1] + 1])

    def edge(self, column: str, pair: str) -> float:
        """Gap at which the force ends [m], by the fine scan."""
        low, high = self.bracket(column, pair, f"fine {column}")
        return 0.5 * (low + high)


def scans(stock: Stock, pairs: Sequence[str], column: str) -> dict[str, Floats]:
    """Gaps of the fine scan of each pair whose coarse scan found the end."""
    gaps = {}
    for pair in pairs:
        try:
            low, high = stock.bracket(column, pair, "coarse")
        except PywetError:
            continue
        if np.isfinite(low):
            gaps[pair] = np.linspace(low, high, SCAN)
    return gaps
