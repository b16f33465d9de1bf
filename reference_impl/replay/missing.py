"""Bridges that did not form although films touch.

This is checked where positions are known: at the output steps of trajectory.parquet and, in the windows that record
motion, at every step at which bridges act.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.motion import impulses, nearest
from reference_impl.motion.touching import near_copies
from reference_impl.replay import images, io, laws, one_place, plans, retired
from reference_impl.replay.arrays import Floats, size
from reference_impl.replay.bodies import bodies
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.formations import GAP_MARGIN, Held, due, keep_films, late, sides_of, thickness
from reference_impl.replay.io import Run, where
from reference_impl.replay.lives import Lives, keys

ONE_PLACE = 2e-6
"""Share of the radius within which closest points of two parts of a wall coincide, so that a sphere has one bridge."""
SMALLEST = 1e-12
"""V* below which no bridge forms, the model's numerical zero."""
COLUMNS = {"step": np.int64, "partner_kind": np.int64, "i": np.int64, "j": np.int64, "triangle": np.int64,
           "separation": float, "films": float, "own_film": float}  # fmt: skip
NONE = pd.DataFrame({name: np.zeros(0, kind) for name, kind in COLUMNS.items()})
"""Empty table of pairs; `films`: of both sides together, `own_film`: of i alone [m]."""


def check(run: Run, lives: Lives, held: Held) -> list[Quantity]:
    """Check a chunk of the log for missing bridges; `held` is the state of the reservoirs before it."""
    return [due(run), late(run, held, lives), missed(run, lives, held), one_place.check(run, lives)]


def missed(run: Run, lives: Lives, held: Held) -> Quantity:
    """Check that there is a bridge wherever films touch, at an output step or where bridges act in a window."""
    table = touching(run, lives, held)
    lacking, zero = table["missed"].to_numpy(float), np.zeros(len(table))
    return compare("formation_missed", "films that touch without a bridge", lacking, zero, zero + 1.0, table, 0.0)


def touching(run: Run, lives: Lives, held: Held) -> pd.DataFrame:
    """Return pairs whose films touch and whether their bridge is missing; except those with an event in that step."""
    table = pd.concat([_at_outputs(run), _in_windows(run, lives, held)], ignore_index=True)
    if not len(table):
        return table
    step, wall = table["step"], table["partner_kind"] != laws.SPHERE
    fixed = bodies(run)
    events, shed = (rows[rows["step"].isin(step)] for rows in (run.table("events"), run.shed))
    # drops come after the formations of their step
    moved = np.concatenate(
        [_place(events["step"], h) for h in sides_of(events, run)]
        + [_place(shed["step"], np.maximum(shed[s], 0)) for s in "ij"]
        + [_place(shed["step"], fixed.walls_from + np.maximum(fixed.film_of.take(shed["j"], mode="clip"), 0))]
    )
    sides = table["i"], np.where(wall, fixed.walls_from + fixed.film_of[table["triangle"]], table["j"])
    busy = [np.isin(_place(step, side), moved) for side in sides]
    return table[~(busy[0] | busy[1])].reset_index(drop=True)


@dataclass(frozen=True)
class Frames:
    """Steps with known positions: x of spheres (steps, spheres, 3), retired ones out of reach, and all liquid."""

    step: Floats
    ids: Floats
    x: Floats
    film: Floats
    walls: Floats


def _frames(run: Run, places: pd.DataFrame) -> Frames:
    """Arrange positions by step, without films and without spheres that the engine has not created, which nothing touches."""
    table = places.sort_values(["step", "id"])
    step = np.unique(table["step"].to_numpy(np.int64))
    spheres, area = run.table("spheres").sort_values("id"), bodies(run).area
    ids, came = (
        spheres["id"].to_numpy(np.int64),
        plans.created(io.scene(run.folder), spheres, plans.plan(run.folder).steps),
    )
    shape = (len(step), len(ids))
    of, at = np.searchsorted(ids, table["id"]), table["step"].to_numpy(np.int64)
    there = (at > came[of]) & (at <= retired.leaves(run.folder, ids)[of])
    table, x = table[there], np.tile(retired.nowhere(len(ids)), (len(step), 1, 1))
    x[np.searchsorted(step, table["step"]), np.searchsorted(ids, table["id"])] = table[["x", "y", "z"]].to_numpy(float)
    return Frames(step, ids, x, np.zeros(shape), np.zeros((len(step), len(area))))


