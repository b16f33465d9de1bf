"""Bridges named as the rows of the table of transfer ratios name them."""

from __future__ import annotations

import pandas as pd

from reference_impl.replay.bodies import bodies, pairs, shapes
from reference_impl.replay.compare import Floats
from reference_impl.replay.io import Run


def of_bridges(rows: pd.DataFrame, volume: Floats, run: Run) -> tuple[Floats, Floats, Floats, Floats]:
    """Kind of partner, type of i, type or group of j, and V* of bridges, as the table's rows are named."""
    fixed = bodies(run)
    return shapes(pairs(rows, fixed), volume, fixed)
