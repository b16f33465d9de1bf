"""Periodic scenes: faces, objects that must not cross them, and walls that continue through them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pywet.cases.custom.description import Periodic, Scene
from pywet.cases.custom.walls import MM, EngineMotion
from pywet.errors import ConfigError
from pywet.geometry.surface import SAME_POINT_M, Floats, Surface
from pywet.scene import Rotation, Slide


def faces_m(periodic: Periodic) -> tuple[float, float]:
    """Return the positions of both faces [m], in the single precision that walls have."""
    low, high = (float(np.float32(MM * face)) for face in (periodic.low_mm, periodic.high_mm))
    return low, high


def axis_of(periodic: Periodic) -> int:
    """Return 0 for x, 1 for y."""
    return "xy".index(periodic.axis)


def refuse_beyond(scene: Scene, table: pd.DataFrame) -> None:
    """Refuse spheres that start outside the periodic faces of a scene, or are inserted across them."""
    if (periodic := scene.periodic) is None:
        return
    low, high = faces_m(periodic)
    at = table[periodic.axis].to_numpy(dtype=float)
    out = np.flatnonzero((at < low - SAME_POINT_M) | (at >= high))
    if len(out):
        entry = scene.spheres[int(table["type"].iloc[out[0]]) - 1]
        raise _refused(
            scene, f"{len(out)} spheres, such as one of {entry.name} at {1e3 * at[out[0]]:g} mm along {periodic.axis}, start or "
            "wait outside the periodic faces", f"all from {periodic.low_mm:g} to {periodic.high_mm:g} mm, with no velocity along "
            f"{periodic.axis} before they enter", f"spheres.{entry.name}",
        )  # fmt: skip


def refuse_short(scene: Scene, reach: float) -> None:
    """Refuse a scene in which two spheres may touch on both sides; `reach` of neighbour lists between centres [m]."""
    if (periodic := scene.periodic) is None:
        return
    low, high = faces_m(periodic)
    if high - low <= 2.0 * reach:
        raise _refused(
            scene, f"the faces of periodic are {1e3 * (high - low):.4g} mm apart, where two spheres may touch on both sides",
            f"over {2e3 * reach:.4g} mm", "periodic",
        )  # fmt: skip


def continued(scene: Scene, name: str, surface: Surface, motion: EngineMotion | None) -> Surface:
    """Return a wall that continues through the faces: without its end faces where both ends have the same outline."""
    if (periodic := scene.periodic) is None:
        return surface
    k, (low, high) = axis_of(periodic), faces_m(periodic)
    _refuse_moving(scene, name, motion, k)
    at = surface.vertices[:, k]
    if at.min() < low - SAME_POINT_M or at.max() > high + SAME_POINT_M:
        raise _refused(
            scene, f"wall {name} reaches from {1e3 * at.min():.4g} to {1e3 * at.max():.4g} mm along {periodic.axis}",
            f"one within the periodic faces, {periodic.low_mm:g} to {periodic.high_mm:g} mm", f"walls.{name}",
        )  # fmt: skip
    ends = [np.flatnonzero(np.abs(at - face) < SAME_POINT_M) for face in (low, high)]
    outlines = [np.delete(surface.vertices[end], k, axis=1) for end in ends]
    if not len(ends[0]) or len(ends[0]) != len(ends[1]):
        return surface
    away, other = (np.asarray(found) for found in cKDTree(outlines[1]).query(outlines[0]))
    if away.max() > SAME_POINT_M or len(np.unique(other)) < len(other):
        return surface
    on_face = np.stack([np.isin(surface.triangles, end).all(axis=1) for end in ends])
    return _of(surface, np.asarray(~on_face.any(axis=0)))


def _of(surface: Surface, rows: NDArray[np.bool_]) -> Surface:
    """Return a surface of some of its triangles, without parts of which none is left."""
    part = surface.part[rows]
    left = np.unique(part)
    widths = tuple(surface.part_half_width[int(p)] for p in left)
    return replace(surface, triangles=surface.triangles[rows], part=np.searchsorted(left, part), part_half_width=widths)


def _refuse_moving(scene: Scene, name: str, motion: EngineMotion | None, k: int) -> None:
    """Refuse a wall that moves through the faces."""
    axis = "xyz"[k]
    if isinstance(motion, Rotation):
        through = any(a for j, a in enumerate(motion.axis) if j != k)
    elif isinstance(motion, Slide):
        through = bool(motion.velocity_m_per_s[k])
    else:
        through = motion is not None and bool(motion.amplitude_m[k])
    if through:
        raise _refused(
            scene, f"wall {name} moves along {axis}, along which the scene repeats",
            f"a motion across {axis}, or a turn about {axis}", f"walls.{name}",
        )  # fmt: skip


def period_m(scene: Scene) -> tuple[Floats, Floats]:
    """Return the lower corner of the box along the periodic axis and the length there [m]; 0 along the other axes."""
    low, length = np.zeros(3), np.zeros(3)
    if scene.periodic is not None:
        k, (first, last) = axis_of(scene.periodic), faces_m(scene.periodic)
        low[k], length[k] = first, last - first
    return low, length


def _refused(scene: Scene, given: str, expected: str, key: str) -> ConfigError:
    return ConfigError(f"scene {scene.name}: {given}; expected {expected}", code="scene.periodic", key=key)
