"""Bridges named as the rows of the table of transfer ratios name them."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl import laws
from reference_impl.compare import Floats
from reference_impl.io import Run
from reference_impl.liquid import bodies


def of_bridges(rows: pd.DataFrame, volume: Floats, run: Run) -> tuple[Floats, Floats, Floats, Floats]:
    """Kind of partner, type of i, type or group of j, and V* of bridges, as the table's rows are named."""
    fixed = bodies(run)
    ri = rows["i"].map(fixed.radius).to_numpy(float)
    wall = (rows["partner_kind"] != laws.SPHERE).to_numpy()
    rj = np.where(wall, 1.0, rows["j"].map(fixed.radius).fillna(1.0)).astype(float)
    width = np.where(wall, rows["j"].map(fixed.half_width).fillna(np.inf), np.inf).astype(float)
    kind = np.where(wall, np.where(width < ri, laws.SMALL_WALL, laws.LARGE_WALL), laws.SPHERE)
    other = np.where(wall, rows["j"].map(fixed.group).fillna(-1), rows["j"].map(fixed.kind_of).fillna(-1)).astype(int)
    return kind, rows["i"].map(fixed.kind_of).to_numpy(int), other, volume / laws.harmonic_radius(ri, rj, wall) ** 3
