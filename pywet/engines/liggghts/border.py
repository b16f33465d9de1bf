"""Check numbers read from files before they reach the plugin: spheres, types, films, triangles, transfer tables.

The plugin indexes its arrays by these numbers and checks none of them.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from pywet.errors import FileError
from pywet.geometry.initial import wall_groups
from pywet.scene import EngineScene
from pywet.schema import LARGE_WALL, SMALL_WALL, SPHERE
from pywet.util.files import AGAIN


def check_tables(
    scene: EngineScene, spheres: pd.DataFrame, transfer: pd.DataFrame, nodes: dict[str, np.ndarray]
) -> None:
    """Refuse tables of a run that are inconsistent with its scene; `nodes`: corners of the triangles of each wall."""
    _spheres(scene, spheres)
    missing = [wall.name for wall in scene.walls if wall.name not in nodes]
    _refuse(missing, "triangles", f"has no triangle of the walls {', '.join(missing)}", "some of each wall")
    for wall in scene.walls:
        flat = nodes[wall.name].reshape(-1, 9)
        _refuse(
            not np.isfinite(flat).all(), "triangles", f"has corners of wall {wall.name} that are no places", "numbers"
        )
        parts = np.asarray(wall.triangle_part, dtype=np.int64)
        _refuse(
            ((parts < 0) | (parts >= len(wall.part_half_width_m))).any(),
            "triangles",
            f"belongs to a scene whose wall {wall.name} has triangles of parts that it does not have",
            f"parts 0 to {len(wall.part_half_width_m) - 1}",
        )
    if scene.effects.bridges:
        _transfer(scene, transfer)


def check_start(spheres: pd.DataFrame, start: pd.DataFrame) -> None:
    """Refuse spheres that differ, in id or type, from those in the file from which the engine starts."""
    there, begun = (t.sort_values("id")[["id", "type"]].to_numpy() for t in (spheres, start))
    _refuse(
        not np.array_equal(there, begun),
        "spheres",
        f"has {len(there)} spheres" if len(there) != len(begun) else "has other ids or types",
        f"the {len(begun)} that the scene starts from",
    )


def _spheres(scene: EngineScene, spheres: pd.DataFrame) -> None:
    ids, types = (spheres[name].to_numpy() for name in ("id", "type"))
    whole = np.array_equal(np.sort(ids), np.arange(1, len(ids) + 1))
    _refuse(not whole, "spheres", "has ids that are repeated, missing or below 1", f"1 to {len(ids)}, each once")
    known = [c.type for c in scene.classes]
    _refuse(not np.isin(types, known).all(), "spheres", "has types that scene.json does not", f"those of {known}")
    if "film" in spheres:
        film = spheres["film"].to_numpy(dtype=float)
        _refuse(not (np.isfinite(film) & (film >= 0.0)).all(), "spheres", "has films that are no volumes", "0 or more")


def _transfer(scene: EngineScene, tables: pd.DataFrame) -> None:
    columns = ["partner_kind", "type_i", "type_j", "part_class"]
    types = [c.type for c in scene.classes]
    groups = wall_groups(scene) if scene.effects.wall_films else {}
    wanted = {(SPHERE, a, b, -1) for a in types for b in types}
    radius = {c.type: c.radius_m for c in scene.classes}
    for a in types:
        wanted |= {(SMALL_WALL if width < radius[a] else LARGE_WALL, a, 0, g) for (width, _), g in groups.items()}
    rows = tables.groupby(columns)
    found = {tuple(int(n) for n in key) for key in tables[columns].drop_duplicates().itertuples(index=False)}
    _refuse(
        found != wanted,
        "transfer",
        f"has {len(found)} tables of pairs",
        f"those of the {len(wanted)} pairs of scene.json",
    )
    v, share = (tables[name].to_numpy(dtype=float) for name in ("v_star", "transfer_i"))
    _refuse(not ((share >= 0.0) & (share <= 1.0)).all(), "transfer", "has shares that are none", "0 to 1")
    _refuse(
        not np.isfinite(v).all() or rows.size().min() < 2,
        "transfer",
        "has a table of less than two nodes",
        "two or more",
    )


def _refuse(wrong: object, table: str, what: str, expected: str) -> None:
    if wrong:
        raise FileError(
            f"history/{table}.parquet {what}; expected {expected}: {AGAIN}",
            code="run.history", key=table, given=what, expected=expected,
        )  # fmt: skip
