"""Bridges that formed too early or not at all, and the snapshots of films and bridges at every output against the events.

A missed formation is looked for where positions are known: between spheres, at the output steps of trajectory.parquet.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from reference_impl import laws
from reference_impl.bodies import bodies, pairs, shapes
from reference_impl.compare import Floats, Quantity, compare
from reference_impl.io import Run, where
from reference_impl.lives import FORMATION, Lives, keys
from reference_impl.transfer import Tables

ROOM = 1e-9
"""Part of the radius by which films may miss each other: a gap is a difference of positions."""
SMALLEST = 1e-12
"""V* below which nothing forms, by definition of the model's numerical zero."""


def thickness(film: Floats, radius: Floats) -> Floats:
    """Of the film on a sphere: (3 L/(4 pi) + r^3)^(1/3) - r (E 34)."""
    return np.asarray(radius * np.expm1(np.log1p(3.0 * film / (4.0 * np.pi * radius**3)) / 3.0))


def films_at_events(run: Run) -> tuple[Floats, Floats, Floats]:
    """Sum of both films' thicknesses before each event, the separation, and the radius of i."""
    fixed, events = bodies(run), run.table("events")
    p = pairs(events, fixed)
    area = np.where(p.wall, fixed.area[np.where(p.wall, events["triangle"], -1)], 1.0)
    i, j = (np.maximum(events[f"film_{s}_before"].to_numpy(float), 0.0) for s in "ij")
    films = thickness(i, p.ri) + np.where(p.wall, j / area, thickness(j, p.rj))
    return films, events["separation"].to_numpy(float), p.ri


def formation_due(run: Run) -> Quantity:
    """A bridge forms only where the films touch, S < h_i + h_j."""
    films, gap, ri = films_at_events(run)
    events = run.table("events")
    early = ((events["kind"] == FORMATION) & (gap > films + ROOM * ri)).to_numpy(float)
    zero = np.zeros(len(early))
    return compare("formation_due", "formations before the films touch", early, zero, zero + 1.0, events, 0.0)


def formation_missed(run: Run) -> Quantity:
    """Spheres whose films touch at an output step have a bridge."""
    table = touching_pairs(run)
    missed, zero = table["missed"].to_numpy(float), np.zeros(len(table))
    return compare("formation_missed", "films that touch without a bridge", missed, zero, zero + 1.0, table, 0.0)


def touching_pairs(run: Run) -> pd.DataFrame:
    """Spheres whose films touch at an output step and whether their bridge is missing; not those with an event in that step."""
    none = pd.DataFrame({name: np.zeros(0) for name in ("step", "i", "j", "separation", "films", "missed")})
    if not where(run.folder, "trajectory").exists():
        return none
    logged, fixed = run.table("films"), bodies(run)
    places = run.table("trajectory")[["step", "id", "x", "y", "z"]]
    films = places[places["step"] > 0].merge(logged, on=["step", "id"])
    films["radius"] = fixed.radius[films["id"].to_numpy()]
    films["reach"] = films["radius"] + thickness(films["film"].to_numpy(float), films["radius"].to_numpy(float))
    close = [found for _, rows in films.groupby("step") if len(found := _touching(rows))]
    if not close:
        return none
    table = pd.concat(close, ignore_index=True)
    bridges, events, step = run.table("bridges"), run.table("events"), table["step"].to_numpy()
    spheres = bridges[bridges["partner_kind"] == laws.SPHERE]
    moved = np.concatenate([_place(events["step"], events[s]) for s in "ij"])
    busy = [np.isin(_place(step, table[s]), moved) for s in "ij"]
    table, step = table[~(busy[0] | busy[1])].reset_index(drop=True), step[~(busy[0] | busy[1])]
    missed = np.ones(len(table), dtype=bool)
    for at in np.unique(step):
        rows, there = step == at, spheres[spheres["step"].to_numpy() == at]
        missed[rows] = ~np.isin(_place(table["i"][rows], table["j"][rows]), _place(there["i"], there["j"]))
    return table.assign(missed=missed)


