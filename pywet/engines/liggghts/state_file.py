"""The plugin's state of a checkpoint (checkpoint.cpp): spheres in the engine, their positions, and retired spheres."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pywet.errors import FileError, shown

HEAD_B = 104
"""Number of bytes before the number of spheres."""
COUNT = np.dtype("<i8")
SPHERE = np.dtype([("id", "<i8"), ("place", "<f8", (2,)), ("rest", "<f8", (12,))])


def count(state: Path) -> int:
    """Return the number of spheres in the engine from the checkpoint on."""
    return int(_numbers(state, HEAD_B, 1)[0])


def places(state: Path) -> np.ndarray:
    """Return the positions of these spheres in plan view, (n, 2)."""
    return np.asarray(_numbers(state, HEAD_B + 8, count(state), SPHERE)["place"])


def retired(state: Path) -> np.ndarray:
    """Return the ids of all spheres retired up to the checkpoint, in order."""
    start = HEAD_B + 8 + count(state) * SPHERE.itemsize
    return _numbers(state, start + 8, int(_numbers(state, start, 1)[0]))


def _numbers(state: Path, start: int, n: int, kind: np.dtype = COUNT) -> np.ndarray:
    """Read a number of records from a byte on; raise a sentence if the file does not contain them."""
    there = (state.stat().st_size - start) // kind.itemsize
    if not 0 <= n <= there:
        raise FileError(
            f"{shown(state)} claims to hold {n} records but has space for {max(there, 0)}; expected a complete "
            "checkpoint: remove engine.partial and call again",
            path=state, code="checkpoint.records", given=n, expected=max(there, 0),
        )  # fmt: skip
    return np.memmap(state, kind, "r", start, (n,)) if n else np.zeros(0, kind)
