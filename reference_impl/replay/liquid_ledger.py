"""Recompute the liquid from the initial films and the order of events alone.

All events of a step draw from the films at its start and are applied at its end, followed by its drops and by bridges
that end because a sphere is retired. The loop is plain Python over arrays, compiled by numba without changing any bit
of the results (tested).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from reference_impl.compiled import compiled
from reference_impl.replay import laws
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import Bodies, Pairs, film_areas, reservoirs_of, shapes
from reference_impl.replay.drops import Falling
from reference_impl.replay.lives import RETIREMENT, Lives
from reference_impl.replay.transfer import Tables


class Columns(NamedTuple):
    """Recomputed columns of every event."""

    volume: Floats
    share_i: Floats
    share_j: Floats
    film_i_before: Floats
    film_i_after: Floats
    film_j_before: Floats
    film_j_after: Floats


class Asks(NamedTuple):
    """Demand of a formation on one side: film times factor over divisor, or a given amount."""

    reservoir: Floats
    wall: Floats
    factor: Floats
    divisor: Floats
    given: Floats


class Entries(NamedTuple):
    """The events of a part of the log, in the form used by the loop."""

    step: Floats
    formation: Floats
    retires: Floats
    """Whether a sphere of the bridge is retired: these events are applied after all others of their step."""
    i: Asks
    j: Asks
    previous: Floats
    """Index of the formation that a rupture ends, -1 for none."""
    row: Floats
    """Row in the table of transfer ratios, -1 for none."""
    cube: Floats
    """Cube of the radius for V*."""


class Ratios(NamedTuple):
    """The table of transfer ratios: row n has the nodes first[n] to first[n + 1]."""

    first: Floats
    nodes: Floats
    values: Floats


def of_spheres(reservoir: Floats, p: Pairs, given: Floats, this: Floats, other: Floats) -> Asks:
    """Return the liquid that a sphere of radius `this` gives to a bridge with one of radius `other` or a wall (E 8, 9, 12)."""
    sine, small = np.where(p.kind == laws.LARGE_WALL, 0.5, other / (this + other)), p.kind == laws.SMALL_WALL
    factor = np.where(small, p.width, 1.0 - np.sqrt(1.0 - sine**2))
    return Asks(reservoir, np.zeros(len(small), dtype=bool), factor, np.where(small, 6.0 * this, 2.0), given)


def asks(table: pd.DataFrame, p: Pairs, fixed: Bodies, logged: bool) -> tuple[Asks, Asks]:
    """Return the amounts that formations draw from both sides; `logged`: take them from the log, for an unknown law."""
    given = [table[f"share_{s}"].to_numpy(float) if logged else np.full(len(table), np.nan) for s in "ij"]
    reservoir_i, reservoir_j = reservoirs_of(table, p, fixed)
    j = of_spheres(reservoir_j, p, given[1], p.rj, p.ri)
    # from a wall (E 10, 13)
    part = np.where(p.kind == laws.SMALL_WALL, 2.0 * p.ri * p.width, np.pi / 4.0 * p.ri**2)
    area = film_areas(table, p, fixed)
    j = j._replace(wall=p.wall, factor=np.where(p.wall, part, j.factor), divisor=np.where(p.wall, area, j.divisor))
    return of_spheres(reservoir_i, p, given[0], p.ri, p.rj), j


def packed(tables: Tables) -> Ratios:
    """Pack the table of events into arrays for compiled code."""
    rows = tables.rows().values()
    first = np.cumsum([0, *(len(nodes) for nodes, _ in rows)])
    return Ratios(first, *(np.concatenate([np.zeros(0), *(r[c] for r in rows)]) for c in (0, 1)))


def row_of(tables: Tables, p: Pairs, fixed: Bodies) -> Floats:
    """Return the row of the table for each event."""
    kind, type_i, other, _ = shapes(p, p.ri, fixed)
    row = np.full(len(kind), -1)
    for n, (k, a, b) in enumerate(tables.rows()):
        row[(kind == k) & (type_i == a) & (other == b)] = n
    return row


def book(
    events: pd.DataFrame, p: Pairs, fixed: Bodies, tables: Tables, lives: Lives, held: Floats, draws: bool,
    outputs: Floats, drops: Falling | None = None,
) -> tuple[Columns, Floats]:  # fmt: skip
    """Recompute a part of the log: changes `held` (liquid of all reservoirs) and the recomputed volumes of `lives`.

    Returns the columns of the events, and `held` after each of the output steps.
    """
    n, recomputed = len(events), lives.all.recomputed
    out, shots = Columns(*np.full((len(Columns._fields), n), np.nan)), np.empty((len(outputs), len(held)))
    entries = Entries(
        np.array(events["step"], dtype=np.int64), lives.formation[len(recomputed) - n :],
        events["kind"].to_numpy() == RETIREMENT, *asks(events, p, fixed, not draws),
        lives.previous, row_of(tables, p, fixed), laws.harmonic_radius(p.ri, p.rj, p.wall) ** 3,
    )  # fmt: skip
    ratios, asked, done = packed(tables), np.zeros(len(held)), 0
    falls = drops.steps if drops else outputs[:0]
    for step in np.union1d(outputs, falls):
        until = int(np.searchsorted(entries.step, step, "right"))
        _book(entries, ratios, held, asked, recomputed, out, done, until)
        done = until
        if drops and step in falls:
            drops.book(int(step), held)
        shots[outputs == step] = held
    _book(entries, ratios, held, asked, recomputed, out, done, n)
    return out, shots


@compiled
def _ask(side: Asks, n: int, held: Any, asked: Any, share: Any) -> None:
    """Return the volume that a formation draws from one side; a film that was emptied may be negative in its last digit."""
    film, reservoir = max(held[side.reservoir[n]], 0.0), side.reservoir[n]
    if side.given[n] == side.given[n]:
        share[n] = side.given[n]
    elif side.wall[n]:
        share[n] = film / side.divisor[n] * side.factor[n]
    else:
        share[n] = film * side.factor[n] / side.divisor[n]
    asked[reservoir] += share[n]


@compiled
def _grant(side: Asks, n: int, held: Any, asked: Any, share: Any) -> None:
    """Reduce the requested volumes in proportion if a step draws more from a film than it contains."""
    there, want = max(held[side.reservoir[n]], 0.0), asked[side.reservoir[n]]
    if want > there:
        share[n] *= there / want


@compiled
def _ratio(table: Ratios, row: int, v_star: float) -> float:
    """Interpolate linearly between the nodes, constant beyond."""
    if row < 0 or v_star != v_star:
        return np.nan
    low, high = table.first[row], table.first[row + 1] - 1
    if v_star <= table.nodes[low]:
        return table.values[low]
    if v_star >= table.nodes[high]:
        return table.values[high]
    while high - low > 1:
        middle = (low + high) // 2
        if table.nodes[middle] <= v_star:
            low = middle
        else:
            high = middle
    slope = (table.values[high] - table.values[low]) / (table.nodes[high] - table.nodes[low])
    return slope * (v_star - table.nodes[low]) + table.values[low]


@compiled
def _book(
    e: Entries, table: Ratios, held: Any, asked: Any, recomputed: Any, out: Columns, start: int, last: int
) -> None:
    """Apply events step by step; the last elements of `recomputed` become the volumes of the events."""
    before = len(recomputed) - len(e.step)
    while start < last:
        end = start + 1
        while end < last and e.step[end] == e.step[start] and e.retires[end] == e.retires[start]:
            end += 1
        for n in range(start, end):
            asked[e.i.reservoir[n]] = asked[e.j.reservoir[n]] = 0.0
            out.film_i_before[n], out.film_j_before[n] = held[e.i.reservoir[n]], held[e.j.reservoir[n]]
        for n in range(start, end):
            if e.formation[n]:
                _ask(e.i, n, held, asked, out.share_i)
                _ask(e.j, n, held, asked, out.share_j)
        for n in range(start, end):
            if e.formation[n]:
                _grant(e.i, n, held, asked, out.share_i)
                _grant(e.j, n, held, asked, out.share_j)
                out.volume[n] = out.share_i[n] + out.share_j[n]
            elif e.previous[n] >= 0:
                out.volume[n] = recomputed[e.previous[n]]
                out.share_i[n] = out.volume[n] * _ratio(table, e.row[n], out.volume[n] / e.cube[n])
                out.share_j[n] = out.volume[n] - out.share_i[n]
            recomputed[before + n] = out.volume[n]
        for n in range(start, end):
            sign = -1.0 if e.formation[n] else 1.0
            held[e.i.reservoir[n]] += sign * out.share_i[n]
            held[e.j.reservoir[n]] += sign * out.share_j[n]
        for n in range(start, end):
            out.film_i_after[n], out.film_j_after[n] = held[e.i.reservoir[n]], held[e.j.reservoir[n]]
        start = end
