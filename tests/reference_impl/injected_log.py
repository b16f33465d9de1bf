"""Faults injected in the log of a sound run: what was written is changed, the run itself was right.

Each entry changes the tables (or what meta.json claims) and says which link must break and by which words it must be named.
"""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.cases.small import small
from reference_impl.replay import io
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of

R = 2.5e-3
Tables = dict[str, Any]


@dataclass(frozen=True)
class Injected:
    """A change of the tables (`meta` among them), the quantity it shows in, and its name."""

    change: Callable[[Tables], None]
    quantity: str
    words: str


def heap(folder: Path) -> Path:
    """Twelve wet spheres of two sizes falling on a floor, every step logged."""
    generator = np.random.default_rng(3)
    at = [(0.0052 * i, 0.0052 * j, 0.003 + 0.0052 * k) for i in (-1, 0, 1) for j in (-1, 0) for k in (0, 1)]
    spheres = [
        small.Sphere(1 + n % 2, p, tuple(generator.normal(0, 0.15, 3)), tuple(generator.normal(0, 20, 3)))
        for n, p in enumerate(at)
    ]
    small.prepare(
        folder,
        spheres_of(R, 2e-3),
        spheres,
        contacts(2, stiffness=1e4),
        liquid=WATER,
        effects=small.PAPER,
        walls=[small.floor()],
        wall_angle_rad=math.radians(45.0),
        time_step_s=2e-5,
        steps=3000,
        output_interval_s=1e-3,
        gravity=(0.0, 0.0, -9.81),
    )
    small.run(folder, spheres)
    return folder


def plant(sound: Path, folder: Path, injected: Injected) -> Path:
    """A copy of a run with one fault in its history."""
    shutil.copytree(sound, folder, dirs_exist_ok=True)
    meta = folder / "history" / "meta.json"
    names = (*io.TABLES, *io.WALL_TABLES)
    tables: Tables = {t: pd.read_parquet(folder / "history" / f"{t}.parquet") for t in names}
    tables["meta"] = json.loads(meta.read_text())
    injected.change(tables)
    meta.write_text(json.dumps(tables.pop("meta")))
    for name, frame in tables.items():
        frame.to_parquet(folder / "history" / f"{name}.parquet", index=False)
    return folder


def scaled(table: str, columns: list[str], factor: float) -> Callable[[Tables], None]:
    """Some columns times a factor."""

    def change(tables: Tables) -> None:
        for column in columns:
            tables[table][column] *= factor

    return change


def vector(name: str) -> list[str]:
    """The columns of a vector."""
    return [f"{name}_{axis}" for axis in "xyz"]


def claim(key: str, factor: float) -> Callable[[Tables], None]:
    """Another constant than the engine computed with."""

    def change(tables: Tables) -> None:
        tables["meta"][key] *= factor

    return change


def law(effect: str, name: str) -> Callable[[Tables], None]:
    """Another law than the engine computed with."""

    def change(tables: Tables) -> None:
        tables["meta"]["effects"][effect] = name

    return change


def drop(kind: int, which: int) -> Callable[[Tables], None]:
    """One event is not in the log."""

    def change(tables: Tables) -> None:
        events = tables["events"]
        tables["events"] = events.drop(events.index[events["kind"] == kind][which]).reset_index(drop=True)

    return change


def double(tables: Tables) -> None:
    """One event is in the log twice."""
    events = tables["events"]
    row = int(events.index[events["kind"] == 1][1])
    parts = [events.iloc[: row + 1], events.iloc[row : row + 1], events.iloc[row + 1 :]]
    tables["events"] = pd.concat(parts, ignore_index=True)


def swap(tables: Tables) -> None:
    """The shares of one rupture between unequal spheres are exchanged."""
    events = tables["events"]
    unequal = (events["kind"] == 1) & (np.abs(events["share_i"] - events["share_j"]) > 1e-3 * events["volume"])
    row = events.index[unequal][0]
    i, j = float(events.loc[row, "share_i"]), float(events.loc[row, "share_j"])
    events.loc[row, ["share_i", "share_j"]] = [j, i]


def twice(tables: Tables) -> None:
    """One formation draws twice what it should."""
    events = tables["events"]
    row = events.index[events["kind"] == 0][3]
    events.loc[row, ["volume", "share_i", "share_j"]] *= 2.0


