"""Copies of a periodic box: shortest displacement between two positions, nearest copy of a wall.

script.json of a user's script contains the length of the box along each periodic axis, a scene the faces of its box.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from reference_impl.replay import io, script
from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import ReplayError

KEY = "periodic_m"


@dataclass(frozen=True)
class Images:
    """Lengths of the box along x, y, z [m], 0 along non-periodic axes."""

    length: Floats

    @property
    def any(self) -> bool:
        """Return whether the box is periodic along any axis."""
        return bool((self.length > 0.0).any())

    def nearest(self, way: Floats) -> Floats:
        """Return the shortest of all displacements between copies of two positions; vectors along the last axis."""
        if not self.any:
            return way
        period = np.where(self.length > 0.0, self.length, np.inf)
        return np.asarray(way - self.length * np.rint(way / period))

    def others(self) -> list[Floats]:
        """Return the displacement to each copy of the box that shares a face, an edge or a corner with it."""
        steps = [(-1, 0, 1) if length > 0.0 else (0,) for length in self.length]
        return [np.array(n) * self.length for n in product(*steps) if any(n)]


def of_scene(scene: Mapping[str, Any]) -> Images:
    """Return the copies of a scene's box, which is periodic along at most one axis."""
    sides = np.array(scene["box_high_m"], float) - np.array(scene["box_low_m"], float)
    return Images(np.where([axis == scene.get("periodic") for axis in "xyz"], sides, 0.0))


def of(folder: Path) -> Images:
    """Return the copies of a run's box."""
    noted = script.of(folder)
    if noted is None:
        return of_scene(io.scene(folder))
    length = noted.get(KEY, [0.0] * 3)
    if not (
        isinstance(length, list) and len(length) == 3
        and all(isinstance(a, (int, float)) and math.isfinite(a) and a >= 0.0 for a in length)
    ):  # fmt: skip
        raise ReplayError(
            f"{Path(folder) / script.FILE} has {KEY} {length}; expected three lengths [m], 0 where the box does not repeat: "
            "run the script again"
        )
    return Images(np.array(length, float))
