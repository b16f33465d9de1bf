"""Relations of the events of a log to each other and to the snapshots, with the faults that violate them (see diagnosis.py).

They are the life of each bridge (formed, ruptured, formed …), the film of each sphere and triangle from event to
event, and the ledger.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from reference_impl.diagnosis.diagnosis import Link, Suspect
from reference_impl.diagnosis.suspects import factor
from reference_impl.replay import laws, liquid, retired
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import Bodies, bodies
from reference_impl.replay.io import Run
from reference_impl.replay.lives import FORMATION, RETIREMENT, RUPTURE

MISSING_FORMATION = "a formation is missing from the log"
MISSING_RUPTURE = "a rupture is missing from the log"
CHANGES = "it changes while the bridge exists"
TWICE = "an event is in the log twice"
Pair = tuple[Floats, Floats]


def sides(table: pd.DataFrame, moves: Pair, fixed: Bodies) -> pd.DataFrame:
    """Return two rows per event, first all of i, then all of j: reservoir (film t of a wall: -1 - t), films, liquid moved.

    Events of one `phase` draw from the same films: bridges that end by retirement follow all others of their step.
    """
    wall = table["partner_kind"].to_numpy() != laws.SPHERE
    j = np.where(wall, -1 - fixed.film_of[table["triangle"].to_numpy()], table["j"].to_numpy())
    columns = {
        "reservoir": np.concatenate([table["i"].to_numpy(), j]).astype(np.int64),
        "step": np.tile(table["step"].to_numpy(), 2),
        "phase": np.tile(2 * table["step"].to_numpy(np.int64) + (table["kind"].to_numpy() == RETIREMENT), 2),
        "move": np.concatenate(moves),
        "row": np.tile(np.arange(len(table)), 2),
    }
    films = {when: np.concatenate([table[f"film_{s}_{when}"] for s in "ij"]) for when in ("before", "after")}
    return pd.DataFrame({**columns, **films})


def histories(run: Run) -> pd.DataFrame:
    """Return the events with the preceding kind of each, and, as last row of each bridge, whether it is active at the end."""
    events, last = _of_lives_alone(run), int(run.table("ledger")["step"].max())
    columns = ["step", "kind", "partner_kind", "i", "j", "triangle"]
    parts = [events[columns]]
    if not len(events) or int(events["step"].max()) <= last:
        active = liquid.at_step(run.table("bridges"), last)
        keys = pd.concat([events[columns[2:]], active[columns[2:]]])
        keys = keys.assign(wall=keys["partner_kind"] != laws.SPHERE).drop_duplicates(["wall", "i", "j"])
        here = active.assign(wall=active["partner_kind"] != laws.SPHERE)[["wall", "i", "j"]].assign(kind=RUPTURE)
        ends = keys.merge(here, on=["wall", "i", "j"], how="left")
        # an active bridge is treated as a rupture at this step, a missing one as a formation
        parts.append(ends.assign(kind=ends["kind"].fillna(FORMATION).astype(int), step=last)[columns])
    rows = pd.concat(parts, ignore_index=True)
    rows["wall"] = rows["partner_kind"] != laws.SPHERE
    groups = rows.groupby(["wall", "i", "j"])
    rows["kind_before"], rows["step_before"] = groups["kind"].shift(1), groups["step"].shift(1)
    return rows


def _of_lives_alone(run: Run) -> pd.DataFrame:
    """Return the events; of those before a part of a long log, the formations of bridges active at its start."""
    events = run.table("events")
    return events[run.known["lives"]].reset_index(drop=True) if "lives" in run.known else events


def broken_lives(run: Run) -> dict[str, pd.DataFrame]:
    """Return the rows of `histories` that are inconsistent with the preceding ones, by the event that must be missing."""
    rows = histories(run)
    rows = rows[rows["step"] > run.since]
    real = rows.index < len(_of_lives_alone(run))
    twice = real & (rows["kind"] == rows["kind_before"]) & (rows["step"] == rows["step_before"])
    without = (rows["kind"] != FORMATION) & (rows["kind_before"] != FORMATION) & ~twice
    again = (rows["kind"] == FORMATION) & (rows["kind_before"] == FORMATION) & ~twice
    return {TWICE: rows[twice], MISSING_FORMATION: rows[without], MISSING_RUPTURE: rows[again]}


def of_lives(run: Run, reservoir: pd.Series, logged: Floats) -> Iterator[Suspect]:
    """Attribute wrong films to bridges with an inconsistent life of the same sphere or triangle."""
    for fault, found in broken_lives(run).items():
        of_walls = bodies(run).film_of[found.loc[found["wall"], "triangle"]]
        touched = {*found["i"], *found.loc[~found["wall"], "j"], *(-1 - of_walls)}
        yield Suspect(fault, np.where(reservoir.isin(touched), logged, np.nan))


def life(run: Run) -> Iterator[Link]:
    """Check that formations and ruptures of each pair alternate, and that a bridge ruptures with the volume with which it
    formed.
    """
    rows, faults = histories(run), broken_lives(run)
    wrong = np.zeros(len(rows))
    for found in faults.values():
        wrong[found.index] = 1.0

    def suspects(_: Floats) -> Iterator[Suspect]:
        for fault, found in faults.items():
            yield Suspect(fault, np.where(rows.index.isin(found.index), 1.0, np.nan))

    one = np.ones(len(rows))
    words = "a formation, rupture or bridge of a snapshot cannot follow the event before it"
    yield Link("bridge_life", "life of the bridges", rows, wrong, 0.0 * one, one, suspects, says=lambda _: words)


def at_formation(run: Run) -> Floats:
    """Return the row of the formation that belongs to each rupture, -1 for other events."""
    events = run.table("events")
    rows = events.assign(wall=events["partner_kind"] != laws.SPHERE, row=np.arange(len(events)))
    groups = rows.groupby(["wall", "i", "j"])
    paired = (rows["kind"] != FORMATION) & (groups["kind"].shift(1) == FORMATION)
    return groups["row"].shift(1).where(paired).fillna(-1).to_numpy(int)


def stored(run: Run, expected: Pair) -> Link:
    """Compare a bridge's volume at rupture with that at its formation; `expected` are the correct shares."""
    events, at = run.table("events"), at_formation(run)
    logged = events["volume"].to_numpy(float)
    formed = np.where(at >= 0, logged[at], logged)

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield from factor(logged, formed, rows)
        yield Suspect(CHANGES, np.where(at >= 0, logged, np.nan), general=True)

    excuse = np.where(at >= 0, (expected[0] + expected[1])[at], logged)
    return Link("volume", "volume at rupture", events, logged, formed, formed, suspects, excuses=(excuse,))