def _place(step: Any, number: Any) -> Floats:
    """Two numbers as one."""
    return (np.asarray(step, np.int64) << 31) | np.asarray(number, np.int64)


def _touching(rows: pd.DataFrame) -> pd.DataFrame:
    """Pairs of spheres of one step whose films overlap and hold something."""
    at, reach = rows[["x", "y", "z"]].to_numpy(), rows["reach"].to_numpy()
    near = cKDTree(at).query_pairs(2.0 * float(reach.max()), output_type="ndarray")
    near = near if len(near) else np.zeros((0, 2), dtype=int)
    ids, film, radius = (rows[n].to_numpy() for n in ("id", "film", "radius"))
    first = np.where(ids[near[:, 0]] < ids[near[:, 1]], near[:, 0], near[:, 1])
    second = near.sum(axis=1) - first
    distance = np.sqrt(((at[first] - at[second]) ** 2).sum(axis=1))
    # the dump of positions holds about six digits
    touch = distance < reach[first] + reach[second] - 1e-4 * radius[first]
    drawn = given(film[first], radius[first], radius[second]) + given(film[second], radius[second], radius[first])
    r = laws.harmonic_radius(radius[first], radius[second], np.zeros(len(first), dtype=bool))
    keep = touch & (drawn > SMALLEST * r**3)
    step = int(rows["step"].iloc[0])
    gap, films = distance - radius[first] - radius[second], (reach - radius)[first] + (reach - radius)[second]
    named = {"i": ids[first], "j": ids[second], "separation": gap, "films": films}
    return pd.DataFrame({"step": step, **{name: values[keep] for name, values in named.items()}})


def given(film: Floats, ri: Floats, rj: Floats) -> Floats:
    """Liquid that sphere i gives to a bridge with sphere j (E 8)."""
    return np.asarray(film / 2.0 * (1.0 - np.sqrt(1.0 - (rj / (ri + rj)) ** 2)))


def standing_at_outputs(run: Run, tables: Tables, lives: Lives) -> list[Quantity]:
    """Volumes and shares of the bridges at every output."""
    bridges, fixed = run.table("bridges"), bodies(run)
    at = lives.at(keys(bridges), bridges["step"].to_numpy(np.int64), strictly=False)
    volume = np.append(lives.all.own, np.nan)[at]
    share = volume * tables.ratios(*shapes(pairs(bridges, fixed), volume, fixed))
    logged_volume, logged_share = (bridges[name].to_numpy(float) for name in ("volume", "share_i"))
    return [
        compare("snapshot_volume", "itself", logged_volume, volume, volume, bridges),
        compare("snapshot_share", "volume of the bridge", logged_share, share, volume, bridges),
    ]


def films_at_outputs(run: Run, outputs: Floats, shots: Floats) -> list[Quantity]:
    """Films of spheres and walls at every output; `shots`: all liquid at the output steps by holder."""
    fixed, found = bodies(run), []
    for name, number, first in (("films", "id", 0), ("wall_films", "triangle", fixed.walls_from)):
        table = run.table(name)
        mine = shots[np.searchsorted(outputs, table["step"].to_numpy()), first + table[number].to_numpy()]
        size = np.full(len(table), float(run.table("spheres")["film"].mean()))
        logged = table["film"].to_numpy(float)
        found.append(compare(f"snapshot_{name}", "mean film of a sphere", logged, mine, size, table))
    return found


def check(run: Run, tables: Tables, lives: Lives, outputs: Floats, shots: Floats) -> list[Quantity]:
    """All of these, of a part of the log."""
    return [
        formation_due(run),
        formation_missed(run),
        *films_at_outputs(run, outputs, shots),
        *standing_at_outputs(run, tables, lives),
    ]
