"""Displacements and near pairs in a periodic box: `period` is its length along each axis [m], 0 for non-periodic axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from pywet.geometry.surface import Floats, Ints


def nearest(ways: Floats, period: Sequence[float] | Floats) -> Floats:
    """The shortest of each way (N, 3) and those to the copies of its end.

    >>> nearest(np.array([[0.9, 0.9, 0.0]]), (0.0, 1.0, 0.0)).round(3).tolist()
    [[0.9, -0.1, 0.0]]
    """
    length = np.asarray(period)
    return np.asarray(ways - length * np.rint(ways / np.where(length > 0.0, length, np.inf)))


def copies(at: Floats, period: Sequence[float] | Floats) -> Floats:
    """Return points (N, 3) and their copies on both sides along each periodic axis, (copies, N, 3)."""
    shifts = [sign * np.diag(period)[k] for k in np.flatnonzero(period) for sign in (-1.0, 1.0)]
    return np.stack([at, *(at + shift for shift in shifts)])


def near_pairs(at: Floats, reach: float, low: Sequence[float] | Floats, period: Sequence[float] | Floats) -> Ints:
    """Return index pairs of points (N, 3) within reach of each other or of a copy; `low`: lower corner of the box [m]."""
    length = np.asarray(period)
    if not length.any():
        return np.asarray(cKDTree(at).query_pairs(reach, output_type="ndarray"))
    places = np.where(length > 0.0, (at - np.asarray(low)) % np.where(length > 0.0, length, 1.0), at)
    return np.asarray(cKDTree(places, boxsize=length).query_pairs(reach, output_type="ndarray"))
