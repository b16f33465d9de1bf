"""Overlaps of spheres with walls at an output: one for each touching sphere and wall, by the wall's closest triangle."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from reference_impl.motion import nearest, window
from reference_impl.replay import images
from reference_impl.replay.arrays import Floats

EDGE = 1e-9
"""Share of a triangle by which a ray may miss it, so that none passes between two triangles."""
FACING = 0.8
"""Cosine of the angle between a ray and the normal of its exit triangle above which these are opposite sides."""
ROWS = 2_000_000
"""Number of pairs of ray and triangle in memory at once."""


class Walls:
    """All walls of a run, with their parts."""

    def __init__(self, folder: Path) -> None:
        setup = window.read(folder)
        self.parts = nearest.Parts(setup, images.of_scene(setup.scene))
        self.none = np.zeros(len(setup.corners))
        self.thickness = np.array([thickness(setup.corners[w.first : w.last]) for w in setup.walls])

    def overlaps(self, step: int, at: Floats, r: Floats) -> tuple[Floats, Floats]:
        """Return overlap over the radius, and over the wall's thickness."""
        if not len(self.thickness):
            return np.zeros(0), np.zeros(0)
        sphere, part, near = self.parts.within(step, at, r, self.none)
        wall = self.parts.wall[part]
        least = np.full((len(self.thickness), len(at)), np.inf)
        np.minimum.at(least, (wall, sphere), near.distance)
        w, a = np.nonzero(np.isfinite(least))
        depth = r[a] - least[w, a]
        return depth / r[a], depth / self.thickness[w]


def thickness(corners: Floats) -> float:
    """Return the smallest distance from a triangle's middle against its normal to an opposite triangle, for corners (t, 3, 3)."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    n = np.cross(u, v)
    length = np.sqrt((n**2).sum(axis=1))
    middle, inward = corners.mean(axis=1), -n / length[:, None]
    best, step = np.inf, max(1, ROWS // len(corners))
    for first in range(0, len(corners), step):
        rays = slice(first, first + step)
        slope = inward[rays] @ n.T
        off = np.einsum("tk,tk->t", a, n) - middle[rays] @ n.T
        with np.errstate(all="ignore"):
            way = off / slope
            foot = middle[rays, None] + way[..., None] * inward[rays, None] - a
            # shares of the two edges, by the areas that the foot spans with each of them
            one = np.einsum("rtk,tk->rt", np.cross(foot, v), n) / length**2
            two = np.einsum("rtk,tk->rt", np.cross(u, foot), n) / length**2
            meets = (one > -EDGE) & (two > -EDGE) & (one + two < 1.0 + EDGE)
            ahead = meets & (slope > FACING * length) & (way > 1e-6 * float(np.ptp(corners)))
        best = min(best, float(way[ahead].min(initial=np.inf)))
    return best
