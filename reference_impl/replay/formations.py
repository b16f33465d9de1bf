"""Bridges that formed too early or too late, between spheres and at walls.

The approach speed is logged with every formation, so that the position at the previous neighbour check, and whether
the films touched then, are known. `missing` checks bridges that did not form.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
import scipy  # its parts are loaded where they are used

from reference_impl.motion import impulses, nearest
from reference_impl.motion.window import slide_steps, way_of
from reference_impl.replay import images, io, laws, script
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import bodies, film_areas, pairs, reservoirs_of
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run, where
from reference_impl.replay.lives import FORMATION, Lives, keys

GAP_MARGIN = 1e-9
"""Share of the radius by which films may fail to touch: a gap is a difference of positions."""
DISPLACEMENT_MARGIN = 1.02, 1e-5
"""Factor, and share of the radius, by which a displacement in one step may exceed the logged one: speeds change within a step."""
FASTER = 2.0
"""Largest speed of a sphere between an output and an event, over that at either."""
CORNER = 1e-7
"""Distance [m] below which corners coincide: STL files are in single precision."""


def thickness(film: Floats, radius: Floats) -> Floats:
    """Compute the film thickness on a sphere: (3 L/(4 pi) + r^3)^(1/3) - r (E 34)."""
    return np.asarray(radius * np.expm1(np.log1p(3.0 * film / (4.0 * np.pi * radius**3)) / 3.0))


class Held:
    """Liquid of every reservoir before a chunk of the log, and the step of its last change."""

    def __init__(self, run: Run) -> None:
        self.film = bodies(run).liquid()
        self.changed = np.full(len(self.film), -1, np.int64)

    def keep(self, run: Run) -> None:
        """Store the films and the last changes of all reservoirs after a chunk of the log."""
        events = run.table("events")
        keep_films(self.film, events, run)
        for side in sides_of(events, run):
            np.maximum.at(self.changed, side, events["step"].to_numpy(np.int64))


def sides_of(events: pd.DataFrame, run: Run) -> tuple[Floats, Floats]:
    """Return the numbers of the reservoirs on both sides of some events."""
    fixed = bodies(run)
    return reservoirs_of(events, pairs(events, fixed), fixed)


def keep_films(film: Floats, events: pd.DataFrame, run: Run) -> None:
    """Update `film` to the liquid of all reservoirs after some events by the log."""
    both = np.stack(sides_of(events, run), axis=1).ravel()
    film[both] = events[["film_i_after", "film_j_after"]].to_numpy().ravel()


def films_at_events(run: Run) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the thicknesses of both films before each event, the separation, and the radius of i."""
    fixed, events = bodies(run), run.table("events")
    p = pairs(events, fixed)
    area = np.where(p.wall, film_areas(events, p, fixed), 1.0)
    i, j = (np.maximum(events[f"film_{s}_before"].to_numpy(float), 0.0) for s in "ij")
    layer_j = np.where(p.wall, j / area, thickness(j, p.rj))
    return thickness(i, p.ri), layer_j, events["separation"].to_numpy(float), p.ri


def early(run: Run) -> tuple[Floats, Floats, Floats]:
    """Return 1 for formations whose films did not touch (not S < h_i + h_j), and films of both sides and gap of every event."""
    film, other, gap, ri = films_at_events(run)
    formed = (run.table("events")["kind"] == FORMATION).to_numpy()
    return (formed & (gap > film + other + GAP_MARGIN * ri)).astype(float), film + other, gap


def due(run: Run) -> Quantity:
    """Check that a bridge forms only if the films touch."""
    wrong, _, _ = early(run)
    zero = np.zeros(len(wrong))
    scale = "formations before the films touch"
    return compare("formation_due", scale, wrong, zero, zero + 1.0, run.table("events"), 0.0)


