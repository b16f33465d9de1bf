"""Domain decomposition into columns of equal width in x and in y, chosen from the positions of the spheres.

They are chosen at the start and at each checkpoint of a run with the plugin. By default the engine divides evenly
with the shortest cuts, across the longer side of the box. If a slide is drawn out to one side of a tower, all spheres
are then on one rank.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from pywet.scene import EngineScene

RESOLVED = 20
"""Grids count as equally good if the spheres of their fullest columns differ by less than the mean divided by this."""


def fullest(scene: EngineScene, xy: ArrayLike, columns: tuple[int, int]) -> float:
    """Return the number of spheres in the fullest column over the mean of all columns."""
    places = np.asarray(xy, dtype=float).reshape(-1, 2)
    low, high = (np.asarray(corner[:2]) for corner in (scene.box_low_m, scene.box_high_m))
    at = np.clip(np.floor((places - low) / (high - low) * columns).astype(int), 0, np.asarray(columns) - 1)
    cell = at[:, 0] * columns[1] + at[:, 1]
    return float(
        np.bincount(cell, minlength=columns[0] * columns[1]).max() * columns[0] * columns[1] / max(len(cell), 1)
    )


def chosen(scene: EngineScene, xy: ArrayLike, ranks: int) -> tuple[int, int]:
    """Return the columns in x and y whose fullest has fewest spheres; of equally good ones, those with the shortest cuts."""
    width, depth = (scene.box_high_m[k] - scene.box_low_m[k] for k in (0, 1))

    def load_and_cuts(columns: tuple[int, int]) -> tuple[int, float]:
        return round(RESOLVED * fullest(scene, xy, columns)), (columns[0] - 1) * depth + (columns[1] - 1) * width

    return min(_grids(ranks), key=load_and_cuts)


def words(scene: EngineScene, xy: ArrayLike, ranks: int) -> str:
    """Format the chosen columns as the engine's script needs them."""
    return " ".join(map(str, chosen(scene, xy, ranks)))


def _grids(ranks: int) -> Iterator[tuple[int, int]]:
    """List all factorisations of a number into two, the most columns in x first."""
    for columns in range(ranks, 0, -1):
        if ranks % columns == 0:
            yield columns, ranks // columns