def carried(run: Run, both: pd.DataFrame) -> Link:
    """Check that the film at the start of a step equals the film after the last event of the same reservoir."""
    first = dict(zip(run.table("spheres")["id"], run.table("spheres")["film"], strict=True))
    ends = both.drop_duplicates(["reservoir", "phase"], keep="last").sort_values("phase", kind="stable")
    before = ends.groupby("reservoir")["after"].shift(1)
    start = ends["reservoir"].map(first).where(ends["reservoir"] > 0, 0.0)
    known = ends.assign(expected=before.fillna(start))[["reservoir", "phase", "expected"]]
    rows = both.merge(known, on=["reservoir", "phase"], how="left")
    logged, expected = rows["before"].to_numpy(float), rows["expected"].to_numpy(float)

    def suspects(_: Floats) -> Iterator[Suspect]:
        yield from of_lives(run, rows["reservoir"], logged)
        yield Suspect("liquid has gone between two events", np.where(logged < expected, logged, np.nan), general=True)
        yield Suspect("liquid has come between two events", np.where(logged > expected, logged, np.nan), general=True)

    return Link("film_before", "film between events", rows, logged, expected, _typical(run, len(rows)), suspects)


def _typical(run: Run, n: int) -> Floats:
    return np.full(n, max(float(run.table("spheres")["film"].mean()), 1e-300))


