"""Compare the spheres from which a run starts with the scene and the feed bin of the configuration."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from reference_impl.diagnosis.held import Held
from reference_impl.replay import io
from reference_impl.replay.arrays import Floats
from reference_impl.scene import amounts
from reference_impl.scene.stl import LENGTH_ERROR
from reference_impl.scene.tower import Heights, Plan


def starts(folder: Path, config: Mapping[str, Any], scene: Mapping[str, Any]) -> list[Held]:
    """Check the spheres at the start: number of each class, radii, initial films, inside the feed bin, no overlaps."""
    spheres = io.columns(folder / "history" / "spheres.parquet", ["id", "type", "radius", "film"]).sort_values("id")
    places = io.columns(folder / scene["spheres_file"], ["id", "type", "x", "y", "z"]).sort_values("id")
    kinds, found = {c["type"]: c for c in scene["classes"]}, []
    thickness = amounts.film(amounts.classes(config), config) if scene["liquid"] is not None else 0.0
    for kind, c in kinds.items():
        rows, there = spheres[spheres["type"] == kind], int((places["type"] == kind).sum())
        found.append(
            Held(f"history/spheres, number of {c['name']}", len(rows), c["count"], "scene.json: classes count")
        )
        found.append(
            Held(f"{scene['spheres_file']}, number of {c['name']}", there, c["count"], "scene.json: classes count")
        )
        if len(rows):
            radius, film = c["radius_m"], amounts.film_volume(thickness, c["radius_m"])
            found.append(_of_class("radius", c["name"], rows["radius"], radius, "scene.json: classes radius_m"))
            found.append(
                _of_class("film", c["name"], rows["film"], film, "the liquid as one film on all spheres", film or 1.0)
            )
    if len(places):
        found += _packing(
            config, places, np.array([kinds[t]["radius_m"] if t in kinds else 0.0 for t in places["type"]])
        )
    return found


def _of_class(column: str, name: str, values: pd.Series, want: float, source: str, scale: float | None = None) -> Held:
    at = int(np.argmax(np.abs(values.to_numpy(float) - want)))
    return Held(f"history/spheres.{column} of {name}", float(values.iloc[at]), want, source, scale)


def _packing(config: Mapping[str, Any], places: pd.DataFrame, radius: Floats) -> Iterator[Held]:
    """Compare with a packing in which no sphere starts in a wall of the feed bin or in another sphere."""
    plan, z, at = Plan.of(config), Heights.of(config), places[["x", "y", "z"]].to_numpy(float)
    facing = 2.0 * np.pi * np.arange(plan.sides) / plan.sides
    reach = (at[:, :2] @ np.array([np.cos(facing), np.sin(facing)])).max(axis=1) + radius
    beyond = int((reach > plan.apothem + LENGTH_ERROR).sum())
    yield Held("spheres at the start that reach into the feed bin's wall", beyond, 0, "scales.yaml: width_mm")
    outside = (at[:, 2] - radius < z.slide_top - LENGTH_ERROR) | (at[:, 2] + radius > z.ceiling + LENGTH_ERROR)
    where, source = "spheres at the start below the slide or above the cover", "scales.yaml: feed_bin_height_mm"
    yield Held(where, int(outside.sum()), 0, source)
    pairs = cKDTree(at).query_pairs(2.0 * float(radius.max()), output_type="ndarray")
    gap = np.sqrt(((at[pairs[:, 0]] - at[pairs[:, 1]]) ** 2).sum(axis=1)) - radius[pairs[:, 0]] - radius[pairs[:, 1]]
    yield Held("pairs of spheres that overlap at the start", int((gap < 0.0).sum()), 0, "a loose fill")
