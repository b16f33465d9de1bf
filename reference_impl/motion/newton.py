"""Newton's law of every sphere in the recorded windows: recomputed forces and torques, change of speed and spin.

Between the ends of two steps the engine adds half a kick by the forces of each, so that

    m (v(n+1) - v(n))/dt = (F(n) + F(n+1))/2

holds to round-off, as it does for spin and torque. F is computed by the reference: weight, dry contacts (dry.py, contacts
found by touching.py), bridges (wet.py). The engine's sums are used only for the half step back to the speeds in the forces;
their consistency with the recorded speeds is checked as well.

impulses.py determines for how many steps bridges act.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.motion import dry, mesh, pushes, touching, wet
from reference_impl.motion.wall_motion import Motion
from reference_impl.motion.weight import carried
from reference_impl.motion.window import Setup, Wall, Window, springs, windows
from reference_impl.replay import arrays, coverage, images
from reference_impl.replay.arrays import Floats, vectors
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run

TOLERANCE = 1e-9
DRIFT = 1e-12
NEARLY = 1e-6
"""Distance over the radius below which two bodies may touch in an engine with its own contact detection."""
STANDARD_WEIGHT = 9.81
"""Acceleration that, times m, is the smallest scale of a force; otherwise the scale is the sum of the forces' magnitudes."""


@dataclass(frozen=True)
class Forces:
    """One window: dry contacts and bridges with their forces, and sums over each sphere (steps, spheres[, 3])."""

    window: Window
    touches: touching.Touches
    contacts: dry.Contacts
    bridges: wet.Bridges | None
    force: Floats
    torque: Floats
    doubt: Floats
    sizes: Floats
    checks: dict[str, tuple[Any, ...]]
    counts: Counter[str]
    """Number of values taken from the engine's log, by kind."""
    start: Floats
    """Springs from which the contacts started their step; `known`: rows whose spring is taken as logged."""
    known: Floats


Compared = dict[str, tuple[Any, ...]]


def forces(setup: Setup, run: Run | None) -> list[Forces]:
    """Recompute all forces in every sampling window, as a list."""
    return list(each(setup, run))


def each(setup: Setup, run: Run | None) -> Iterator[Forces]:
    """Recompute all forces window by window, with one window in memory at a time."""
    motion = Motion(setup)
    copies = images.of_scene(setup.scene).others()
    shapes = {w.name: mesh.repeated(setup.corners[w.first : w.last], copies, apart=w.analytic) for w in setup.walls}
    logs = touching.Springs(springs(setup, "pair_springs"), len(setup.ids) + len(setup.corners))
    walls = touching.Springs(springs(setup, "wall_springs"), len(setup.ids) + len(setup.corners))
    for w in windows(setup, carried(run).at if run is not None else None):
        yield _window(setup, w, run, motion, shapes, logs, walls)


def _window(
    setup: Setup, window: Window, run: Run | None, motion: Motion, shapes: dict[str, mesh.Topology],
    logs: touching.Springs, walls: touching.Springs,
) -> Forces:  # fmt: skip
    counts: Counter[str] = Counter()
    # with the engine's own contact model spheres that almost touch are excluded
    near = replace(setup, radius=setup.radius * (1.0 + NEARLY)) if setup.foreign else setup
    pairs = touching.of_pairs(near, window)
    at_walls = touching.of_walls(near, window, motion, shapes)
    parts = [(pairs, logs), *((t, walls) for t in at_walls)]
    found, before, given = [], [], []
    for (t, log), plane in zip(parts, [None, *(w for w in setup.walls)], strict=True):
        t, s, g = _springs(setup, window, t, log, None if plane is None else (plane.first, shapes[plane.name]), counts)
        found.append(t)
        before.append(s)
        given.append(g)
    touches = touching.join(found)
    known, start = np.concatenate(given), np.concatenate(before)
    contact = dry.contacts(setup, window, touches, start, known)
    of_log = [log.of(window.steps[t.k], t.a, t.b) for t, (_, log) in zip(found, parts, strict=True)]
    logged, there = (np.concatenate([of[n] for of in of_log]) for n in (0, 1))
    # the spring of a head-on contact is round-off only; a sliding one has the round-off of the wall's position
    scale = np.maximum(arrays.size(start) + arrays.size(contact.slip) * setup.step, 1e-9 * setup.radius[touches.a])
    law = setup.dry  # no contact between two walls
    slid = np.divide(law.friction * law.normal, law.tangential, out=np.zeros_like(law.normal), where=law.tangential > 0)
    scale[touches.wall] += float(slid.max()) * rounding(setup) / SCALES["contact_spring"][1]
    rows = pd.DataFrame(
        {"step": window.steps[touches.k], "i": setup.ids[touches.a], "b": touches.b, "wall": touches.wall}
    )
    checks: dict[str, tuple[Any, ...]] = {}
    if not setup.foreign:
        checks["contact_spring"] = (logged[~known], contact.spring[~known], scale[~known], rows[~known])
    if setup.memory:
        overlap = np.where(there, contact.overlap, 0.0)
        checks["contact_logged"] = (overlap, contact.overlap, setup.radius[touches.a], rows)
    bridges = wet.of_window(run, setup, window) if run is not None else None
    if run is not None:
        checks["event_speed"] = wet.event_speeds(run, setup, window)
    force, torque, doubt, sizes = _sums(setup, window, touches, contact, bridges)
    if run is not None and bridges is not None and coverage.semi_implicit(run):
        least = np.maximum(sizes, window.mass * STANDARD_WEIGHT)
        checks |= pushes.against_log(run, setup, window, bridges, force, torque, least, doubt / limit(setup))
    counts["dry_contacts"] = len(touches)
    counts["at_walls"] = int(touches.wall.sum())
    counts["between_spheres"] = len(touches) - counts["at_walls"]
    for wall in setup.walls:
        if wall.motion != "fixed" or wall.analytic:
            counts[f"on {wall.name}"] = _on(setup, wall, touches, bridges)
    counts["beside_an_edge"] = _beside_edges(setup, touches)
    counts["no_rolling_direction"] = int((contact.doubt > TOLERANCE * setup.radius[touches.a] * contact.elastic).sum())
    return Forces(window, touches, contact, bridges, force, torque, doubt, sizes, checks, counts, start, known)


