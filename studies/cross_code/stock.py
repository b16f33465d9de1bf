"""Forces of YADE and of LIGGGHTS' stock models at all points of the force rows, by a few calls of each program."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from pywet.errors import PywetError
from studies.cross_code.model import Floats
from studies.cross_code.rows import EASO, WASHINO, YADE
from studies.stock.liggghts import liggghts_force
from studies.stock.yade import yade_force

YADE_LAWS = {"paper": "Rabinovich", "exact": "Willett_numeric"}
"""Preset -> corresponding law of YADE; a stock model of LIGGGHTS has one law."""
PROGRAMS: dict[str, Callable[[pd.DataFrame, str], pd.DataFrame]] = {
    YADE: yade_force,
    WASHINO: liggghts_force,
    EASO: liggghts_force,
}
SCAN = 61
"""Number of points of each of the two scans for the end of a force, which is found to 4e-4 of itself."""


def law_of(column: str, preset: str) -> str:
    """Return the program's law that corresponds to a preset."""
    return YADE_LAWS[preset] if column == YADE else column


@dataclass
class Stock:
    """Measured forces by law, and the reasons why columns have none."""

    tables: dict[str, pd.DataFrame] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)

    @property
    def there(self) -> list[str]:
        """List the columns of stock programs that were measured."""
        return [column for column in PROGRAMS if column not in self.missing]

    def measure(self, points: pd.DataFrame) -> None:
        """Measure points (columns of engines.stock.points, `pair`, `what`) by every law and add them to the existing ones."""
        for column in self.there:
            for law in dict.fromkeys(law_of(column, preset) for preset in YADE_LAWS):
                try:
                    forces = PROGRAMS[column](points, law)
                except PywetError as error:
                    self.missing[column] = str(error)
                    break
                self.tables[law] = pd.concat([self.tables.get(law), forces])

    def force(self, column: str, preset: str, pair: str, what: str) -> tuple[Floats, Floats]:
        """Return gaps [m] and forces [N] of a pair's points of one kind."""
        table = self.tables[law_of(column, preset)]
        rows = table[(table["pair"] == pair) & (table["what"] == what)]
        return rows["separation"].to_numpy(float), rows["force"].to_numpy(float)

    def bracket(self, column: str, pair: str, what: str) -> tuple[float, float]:
        """Return the last scanned gap with a force and the next one; NaN if the end is outside the scan."""
        gaps, force = self.force(column, "paper", pair, what)
        on = np.flatnonzero(np.nan_to_num(force) > 0.0)
        if len(on) == 0 or on[-1] == len(gaps) - 1:
            return np.nan, np.nan
        return float(gaps[on[-1]]), float(gaps[on[-1] + 1])

    def edge(self, column: str, pair: str) -> float:
        """Return the gap at which the force ends [m], by the fine scan."""
        low, high = self.bracket(column, pair, f"fine {column}")
        return 0.5 * (low + high)


def scans(stock: Stock, pairs: Sequence[str], column: str) -> dict[str, Floats]:
    """Return the gaps of the fine scan of each pair whose coarse scan found the end."""
    ends = {pair: stock.bracket(column, pair, "coarse") for pair in pairs}
    return {pair: np.linspace(*end, SCAN) for pair, end in ends.items() if np.isfinite(end[0])}
