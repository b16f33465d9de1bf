"""Initial state of a run: scene, walls, spheres, and history/spheres, triangles and parts, numbered as in schema.py."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pywet import run_folder
from pywet.geometry import Surface, write_stl
from pywet.laws.contact import film_volume
from pywet.scene import EngineScene, WallMesh
from pywet.schema import CORNERS
from pywet.util.file_list import remove
from pywet.util.files import write_json, write_table


def wall_mesh(surface: Surface, contact_angle_rad: float, analytic_wires: bool = False) -> WallMesh:
    """Return the scene's description of a surface; `analytic_wires`: dry contacts with its parts as analytic wires."""
    return WallMesh(
        name=surface.name,
        reservoir=surface.reservoir,
        stl=Path("stl") / f"{surface.name}.stl",
        contact_angle_rad=contact_angle_rad,
        motion=surface.motion,
        triangle_part=tuple(int(p) for p in surface.part),
        part_half_width_m=surface.part_half_width,
        analytic_wires=analytic_wires,
    )


def sphere_table(scene: EngineScene, spheres: pd.DataFrame) -> pd.DataFrame:
    """Return id, type, radius [m], film [m3] from the column `film` if given, otherwise from the scene's thickness."""
    thickness = scene.liquid.initial_film_thickness_m if scene.liquid else 0.0
    table = spheres[["id", "type"]].copy()
    table["radius"] = table["type"].map({c.type: c.radius_m for c in scene.classes})
    table["film"] = table["type"].map({c.type: film_volume(thickness, c.radius_m) for c in scene.classes})
    if "film" in spheres:
        table["film"] = spheres["film"].fillna(table["film"])
    return table


def triangle_table(surfaces: Sequence[Surface]) -> pd.DataFrame:
    """Return triangle, part, mesh, reservoir, area [m2], nodes at rest v0_x to v2_z [m]."""
    tables, first = [], 0
    for surface in surfaces:
        rows = pd.DataFrame(
            {"part": surface.part + first, "mesh": surface.name, "reservoir": surface.reservoir, "area": surface.area}
        )
        rows[CORNERS] = surface.corners.reshape(-1, 9)
        tables.append(rows)
        first += len(surface.part_half_width)
    table = pd.concat(tables, ignore_index=True)
    table.insert(0, "triangle", np.arange(len(table)))
    return table


def wall_groups(scene: EngineScene) -> dict[tuple[float, float], int]:
    """Return distinct (half width, contact angle) of all wall parts -> number of their transfer table."""
    groups: dict[tuple[float, float], int] = {}
    for wall in scene.walls:
        for width in wall.part_half_width_m:
            groups.setdefault((math.inf if width is None else width, wall.contact_angle_rad), len(groups))
    return groups


def part_table(scene: EngineScene, surfaces: Sequence[Surface]) -> pd.DataFrame:
    """Return part, mesh, reservoir, half_width [m] (NaN: large), contact_angle [rad], area [m2], part_class of `wall_groups`."""
    rows: list[tuple[int, str, str, float, float, float, int]] = []
    groups = wall_groups(scene)
    for surface, wall in zip(surfaces, scene.walls, strict=True):
        area = np.bincount(surface.part, weights=surface.area)
        for half_width, a in zip(wall.part_half_width_m, area, strict=True):
            width, angle = math.inf if half_width is None else half_width, wall.contact_angle_rad
            row = (surface.name, surface.reservoir, math.nan if half_width is None else width, angle, float(a))
            rows.append((len(rows), *row, groups[width, angle]))
    return pd.DataFrame(
        rows, columns=["part", "mesh", "reservoir", "half_width", "contact_angle", "area", "part_class"]
    )


def write_initial(scene: EngineScene, surfaces: Sequence[Surface], spheres: pd.DataFrame, run_dir: Path) -> None:
    """Write the scene and all it refers to; `surfaces` in the order of scene.walls, the films of `spheres` as `sphere_table`."""
    run_dir = Path(run_dir)
    run_folder.claim(run_dir)
    if not surfaces:  # files of an earlier scene
        remove(run_dir, "history/triangles.parquet", "history/parts.parquet")
    for surface, wall in zip(surfaces, scene.walls, strict=True):
        write_stl(surface, run_dir / wall.stl)
    write_table(spheres.drop(columns="film", errors="ignore"), run_dir / scene.spheres_file)
    write_json(run_dir / "scene.json", scene.model_dump(mode="json"))
    history = run_dir / "history"
    write_table(sphere_table(scene, spheres), history / "spheres.parquet")
    if surfaces:
        write_table(triangle_table(surfaces), history / "triangles.parquet")
        write_table(part_table(scene, surfaces), history / "parts.parquet")