def _on(setup: Setup, wall: Wall, t: touching.Touches, bridges: wet.Bridges | None) -> int:
    """Return the number of dry contacts and bridges with one wall."""
    found = int((t.wall & (t.b >= wall.first) & (t.b < wall.last)).sum())
    if bridges is not None:
        found += int((bridges.wall & np.isin(bridges.b, setup.part[wall.first : wall.last])).sum())
    return found


def _springs(
    setup: Setup, window: Window, t: touching.Touches, log: touching.Springs, plane: tuple[int, mesh.Topology] | None,
    counts: Counter[str],
) -> tuple[touching.Touches, Floats, Floats]:  # fmt: skip
    """Return the springs from which each contact starts its step, and rows in which that is the present spring itself.

    In the first step of a window the present springs are taken as logged. A new contact starts from zero; on a
    flat wall from the spring of the neighbouring triangle. One case is taken from the engine's log and counted:
    a contact skipped because the neighbouring triangle has one.
    """
    if not setup.memory:
        return t, np.zeros((len(t), 3)), np.ones(len(t), dtype=bool)
    step = window.steps[t.k]
    now, there = log.of(step, t.a, t.b)
    if plane is not None and not there.all():
        skip = ~there & np.array([_beside(setup, log, plane, *row)[1] for row in zip(step, t.a, t.b, strict=True)])
        counts["skipped_beside_another"] += int(skip.sum())
        t = touching.Touches(*(getattr(t, f)[~skip] for f in touching.Touches.__dataclass_fields__))
        step, now, there = step[~skip], now[~skip], there[~skip]
    given = t.k == 0
    before, had = log.of(step - 1, t.a, t.b)
    fresh = ~given & ~had
    if plane is not None:
        for at in np.flatnonzero(fresh & t.face):
            before[at] = _beside(setup, log, plane, step[at] - 1, t.a[at], t.b[at])[0]
    return t, np.where(given[:, None], now, before), given


def _beside(
    setup: Setup, log: touching.Springs, plane: tuple[int, mesh.Topology], step: int, a: int, triangle: int
) -> tuple[Floats, bool]:
    """Return the spring of the same sphere with a triangle in the same plane that shares a corner."""
    first, shape = plane
    near = np.array(sorted(shape.plane[int(triangle) - first]), dtype=np.int64) + first
    if not len(near):
        return np.zeros(3), False
    values, there = log.of(np.full(len(near), step), np.full(len(near), a), near)
    return (values[np.flatnonzero(there)[-1]], True) if there.any() else (np.zeros(3), False)


def _beside_edges(setup: Setup, t: touching.Touches) -> int:
    """Count the contacts beyond the first of one sphere with one wall part in one step: a convex edge acts next to its face."""
    if not t.wall.any():
        return 0
    one = np.stack([t.k, t.a, setup.part[np.where(t.wall, t.b, 0)]], axis=1)[t.wall]
    return int(len(one) - len(np.unique(one, axis=0)))


