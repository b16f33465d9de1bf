"""Bridges that formed too early, too late or not at all, between spheres and at walls.

Too late: how fast both sides came is logged with a formation, so where they were one look before is known, and whether the films
touched then; of every formation of the run. Not at all: where places are known, that is at the output steps of trajectory.parquet
and in the windows that record motion, there at every step at which bridges act.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from reference_impl.motion import impulses, nearest
from reference_impl.motion.window import slide_steps
from reference_impl.replay import io, laws
from reference_impl.replay.bodies import bodies, holders, pairs
from reference_impl.replay.compare import Floats, Quantity, compare
from reference_impl.replay.io import Run, where
from reference_impl.replay.lives import FORMATION, Lives, keys

ROOM = 1e-9
"""Part of the radius by which films may miss each other: a gap is a difference of positions."""
ROOM_OF_WAY = 1.02, 1e-5
"""A way in one step may be longer than logged by this factor and this part of the radius: speeds change within a step."""
SMALLEST = 1e-12
"""V* below which nothing forms, by definition of the model's numerical zero."""
COLUMNS = {"step": np.int64, "partner_kind": np.int64, "i": np.int64, "j": np.int64, "triangle": np.int64,
           "separation": float, "films": float, "own_film": float}  # fmt: skip
NONE = pd.DataFrame({name: np.zeros(0, kind) for name, kind in COLUMNS.items()})
"""No pairs; `films`: of both sides together, `own_film`: of i alone [m]."""


def thickness(film: Floats, radius: Floats) -> Floats:
    """Of the film on a sphere: (3 L/(4 pi) + r^3)^(1/3) - r (E 34)."""
    return np.asarray(radius * np.expm1(np.log1p(3.0 * film / (4.0 * np.pi * radius**3)) / 3.0))


class Held:
    """What every holder has by the log before a part of it, and the step in which that last changed."""

    def __init__(self, run: Run) -> None:
        self.film = bodies(run).liquid()
        self.changed = np.full(len(self.film), -1, np.int64)

    def keep(self, run: Run) -> None:
        """A part of the log has been gone through."""
        fixed, events = bodies(run), run.table("events")
        both = np.stack(holders(events, pairs(events, fixed), fixed), axis=1).ravel()
        keep_films(self.film, events, run)
        np.maximum.at(self.changed, both, np.repeat(events["step"].to_numpy(np.int64), 2))


def keep_films(film: Floats, events: pd.DataFrame, run: Run) -> None:
    """Have in `film` what all holders have after some events by the log."""
    fixed = bodies(run)
    both = np.stack(holders(events, pairs(events, fixed), fixed), axis=1).ravel()
    film[both] = events[["film_i_after", "film_j_after"]].to_numpy().ravel()


def films_at_events(run: Run) -> tuple[Floats, Floats, Floats, Floats]:
    """Thicknesses of both films before each event, the separation, and the radius of i."""
    fixed, events = bodies(run), run.table("events")
    p = pairs(events, fixed)
    area = np.where(p.wall, fixed.area[np.where(p.wall, events["triangle"], -1)], 1.0)
    i, j = (np.maximum(events[f"film_{s}_before"].to_numpy(float), 0.0) for s in "ij")
    return (
        thickness(i, p.ri),
        np.where(p.wall, j / area, thickness(j, p.rj)),
        events["separation"].to_numpy(float),
        p.ri,
    )


def due(run: Run) -> Quantity:
    """A bridge forms only where the films touch, S < h_i + h_j."""
    own, other, gap, ri = films_at_events(run)
    events = run.table("events")
    early = ((events["kind"] == FORMATION) & (gap > own + other + ROOM * ri)).to_numpy(float)
    zero = np.zeros(len(early))
    return compare("formation_due", "formations before the films touch", early, zero, zero + 1.0, events, 0.0)


def lateness(run: Run, held: Held) -> tuple[Floats, Floats]:
    """By how much the films of each formation overlapped one look before at least [m], and the way since then.

    Zero where a film changed since, where all is new (step 0) and where the engine was set up anew.
    """
    fixed, events, every = bodies(run), run.table("events"), impulses.every(run)
    own, other, gap, ri = films_at_events(run)
    step = events["step"].to_numpy(np.int64)
    way = every * float(run.meta["time_step"]) * events["speed"].to_numpy(float) * ROOM_OF_WAY[0]
    # speeds are known at one of several steps
    way = way * (1.0 if every == 1 else 2.0) + (ROOM_OF_WAY[1] if every == 1 else 1e-3) * ri + _turned(run, ri)
    sides = holders(events, pairs(events, fixed), fixed)
    since = np.maximum(*(_changed(run, held, side, step) for side in sides))
    judged = (events["kind"] == FORMATION).to_numpy() & (step > 0) & (since < step - every) & ~np.isin(step, _anew(run))
    return np.where(judged, np.maximum(own + other - gap - way, 0.0), 0.0), way


