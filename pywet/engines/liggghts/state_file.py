"""The plugin's state of a checkpoint (checkpoint.cpp): which spheres the engine holds, where they are, which are retired."""

from __future__ import annotations

from pathlib import Path

import numpy as np

HEAD_B = 104
"""Bytes before the number of spheres."""
SPHERE = np.dtype([("id", "<i8"), ("place", "<f8", (2,)), ("rest", "<f8", (9,))])


def count(state: Path) -> int:
    """Number of spheres that are in the engine from the checkpoint on."""
    return int(np.fromfile(state, "<i8", 1, offset=HEAD_B)[0])


def places(state: Path) -> np.ndarray:
    """Position of these spheres in the plan view, (n, 2)."""
    n = count(state)
    spheres = np.memmap(state, SPHERE, "r", HEAD_B + 8, (n,)) if n else np.zeros(0, SPHERE)
    return np.asarray(spheres["place"])


def retired(state: Path) -> np.ndarray:
    """Numbers of all spheres retired until the checkpoint and at it, in order."""
    start = HEAD_B + 8 + count(state) * SPHERE.itemsize
    n = int(np.fromfile(state, "<i8", 1, offset=start)[0])
    return np.fromfile(state, "<i8", n, offset=start + 8)
