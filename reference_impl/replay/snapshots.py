"""Bridges that formed too early or not at all, and the snapshots of films and bridges at every output against the events.

A missed formation is looked for where positions are known: between spheres, at the output steps of trajectory.parquet and in the
windows that record motion, there at every step at which bridges act. So none is later than the steps between those.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from reference_impl.motion import impulses
from reference_impl.replay import laws
from reference_impl.replay.bodies import bodies, pairs, shapes
from reference_impl.replay.compare import Floats, Quantity, compare
from reference_impl.replay.io import Run, where
from reference_impl.replay.lives import FORMATION, Lives, keys
from reference_impl.replay.transfer import Tables

ROOM = 1e-9
"""Part of the radius by which films may miss each other: a gap is a difference of positions."""
SMALLEST = 1e-12
"""V* below which nothing forms, by definition of the model's numerical zero."""
NONE = pd.DataFrame({"step": np.zeros(0, np.int64), "i": np.zeros(0, np.int64), "j": np.zeros(0, np.int64),
                     "separation": np.zeros(0), "films": np.zeros(0), "missed": np.zeros(0, dtype=bool)})  # fmt: skip
"""No pairs."""


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


def formation_missed(run: Run, lives: Lives, film: Floats) -> Quantity:
    """Spheres whose films touch at an output step, or where bridges act in a window, have a bridge."""
    table = touching_pairs(run, lives, film)
    missed, zero = table["missed"].to_numpy(float), np.zeros(len(table))
    return compare("formation_missed", "films that touch without a bridge", missed, zero, zero + 1.0, table, 0.0)


def touching_pairs(run: Run, lives: Lives, film: Floats) -> pd.DataFrame:
    """Spheres whose films touch and whether their bridge is missing; not those with an event in that step.

    `film`: what each sphere holds by the log before its first event here.
    """
    table = pd.concat([_at_outputs(run), _in_windows(run, lives, film)], ignore_index=True)
    if not len(table):
        return table
    step = table["step"]
    # drops come after the formations of their step
    moved = np.concatenate([_place(log["step"], log[s]) for log in (run.table("events"), run.shed) for s in "ij"])
    busy = [np.isin(_place(step, table[s]), moved) for s in "ij"]
    return table[~(busy[0] | busy[1])].reset_index(drop=True)


def _at_outputs(run: Run) -> pd.DataFrame:
    """Pairs that touch at the output steps, and whether they are missing in the snapshot of bridges."""
    if not where(run.folder, "trajectory").exists():
        return NONE
    places = run.table("trajectory")[["step", "id", "x", "y", "z"]]
    table = _all_touching(run, places[places["step"] > 0].merge(run.table("films"), on=["step", "id"]))
    bridges, step = run.table("bridges"), table["step"].to_numpy()
    spheres, missed = bridges[bridges["partner_kind"] == laws.SPHERE], np.ones(len(table), dtype=bool)
    for at in np.unique(step):
        rows, there = step == at, spheres[spheres["step"].to_numpy() == at]
        missed[rows] = ~np.isin(_place(table["i"][rows], table["j"][rows]), _place(there["i"], there["j"]))
    return table.assign(missed=missed)


def _in_windows(run: Run, lives: Lives, film: Floats) -> pd.DataFrame:
    """The same at the windows' steps at which bridges act, with films and bridges by the event log."""
    if len(run.shed) or not where(run.folder, "window_states").exists():  # drops change films between events
        return NONE
    places, events = run.table("window_states")[["step", "id", "x", "y", "z"]], run.table("events")
    places = places[(places["step"] > 0) & (places["step"] % impulses.every(run) == 0)]
    film, done, parts = film.copy(), 0, []
    for step in np.unique(places["step"].to_numpy()):
        rows = places[places["step"] == step]
        until = int(np.searchsorted(events["step"].to_numpy(), step, "right"))
        keep_films(film, events.iloc[done:until], run)
        done = until
        parts.append(rows.assign(film=np.maximum(film[rows["id"].to_numpy(np.int64)], 0.0)))
    table = _all_touching(run, pd.concat(parts)) if parts else NONE
    at = lives.at(keys(table.assign(partner_kind=laws.SPHERE)), table["step"].to_numpy(np.int64), strictly=False)
    return table.assign(missed=at < 0)


def keep_films(film: Floats, events: pd.DataFrame, run: Run) -> None:
    """Have in `film` what the spheres hold after some events by the log."""
    p = pairs(events, bodies(run))
    film[np.stack([p.i, p.sphere_j], axis=1).ravel()] = events[["film_i_after", "film_j_after"]].to_numpy().ravel()


def _all_touching(run: Run, films: pd.DataFrame) -> pd.DataFrame:
    """Pairs that touch in each step of a table of places and films."""
    radius = bodies(run).radius[films["id"].to_numpy(np.int64)]
    films = films.assign(radius=radius, reach=radius + thickness(films["film"].to_numpy(float), radius))
    close = [found for _, rows in films.groupby("step") if len(found := _touching(rows))]
    return pd.concat(close, ignore_index=True) if close else NONE


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


def check(run: Run, tables: Tables, lives: Lives, outputs: Floats, shots: Floats, film: Floats) -> list[Quantity]:
    """All of these, of a part of the log before which the spheres held `film` by the log."""
    return [
        formation_due(run),
        formation_missed(run, lives, film),
        *films_at_outputs(run, outputs, shots),
        *standing_at_outputs(run, tables, lives),
    ]
