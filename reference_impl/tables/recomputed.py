"""State of a run at its outputs from the reference's own reading of the logs: spheres, and the liquid of each reservoir.

A sphere has its film and its share of every active bridge (Elskamp & Kruggel-Emden 2018, sections 4, 5.3). The logs
are read in parts: one output is in memory at a time.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.replay import io, plans
from reference_impl.replay.arrays import Columns, Floats
from reference_impl.replay.io import ReplayError, where
from reference_impl.replay.plans import enters
from reference_impl.replay.stream import Rows

PAIR = 0
"""Kind of partner: another sphere."""
LOGS = {
    "films": ["step", "id", "film"],
    "bridges": ["step", "partner_kind", "i", "j", "triangle", "volume", "share_i"],
    "wall_films": ["step", "triangle", "film"],
}  # fmt: skip


@dataclass
class Bodies:
    """Spheres in the order of their ids, classes, and the reservoir of every triangle."""

    ids: Floats
    kind: Floats
    mass: Floats
    film: Floats
    names: dict[int, str]
    density: float
    reservoir: Floats
    """Row of `walls` for each triangle."""
    walls: list[str]

    @classmethod
    def of(cls, folder: Path, scene: Mapping[str, Any], row_of: Callable[[Mapping[str, Any]], str]) -> Bodies:
        """Read the bodies from scene.json and the start; `row_of`: name under which a wall's liquid is counted."""
        spheres = io.columns(folder / "history" / "spheres.parquet", ["id", "type", "film"]).sort_values("id")
        kind = spheres["type"].to_numpy(int)
        mass = io.masses(scene)
        if not set(kind) <= set(mass):
            raise ReplayError(f"{folder}: history/spheres.parquet has types that scene.json does not have; expected both of one "
                              "run: run the case again")  # fmt: skip
        rows = list(dict.fromkeys(row_of(w) for w in scene["walls"]))
        counts = [len(w["triangle_part"]) for w in scene["walls"]]
        reservoir = np.repeat([rows.index(row_of(w)) for w in scene["walls"]], counts).astype(int)
        liquid = scene["liquid"]
        return cls(
            spheres["id"].to_numpy(int), kind, np.array([mass[k] for k in kind]), spheres["film"].to_numpy(float),
            {c["type"]: c["name"] for c in scene["classes"]}, liquid["density_kg_per_m3"] if liquid else 0.0, reservoir, rows,
        )  # fmt: skip

    def counts(self, those: Floats) -> dict[str, int]:
        """Return the number of spheres of each class among those marked."""
        return {name: int((those & (self.kind == kind)).sum()) for kind, name in self.names.items()}

    def at(self, ids: Floats, path: Path) -> Floats:
        """Return the index of each id; an id that does not exist at the start is refused."""
        found = np.minimum(np.searchsorted(self.ids, ids), len(self.ids) - 1)
        if not np.array_equal(self.ids[found], ids):
            raise ReplayError(f"{path} names spheres that history/spheres.parquet does not have; expected those of the start: "
                              "run the case again")  # fmt: skip
        return found


@dataclass
class Output:
    """One output: rows of the trajectory and their indices at the start, spheres in the box, and the liquid [m3]."""

    step: int
    places: Columns
    at: Floats
    here: Floats
    on: Floats
    """Liquid of every sphere."""
    walls: Floats
    """Liquid on every row of walls."""
    in_bridges: float
    """Liquid in active bridges, whose number is `bridges`."""
    bridges: int
    left: float
    waits: Floats
    """Whether a sphere has not entered."""


@dataclass
class Recomputed:
    """Result tables as recomputed from the logs."""

    tables: dict[str, pd.DataFrame]
    """Name in results/ -> table."""
    liquid: pd.DataFrame
    """Table with the distribution of liquid."""
    checks: dict[str, float]
    """Name of a check -> its value."""
    limits: dict[str, float]
    printed: list[int]
    """Numbers in the sentence on lost spheres."""
    more: dict[str, tuple[Any, str]]
    """Further entries of the summary, and their sources."""
    ends: dict[str, float] | None
    """Contacts at the end, if the summary has them."""
    mass: float
    initial: float
    counts: dict[str, int]


def slug(name: str) -> str:
    """Convert a class name to a part of a column's name."""
    return re.sub("[^a-z0-9]+", "_", name.lower()).strip("_")


def outputs(folder: Path, scene: Mapping[str, Any], of: Bodies, columns: Sequence[str]) -> Iterator[Output]:
    """Yield every output of a run once; `columns` of the trajectory in addition to step and id."""
    moist, path = bool(scene["effects"]["bridges"]), where(folder, "trajectory")
    logs = {name: Rows(where(folder, name), name, LOGS[name]) for name in (LOGS if moist else ())}
    trajectory, steps = Rows(path, "trajectory", ["step", "id", *columns]), plans.plan(folder).outputs
    left, start = np.zeros(len(steps)), enters(dict(scene), of.kind)
    if moist:
        ledger = io.table(where(folder, "ledger"), "ledger").drop_duplicates("step", keep="last").set_index("step")
        left = ledger["left"].reindex(steps).fillna(0.0).to_numpy()
    for step, gone in zip(steps.tolist(), left.tolist(), strict=True):
        places = trajectory.columns(step)
        at, here = of.at(places["id"], path), np.zeros(len(of.ids), bool)
        here[at] = True
        dry = (of.film, np.zeros(len(of.walls)), 0.0, 0)
        on, walls, in_bridges, bridges = _liquid(folder, of, logs, step) if moist else dry
        yield Output(step, places, at, here, on, walls, in_bridges, bridges, gone, step < start)


def _liquid(folder: Path, of: Bodies, logs: Mapping[str, Rows], step: int) -> tuple[Floats, Floats, float, int]:
    """Return for one output the liquid [m3] of every sphere, of every row of walls and in active bridges, and their number."""
    films, b, wet = (logs[name].columns(step) for name in ("films", "bridges", "wall_films"))
    n, pair = len(of.ids), b["partner_kind"] == PAIR
    volume, share = b["volume"], b["share_i"]
    path = where(folder, "bridges")
    on = np.bincount(of.at(films["id"], where(folder, "films")), films["film"], n)
    on += np.bincount(of.at(b["i"], path), share, n)
    on += np.bincount(of.at(b["j"][pair], path), (volume - share)[pair], n)
    triangle = np.concatenate([wet["triangle"], b["triangle"][~pair]]).astype(int)
    if len(triangle) and not 0 <= triangle.min() <= triangle.max() < len(of.reservoir):
        raise ReplayError(f"{folder}: liquid is on triangles that scene.json does not have; expected those of its walls: "
                          "run the case again")  # fmt: skip
    amount = np.concatenate([wet["film"], (volume - share)[~pair]])
    return on, np.bincount(of.reservoir[triangle], amount, len(of.walls)), float(volume.sum()), len(b)


def accounted(liquid: pd.DataFrame, initial: float) -> float:
    """Return the relative difference between the liquid of all reservoirs and the liquid inserted until then."""
    return float((liquid["total_m3"] - liquid["initial_m3"]).abs().max()) / initial if initial > 0.0 else 0.0


ALL_THERE = 1e-12
"""Limit of the check that all liquid is accounted for."""
