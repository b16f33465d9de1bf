"""Fraction retained, liquid by holder and sums of a run by the reference's own reading of its logs, output by output.

Elskamp & Kruggel-Emden 2018: (44), (45); a sphere holds its film and its side of every standing bridge (sections 4, 5.3). The
logs are read in parts: of a long run one output is in memory at a time.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.replay import io, whole
from reference_impl.replay.compare import Floats
from reference_impl.replay.io import ReplayError, where
from reference_impl.replay.stream import Rows

ROWS = {
    "wires": "wires", "side_wall": "side_wall", "feed_bin": "feed_bin", "slide": "feed_bin", "outlet": "outlet",
    "impact_plate": "impact_plate", "collecting_bin": "collecting_bin", "wall": "wall",
}  # fmt: skip
"""Holder -> row of the table of liquid: the slide is the feed bin's floor."""
BIN = "collecting_bin"
PAIR = 0
"""Kind of partner: another sphere."""
LOGS = {
    "trajectory": ["step", "id", "type", "x", "y", "z"], "films": ["step", "id", "film"],
    "bridges": ["step", "partner_kind", "i", "j", "triangle", "volume", "share_i"],
    "wall_films": ["step", "triangle", "film"],
}  # fmt: skip


@dataclass
class Bodies:
    """Spheres in the order of their ids, classes, and the holder of every triangle."""

    ids: Floats
    kind: Floats
    mass: Floats
    film: Floats
    names: dict[int, str]
    density: float
    holder: Floats
    """Number of the row of `walls` for each triangle."""
    walls: list[str]

    @classmethod
    def of(cls, folder: Path, scene: Mapping[str, Any]) -> Bodies:
        """From scene.json and the start."""
        spheres = io.columns(folder / "history" / "spheres.parquet", ["id", "type", "film"]).sort_values("id")
        kind = spheres["type"].to_numpy(int)
        mass = {c["type"]: c["density_kg_per_m3"] * 4.0 / 3.0 * np.pi * c["radius_m"] ** 3 for c in scene["classes"]}
        if not set(kind) <= set(mass):
            raise ReplayError(f"{folder}: history/spheres.parquet has types that scene.json does not have; expected both of one "
                              "run: run the case again")  # fmt: skip
        rows = list(dict.fromkeys(ROWS.values()))
        counts = [len(w["triangle_part"]) for w in scene["walls"]]
        holder = np.repeat([rows.index(ROWS[w["holder"]]) for w in scene["walls"]], counts).astype(int)
        liquid = scene["liquid"]
        return cls(
            spheres["id"].to_numpy(int), kind, np.array([mass[k] for k in kind]), spheres["film"].to_numpy(float),
            {c["type"]: c["name"] for c in scene["classes"]}, liquid["density_kg_per_m3"] if liquid else 0.0, holder, rows,
        )  # fmt: skip

    def at(self, ids: pd.Series, path: Path) -> Floats:
        """Place of each id; an id that the start does not have is refused."""
        found = np.minimum(np.searchsorted(self.ids, ids), len(self.ids) - 1)
        if not np.array_equal(self.ids[found], ids):
            raise ReplayError(f"{path} names spheres that history/spheres.parquet does not have; expected those of the start: "
                              "run the case again")  # fmt: skip
        return found


@dataclass
class Own:
    """What the logs give."""

    retained: pd.DataFrame
    liquid: pd.DataFrame
    came_back: int
    mass: float
    initial: float
    counts: dict[str, int]
    checks: dict[str, float] = field(default_factory=dict)
    """Name of a check -> its value."""
    limits: dict[str, float] = field(default_factory=dict)


def slug(name: str) -> str:
    """A class' name as a part of a column's."""
    return re.sub("[^a-z0-9]+", "_", name.lower()).strip("_")


def go_through(folder: Path, scene: Mapping[str, Any]) -> Own:
    """Read all outputs of a run once."""
    of, moist = Bodies.of(folder, scene), bool(scene["effects"]["bridges"])
    names = LOGS if moist else ("trajectory",)
    logs = {name: Rows(where(folder, name), name, LOGS[name]) for name in names}
    outputs, passed, back = whole.plan(folder).outputs, np.zeros(len(of.ids), bool), np.zeros(len(of.ids), bool)
    ledger = io.table(where(folder, "ledger"), "ledger").drop_duplicates("step", keep="last") if moist else None
    left = (
        ledger.set_index("step")["left"].reindex(outputs).fillna(0.0).to_numpy()
        if ledger is not None
        else np.zeros(len(outputs))
    )
    rows: list[tuple[dict[str, float], dict[str, float]]] = []
    opening = scene["slide"]["opens_at_s"] if scene["slide"] else 0.0
    for step, gone in zip(outputs, left, strict=True):
        places = logs["trajectory"].until(int(step))
        at = of.at(places["id"], where(folder, "trajectory"))
        below = np.zeros(len(of.ids), bool)
        here = np.zeros(len(of.ids), bool)
        here[at], below[at] = True, places["z"].to_numpy() < scene["bin_z_m"]
        passed |= below
        back |= passed & here & ~below
        on, walls, standing = _liquid(folder, of, logs, int(step)) if moist else (of.film, np.zeros(len(of.walls)), 0.0)
        time = {
            "step": float(step),
            "time_s": step * scene["time_step_s"],
            "time_since_opening_s": step * scene["time_step_s"] - opening,
        }
        rows.append(
            ({**time, **_retained(of, on, walls, here, passed)},
             {**time, **_held(of, scene, on, walls, here, passed, float(gone), standing)})
        )  # fmt: skip
    retained, liquid = (pd.DataFrame([row[k] for row in rows]) for k in (0, 1))
    counts = {name: int((of.kind == kind).sum()) for kind, name in of.names.items()}
    own = Own(retained, liquid, int(back.sum()), float(of.mass.sum()), float(of.film.sum()), counts)
    _check(own, of)
    return own


