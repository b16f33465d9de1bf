"""The life of the liquid, recomputed from the start films and the order of events alone."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from reference_impl import coverage, exact, laws
from reference_impl.compare import Quantity, compare
from reference_impl.drops import Falling
from reference_impl.io import Run, note
from reference_impl.transfer import Tables

FORMATION, RUPTURE = 0, 1
Key = tuple[bool, int, int]
COLUMNS = ("kind", "partner_kind", "i", "j", "triangle", "separation", "speed", "share_i", "share_j")


@dataclass
class State:
    """Films of spheres and triangles, standing bridges, as the reference believes them to be."""

    film: dict[int, float]
    wall: dict[int, float]
    bridges: dict[Key, float] = field(default_factory=dict)


@dataclass
class Bodies:
    """What does not change: radii, angles, areas, half widths."""

    radius: dict[int, float]
    kind_of: dict[int, int]
    angle_of_type: dict[int, float]
    area: dict[int, float]
    half_width: dict[int, float]
    wall_angle: dict[int, float]
    group: dict[int, int]
    draws: bool
    """Whether what a formation draws is recomputed; else it is taken as logged."""

    def angle(self, sphere: int) -> float:
        """Contact angle of a sphere."""
        return self.angle_of_type[self.kind_of[sphere]]


def bodies(run: Run) -> Bodies:
    """Read the unchanging data of a run."""
    spheres = run.table("spheres")
    no_walls = pd.DataFrame({k: [] for k in ("triangle", "area", "part", "half_width", "contact_angle", "part_class")})
    triangles, parts = run.tables.get("triangles", no_walls), run.tables.get("parts", no_walls)
    return Bodies(
        radius=dict(zip(spheres["id"], spheres["radius"], strict=True)),
        kind_of=dict(zip(spheres["id"], spheres["type"], strict=True)),
        angle_of_type={t["type"]: t["contact_angle"] for t in run.meta["types"]},
        area=dict(zip(triangles["triangle"], triangles["area"], strict=True)),
        half_width=dict(zip(parts["part"], parts["half_width"].fillna(np.inf), strict=True)),
        wall_angle=dict(zip(parts["part"], parts["contact_angle"], strict=True)),
        group=dict(zip(parts["part"], parts["part_class"], strict=True)),
        draws=coverage.known(run, "formation"),
    )


def key_of(partner_kind: int, i: int, j: int) -> Key:
    """Bridges are told apart by wall or sphere, i and j."""
    return (partner_kind != laws.SPHERE, i, j)


def wanted(event: Any, state: State, fixed: Bodies) -> tuple[float, float]:
    """What a formation asks of both sides, from the films at the start of the step."""
    if not fixed.draws:
        return float(event.share_i), float(event.share_j)
    ri = fixed.radius[event.i]
    if event.partner_kind == laws.SPHERE:
        rj = fixed.radius[event.j]
        ask_i = laws.drawn_from_sphere(laws.SPHERE, max(state.film[event.i], 0.0), ri, rj, 0.0)
        return ask_i, laws.drawn_from_sphere(laws.SPHERE, max(state.film[event.j], 0.0), rj, ri, 0.0)
    width = fixed.half_width[event.j]
    thickness = max(state.wall.get(event.triangle, 0.0), 0.0) / fixed.area[event.triangle]
    kind = laws.SMALL_WALL if width < ri else laws.LARGE_WALL
    ask_i = laws.drawn_from_sphere(kind, max(state.film[event.i], 0.0), ri, 0.0, width)
    return ask_i, laws.drawn_from_wall(kind, thickness, ri, width)


def holder_j(event: Any) -> tuple[str, int]:
    """Where j's liquid is booked."""
    return ("sphere", event.j) if event.partner_kind == laws.SPHERE else ("wall", event.triangle)


