"""Liquid by wall and contact statistics of a user-defined scene."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.motion.touching import near_copies
from reference_impl.replay import images, io, retired
from reference_impl.replay.arrays import Floats
from reference_impl.tables import at_walls
from reference_impl.tables.recomputed import ALL_THERE, Bodies, Output, Recomputed, accounted, outputs, slug

NAMES = ("liquid_by_wall", "contact_statistics")
STATISTICS = (
    "contacts_per_sphere", "mean_overlap", "largest_overlap", "walls_per_sphere", "mean_wall_overlap", "largest_wall_overlap",
    "largest_wall_penetration", "bridges_per_sphere", "mean_speed_m_per_s", "largest_speed_m_per_s", "centre_of_mass_height_m",
)  # fmt: skip
MOTION = ["type", "x", "y", "z", "vx", "vy", "vz"]


def written(folder: Path) -> bool:
    """Return whether the results of a run are those of a user-defined scene."""
    if any(path.stem in NAMES for path in (folder / "results").glob("*")):
        return True
    path = folder / "summary.json"
    try:
        return path.exists() and "contacts_end" in json.loads(path.read_text())
    except (OSError, ValueError, TypeError, RecursionError):
        return False  # reported by the function that reads it


def tables(folder: Path, scene: Mapping[str, Any]) -> Recomputed:
    """Read all outputs of a run once."""
    of = Bodies.of(folder, scene, lambda wall: str(wall["name"]))
    radius = {c["type"]: c["radius_m"] for c in scene["classes"]}
    r, liquid, touching, lost = np.array([radius[k] for k in of.kind]), [], [], 0
    came = np.zeros(len(of.ids), bool)
    walls, origin, left = at_walls.Walls(folder), io.origin(folder), retired.table(folder)
    last = retired.leaves(folder, of.ids)
    for o in outputs(folder, scene, of, MOTION):
        stamp = {"step": float(o.step), "time_s": o.step * scene["time_step_s"]}
        liquid.append({**stamp, **_held(of, o, _booked(scene, left[left["step"] <= o.step]), last <= o.step)})
        touching.append({**stamp, **_contacts(of, o, r[o.at], scene, walls, origin)})
        lost, came = max(lost, int((~o.here & (last >= o.step)).sum())), ~o.waits
    by_wall, contacts = pd.DataFrame(liquid), pd.DataFrame(touching)
    initial = float(of.film[came].sum())
    return Recomputed(
        tables=dict(zip(NAMES, (by_wall, contacts), strict=True)),
        liquid=by_wall,
        checks={"no_particle_lost": float(lost), "liquid_accounted_for": accounted(by_wall, initial)},
        limits={"no_particle_lost": 0.0, "liquid_accounted_for": ALL_THERE},
        printed=[int(came.sum()), lost],
        more={},
        ends={str(k): float(v) for k, v in touching[-1].items() if k not in ("step", "time_s")},
        mass=float(of.mass[came].sum()),
        initial=initial,
        counts=of.counts(came),
    )


def _booked(scene: Mapping[str, Any], left: pd.DataFrame) -> dict[str, float]:
    """Return the liquid that had left through each outlet [m3]; empty if spheres are retired in a bin, which still count."""
    return {
        f"outlet_{o['name']}_m3": float(left["film"][left["outlet"] == k].sum())
        for k, o in enumerate(scene.get("outlets") or [], start=1)
    }


def _held(of: Bodies, o: Output, booked: Mapping[str, float], gone: Floats) -> dict[str, float]:
    """Return one row of the liquid by reservoir [m3]; `gone` marks spheres that have left, or leave at this output."""
    on = o.on - np.where(o.waits, of.film, 0.0)
    if booked:
        on[gone] = 0.0
    row = {f"spheres_{slug(c)}_m3": on[of.kind == kind].sum() for kind, c in of.names.items()}
    row |= {f"wall_{name}_m3": amount for name, amount in zip(of.walls, o.walls, strict=True)}
    row |= booked
    total = sum(row.values()) + o.left
    return {
        **row,
        "left_m3": o.left,
        "total_m3": total,
        "standing_bridges_m3": o.in_bridges,
        "initial_m3": of.film[~o.waits].sum(),
    }


def _contacts(
    of: Bodies, o: Output, r: Floats, scene: Mapping[str, Any], walls: at_walls.Walls, origin: Floats
) -> dict[str, float]:
    """One row of touching spheres and walls, bridges, speeds and height of the centre of mass, of the spheres that are inside.

    Those that still wait for their entry are not; zeros while none is.
    """
    inside = ~o.waits[o.at]
    if not inside.any():
        return dict.fromkeys(STATISTICS, 0.0)
    at, v = (o.places.rows(names)[inside] for names in (["x", "y", "z"], ["vx", "vy", "vz"]))
    r = r[inside]
    box = images.of_scene(scene)
    a, b = near_copies(at, r, box)
    depth = (r[a] + r[b] - np.sqrt((box.nearest(at[a] - at[b]) ** 2).sum(axis=1))) / np.minimum(r[a], r[b])
    depth, speed, g = depth[depth > 0.0], np.sqrt((v**2).sum(axis=1)), np.array(scene["gravity_m_per_s2"], float)
    pull, n, mass = float(np.sqrt((g**2).sum())), len(at), of.mass[o.at][inside]
    height = (at + origin) @ (-g / pull) if pull else np.zeros(n)
    wall, through = walls.overlaps(o.step, at, r)
    return {
        "contacts_per_sphere": 2.0 * len(depth) / n,
        "mean_overlap": float(depth.mean()) if len(depth) else 0.0,
        "largest_overlap": float(depth.max(initial=0.0)),
        "walls_per_sphere": len(wall) / n,
        "mean_wall_overlap": float(wall.mean()) if len(wall) else 0.0,
        "largest_wall_overlap": float(wall.max(initial=0.0)),
        "largest_wall_penetration": float(through.max(initial=0.0)),
        "bridges_per_sphere": 2.0 * o.bridges / n,
        "mean_speed_m_per_s": float(speed.mean()),
        "largest_speed_m_per_s": float(speed.max()),
        "centre_of_mass_height_m": float((mass * height).sum() / mass.sum()),
    }