def one(table: str, column: str, row: int, factor: float, kind: int | None = None) -> Callable[[Tables], None]:
    """One value times a factor."""

    def change(tables: Tables) -> None:
        frame = tables[table]
        index = frame.index if kind is None else frame.index[frame["kind"] == kind]
        frame.loc[index[row], column] *= factor

    return change


def moved(tables: Tables) -> None:
    """A sphere is logged far beyond the rupture distance of an active bridge."""
    frame = tables["contacts"]
    row = frame.index[frame["partner_kind"] == 1][-1]
    frame.loc[row, "xi_z"] = frame.loc[row, "xj_z"] + 2.0 * R + frame.loc[row, "rupture_distance"]


def turned_spin(tables: Tables) -> None:
    """Spins are logged with the other sign."""
    scaled("contacts", [*vector("wi"), *vector("wj")], -1.0)(tables)


FAULTS: dict[str, Injected] = {
    "capillary force halved": Injected(scaled("contacts", ["capillary"], 0.5), "capillary", "half of it counts"),
    "force as it acts, a millionth off": Injected(
        scaled("contacts", ["viscous_normal"], 1.0 + 1e-6), "viscous_normal", "it is 1 + 1e-06 times"
    ),
    "torque a tenth too large": Injected(scaled("contacts", vector("torque_i"), 1.1), "torque_i", "it is 1.1 times"),
    "torque on j left out": Injected(scaled("contacts", vector("torque_j"), 0.0), "torque_j", "it is left out"),
    "tangential force turned": Injected(
        scaled("contacts", vector("viscous_tangential"), -1.0), "viscous_tangential", "the sign is turned"
    ),
    "total force in mN": Injected(scaled("contacts", vector("force_i"), 1e3), "force", "it is 1000 times too large"),
    "rupture limit 2 % short": Injected(
        scaled("contacts", ["rupture_distance"], 0.98), "rupture_limit", "it is 0.98 times"
    ),
    "gap in mm": Injected(scaled("contacts", ["separation"], 1e3), "separation", "it is 1000 times too large"),
    "spins with the other sign": Injected(turned_spin, "viscous_tangential", "the sign of the spin is turned"),
    "volume of a contact a bit off": Injected(
        one("contacts", "volume", -1, 1.0 + 2.3e-16), "contact_volume", "single values are wrong"
    ),
    "position far beyond the limit": Injected(moved, "separation", "single values are wrong"),
    "viscosity doubled in the claims": Injected(claim("viscosity", 2.0), "viscous_law", "the viscosity is 0.5 times"),
    "surface tension 5 % off in the claims": Injected(
        claim("surface_tension", 1.05), "capillary", "the surface tension is 0.952381 times"
    ),
    "lambert in place of rabinovich": Injected(
        law("capillary", "lambert"), "capillary", "the law is rabinovich, not lambert"
    ),
    "lian in place of goldman": Injected(
        law("viscous_tangential", "lian"), "viscous_tangential", "the law is goldman, not lian"
    ),
    "lian's rupture distance": Injected(
        law("rupture", "lian"), "rupture_distance", "the law is willett_unequal, not lian"
    ),
    "a formation dropped": Injected(drop(0, 2), "bridge_life", "a formation is missing from the log"),
    "a rupture dropped": Injected(drop(1, 2), "bridge_life", "a rupture is missing from the log"),
    "an event doubled": Injected(double, "bridge_life", "an event is in the log twice"),
    "shares swapped": Injected(swap, "share_i", "the transfer ratio is swapped"),
    "volume drawn twice": Injected(twice, "share_i", "the volume is drawn twice"),
    "rupture at half its distance": Injected(
        one("events", "separation", 0, 0.5, kind=1), "rupture_due", "it is made too early"
    ),
    "film after one event wrong": Injected(
        one("events", "film_i_after", 5, 1.001), "film_after", "single values are wrong"
    ),
    "film in the last snapshot wrong": Injected(
        one("films", "film", -1, 1.0 + 1e-6), "snapshot_films", "single values are wrong"
    ),
    "liquid leaks from the ledger": Injected(one("ledger", "films", -1, 1.0 - 1e-10), "ledger", "mm³ are lost"),
    "transfer table 1 % off": Injected(scaled("transfer", ["transfer_i"], 0.99), "transfer_table", "it is 0.99 times"),
}