def step(events: list[Any], state: State, fixed: Bodies, tables: Tables, out: dict[str, list[float]]) -> None:
    """All events of one time step: draw on the films at its start, book at its end."""
    asked: dict[tuple[str, int], float] = defaultdict(float)
    asks = {}
    for n, e in enumerate(events):
        if e.kind == FORMATION:
            asks[n] = wanted(e, state, fixed)
            asked["sphere", e.i] += asks[n][0]
            asked[holder_j(e)] += asks[n][1]

    def held(holder: tuple[str, int]) -> float:
        return state.film[holder[1]] if holder[0] == "sphere" else state.wall.get(holder[1], 0.0)

    there = {h: max(held(h), 0.0) for h in asked}  # drawn dry, a film may be below zero by its last digit
    grant = {h: (there[h] / a if a > there[h] else 1.0) for h, a in asked.items()}
    before = [(held(("sphere", e.i)), held(holder_j(e))) for e in events]
    moves: list[tuple[tuple[str, int], float]] = []
    for n, e in enumerate(events):
        name = key_of(e.partner_kind, e.i, e.j)
        if e.kind == FORMATION:
            share_i, share_j = asks[n][0] * grant["sphere", e.i], asks[n][1] * grant[holder_j(e)]
            volume = share_i + share_j
            state.bridges[name] = volume
            sign = -1.0
        else:
            volume = state.bridges.pop(name, float("nan"))
            share_i = volume * ratio(e, volume, fixed, tables)
            share_j = volume - share_i
            sign = 1.0
        moves += [(("sphere", e.i), sign * share_i), (holder_j(e), sign * share_j)]
        for column, value in (("volume", volume), ("share_i", share_i), ("share_j", share_j)):
            out[column].append(value)
    for (where, which), amount in moves:
        if where == "sphere":
            state.film[which] += amount
        else:
            state.wall[which] = state.wall.get(which, 0.0) + amount
    for n, e in enumerate(events):
        out["film_i_before"].append(before[n][0])
        out["film_j_before"].append(before[n][1])
        out["film_i_after"].append(held(("sphere", e.i)))
        out["film_j_after"].append(held(holder_j(e)))


def ratio(event: Any, volume: float, fixed: Bodies, tables: Tables) -> float:
    """Transfer ratio of a bridge by the engine's table (the table itself is checked by transfer.py)."""
    ri = fixed.radius[event.i]
    if event.partner_kind == laws.SPHERE:
        rj = fixed.radius[event.j]
        r = 2.0 * ri * rj / (ri + rj)
        return tables.ratio(laws.SPHERE, fixed.kind_of[event.i], fixed.kind_of[event.j], volume / r**3)
    kind = laws.SMALL_WALL if fixed.half_width[event.j] < ri else laws.LARGE_WALL
    return tables.ratio(kind, fixed.kind_of[event.i], fixed.group[event.j], volume / ri**3)


def replay(run: Run, tables: Tables) -> tuple[dict[str, Any], State, Falling]:
    """Recompute every event's volumes in order; returns columns beside the event log, the state at the last output, and drops."""
    fixed, last = bodies(run), int(run.table("ledger")["step"].max())
    spheres, events = run.table("spheres"), run.table("events")
    state = State(dict(zip(spheres["id"], spheres["film"], strict=True)), {})
    drops = Falling(run, fixed.radius)
    out: dict[str, list[float]] = defaultdict(list)
    at_last: State | None = None
    waiting: list[Any] = []
    in_order: Iterator[Any] = events.itertuples(index=False)
    for n, event in enumerate(in_order):
        if n % 20000 == 0:
            note(f"events: {n} of {len(events)}")
        if waiting and event.step != waiting[0].step:
            step(waiting, state, fixed, tables, out)
            waiting = []
        if event.step > last and at_last is None:
            drops.before(last + 1, state.film, state.wall)
            at_last = State(dict(state.film), dict(state.wall), dict(state.bridges))
        if not waiting:
            drops.before(event.step, state.film, state.wall)
        waiting.append(event)
    if waiting:
        step(waiting, state, fixed, tables, out)
    if at_last is None:
        drops.before(last + 1, state.film, state.wall)
        at_last = State(dict(state.film), dict(state.wall), dict(state.bridges))
    drops.before(np.inf, state.film, state.wall)
    return out, at_last, drops


