"""Depth of spheres in walls: overlaps at an output, relative to the radius and to the wall thickness."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np

from pywet.runs.rundir import Floats, RunDir
from pywet.runs.walls import wall_corners
from pywet.scene import Vector

PRESSED = 0.5
"""Overlap over the wall thickness above which a sphere may leave through the far side."""
FACING = 0.8
"""Cosine of the angle up to which two triangles count as opposite sides of a wall rather than an edge."""


class AtWalls:
    """Walls of a run; a sphere has one contact with a wall, at the wall's closest point."""

    def __init__(self, run: RunDir) -> None:
        self.run = run
        self.rows = [(run.triangles["mesh"] == wall.name).to_numpy() for wall in run.scene.walls]
        self._meshes: list[Any] = [None] * len(self.rows)

    @cached_property
    def thickness(self) -> list[float]:
        """Thickness of each wall [m]."""
        corners = wall_corners(self.run, 0)
        return [thickness(corners[rows]) for rows in self.rows]

    def overlaps(self, step: int, at: Floats, radius: Floats) -> tuple[Floats, Floats]:
        """Return the overlaps of touching spheres and walls at an output, over the radius and over the wall's thickness."""
        import pyvista as pv

        corners, found = wall_corners(self.run, step), [np.zeros((0, 2))]
        for n, (rows, wall) in enumerate(zip(self.rows, self.run.scene.walls, strict=True)):
            here = _with_copies(corners[rows], self.run.scene.periods_m)
            low, high = here.min(axis=(0, 1)), here.max(axis=(0, 1))
            near = ((at > low - radius[:, None]) & (at < high + radius[:, None])).all(axis=1)
            if not near.any():
                continue
            if self._meshes[n] is None or wall.motion != "fixed":
                self._meshes[n] = _mesh(here)
            points = pv.PolyData(at[near]).compute_implicit_distance(self._meshes[n])
            depth = radius[near] - np.abs(np.asarray(points["implicit_distance"], dtype=float))
            touch = depth > 0.0
            found.append(
                np.stack([depth[touch] / radius[near][touch], depth[touch] / self.thickness[n]], axis=1)
            )  # fmt: skip
        both = np.concatenate(found)
        return both[:, 0], both[:, 1]


def _with_copies(corners: Floats, periods: Vector) -> Floats:
    """Return the triangles of a wall and of its periodic copies on both sides."""
    ways = [sign * np.array(periods) for sign in (-1.0, 1.0)] if any(periods) else []
    return np.concatenate([corners, *(corners + way for way in ways)])


def thickness(corners: Floats) -> float:
    """Smallest distance [m] inwards from the centre of a triangle to an opposite one, for corners (t, 3, 3); inf for a sheet."""
    mesh, middle = _mesh(corners), corners.mean(axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    size = float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0)))
    least = math.inf
    for start, n in zip(middle, normal, strict=True):
        hits, cells = mesh.ray_trace(start - 1e-6 * size * n, start - size * n)
        ways = ((start - hits) @ n)[-(normal[cells] @ n) > FACING]
        least = min(least, float(ways.min(initial=math.inf)))
    return least


def expected(speed: float, mass: float, stiffness: float) -> float:
    """Overlap [m] of a sphere [kg] that meets a wall at a speed [m/s] with a contact stiffness [N/m]: v √(m/k).

    >>> f"{expected(2.2, 4.1e-3, 2000.0):.5f}"
    '0.00315'
    """
    return speed * math.sqrt(mass / stiffness)


def _mesh(corners: Floats) -> Any:
    import pyvista as pv

    faces = np.insert(np.arange(3 * len(corners)).reshape(-1, 3), 0, 3, axis=1).ravel()
    return pv.PolyData(corners.reshape(-1, 3), faces)