def lateness(run: Run, held: Held, lives: Lives) -> tuple[Floats, Floats]:
    """Return the smallest overlap [m] of the films of each formation at the previous neighbour check, and the displacement since.

    Both are zero if a film has changed since, at the start (step 0) and after the engine was set up again.
    """
    events, every = run.table("events"), impulses.every(run)
    film, other, gap, ri = films_at_events(run)
    step = events["step"].to_numpy(np.int64)
    way = every * float(run.meta["time_step"]) * events["speed"].to_numpy(float) * DISPLACEMENT_MARGIN[0]
    # with `every` > 1 speeds are known at some steps only
    way = way * (1.0 if every == 1 else 2.0) + (DISPLACEMENT_MARGIN[1] if every == 1 else 1e-3) * ri + _turned(run, ri)
    since = _changed(run, held, step)
    judged = (events["kind"] == FORMATION).to_numpy() & (step > _born(run)) & (since < step - every)
    judged &= ~np.isin(step, setup_steps(run))
    excess = np.where(judged, np.maximum(film + other - gap - way, 0.0), 0.0)
    late_at_walls = np.flatnonzero((excess > 0.0) & (events["partner_kind"] != laws.SPHERE).to_numpy())
    for row in late_at_walls:
        if _over_an_edge(run, lives, events.iloc[row], int(step[row]) - every):
            excess[row] = 0.0
            continue
        # the closest point may have crossed an edge, from an adjacent triangle with a thinner film
        beside = _thinnest_beside(run, held, events.iloc[row], int(step[row]) - every)
        excess[row] = max(film[row] + min(other[row], beside) - gap[row] - way[row], 0.0)
    return excess, way


def _born(run: Run) -> Floats:
    """Return for each event the first step at which both spheres exist: 0, or in a script's run the step at which the later one
    was inserted.
    """
    events, spheres = run.table("events"), run.table("spheres")
    if "enters" not in spheres:
        return np.zeros(len(events), int)
    came = spheres.set_index("id")["enters"]
    j = events["j"].where(events["partner_kind"] == laws.SPHERE, events["i"])
    return np.maximum(events["i"].map(came).to_numpy(), j.map(came).to_numpy())


def _over_an_edge(run: Run, lives: Lives, event: pd.Series, look: int) -> bool:
    """Return whether a bridge with an adjacent part prevented a formation at the previous neighbour check.

    This is a bridge of the same sphere with a part of the wall adjacent to the event's, or adjacent to such a
    part. A sphere has one bridge with parts that meet in one closest point, and a part excluded in this way, such
    as the rim between two sides, excludes the part beyond it.
    """
    parts, fixed, number = nearest.parts(run), bodies(run), int(event["j"])
    next_to = _meeting(parts, np.array([number]), int(event["triangle"]))
    reached = np.setdiff1d(np.union1d(next_to, _meeting(parts, next_to)), number)
    kind = np.where(fixed.half_width[reached] < fixed.radius[int(event["i"])], laws.SMALL_WALL, laws.LARGE_WALL)
    rows = pd.DataFrame({"partner_kind": kind, "i": int(event["i"]), "j": reached})
    return bool((lives.at(keys(rows), np.full(len(reached), max(look, lives.start)), strictly=False) >= 0).any())


def _meeting(parts: nearest.Parts, of: Floats, triangle: int | None = None) -> Floats:
    """Return other parts of the same wall that share a corner with some parts, or intersect a triangle."""
    corners, part = parts.setup.corners, parts.setup.part
    mine = np.isin(part, of)
    others = np.isin(parts.wall[part], parts.wall[of]) & ~mine
    if not others.any() or not mine.any():
        return np.zeros(0, np.int64)
    boxes = corners[others]
    there = (
        np.reshape(scipy.spatial.cKDTree(corners[mine].reshape(-1, 3)).query(boxes.reshape(-1, 3))[0], (-1, 3)).min(
            axis=1
        )
        < CORNER
    )
    if triangle is not None:
        low, high = corners[triangle].min(axis=0) - CORNER, corners[triangle].max(axis=0) + CORNER
        there |= ((boxes.min(axis=1) <= high) & (boxes.max(axis=1) >= low)).all(axis=1)
    return np.unique(part[others][there])


def _thinnest_beside(run: Run, held: Held, event: pd.Series, look: int) -> float:
    """Least thickness [m] at a neighbour check of the films on an event's triangle and on triangles of its wall that share a
    corner with it and can have been as near: at a convex edge a sphere has one bridge, with the part that is nearest.
    """
    parts, fixed, events, triangle = nearest.parts(run), bodies(run), run.table("events"), int(event["triangle"])
    corners, part = parts.setup.corners, parts.setup.part
    apart = np.abs(images.of(run.folder).nearest(corners[:, :, None] - corners[triangle][None, None])).max(axis=3)
    beside = np.flatnonzero((apart.min(axis=(1, 2)) < CORNER) & (parts.wall[part] == parts.wall[part[triangle]]))
    beside = beside[(beside == triangle) | _in_reach(run, event, beside)]
    film = {n: max(float(held.film[fixed.walls_from + n]), 0.0) for n in fixed.film_of[beside]}
    before = events[(events["step"] <= look) & (events["partner_kind"] != laws.SPHERE)]
    before = before.assign(of=fixed.film_of[before["triangle"]])
    before = before[before["of"].isin(list(film))]
    film.update(dict(zip(before["of"], before["film_j_after"], strict=True)))
    return min(film[fixed.film_of[n]] / float(fixed.film_area[n]) for n in beside)