def _turned(run: Run, ri: Floats) -> Floats:
    """How far a turning wall's points around a closest point part from it in a look [m]."""
    rotation = io.scene(run.folder).get("rotation")
    rate = 2.0 * np.pi / abs(rotation["period_s"]) if rotation else 0.0
    return np.asarray(2.0 * rate * ri * impulses.every(run) * float(run.meta["time_step"]))


def _anew(run: Run) -> Floats:
    """Steps at which the engine is set up anew, with speeds of the step in place of those half a step back."""
    scene = io.scene(run.folder)
    return np.array(slide_steps(scene, scene["time_step_s"], round(scene["duration_s"] / scene["time_step_s"])), int)


def _changed(run: Run, held: Held, holder: Floats, step: Floats) -> Floats:
    """The last step before each event in which its holder's liquid changed, -1 for none."""
    fixed, events, shed = bodies(run), run.table("events"), run.shed
    walls = np.where(shed["partner_kind"] == laws.SPHERE, 0, fixed.walls_from)
    of_drops = [shed["i"].to_numpy(np.int64), np.maximum(shed["j"].to_numpy(np.int64), 0) + walls]
    sides = holders(events, pairs(events, fixed), fixed)
    all_changes = _place(np.concatenate([step, step, *2 * [shed["step"].to_numpy(np.int64)]]),
                         np.concatenate([*sides, *of_drops]), holder_first=True)  # fmt: skip
    sorted_changes = np.append(np.sort(all_changes), np.iinfo(np.int64).max)
    at = np.searchsorted(sorted_changes, _place(step, holder, holder_first=True), "left") - 1
    before = sorted_changes[at]
    here = (at >= 0) & (before >> 32 == holder)
    return np.where(here, before & 0xFFFFFFFF, held.changed[holder])


def late(run: Run, held: Held) -> Quantity:
    """A bridge forms at the first look at which the films touch."""
    excess, _ = lateness(run, held)
    events = run.table("events")
    return compare("formation_late", "radius", excess, np.zeros(len(excess)), bodies(run).radius[events["i"]], events)


def check(run: Run, lives: Lives, held: Held) -> list[Quantity]:
    """All of these, of a part of the log before which the holders were as in `held`."""
    return [due(run), late(run, held), missed(run, lives, held)]


def missed(run: Run, lives: Lives, held: Held) -> Quantity:
    """Where films touch, at an output step or where bridges act in a window, there is a bridge."""
    table = touching(run, lives, held)
    lacking, zero = table["missed"].to_numpy(float), np.zeros(len(table))
    return compare("formation_missed", "films that touch without a bridge", lacking, zero, zero + 1.0, table, 0.0)


def touching(run: Run, lives: Lives, held: Held) -> pd.DataFrame:
    """Pairs whose films touch and whether their bridge is missing; not those with an event in that step."""
    table = pd.concat([_at_outputs(run), _in_windows(run, lives, held)], ignore_index=True)
    if not len(table):
        return table
    step, wall = table["step"], table["partner_kind"] != laws.SPHERE
    fixed, events, shed = bodies(run), run.table("events"), run.shed
    # drops come after the formations of their step
    moved = np.concatenate(
        [_place(events["step"], h) for h in holders(events, pairs(events, fixed), fixed)]
        + [_place(shed["step"], np.maximum(shed[s], 0) + n * fixed.walls_from) for s in "ij" for n in (0, 1)]
    )
    sides = table["i"], np.where(wall, fixed.walls_from + table["triangle"], table["j"])
    busy = [np.isin(_place(step, side), moved) for side in sides]
    return table[~(busy[0] | busy[1])].reset_index(drop=True)


def _at_outputs(run: Run) -> pd.DataFrame:
    """Pairs that touch at the output steps, and whether they are missing in the snapshot of bridges."""
    if not where(run.folder, "trajectory").exists():
        return NONE.assign(missed=False)
    places = run.table("trajectory")[["step", "id", "x", "y", "z"]]
    walls, found = run.table("wall_films"), []
    for step, rows in places[places["step"] > 0].merge(run.table("films"), on=["step", "id"]).groupby("step"):
        at, film = walls[walls["step"] == step], np.zeros(len(bodies(run).area))
        film[at["triangle"].to_numpy(np.int64)] = at["film"].to_numpy(float)
        found.append(_touching(run, rows, film))
    table = pd.concat([NONE, *found], ignore_index=True)
    bridges, step = run.table("bridges"), table["step"].to_numpy()
    lacking = np.ones(len(table), dtype=bool)
    for at in np.unique(step):
        rows = step == at
        lacking[rows] = ~np.isin(keys(table[rows]), keys(bridges[bridges["step"].to_numpy() == at]))
    return table.assign(missed=lacking)