def _liquid(folder: Path, of: Bodies, logs: Mapping[str, Rows], step: int) -> tuple[Floats, Floats, float]:
    """At one output: liquid that belongs to every sphere, to every row of walls, and what of it stands in bridges [m3]."""
    films, b, wet = (logs[name].until(step) for name in ("films", "bridges", "wall_films"))
    n, pair = len(of.ids), b["partner_kind"].to_numpy() == PAIR
    volume, share = b["volume"].to_numpy(float), b["share_i"].to_numpy(float)
    path = where(folder, "bridges")
    on = np.bincount(of.at(films["id"], where(folder, "films")), films["film"], n)
    on += np.bincount(of.at(b["i"], path), share, n)
    on += np.bincount(of.at(b["j"][pair], path), (volume - share)[pair], n)
    triangle = np.concatenate([wet["triangle"].to_numpy(int), b["triangle"].to_numpy(int)[~pair]])
    if len(triangle) and not 0 <= triangle.min() <= triangle.max() < len(of.holder):
        raise ReplayError(f"{folder}: liquid is on triangles that scene.json does not have; expected those of its walls: "
                          "run the case again")  # fmt: skip
    amount = np.concatenate([wet["film"].to_numpy(float), (volume - share)[~pair]])
    return on, np.bincount(of.holder[triangle], amount, len(of.walls)), float(volume.sum())


def _retained(of: Bodies, on: Floats, walls: Floats, here: Floats, passed: Floats) -> dict[str, float]:
    """One row of Y(t): mass of spheres and liquid that is not in the bin over that at the start."""
    above = here & ~passed
    wet, start = of.mass + of.density * on, of.mass + of.density * of.film
    outside = of.density * walls[[k for k, name in enumerate(of.walls) if name != BIN]].sum()
    row = {
        "fraction_retained": (wet[above].sum() + outside) / start.sum(),
        "fraction_retained_spheres": of.mass[above].sum() / of.mass.sum(),
    }
    for kind, name in of.names.items():
        own = of.kind == kind
        if own.any():
            row[f"fraction_retained_{slug(name)}"] = wet[above & own].sum() / start[own].sum()
    counts = {"on_screen": above, "in_bin": here & passed, "lost": ~here}
    return {**row, **{f"spheres_{name}": float(rows.sum()) for name, rows in counts.items()}}


def _held(
    of: Bodies, scene: Mapping[str, Any], on: Floats, walls: Floats, here: Floats, passed: Floats, left: float, standing: float
) -> dict[str, float]:  # fmt: skip
    """One row of where the liquid is [m3]."""
    row, total = {}, left
    for name, rows in (("coarse_material", here & ~passed), ("fines", here & passed)):
        row[f"{name}_m3"] = on[rows].sum()
        total += row[f"{name}_m3"]
        row |= {f"{name}_{slug(c)}_m3": on[rows & (of.kind == kind)].sum() for kind, c in of.names.items()}
    used = {ROWS[w["holder"]] for w in scene["walls"]}
    row |= {f"{name}_m3": amount for name, amount in zip(of.walls, walls, strict=True) if name in used}
    total += walls.sum()
    return {**row, "left_m3": left, "total_m3": total, "standing_bridges_m3": standing, "initial_m3": of.film.sum()}


def _check(own: Own, of: Bodies) -> None:
    """What must hold in every run: no sphere lost, Y never rises (but for liquid drawn out of the bin), all liquid there."""
    y, liquid = own.retained, own.liquid
    seen = y["spheres_on_screen"] + y["spheres_in_bin"]
    wet = own.initial * of.density
    gap = float((liquid["total_m3"] - own.initial).abs().max())
    own.checks = {
        "no_particle_lost": float((len(of.ids) - seen).abs().max()),
        "fraction_retained_monotone": max(0.0, float(np.diff(y["fraction_retained"]).max(initial=0.0))),
        "liquid_accounted_for": gap / own.initial if own.initial > 0.0 else 0.0,
    }
    own.limits = {
        "no_particle_lost": 0.0,
        "fraction_retained_monotone": 1e-12 + 1e-3 * wet / (own.mass + wet),
        "liquid_accounted_for": 1e-12,
    }
