"""Compare the liquid of a part of the log with the papers: volumes, shares, films, ruptures; ledger and end of a run."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl.motion import impulses
from reference_impl.replay import coverage, io, laws, script
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import bodies, pairs
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.formations import setup_steps
from reference_impl.replay.io import Run
from reference_impl.replay.liquid_ledger import Columns
from reference_impl.replay.lives import FORMATION, RETIREMENT, RUPTURE, Lives, keys
from reference_impl.replay.plans import entered

__all__ = ["FORMATION", "RUPTURE", "at_step", "bodies", "check", "end", "ledger"]
MEAN = "mean film of a sphere"
FASTER = 1.1
"""Factor by which the speed at one check may exceed that at the next one or at the formation; `change` is added to it.

An impact of one of the two spheres on a third body adds the speed of that impact, if it is larger (`impact_speeds`).
"""
LITTLE = 0.05
"""Share of the limit that a speed may add at rest without being considered."""
LARGEST_CHANGE = 0.2
"""Largest additional speed [m/s] without an impact."""


def total(run: Run) -> float:
    """Return the initial liquid [m3]."""
    return float(run.table("spheres")["film"].sum())


def mean_film(run: Run) -> float:
    """Return the scale of all films [m3]."""
    return total(run) / max(len(run.table("spheres")), 1)


def check(run: Run, columns: Columns, lives: Lives) -> list[Quantity]:
    """Check the events; `columns` are their recomputed values."""
    events, found = run.table("events"), []
    for name in ("volume", "share_i", "share_j"):
        mine = getattr(columns, name)
        found.append(compare(name, "volume of the bridge", events[name].to_numpy(), mine, columns.volume, events))
    typical = np.full(len(events), mean_film(run))
    for name in ("film_i_before", "film_i_after", "film_j_before", "film_j_after"):
        found.append(compare(name, MEAN, events[name].to_numpy(), getattr(columns, name), typical, events))
    return [*found, *check_rupture(run, lives)]


def check_rupture(run: Run, lives: Lives) -> list[Quantity]:
    """Check the static rupture distance of every event (for the exact law see sampled.py), and whether each rupture was due."""
    events = run.table("events")
    p = pairs(events, bodies(run))
    name, logged = coverage.law(run, "rupture"), events["rupture_distance"].to_numpy(float)
    static, found = logged, []
    if not coverage.solved(run, "rupture") and name in laws.RUPTURE:
        static = laws.RUPTURE[name](events["volume"].to_numpy(float), p.ri, p.rj, p.wall, p.ti, p.tj)
        found = [compare("rupture_distance", "itself", logged, static, static, events)]
    limit = limits(run, static, events["speed"].to_numpy(float))
    due = events["separation"].to_numpy() >= limit * (1.0 - 1e-9)
    others = np.isin(
        events["kind"], (FORMATION, RETIREMENT)
    )  # these are judged elsewhere, and there are no further kinds
    right, one = np.where(events["kind"] == RUPTURE, due, others).astype(float), np.ones(len(events))
    late, zero = late_ruptures(run, static, lives).astype(float), np.zeros(len(events))
    return [
        *found,
        compare("rupture_due", "wrong ruptures", right, one, one, events, 0.0),
        compare("rupture_late", "ruptures that were due a look before", late, zero, one, events, 0.0),
    ]


def change(run: Run) -> float:
    """Return the speed [m/s] that a pair may lose to a third body between two checks: that of the fastest event.

    In a script's run, in which speeds may be set, it is `LARGEST_CHANGE`.
    """
    if "change" not in run.known:
        fastest = io.columns(io.where(run.folder, "events"), ["speed"])["speed"].to_numpy().max(initial=1e-9)
        little = LITTLE**2 * run.meta["surface_tension"] / max(run.meta["viscosity"], 1e-300)
        run.known["change"] = LARGEST_CHANGE if script.of(run.folder) else min(max(little, fastest), LARGEST_CHANGE)
    return float(run.known["change"])


def limits(run: Run, static: Floats, speed: Floats) -> Floats:
    """Return the gaps at which bridges rupture at some speeds; the static ones for a law that is not known."""
    if coverage.law(run, "dynamic_rupture") is None or not coverage.known(run, "dynamic_rupture"):
        return static
    return static * laws.pitois_factor(speed, run.meta["viscosity"], run.meta["surface_tension"])


def late_ruptures(run: Run, static: Floats, lives: Lives) -> Floats:
    """Ruptures whose gap exceeded the limit at the previous neighbour check already, as far as the logged speed shows.

    Between two neighbour checks the speed may change: by a third body, and by an impact that takes what was left of the speed at
    the formation. The limit is evaluated at a speed that exceeds the larger of both by `FASTER` and `change`. Those just after a
    wall has started or stopped are not judged.
    """

    def gone(of: Floats) -> Floats:
        """Whether the previous gap exceeds the limit at speeds that were higher by `of`."""
        limit = limits(run, static, FASTER * np.maximum(speed, at_formation) + of)
        return np.asarray(stood & (gap - way > limit * (1.0 + 1e-9)))

    events, every = run.table("events"), impulses.every(run)
    speed, gap = events["speed"].to_numpy(float), events["separation"].to_numpy(float)
    way = speed * every * float(run.meta["time_step"]) * (1.02 if every == 1 else 2.0)
    dynamic = coverage.law(run, "dynamic_rupture") is not None
    if dynamic and not coverage.known(run, "dynamic_rupture"):
        return np.zeros(len(gap), dtype=bool)
    at_formation = np.append(lives.all.speed, 0.0)[lives.previous]
    # a bridge formed at the last check has not been checked for rupture
    formed = np.append(lives.all.step, np.iinfo(np.int64).max)[lives.previous]
    step = events["step"].to_numpy(np.int64)
    since = step[:, None] - setup_steps(run)
    stood = (events["kind"] == RUPTURE).to_numpy() & (formed < step - every)
    stood &= ~((since >= 0) & (since <= every)).any(axis=1)
    more = np.full(len(gap), change(run))
    late = gone(more)
    if dynamic and late.any():
        rows = np.flatnonzero(late)
        more[rows] = np.maximum(impact_speeds(lives, rows, static[rows], float(run.meta["time_step"])), more[rows])
        late = gone(more)
    return late


def impact_speeds(lives: Lives, rows: Floats, reach: Floats, time_step: float) -> Floats:
    """Return the speed of the last impacts of the two spheres of events on other bodies [m/s], 0 without any.

    An impact is the formation of another bridge, from which on its speed has covered at most `reach` [m].
    """
    of, fast = lives.all, np.flatnonzero(lives.formation & (lives.all.speed > LARGEST_CHANGE))
    fast = fast[np.argsort(of.step[fast], kind="stable")]
    ends, found = of.ends(), np.zeros(len(rows))
    here = rows + len(of) - len(lives.previous)  # the events are the last entries of `all`
    earliest = of.step[here] - np.ceil(reach / (LARGEST_CHANGE * time_step))
    spans = np.searchsorted(of.step[fast], [earliest, of.step[here]], "right").T
    for k, (first, last) in enumerate(spans):
        near = fast[first:last]
        near = near[
            (of.key[near] != of.key[here[k]])
            & ((of.step[here[k]] - of.step[near]) * time_step * of.speed[near] <= reach[k])
        ]
        same = np.isin(ends[near], ends[here[k]]) & (ends[near] >= 0)
        found[k] = of.speed[near[same.any(axis=1)]].max(initial=0.0)
    return found


def at_step(table: pd.DataFrame, step: int) -> pd.DataFrame:
    """Select the rows of one step."""
    return table[table["step"] == step]


def end(run: Run, held: Floats, lives: Lives) -> list[Quantity]:
    """Check films and bridges at the last output; `held`: all liquid there by reservoir."""
    last, fixed = int(run.table("ledger")["step"].max()), bodies(run)
    films, walls, active = (at_step(run.table(name), last) for name in ("films", "wall_films", "bridges"))
    mean = total(run) / max(len(films), 1)
    found = []
    triangle = walls["triangle"].to_numpy()
    for name, table, reservoir, part in (
        ("spheres", films, films["id"].to_numpy(), 1.0),
        ("walls", walls, fixed.walls_from + fixed.film_of[triangle], fixed.share_of(triangle)),
    ):
        logged, size = table["film"].to_numpy(), np.full(len(table), mean)
        found.append(compare(f"final_film_{name}", MEAN, logged, held[reservoir] * part, size, table))
    here, mine = keys(active), lives.active(last)
    order = np.argsort(mine.key)
    place = order[np.minimum(np.searchsorted(mine.key[order], here), len(order) - 1)] if len(order) else 0 * here
    volumes = np.where(np.isin(here, mine.key), np.append(mine.recomputed, np.nan)[place], np.nan)
    found.append(compare("final_bridges", "itself", active["volume"].to_numpy(), volumes, volumes, active))
    missing = pd.DataFrame({"logged": [len(here)], "reference": [len(mine)]})
    count = np.array([float(len(np.setxor1d(here, mine.key)))])
    return [*found, compare("final_bridges_missing", "count", count, np.zeros(1), np.ones(1), missing, 0.0)]


def ledger(run: Run) -> Quantity:
    """Compare Σ films + Σ bridges + Σ walls + left + retired with the inserted liquid, at every output."""
    table = run.table("ledger")
    held = (table["films"] + table["bridges"] + table["walls"] + table["left"] + table["retired"]).to_numpy()
    put_in = total(run) - to_come(run, table["step"].to_numpy())
    return compare("ledger", "initial liquid", held, put_in, np.full(len(table), total(run)), table, 1e-12)


def to_come(run: Run, steps: Floats) -> Floats:
    """Return the liquid [m3] on the spheres that have not entered at each step."""
    spheres = run.table("spheres").sort_values("id")
    waits = steps[:, None] < entered(io.scene(run.folder), spheres)
    return np.asarray((waits * spheres["film"].to_numpy(float)).sum(axis=1))