def _at_outputs(run: Run) -> pd.DataFrame:
    """Return pairs that touch at the output steps, and whether they are missing in the snapshot of bridges."""
    if not where(run.folder, "trajectory").exists():
        return NONE.assign(missed=False)
    places, films, walls = run.table("trajectory"), run.table("films"), run.table("wall_films")
    frames = _frames(run, places[places["step"] > 0])
    films = films[films["step"].isin(frames.step)]
    place = np.searchsorted(frames.step, films["step"]), np.searchsorted(frames.ids, films["id"])
    frames.film[place] = np.maximum(films["film"].to_numpy(float), 0.0)
    walls = walls[walls["step"].isin(frames.step)]
    frames.walls[np.searchsorted(frames.step, walls["step"]), walls["triangle"]] = walls["film"]
    table, bridges = _touching(run, frames), run.table("bridges")
    wanted, active, lacking = keys(table), keys(bridges), np.ones(len(table), dtype=bool)
    ends = np.searchsorted(bridges["step"].to_numpy(), frames.step[:, None] + np.array([0, 1]))
    of = table["step"].to_numpy()
    for step in np.unique(of):
        rows = np.flatnonzero(of == step)
        first, end = ends[np.searchsorted(frames.step, step)]
        there = np.append(np.sort(active[first:end]), -1)
        lacking[rows] = there[np.searchsorted(there[:-1], wanted[rows])] != wanted[rows]

    def exists(rows: pd.DataFrame) -> Floats:
        first, end = ends[np.searchsorted(frames.step, rows["step"].iloc[0])]
        return np.isin(keys(rows), active[first:end])

    return table.assign(missed=lacking & ~_one_place(run, frames, table, lacking, exists))


def _in_windows(run: Run, lives: Lives, held: Held) -> pd.DataFrame:
    """Find missed formations at the window steps at which bridges act, with films and bridges by the event log."""
    if len(run.shed) or not where(run.folder, "window_states").exists():  # drops change films between events
        return NONE.assign(missed=False)
    places, events, fixed = run.table("window_states"), run.table("events"), bodies(run)
    from_here = fixed.walls_from
    frames = _frames(run, places[(places["step"] > 0) & (places["step"] % impulses.every(run) == 0)])
    film, done = held.film.copy(), 0
    for k, until in enumerate(np.searchsorted(events["step"].to_numpy(), frames.step, "right")):
        if until > done:
            keep_films(film, events.iloc[done:until], run)
        done = until
        of_wall = np.maximum(film[from_here + fixed.film_of], 0.0) * fixed.share_of(np.arange(len(fixed.area)))
        frames.film[k], frames.walls[k] = np.maximum(film[frames.ids], 0.0), of_wall
    table = _touching(run, frames)
    at = lives.at(keys(table), table["step"].to_numpy(np.int64), strictly=False)

    def exists(rows: pd.DataFrame) -> Floats:
        return np.asarray(lives.at(keys(rows), rows["step"].to_numpy(np.int64), strictly=False) >= 0)

    lacking = at < 0
    return table.assign(missed=lacking & ~_one_place(run, frames, table, lacking, exists))


def _one_place(
    run: Run, frames: Frames, table: pd.DataFrame, lacking: Floats, exists: Callable[[pd.DataFrame], Floats]
) -> Floats:
    """Return the rows of wall parts without a bridge because another part of that wall has or must have one at that position.

    At a convex edge the faces that meet there have one bridge: no bridge forms with a part whose closest point is
    on another part that continues there towards the sphere, nor with a part whose closest point is the foot of a
    bridge with another part, or that continues there towards the sphere.
    """
    found = np.zeros(len(table), dtype=bool)
    rows = np.flatnonzero(lacking & (table["partner_kind"] != laws.SPHERE).to_numpy())
    parts = nearest.parts(run) if len(rows) else None
    for row in rows:
        assert parts is not None
        step, i, part = (int(table[name].iloc[row]) for name in ("step", "i", "j"))
        x = frames.x[np.searchsorted(frames.step, step), np.searchsorted(frames.ids, i)]
        found[row] = _at_neighbour(run, parts, (step, i, part), x, exists)
    return found


