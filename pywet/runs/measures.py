"""Quantities measured from positions: slope of a heap, angle of the bed in a drum, rate of discharge through a plane."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from pywet.errors import PywetError
from pywet.runs.rundir import Bools, Floats
from pywet.scene import Rotation

STEADY = (0.1, 0.9)
"""Shares of the total passed mass between which the discharge counts as steady."""


def heap_angle(at: Floats, radius: Floats) -> float:
    """Return the slope [deg] of the surface of a heap of spheres around its vertical axis.

    The surface is the top of the highest sphere of each ring, two radii wide; a straight line is fitted from the
    second ring on, as far as the heap is higher than a layer. A heap of fewer than three such rings has no slope
    (NaN).
    """
    size = float(radius.max())
    away = np.hypot(*(at[:, :2] - np.median(at[:, :2], axis=0)).T)
    ring = (away // (2.0 * size)).astype(int)
    top = pd.Series(at[:, 2] + radius).groupby(ring).max()
    flank = top[(top - float((at[:, 2] - radius).min()) > 2.5 * size) & (top.index > 0)]
    if len(flank) < 3:
        return math.nan
    slope = np.polyfit(2.0 * size * (flank.index.to_numpy(dtype=float) + 0.5), flank.to_numpy(dtype=float), 1)[0]
    return math.degrees(math.atan(-float(slope)))


def upward(gravity: tuple[float, float, float]) -> Floats:
    """Return the unit vector against gravity; z without gravity."""
    size = float(np.linalg.norm(gravity))
    return -np.asarray(gravity, dtype=float) / size if size else np.array([0.0, 0.0, 1.0])


def bed_angle(at: Floats, mass: Floats, drum: Rotation, up: Floats) -> float:
    """Return the angle [deg] of the bed in a drum: between its centre of mass, seen from the drum's axis, and the vertical.

    For a bed with a plane surface, a segment of a circle, it is the slope of that surface.
    """
    axis = np.asarray(drum.axis, dtype=float) / np.linalg.norm(drum.axis)
    arm = np.average(at, axis=0, weights=mass) - np.asarray(drum.origin_m)
    arm = arm - arm @ axis * axis
    down = up @ axis * axis - up
    return math.degrees(math.acos(np.clip(arm @ down / (np.linalg.norm(arm) * np.linalg.norm(down)), -1.0, 1.0)))


def passed_mass(below: Bools, mass: Floats) -> Floats:
    """Return the mass [kg] that has been below a plane until each output; `below` (outputs, spheres)."""
    return np.asarray(np.logical_or.accumulate(below, axis=0) @ mass, dtype=float)


def steady_rate(time: Floats, passed: Floats) -> float:
    """Return the slope [kg/s] of the passed mass between 10 and 90 % of its total, by least squares."""
    if len(passed) == 0 or not passed[-1] > 0.0:
        raise PywetError(
            "no sphere has passed the plane; expected a height_m between where they start and where they end",
            code="discharge.none", key="height_m",
        )  # fmt: skip
    inside = (passed >= STEADY[0] * passed[-1]) & (passed <= STEADY[1] * passed[-1])
    if inside.sum() < 3:
        raise PywetError(
            f"the discharge has {int(inside.sum())} outputs between 10 and 90 % of what passes; expected at least three: "
            "more outputs (results.interval_s)",
            code="discharge.few_outputs", given=int(inside.sum()), expected=3,
        )  # fmt: skip
    return float(np.polyfit(time[inside], passed[inside], 1)[0])