def _in_windows(run: Run, lives: Lives, held: Held) -> pd.DataFrame:
    """The same at the windows' steps at which bridges act, with films and bridges by the event log."""
    if len(run.shed) or not where(run.folder, "window_states").exists():  # drops change films between events
        return NONE.assign(missed=False)
    places, events, fixed = run.table("window_states")[["step", "id", "x", "y", "z"]], run.table("events"), bodies(run)
    places = places[(places["step"] > 0) & (places["step"] % impulses.every(run) == 0)]
    film, done, found = held.film.copy(), 0, []
    for step, rows in places.groupby("step"):
        until = int(np.searchsorted(events["step"].to_numpy(), step, "right"))
        keep_films(film, events.iloc[done:until], run)
        done, there = until, np.maximum(film, 0.0)
        rows = rows.assign(film=there[rows["id"].to_numpy(np.int64)])
        found.append(_touching(run, rows, there[fixed.walls_from :]))
    table = pd.concat([NONE, *found], ignore_index=True)
    at = lives.at(keys(table), table["step"].to_numpy(np.int64), strictly=False)
    return table.assign(missed=at < 0)


def _place(step: Any, number: Any, holder_first: bool = False) -> Floats:
    """Two numbers as one."""
    step, number = np.asarray(step, np.int64), np.asarray(number, np.int64)
    return (number << 32) | step if holder_first else (step << 31) | number


def _touching(run: Run, rows: pd.DataFrame, walls: Floats) -> pd.DataFrame:
    """Pairs of one step whose films overlap and hold something; `walls`: films of all triangles."""
    radius = bodies(run).radius[rows["id"].to_numpy(np.int64)]
    rows = rows.assign(radius=radius, reach=radius + thickness(rows["film"].to_numpy(float), radius))
    parts = [_of_spheres(rows)]
    if len(bodies(run).area) > 1 and io.scene(run.folder)["effects"].get("wall_films", True):
        parts.append(_at_walls(run, rows, walls))
    return pd.concat(parts, ignore_index=True) if len(parts) > 1 else parts[0]


def _of_spheres(rows: pd.DataFrame) -> pd.DataFrame:
    at, reach = rows[["x", "y", "z"]].to_numpy(), rows["reach"].to_numpy()
    near = cKDTree(at).query_pairs(2.0 * float(reach.max()), output_type="ndarray")
    near = near if len(near) else np.zeros((0, 2), dtype=int)
    ids, film, radius = (rows[n].to_numpy() for n in ("id", "film", "radius"))
    first = np.where(ids[near[:, 0]] < ids[near[:, 1]], near[:, 0], near[:, 1])
    second = near.sum(axis=1) - first
    distance = np.sqrt(((at[first] - at[second]) ** 2).sum(axis=1))
    touch = distance < reach[first] + reach[second] - ROOM * radius[first]
    drawn = given(film[first], radius[first], radius[second]) + given(film[second], radius[second], radius[first])
    r = laws.harmonic_radius(radius[first], radius[second], np.zeros(len(first), dtype=bool))
    keep = touch & (drawn > SMALLEST * r**3)
    gap, films = distance - radius[first] - radius[second], (reach - radius)[first] + (reach - radius)[second]
    own = (reach - radius)[first]
    return _table(rows, 0 * first, ids[first], ids[second], 0 * first - 1, gap, films, own, keep)


def _at_walls(run: Run, rows: pd.DataFrame, walls: Floats) -> pd.DataFrame:
    """Spheres and wall parts; of several triangles as near the one with the least film counts."""
    parts, fixed, step = nearest.parts(run), bodies(run), int(rows["step"].iloc[0])
    x, reach, radius, film = (
        rows[["x", "y", "z"]].to_numpy(float),
        *(rows[n].to_numpy() for n in ("reach", "radius", "film")),
    )
    thick = np.nan_to_num(walls[: len(parts.middle)] / fixed.area[: len(parts.middle)])
    most = np.zeros(len(parts))
    np.maximum.at(most, parts.setup.part, thick)
    a, part = parts.near(step, x, reach, most)
    near = parts.closest(np.full(len(a), step), x[a], part, thick)
    distance, triangle, layer = near.distance, near.triangle, near.least
    width, r = fixed.half_width[part], radius[a]
    wire = width < r
    drawn = film[a] * np.where(wire, width / (6.0 * r), 0.5 * (1.0 - np.sqrt(0.75)))
    drawn = drawn + layer * np.where(wire, 2.0 * r * np.where(wire, width, 0.0), np.pi / 4.0 * r**2)
    touch = (distance < reach[a] + layer - ROOM * r) & (drawn > SMALLEST * r**3)
    kind, own_film = np.where(wire, laws.SMALL_WALL, laws.LARGE_WALL), reach[a] - r
    return _table(rows, kind, rows["id"].to_numpy()[a], part, triangle, distance - r, own_film + layer, own_film, touch)


def _table(rows: pd.DataFrame, *columns: Any) -> pd.DataFrame:
    """The columns of NONE after the step, of the rows in the last argument."""
    *values, keep = columns
    step = int(rows["step"].iloc[0])
    return pd.DataFrame({"step": step, **{n: v[keep] for n, v in zip(list(COLUMNS)[1:], values, strict=True)}})


def given(film: Floats, ri: Floats, rj: Floats) -> Floats:
    """Liquid that sphere i gives to a bridge with sphere j (E 8)."""
    return np.asarray(film / 2.0 * (1.0 - np.sqrt(1.0 - (rj / (ri + rj)) ** 2)))