def _at_neighbour(
    run: Run, parts: nearest.Parts, row: tuple[int, int, int], x: Floats, exists: Callable[[pd.DataFrame], Floats]
) -> bool:
    """Return whether the bridge of a step's sphere at x with a part is left to another part by the rule of `_one_place`."""
    step, i, part = row
    others = np.flatnonzero((parts.wall == parts.wall[part]) & (np.arange(len(parts)) != part))
    closest, radius = parts.closest(np.array([step]), x[None], np.array([part])), float(bodies(run).radius[i])

    def off(points: Floats, of: Floats) -> Floats:
        """Return the distance of points from wall parts."""
        return parts.closest(np.full(len(of), step), np.broadcast_to(points, (len(of), 3)).copy(), of).distance

    others = others[off(x, others) < closest.distance[0] + 2.0 * radius]
    feet = parts.closest(np.full(len(others), step), np.repeat(x[None], len(others), axis=0), others).point
    near = ONE_PLACE * radius

    def onward(of: Floats, points: Floats) -> Floats:
        """Return whether parts continue at their points towards the sphere."""
        x_of_all, limits = np.repeat(x[None], len(of), axis=0), np.full((2, len(of)), near)
        return parts.goes_on(np.full(len(of), step), x_of_all, of, points, limits[0], 0.25 * limits[1])

    shared = off(closest.point, others) <= near
    if onward(others[shared], np.repeat(closest.point, int(shared.sum()), axis=0)).any():
        return True
    mine = np.full(len(others), part)
    others = others[(size(feet - closest.point) <= near) | (off(feet, mine) <= near) & onward(mine, feet)]
    kind = np.where(bodies(run).half_width[others] < radius, laws.SMALL_WALL, laws.LARGE_WALL)
    ends = pd.DataFrame({"step": step, "partner_kind": kind, "i": i, "j": others})
    return len(others) > 0 and bool(exists(ends).any())


def _place(step: Any, number: Any) -> Floats:
    """Combine a step and a number into one integer key."""
    return (np.asarray(step, np.int64) << 31) | np.asarray(number, np.int64)


def _touching(run: Run, frames: Frames) -> pd.DataFrame:
    """Return pairs whose films overlap and contain liquid."""
    if not len(frames.step):
        return NONE
    radius = bodies(run).radius[frames.ids]
    layer = thickness(frames.film, radius)
    parts = [_of_spheres(frames, radius, layer, images.of(run.folder))]
    if len(bodies(run).area) > 1 and io.scene(run.folder)["effects"].get("wall_films", True):
        parts.append(_at_walls(run, frames, radius, layer))
    return pd.concat(parts, ignore_index=True)


def _of_spheres(frames: Frames, radius: Floats, layer: Floats, box: images.Images) -> pd.DataFrame:
    near = []
    for k, x in enumerate(frames.x):
        a, b = near_copies(x, radius + layer[k], box)
        near.append(np.stack([np.full(len(a), k), a, b]))
    k, a, b = np.concatenate(near, axis=1)
    gap = size(box.nearest(frames.x[k, a] - frames.x[k, b])) - radius[a] - radius[b]
    films = layer[k, a] + layer[k, b]
    drawn = laws.drawn_from_sphere(laws.SPHERE, frames.film[k, a], radius[a], radius[b], 0.0)
    drawn = drawn + laws.drawn_from_sphere(laws.SPHERE, frames.film[k, b], radius[b], radius[a], 0.0)
    r = laws.harmonic_radius(radius[a], radius[b], np.zeros(len(a), dtype=bool))
    touch = (gap < films - GAP_MARGIN * radius[a]) & (drawn > SMALLEST * r**3)
    return _table(touch, frames.step[k], 0 * k, frames.ids[a], frames.ids[b], 0 * k - 1, gap, films, layer[k, a])


def _at_walls(run: Run, frames: Frames, radius: Floats, layer: Floats) -> pd.DataFrame:
    """Return spheres and wall parts; of several equally near triangles the one with the smallest film is used."""
    parts, fixed = nearest.parts(run), bodies(run)
    thick = np.nan_to_num(frames.walls / fixed.area)[:, : len(parts.bounds)]
    found = []
    for n, step in enumerate(frames.step):
        a, part, near = parts.within(int(step), frames.x[n], radius + layer[n], thick[n])
        found.append((np.full(len(a), n), a, part, *near))
    k, a, part, distance, triangle, least = (np.concatenate(column) for column in zip(*found, strict=True))
    r, width = radius[a], fixed.half_width[part]
    wire = width < r
    kind, width = np.where(wire, laws.SMALL_WALL, laws.LARGE_WALL), np.where(wire, width, 0.0)
    drawn = laws.drawn_from_sphere(kind, frames.film[k, a], r, r, width)
    drawn = drawn + laws.drawn_from_wall(kind, least, r, width)
    gap, films = distance - r, layer[k, a] + least
    touch = (gap < films - GAP_MARGIN * r) & (drawn > SMALLEST * r**3)
    return _table(touch, frames.step[k], kind, frames.ids[a], part, triangle, gap, films, layer[k, a])


def _table(keep: Floats, *columns: Floats) -> pd.DataFrame:
    """Return the columns of NONE for some rows."""
    return pd.DataFrame({name: values[keep] for name, values in zip(COLUMNS, columns, strict=True)})