def check_rupture(run: Run) -> list[Quantity]:
    """Static rupture distance of every event (of a sample for the exact law), and whether each rupture was due."""
    fixed, events = bodies(run), run.table("events")
    wall = events["partner_kind"].to_numpy() != laws.SPHERE
    ri = events["i"].map(fixed.radius).to_numpy(float)
    rj = np.where(wall, 1.0, events["j"].map(fixed.radius).fillna(1.0).to_numpy(float))
    ti = events["i"].map({i: fixed.angle(i) for i in fixed.radius}).to_numpy(float)
    tj_sphere = events["j"].map({i: fixed.angle(i) for i in fixed.radius}).fillna(0.0).to_numpy(float)
    tj = np.where(wall, events["j"].map(fixed.wall_angle).fillna(0.0).to_numpy(float), tj_sphere)
    name, logged = coverage.law(run, "rupture"), events["rupture_distance"].to_numpy(float)
    static, found = logged, []
    if coverage.solved(run, "rupture"):
        found = [exact.check_rupture(events, wall, ri, rj, ti, tj)]
    elif name in laws.RUPTURE:
        static = laws.RUPTURE[name](events["volume"].to_numpy(float), ri, rj, wall, ti, tj)
        found = [compare("rupture_distance", "itself", logged, static, static, events)]
    factor = np.ones(len(events))
    if coverage.law(run, "dynamic_rupture") and coverage.known(run, "dynamic_rupture"):
        factor = laws.pitois_factor(events["speed"].to_numpy(float), run.meta["viscosity"], run.meta["surface_tension"])
    due = events["separation"].to_numpy() >= static * factor * (1.0 - 1e-9)
    right, one = np.where(events["kind"] == RUPTURE, due, True).astype(float), np.ones(len(events))
    return [*found, compare("rupture_due", "wrong ruptures", right, one, one, events, 0.0)]


def check(run: Run, own: dict[str, Any], state: State, drops: Falling) -> list[Quantity]:
    """All quantities of the events and of the end; `own`, `state` and `drops` are what `replay` gives."""
    events = run.table("events")
    total = float(run.table("spheres")["film"].sum())
    found = []
    for name in ("volume", "share_i", "share_j"):
        mine = np.array(own[name])
        size = np.array(own["volume"])
        found.append(compare(name, "volume of the bridge", events[name].to_numpy(), mine, size, events))
    typical = np.full(len(events), total / max(len(run.table("spheres")), 1))
    for name in ("film_i_before", "film_i_after", "film_j_before", "film_j_after"):
        mine = np.array(own[name])
        found.append(compare(name, "mean film of a sphere", events[name].to_numpy(), mine, typical, events))
    found += [*check_rupture(run), *final_state(run, state, total), ledger(run, total)]
    return [*found, *drops.check(float(typical.mean()) if len(typical) else total)]


def at_step(table: pd.DataFrame, step: int) -> pd.DataFrame:
    """Rows of one step."""
    return table[table["step"] == step]


def final_state(run: Run, state: State, total: float) -> list[Quantity]:
    """Films and bridges at the last output."""
    last = int(run.table("ledger")["step"].max())
    films = at_step(run.table("films"), last)
    mine = films["id"].map(state.film).to_numpy(float)
    mean = np.full(len(films), total / max(len(films), 1))
    found = [compare("final_film_spheres", "mean film of a sphere", films["film"].to_numpy(), mine, mean, films)]
    walls = at_step(run.table("wall_films"), last)
    own = walls["triangle"].map(state.wall).fillna(0.0).to_numpy(float)
    found.append(
        compare(
            "final_film_walls",
            "mean film of a sphere",
            walls["film"].to_numpy(),
            own,
            mean[:1].repeat(len(walls)),
            walls,
        )
    )
    standing = at_step(run.table("bridges"), last)
    keys = [key_of(int(k), int(i), int(j)) for k, i, j in standing[["partner_kind", "i", "j"]].to_numpy()]
    volumes = np.array([state.bridges.get(k, np.nan) for k in keys])
    found.append(compare("final_bridges", "itself", standing["volume"].to_numpy(), volumes, volumes, standing))
    missing = pd.DataFrame({"logged": [len(keys)], "reference": [len(state.bridges)]})
    count = np.array([float(len(set(keys) ^ set(state.bridges)))])
    found.append(compare("final_bridges_missing", "count", count, np.zeros(1), np.ones(1), missing, 0.0))
    return found


def ledger(run: Run, total: float) -> Quantity:
    """Σ films + Σ bridges + Σ walls + left against what was put in, at every output."""
    table = run.table("ledger")
    held = (table["films"] + table["bridges"] + table["walls"] + table["left"]).to_numpy()
    n = len(table)
    return compare("ledger", "initial liquid", held, np.full(n, total), np.full(n, total), table, 1e-12)