def _sums(
    setup: Setup, window: Window, t: touching.Touches, c: dry.Contacts, w: wet.Bridges | None
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return force, torque, the torque's uncertainty and the sum of the forces' magnitudes on every sphere in every step."""
    shape = (len(window.steps), len(setup.ids))
    force = window.mass[:, :, None] * setup.pull(window.steps)
    torque, doubt, sizes = np.zeros((*shape, 3)), np.zeros(shape), np.sqrt((force**2).sum(axis=2))
    np.add.at(doubt, (t.k, t.a), c.doubt)
    np.add.at(doubt, (t.k[~t.wall], t.b[~t.wall]), c.doubt[~t.wall])
    terms = [(t.k, t.a, t.b, t.wall, c.force(t.n), c.torque_a(t.n), c.torque_b(t.n))]
    weights = [np.abs(c.elastic) + np.abs(c.damping) + arrays.size(c.tangential)]
    if w is not None:
        force_a, torque_a, torque_b = (w.weight[:, None] * part for part in (w.force(), *w.torques(setup)))
        terms.append((w.k, w.a, w.b, w.wall, force_a, torque_a, torque_b))
        weights.append(w.weight * (np.abs(w.capillary) + np.abs(w.normal) + arrays.size(w.tangential)))
    for (k, a, b, wall, f, ta, tb), weight in zip(terms, weights, strict=True):
        pair = np.flatnonzero(~wall)
        for at, who, sign, turn in ((np.arange(len(k)), a, 1.0, ta), (pair, b, -1.0, tb)):
            where = (k[at], who[at])
            np.add.at(force, where, sign * f[at])
            np.add.at(torque, where, turn[at])
            np.add.at(sizes, where, weight[at])
    return force, torque, doubt, sizes


def check(setup: Setup, found: list[Forces]) -> list[Quantity]:
    """Check Newton's law for force and torque, the engine's kicks, springs; in moist runs the walls and the log's states."""
    return quantities(setup, [compared(setup, f) for f in found])


def compared(setup: Setup, f: Forces) -> Compared:
    """Return the compared values of one window: logged and recomputed values, the scale of the deviations, and the records."""
    parts = {**law(setup, f), **f.checks}
    return parts if f.bridges is None else parts | against_log(setup, f)


def quantities(setup: Setup, found: list[Compared]) -> list[Quantity]:
    """Join the quantities of several sampling windows."""
    rows: dict[str, list[tuple[Any, ...]]] = {}
    for parts in found:
        for name, part in parts.items():
            rows.setdefault(name, []).append(part)
    return [_quantity(setup, name, parts) for name, parts in rows.items()]


SCALES = {
    "newton_force": ("sum of the forces' sizes, at least the weight at 9.81 m/s2", TOLERANCE),
    "newton_torque": ("r times the same, and the doubt about a rolling direction over the limit", TOLERANCE),
    "newton_kick": ("speed, or half a kick where that is more", 1e-12),
    "newton_drift": ("radius, and the rounding of a position over the limit", DRIFT),
    "contact_spring": ("spring of the step before and slip in the step, at least 1e-9 r", 1e-6),
    "contact_logged": ("radius, by the overlap of a contact that is not in the log", TOLERANCE),
    "wall_closest_point": ("radius", TOLERANCE),
    "wall_velocity": ("itself, or 1 mm/s", TOLERANCE),
    "window_position": ("radius", 1e-12),
    "window_velocity": ("speed, or 1 mm/s", TOLERANCE),
    "event_speed": ("speed of the faster body, or 1 mm/s", TOLERANCE),
    **{name: (scale, TOLERANCE) for name, scale in pushes.SCALES.items()},
}
"""Scale of each deviation, and its limit."""


def rounding(setup: Setup) -> float:
    """Return the largest rounding error of a wall's position [m], since the engine adds up the steps of a moving wall.

    It is about sqrt(steps) roundings of its largest coordinate. A rotating wall is turned in every step by the
    same numbers, so that the rounding, half of the last digit, adds up (a drum: 7e-12 of its radius after 74,000
    steps).
    """
    found = 4.0 * float(np.abs(setup.corners).max(initial=0.0))
    steps = setup.scene["duration_s"] / setup.step
    for wall in setup.walls:
        if wall.motion != "fixed":
            place = float(np.abs(setup.corners[wall.first : wall.last]).max())
            found = max(found, place * (0.5 * steps if wall.motion == "turns" else np.sqrt(steps)))
    return found * float(np.finfo(float).eps)


def limit(setup: Setup) -> float:
    """Return 1e-9, or the spring's force due to the rounding of a wall's position over the lightest weight, if that is larger."""
    weight = float(setup.mass.min()) * STANDARD_WEIGHT
    return max(TOLERANCE, float(setup.dry.steepest(weight) * rounding(setup) / weight))


def _quantity(setup: Setup, name: str, parts: list[tuple[Any, ...]]) -> Quantity:
    logged, expected, scale = (np.concatenate([p[k] for p in parts]) for k in range(3))
    rows = pd.concat([p[3] for p in parts], ignore_index=True)
    summed = ("newton_force", "newton_torque", "window_push", "window_spin_push")
    most = limit(setup) if name in summed else SCALES[name][1]
    return compare(name, SCALES[name][0], logged, expected, scale, rows, most)


def records(setup: Setup, f: Forces) -> tuple[Floats, Floats]:
    """Return step (index in the window) and sphere for which the law is checked."""
    w = f.window
    k = np.flatnonzero((np.diff(w.steps) == 1) & ~np.isin(w.steps[:-1], list(setup.broken)))
    free = np.flatnonzero(setup.free & (setup.leaves >= w.steps[-1]))  # no sphere is retired within a window
    return np.repeat(k, len(free)), np.tile(free, len(k))


def law(setup: Setup, f: Forces) -> dict[str, tuple[Any, ...]]:
    """Check consecutive steps of free spheres, unless the engine was set up again between them."""
    w, dt = f.window, setup.step
    at, who = records(setup, f)
    m, r = w.mass[at, who], setup.radius[who]
    part = m / w.mass[at + 1, who]  # the liquid may change between the two halves of the kick
    inertia = 0.4 * m * r**2
    rows = pd.DataFrame({"step": w.steps[at], "i": setup.ids[who]})
    scale = np.maximum(0.5 * (f.sizes[at, who] + f.sizes[at + 1, who]), m * STANDARD_WEIGHT)
    dv, dw = w.v[at + 1, who] - w.v[at, who], w.w[at + 1, who] - w.w[at, who]
    expected, turn = (0.5 * (s[at, who] + part[:, None] * s[at + 1, who]) for s in (f.force, f.torque))
    doubt = 0.5 * (f.doubt[at, who] + f.doubt[at + 1, who])
    halves = [0.5 * dt / w.mass[k, who][:, None] * w.force[k, who] for k in (at, at + 1)]
    kick = halves[0] + halves[1]
    drift = images.of_scene(setup.scene).nearest(w.x[at + 1, who] - w.x[at, who])
    middle = dt * w.v[at, who] + 0.5 * dt**2 / m[:, None] * w.force[at, who]
    summed = np.ones(len(at), dtype=bool)
    if setup.foreign:
        touched = np.zeros(w.force.shape[:2], dtype=bool)
        touched[f.touches.k, f.touches.a] = True
        touched[f.touches.k[~f.touches.wall], f.touches.b[~f.touches.wall]] = True
        summed = ~(touched[at, who] | touched[at + 1, who])
    speed = np.max([arrays.size(v) for v in (w.v[at, who], w.v[at + 1, who], *halves)], axis=0)
    return {
        **{
            name: (found[summed], wanted[summed], size[summed], rows[summed])
            for name, found, wanted, size in (
                ("newton_force", m[:, None] * dv / dt, expected, scale),
                ("newton_torque", inertia[:, None] * dw / dt, turn, r * scale + doubt / limit(setup)),
            )
        },
        "newton_kick": (dv, kick, np.maximum(speed, 1e-300), rows),
        "newton_drift": (drift, middle, np.maximum(r, _lost_digits(w.x[at + 1, who])), rows),
    }


def _lost_digits(x: Floats) -> Floats:
    """Return the rounding of positions and of their difference, over the limit of a drift."""
    return np.asarray(2.0 * np.finfo(float).eps * arrays.size(x) / DRIFT)


def against_log(setup: Setup, f: Forces) -> dict[str, tuple[Any, ...]]:
    """Compare the contact log with the trajectory and the walls."""
    b, w = f.bridges, f.window
    assert b is not None
    x, v = vectors(b.table, "xi"), vectors(b.table, "vi")
    radius, speed = setup.radius[b.a], np.maximum(arrays.size(w.v_half[b.k, b.a]), 1e-3)
    found = {
        "window_position": (x, w.x[b.k, b.a], radius, b.table),
        "window_velocity": (v, w.v_half[b.k, b.a], speed, b.table),
    }
    if b.wall.any():
        at = np.flatnonzero(b.wall)
        rows = b.table.iloc[at].reset_index(drop=True)
        found["wall_closest_point"] = (vectors(rows, "xj"), b.point[at], radius[at], rows)
        found["wall_velocity"] = (vectors(rows, "vj"), b.vb[at], np.maximum(arrays.size(b.vb[at]), 1e-3), rows)
    return found


def places(setup: Setup, found: list[Forces]) -> pd.DataFrame:
    """Return the recorded positions of all spheres that are not retired: step, id, x, y, z [m]."""
    steps = np.concatenate([f.window.steps for f in found])
    x = np.concatenate([f.window.x for f in found]).reshape(-1, 3)
    table = pd.DataFrame({"step": np.repeat(steps, len(setup.ids)), "id": np.tile(setup.ids, len(steps))})
    table = table.assign(**dict(zip("xyz", x.T, strict=True)))
    return table[(steps[:, None] <= setup.leaves).ravel()].reset_index(drop=True)
