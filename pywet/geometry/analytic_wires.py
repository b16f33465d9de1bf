"""Detect closed parts of a surface that extrude a convex section along x, y or z, such as the wires of a screen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pywet.errors import PywetError
from pywet.geometry.surface import Floats, enclosed

SAME_VOLUME = 1e-6
"""Relative difference of a part's volume from that of its section times its length; single precision leaves 1e-7 of a side."""


@dataclass(frozen=True)
class AnalyticWire:
    """`axis` 0, 1, 2 for x, y, z; ends `low` and `high` on it [m]; section (n, 2) on the next two axes in cyclic order [m].

    The section runs counter-clockwise, seen against the axis.
    """

    axis: int
    low: float
    high: float
    section: Floats


def analytic_wire_of(corners: Floats, name: str) -> AnalyticWire:
    """Return the analytic wire that closed triangles (m, 3, 3) bound exactly; `PywetError` if they bound another shape."""
    points = np.unique(corners.reshape(-1, 3), axis=0)
    volume = enclosed(corners)
    for axis in np.argsort(-np.ptp(points, axis=0), kind="stable"):
        others = [(axis + 1) % 3, (axis + 2) % 3]
        low, high = (float(f(points[:, axis])) for f in (np.min, np.max))
        section = _around(np.unique(points[:, others], axis=0))
        ends = [np.unique(points[points[:, axis] == end][:, others], axis=0) for end in (low, high)]
        if all(len(e) == len(section) for e in ends) and _convex(section):
            x, y = section.T
            area = 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
            if volume > 0.0 and abs(area * (high - low) - volume) <= SAME_VOLUME * volume:
                return AnalyticWire(int(axis), low, high, section)
    raise PywetError(
        f"{name} was given as an analytic wire but is none; expected a closed convex section drawn along x, y or z: "
        "set analytic_wires to false for this wall",
        code="surface.not_prism", key=name,
    )  # fmt: skip


def _around(points: Floats) -> Floats:
    """Return points (n, 2) in order around their middle."""
    d = points - points.mean(axis=0)
    return np.asarray(points[np.argsort(np.arctan2(d[:, 1], d[:, 0]))])


def _convex(loop: Floats) -> bool:
    """Return whether every corner of a counter-clockwise loop turns left."""
    if len(loop) < 3:
        return False
    edge = np.roll(loop, -1, axis=0) - loop
    after = np.roll(edge, -1, axis=0)
    return bool((edge[:, 0] * after[:, 1] - edge[:, 1] * after[:, 0] > 0.0).all())
