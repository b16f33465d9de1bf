"""Liquid on every class of spheres and every wall of a scene of one's own, added up anew from the logs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from reference_impl.replay import io
from reference_impl.tables.own import slug

SPHERE = 0


def liquid_by_wall(folder: Path, scene: Mapping[str, Any]) -> pd.DataFrame:
    """The table results/liquid_by_wall of a moist run [m3]: who would have how much if every bridge broke now."""
    history = folder / "history"
    kind = io.columns(history / "spheres.parquet", ["id", "type"]).set_index("id")["type"]
    mesh: Any = {}
    if scene["walls"]:
        mesh = io.columns(history / "triangles.parquet", ["triangle", "mesh"]).set_index("triangle")["mesh"]
    films = io.columns(history / "films.parquet", ["step", "id", "film"])
    dry = io.columns(history / "wall_films.parquet", ["step", "triangle", "film"])
    b = io.columns(history / "bridges.parquet", ["step", "partner_kind", "i", "j", "triangle", "volume", "share_i"])
    pair, rest = b["partner_kind"] == SPHERE, b["volume"] - b["share_i"]
    classes = {c["type"]: f"spheres_{slug(c['name'])}_m3" for c in scene["classes"]}
    names = {w["name"]: f"wall_{w['name']}_m3" for w in scene["walls"]}
    held = [
        pd.DataFrame({"step": films["step"], "who": films["id"].map(kind).map(classes), "volume": films["film"]}),
        pd.DataFrame({"step": b["step"], "who": b["i"].map(kind).map(classes), "volume": b["share_i"]}),
        pd.DataFrame({"step": b["step"], "who": b["j"].map(kind).map(classes), "volume": rest})[pair],
        pd.DataFrame({"step": b["step"], "who": b["triangle"].map(mesh).map(names), "volume": rest})[~pair],
        pd.DataFrame({"step": dry["step"], "who": dry["triangle"].map(mesh).map(names), "volume": dry["film"]}),
    ]
    sums = pd.concat(held).pivot_table(index="step", columns="who", values="volume", aggfunc="sum")
    table = sums.reindex(columns=[*classes.values(), *names.values()]).fillna(0.0)
    ledger = io.columns(history / "ledger.parquet", ["step", "left", "bridges", "initial"]).set_index("step")
    table["left_m3"] = ledger["left"]
    table["total_m3"] = table.sum(axis=1)
    table["standing_bridges_m3"], table["initial_m3"] = ledger["bridges"], ledger["initial"]
    table.insert(0, "time_s", table.index * scene["time_step_s"])
    return table.reset_index()