def booked(run: Run, expected: Pair) -> Link:
    """Check that the film after a step is that before it, minus what its formations took, plus what its ruptures returned."""
    events = run.table("events")
    formation = events["kind"].to_numpy() == FORMATION
    share_i, share_j = (events[f"share_{s}"].to_numpy(float) for s in "ij")

    def after(i: Floats, j: Floats) -> Floats:
        both = sides(events, (i, j), bodies(run))
        moved = both.groupby(["reservoir", "phase"])["move"].transform("sum").to_numpy()
        return np.asarray(both["before"].to_numpy() + moved)

    sign = np.where(formation, -1.0, 1.0)
    i, j, back = sign * share_i, sign * share_j, ~formation
    both = sides(events, (i, j), bodies(run))
    logged, n = both["after"].to_numpy(float), len(events)

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield from of_lives(run, both["reservoir"], logged)
        yield Suspect("the volume is drawn twice", after(np.where(back, i, 2 * i), np.where(back, j, 2 * j)))
        yield Suspect("liquid given back to j is lost", after(i, np.where(back, 0.0, j)))
        yield Suspect("liquid given back to i is lost", after(np.where(back, 0.0, i), j))
        yield Suspect("liquid given back is lost", after(np.where(back, 0.0, i), np.where(back, 0.0, j)))
        yield Suspect("liquid given back counts twice", after(np.where(back, 2 * i, i), np.where(back, 2 * j, j)))
        yield Suspect("what is given back goes to the other side", after(np.where(back, j, i), np.where(back, i, j)))
        yield Suspect("what is drawn from j is taken from i", after(np.where(back, i, i + j), np.where(back, j, 0.0)))
        yield Suspect("what is drawn from i is taken from j", after(np.where(back, i, 0.0), np.where(back, j, i + j)))
        yield Suspect("liquid drawn from j is not taken from it", after(i, np.where(back, j, 0.0)))
        yield Suspect("liquid drawn from i is not taken from it", after(np.where(back, i, 0.0), j))
        yield Suspect("events of one step overwrite each other", both["before"].to_numpy() + both["move"].to_numpy())
        yield from factor(logged, after(i, j), rows)

    marks = {"films of i": np.arange(2 * n) < n, "films of j": np.arange(2 * n) >= n,
             "on walls": (both["reservoir"] < 0).to_numpy(), "steps with a rupture": np.tile(back, 2)}  # fmt: skip
    return Link("film_after", "film after an event", both, logged, after(i, j), _typical(run, 2 * n), suspects,
                excuses=(after(sign * expected[0], sign * expected[1]),), marks=marks)  # fmt: skip


def snapshots(run: Run, both: pd.DataFrame) -> Iterator[Link]:
    """Compare films in the snapshots, and films of spheres when retired, with the event log."""
    ends = both.sort_values("phase", kind="stable").drop_duplicates(["reservoir", "step"], keep="last")
    first = dict(zip(run.table("spheres")["id"], run.table("spheres")["film"], strict=True))
    tables = {"snapshot_films": run.table("films"), "snapshot_wall_films": run.table("wall_films")}
    tables["retired_film"], fixed = _retired(run), bodies(run)
    for name, table in tables.items():
        turn = 1 if "id" in table else -1
        rows = table.assign(reservoir=table["id" if turn > 0 else "triangle"])
        rows["part"] = 1.0 if turn > 0 else fixed.share_of(rows["reservoir"])
        rows["reservoir"] = (rows["reservoir"] if turn > 0 else -1 - fixed.film_of[rows["reservoir"]]).astype(np.int64)
        rows = rows.sort_values("step", kind="stable").reset_index(drop=True)
        if not len(rows):
            continue
        found = pd.merge_asof(rows, ends[["reservoir", "step", "after"]], on="step", by="reservoir")
        expected = (
            found["after"].fillna(rows["reservoir"].map(first).fillna(0.0)).to_numpy(float) * rows["part"].to_numpy()
        )
        logged = rows["film"].to_numpy(float)

        def suspects(
            broken: Floats, logged: Floats = logged, expected: Floats = expected, rows: pd.DataFrame = rows
        ) -> Iterator[Suspect]:
            yield from of_lives(run, rows["reservoir"], logged)
            yield from factor(logged, expected, broken)

        what = "film of a retired sphere" if name == "retired_film" else "film in a snapshot"
        yield Link(name, what, rows, logged, expected, _typical(run, len(rows)), suspects)