def _in_reach(run: Run, event: pd.Series, triangles: Floats) -> Floats:
    """Return the triangles that may contain the closest point of an event, limited by the nearest output if known."""
    everywhere = np.ones(len(triangles), dtype=bool)
    if not where(run.folder, "trajectory").exists():
        return everywhere
    places = run.table("trajectory")
    places = places[places["id"] == event["i"]]
    if not len(places):
        return everywhere
    at = places.iloc[int(np.abs(places["step"].to_numpy() - event["step"]).argmin())]
    x, v = (at[list(names)].to_numpy(float) for names in (("x", "y", "z"), ("vx", "vy", "vz")))
    fastest = FASTER * max(float(np.sqrt((v**2).sum())), float(event["speed"]))
    # an output may be at the step of the event
    since_look = abs(float(at["step"]) - float(event["step"])) + impulses.every(run)
    way = fastest * float(run.meta["time_step"]) * since_look
    parts, step = nearest.parts(run), np.full(len(triangles), int(event["step"]))
    x_of_all = np.repeat(x[None], len(triangles), axis=0)
    distance = parts.closest(step, x_of_all, parts.setup.part[triangles]).distance.min()
    return np.asarray(parts.to(step, x_of_all, triangles)[0] - distance <= 2.0 * way)


def _turned(run: Run, ri: Floats) -> Floats:
    """Return how far points of a turning wall move away from a closest point between two neighbour checks [m]."""
    scene = io.scene(run.folder)
    periods = [abs(way_of(scene, w)["period_s"]) for w in scene["walls"] if w["motion"] == "turns"]
    rate = 2.0 * np.pi / min(periods) if periods else 0.0
    if script.of(run.folder) and scene["walls"]:
        rate = script.Poses(run.folder).fastest()
    return np.asarray(2.0 * rate * ri * impulses.every(run) * float(run.meta["time_step"]))


def setup_steps(run: Run) -> Floats:
    """Return the steps at which the engine is set up again; velocities there are those of the step itself."""
    windows = slide_steps(io.scene(run.folder)).values()
    return np.array([step for window in windows for step in window], int)


def _changed(run: Run, held: Held, step: Floats) -> Floats:
    """Return the last step before each event in which the liquid on either side changed, -1 for none."""
    fixed, shed = bodies(run), run.shed
    landed = np.where(
        shed["partner_kind"] == laws.SPHERE,
        np.maximum(shed["j"], 0),
        fixed.walls_from + np.maximum(fixed.film_of.take(shed["j"], mode="clip"), 0),
    )
    drops = shed["step"].to_numpy(np.int64)
    reservoir = np.concatenate([*sides_of(run.table("events"), run), shed["i"], landed]).astype(np.int64)
    change = np.concatenate([step, step, drops, drops])
    order = np.lexsort((change, reservoir))
    ordered, of = change[order], reservoir[order]
    new = np.ones(len(order), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]) | (of[1:] != of[:-1])
    first = np.flatnonzero(new)  # the first of several changes of a reservoir in one step
    before = np.where(
        np.append(-1, of[first][:-1]) == of[first], np.append(-1, ordered[first][:-1]), held.changed[of[first]]
    )
    found = np.empty(len(order), np.int64)
    found[order] = before[np.cumsum(new) - 1]
    return np.maximum(found[: len(step)], found[len(step) : 2 * len(step)])


def late(run: Run, held: Held, lives: Lives) -> Quantity:
    """Check that a bridge forms at the first neighbour check at which the films touch."""
    excess, _ = lateness(run, held, lives)
    events = run.table("events")
    return compare("formation_late", "radius", excess, np.zeros(len(excess)), bodies(run).radius[events["i"]], events)
