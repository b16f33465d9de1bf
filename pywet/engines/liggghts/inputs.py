"""Inputs of a moist run and its replay in addition to the scene: transfer tables, constants of the laws, the laws' own tables.

A law's table is computed here once, with progress messages, and cached.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from pywet.engines.liggghts.plugin_api import angle_pairs
from pywet.geometry.initial import wall_groups
from pywet.laws import registry
from pywet.laws.kinds import KINDS
from pywet.laws.transfer import v_star_grid
from pywet.scene import EngineScene
from pywet.schema import LARGE_WALL, SMALL_WALL, SPHERE
from pywet.util.file_list import remove
from pywet.util.files import write_json, write_table
from pywet.util.notices import bar


def write_inputs(scene: EngineScene, run_dir: Path) -> None:
    """Write the tables that a moist run and its replay read in addition to the scene; remove them from a dry one."""
    history = run_dir / "history"
    if not scene.effects.bridges:
        remove(run_dir, "history/transfer.parquet", "history/meta.json")
        return
    prepare_laws(scene)
    write_table(transfer_tables(scene), history / "transfer.parquet")
    write_json(history / "meta.json", meta(scene, scene.output_steps))


def meta(scene: EngineScene, output_steps: list[int]) -> dict[str, Any]:
    """Return the constants for the replay in addition to the tables."""
    liquid = scene.liquid
    assert liquid is not None
    return {
        "surface_tension": liquid.surface_tension_N_per_m,
        "viscosity": liquid.viscosity_Pa_s,
        "time_step": scene.time_step_s,
        "viscous_integration": scene.viscous_integration,
        "bridges_every": scene.bridges_every,
        "effects": scene.effects.model_dump(),
        "types": [
            {"type": c.type, "radius": c.radius_m, "contact_angle": c.contact_angle_rad, "density": c.density_kg_per_m3}
            for c in scene.classes
        ],
        "output_steps": output_steps,
    }


def prepare_laws(scene: EngineScene) -> None:
    """Prepare the tables of all laws of the scene that need one."""
    with bar("exact bridge tables (stored for later runs)") as move:
        for kind, name in scene.effects.laws.items():
            if KINDS[kind].parts:
                registry.get(kind, name).prepare(angle_pairs(scene), move)


def transfer_tables(scene: EngineScene) -> pd.DataFrame:
    """Return the transfer ratios T_i(V*) of every pair of types, and of every type with every group of wall parts.

    Columns partner_kind, type_i, type_j (0 for walls), part_class (-1 for spheres), v_star, transfer_i.
    """
    name = scene.effects.transfer or "parabola"
    table, grid = registry.transfer_model(name), v_star_grid(2 if name == "half" else scene.transfer_nodes)
    groups = wall_groups(scene) if scene.effects.wall_films else {}
    rows = []
    for a in scene.classes:
        cases = [(SPHERE, b.type, b.radius_m, b.contact_angle_rad) for b in scene.classes]
        for (width, angle), group in groups.items():
            wire = width < a.radius_m
            cases.append((SMALL_WALL if wire else LARGE_WALL, group, width, angle))
        for kind, other, size, angle in cases:
            values = table(a.radius_m, size, a.contact_angle_rad, angle, kind, grid)
            row = {"partner_kind": kind, "type_i": a.type, "type_j": other if kind == SPHERE else 0}
            row["part_class"] = -1 if kind == SPHERE else other
            rows.append(pd.DataFrame({**row, "v_star": grid, "transfer_i": values}))
    if not rows:
        return pd.DataFrame(
            columns=["partner_kind", "type_i", "type_j", "part_class", "v_star", "transfer_i"], dtype=float
        )
    return pd.concat(rows, ignore_index=True)
