"""Derive parts of walls from their triangles alone: faces that end where neighbouring facets meet at more than an angle.

This is independent of how the walls were built: facets are visited one after the other from neighbour to neighbour.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from reference_impl.diagnosis.held import Held
from reference_impl.replay.arrays import Floats
from reference_impl.scene.stl import nodes

ROUNDING_DEG = 1e-3
"""Rotation of a facet's normal [deg] due to single precision of its corners."""


def derived(scene: Mapping[str, Any], meshes: Mapping[str, Floats]) -> Iterator[Held]:
    """Compare the parts of every wall that follow from an angle with those of its triangles."""
    for wall in scene["walls"]:
        angle, name = wall.get("feature_angle_deg"), wall["name"]
        if angle is None:
            continue
        given, corners = np.asarray(wall["triangle_part"]), meshes[name]
        what = f"walls.{name}.triangle_part, "
        if len(given) != len(corners):
            yield Held(f"{what}its number", len(given), len(corners), "triangles of the STL")
            continue
        wrong = _not_derived(given, corners, float(angle))
        yield Held(f"{what}triangles of another part", wrong, 0, f"faces of the STL with folds up to {angle:g} deg")


def _not_derived(given: Floats, corners: Floats, angle: float) -> int:
    """Return the number of triangles with a wrongly joined neighbour, and of those in parts with more than one piece."""
    _, index = nodes(corners)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    of_edge: dict[tuple[int, int], list[int]] = defaultdict(list)
    for k, triangle in enumerate(index.tolist()):
        for n in range(3):
            a, b = triangle[n], triangle[(n + 1) % 3]
            of_edge[min(a, b), max(a, b)].append(k)
    near: dict[int, set[int]] = defaultdict(set)
    for first, second in (pair for pair in of_edge.values() if len(pair) == 2):
        p, q = cross[first], cross[second]
        c = np.cross(p, q)
        fold = np.degrees(np.arctan2(np.sqrt(c @ c), p @ q))
        if fold <= angle + ROUNDING_DEG:
            near[first].add(second)
            near[second].add(first)
    labels = np.full(len(given), -1)
    faces = 0
    for start in range(len(given)):
        if labels[start] < 0:
            waiting, labels[start] = [start], faces
            while waiting:
                for k in near[waiting.pop()]:
                    if labels[k] < 0:
                        labels[k] = faces
                        waiting.append(k)
            faces += 1
    pairs = np.unique(np.column_stack([given, labels]), axis=0)
    mixed = pairs[np.bincount(pairs[:, 0])[pairs[:, 0]] > 1], pairs[np.bincount(pairs[:, 1])[pairs[:, 1]] > 1]
    return int((np.isin(given, mixed[0][:, 0]) | np.isin(labels, mixed[1][:, 1])).sum())