def _retired(run: Run) -> pd.DataFrame:
    """Return the spheres retired within the examined part of the log."""
    gone, last = retired.table(run.folder), int(run.table("events")["step"].max())
    return gone[(gone["step"] > run.since) & (gone["step"] <= max(last, int(run.table("films")["step"].max())))]


def by_events(run: Run, steps: Floats) -> Floats:
    """Return the liquid that events have added until given steps: changes of the films and of the bridges' volumes."""
    events = run.table("events")
    events = events[events["step"] > run.since]
    both = sides(events, (events["share_i"].to_numpy(float), events["share_j"].to_numpy(float)), bodies(run))
    films = both.drop_duplicates(["reservoir", "phase"])
    sign = np.where(events["kind"].to_numpy() == FORMATION, 1.0, -1.0)
    at = np.concatenate([films["step"], events["step"]])
    gain = np.concatenate([films["after"] - films["before"], sign * events["volume"].to_numpy(float)])
    order = np.argsort(at, kind="stable")
    sums = np.concatenate([[0.0], np.cumsum(gain[order])])
    return np.asarray(sums[np.searchsorted(at[order], steps, side="right")])


def ledger(run: Run) -> Link:
    """Check that films, bridges, walls and removed liquid add up to the initial liquid.

    Events that create or destroy liquid are reported by their own link.
    """
    table = run.table("ledger")
    parts = {name: table[name].to_numpy(float) for name in ("films", "bridges", "walls", "left", "retired")}
    held, size = sum(parts.values(), np.zeros(len(table))), np.full(len(table), liquid.total(run))
    expected = size - liquid.to_come(run, table["step"].to_numpy())

    def suspects(rows: Floats) -> Iterator[Suspect]:
        for name, part in parts.items():
            yield Suspect(f"the liquid of {name} is left out", expected - part)
            yield Suspect(f"the liquid of {name} counts twice", expected + part)
        lost = held - expected
        amount = float(np.median(lost[rows]))
        words = f"{abs(amount) * 1e9:.4g} mm³ are {'lost' if amount < 0 else 'too much'}"
        yield Suspect(words, np.where(rows, expected + amount, expected), amount)
        grows = np.sign(amount) * np.diff(lost, prepend=0.0) >= 0.0
        word = "liquid leaks away" if amount < 0 else "liquid comes from nowhere"
        yield Suspect(word, np.where(grows | ~rows, held, np.nan), float(lost[-1]))

    moved = expected + by_events(run, table["step"].to_numpy())
    seen = np.where(np.abs(moved - expected) > 1e-9 * size, moved, np.nan)
    # the sum over many events has round-off
    excuse = np.where(np.abs(held - seen) < 1e-9 * size, held, np.nan)
    return Link("ledger", "ledger of the liquid", table, held, expected, size, suspects, 1e-12, excuses=(excuse,))


def links(run: Run, expected: Pair) -> Iterator[Link]:
    """Yield all links of the events except the lives of bridges; `expected`: the correct shares of each event."""
    events = run.table("events")
    if len(events):
        both = sides(events, (events["share_i"].to_numpy(float), events["share_j"].to_numpy(float)), bodies(run))
        yield stored(run, expected)
        if "drops" not in run.tables:  # drops change films between the events
            yield carried(run, both)
            yield from snapshots(run, both)
        yield booked(run, expected)
    yield ledger(run)
