"""Initial arrangement of the spheres: placed one by one at random in the feed bin, without overlap.

Random sequential placing, largest spheres first, at a solid fraction of 0.28, gives a loose, well mixed cloud above
the slide, on which it settles. It is not a packed bed.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Literal

import numpy as np
import pandas as pd
import scipy

from pywet.errors import PywetError
from pywet.geometry.surface import Floats
from pywet.scene import SphereClass

SOLID_FRACTION = 0.28
GROWTH = 1.1
"""Factor on the height for the next attempt if the spheres do not fit."""
ROUNDS = 400
SPHERE_B = 1000
"""Smallest memory [B] for placing a sphere: its attempts, their neighbours, its rows."""
SPACING = 1.0 + 1e-6
"""Smallest distance of centres over the sum of the radii."""


@dataclass(frozen=True)
class FeedRegion:
    """Region of the initial spheres: a square of side `width_m` or a cylinder of that diameter around a line along z."""

    shape: Literal["square", "cylinder"]
    width_m: float
    z_low_m: float
    z_high_m: float
    depth_m: float | None = None
    """Side along y if it differs from that along x."""
    centre_m: tuple[float, float] = (0.0, 0.0)
    name: str = "feed bin"
    cure: str = "make feed_bin_height_mm larger or take fewer spheres"

    @property
    def sides_m(self) -> tuple[float, float]:
        """Return the extent along x and y [m]."""
        return self.width_m, self.width_m if self.depth_m is None else self.depth_m

    @property
    def cross_section(self) -> float:
        x, y = self.sides_m
        return x * y * (1.0 if self.shape == "square" else 0.25 * math.pi)


def refuse_beyond_memory(count: int, where: str, cure: str) -> None:
    """Refuse more spheres than fit into this machine's memory, before it is allocated."""
    there = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if count * SPHERE_B > there:
        many = Decimal(count)  # a float cannot represent numbers of any length
        raise PywetError(
            f"{where}: {many:.3g} spheres need at least {many * SPHERE_B / 10**9:.3g} GB of memory, this machine has "
            f"{there / 1e9:.3g} GB; {cure}",
            code="packing.memory", given=count,
        )  # fmt: skip


def fill(classes: Sequence[SphereClass], region: FeedRegion, seed: int | Sequence[int]) -> pd.DataFrame:
    """Place `count` spheres of every class; columns id (from 1), type, x, y, z [m].

    The same seed gives the same table, s and (s, 0) too. Raises `PywetError` when the spheres do not fit into the region.
    """
    refuse_beyond_memory(sum(c.count for c in classes), region.name, region.cure)
    solid = sum(c.count * 4.0 / 3.0 * math.pi * c.radius_m**3 for c in classes)
    largest = max((c.radius_m for c in classes if c.count), default=0.0)
    available = region.z_high_m - region.z_low_m
    loose = solid / (SOLID_FRACTION * region.cross_section)
    height = max(loose, 2.1 * largest)
    if max(loose, 2.0 * SPACING * largest) < available:
        height = min(height, available)
    generator = np.random.default_rng(seed)
    placed = None
    while placed is None and height <= available and 2.0 * largest < min(region.sides_m):
        placed = _place_all(classes, region, height, generator)
        height = min(GROWTH * height, available) if height < available else GROWTH * height
    if placed is None:
        count = sum(c.count for c in classes)
        raise PywetError(
            f"{region.name}: {count} spheres ({solid * 1e6:.1f} cm3) do not fit loosely into {available * 1e3:.4g} mm of a "
            f"{region.shape} {region.width_m * 1e3:.4g} mm wide, expected at least about {height * 1e3:.4g} mm; {region.cure}",
            code="packing.crowded", key=region.name, given=count, expected=height,
        )  # fmt: skip
    return placed


def _place_all(
    classes: Sequence[SphereClass], region: FeedRegion, height: float, generator: np.random.Generator
) -> pd.DataFrame | None:
    done: list[tuple[SphereClass, Floats]] = []
    for sphere in sorted(classes, key=lambda c: (-c.radius_m, c.type)):
        trees: list[tuple[Any, float]] = [
            (scipy.spatial.cKDTree(points), SPACING * (sphere.radius_m + other.radius_m)) for other, points in done
        ]
        points = _place_class(sphere, region, height, trees, generator)
        if points is None:
            return None
        if len(points):
            done.append((sphere, points))
    xyz = np.concatenate([p for _, p in done]) if done else np.zeros((0, 3))
    kinds = np.repeat([c.type for c, _ in done], [len(p) for _, p in done]).astype(np.int64)
    return pd.DataFrame(
        {"id": np.arange(1, len(xyz) + 1), "type": kinds, "x": xyz[:, 0], "y": xyz[:, 1], "z": xyz[:, 2]}
    )


def _place_class(
    sphere: SphereClass,
    region: FeedRegion,
    height: float,
    trees: list[tuple[Any, float]],
    generator: np.random.Generator,
) -> Floats | None:
    """Return the centres (count, 3) of one class, or None if they do not fit."""
    points = np.zeros((0, 3))
    for _ in range(ROUNDS):
        missing = sphere.count - len(points)
        if missing == 0:
            return points
        trial = _draw(max(256, 3 * missing), sphere.radius_m, region, height, generator)
        for tree, distance in trees:
            trial = trial[np.isinf(tree.query(trial, distance_upper_bound=distance)[0])]
        if len(points) and len(trial):
            near = scipy.spatial.cKDTree(points).query(trial, distance_upper_bound=2.0 * SPACING * sphere.radius_m)[0]
            trial = trial[np.isinf(near)]
        points = np.concatenate([points, _thin(trial, 2.0 * SPACING * sphere.radius_m)[:missing]])
    return points if len(points) == sphere.count else None


def _draw(count: int, radius: float, region: FeedRegion, height: float, generator: np.random.Generator) -> Floats:
    """Draw uniform centres of spheres entirely inside the region's lowest `height`."""
    half = 0.5 * np.array(region.sides_m) - SPACING * radius
    xyz = generator.uniform(-1.0, 1.0, size=(count, 3))
    xyz[:, 2] = region.z_low_m + SPACING * radius + 0.5 * (xyz[:, 2] + 1.0) * (height - 2.0 * SPACING * radius)
    if region.shape == "cylinder":
        xyz = xyz[np.hypot(xyz[:, 0], xyz[:, 1]) <= 1.0]
    xyz[:, :2] = xyz[:, :2] * half + region.centre_m
    return xyz


def _thin(trial: Floats, distance: float) -> Floats:
    """Select, in order, the trial centres that are at least `distance` from all those selected before."""
    if len(trial) < 2:
        return trial
    pairs = scipy.spatial.cKDTree(trial).query_pairs(distance, output_type="ndarray")
    keep = np.ones(len(trial), dtype=bool)
    for first, second in pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]:
        if keep[first]:
            keep[second] = False
    return trial[keep]
