"""Process a moist run's logs once, part by part: each part is compared and only its sums are stored.

A part ends with a step. Only the liquid of every reservoir and the active bridges are carried to the next part.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from reference_impl.motion import between, budget, contributions, flights, impulses, weight, window
from reference_impl.replay import (
    bridge_ends,
    coverage,
    drops,
    forces,
    formations,
    liquid,
    missing,
    plans,
    retired,
    sampled,
    snapshots,
    stored_tables,
    whole,
)
from reference_impl.replay.arrays import Columns, Floats
from reference_impl.replay.bodies import all_known, bodies, known, pairs, reservoirs_of
from reference_impl.replay.compare import Quantity, merged
from reference_impl.replay.io import Run, note, where
from reference_impl.replay.liquid_ledger import book
from reference_impl.replay.lives import Lives, none
from reference_impl.replay.stream import BATCH, END, Rows
from reference_impl.replay.transfer import Tables

SIZE = 200_000
"""Number of events of a part, which has outputs of at most about as many spheres."""
PIECE = 32_768
"""Largest number of contacts that are processed at once, so that their columns fit in a processor's second-level cache."""
PLACE = ["step", "id", "x", "y", "z"]
LOGS = {"events": None, "contacts": None, "bridges": None, "films": None, "wall_films": None, "impulses": None,
        "trajectory": [*PLACE, *budget.VELOCITY], "window_states": PLACE}  # fmt: skip
OF_PLACES = ("bridges", "films", "wall_films", "impulses", "trajectory", "window_states")


@dataclass(frozen=True)
class Before:
    """State of the log before a chunk.

    It has the last step, the last events of all reservoirs, the formations of active bridges, and the indices of
    these events.
    """

    step: int
    rows: Floats
    active: Floats


@dataclass
class Found:
    """Quantities found in all chunks of a log, joined."""

    events: int = 0
    contacts: int = 0
    seconds: dict[str, float] = field(default_factory=lambda: {"events": 0.0, "contacts": 0.0})
    """Processor time [s] by kind of log."""
    moved: contributions.Moved = field(default_factory=contributions.Moved)
    quantities: dict[str, dict[str, Quantity]] = field(default_factory=dict)
    now: Before = field(default_factory=lambda: Before(-1, *2 * [np.zeros(0, np.int64)]))
    """State before the current part."""
    broke: dict[str, Before] = field(default_factory=dict)
    """Log -> state before the first part in which it disagrees."""

    def add(self, group: str, quantities: list[Quantity], log: str = "events") -> None:
        """Add the quantities of one chunk to those found before."""
        so_far = self.quantities.setdefault(group, {})
        for q in quantities:
            so_far[q.name] = merged([so_far[q.name], q] if q.name in so_far else [q])
            if not q.ok:
                self.broke.setdefault(log, self.now)

    def of(self, group: str) -> list[Quantity]:
        """Return the quantities of a group."""
        return list(self.quantities.get(group, {}).values())


def ends(logs: dict[str, Rows], outputs: Floats, spheres: int, size: int) -> Iterator[int]:
    """Yield the last steps of the parts: about `size` events, and outputs of about as many spheres."""
    shot, many = 0, max(1, size // max(spheres, 1))
    while True:
        step = logs["events"].ahead(size)
        shot_end = int(outputs[shot + many - 1]) if shot + many < len(outputs) else END
        step = min(step, shot_end)
        shot = int(np.searchsorted(outputs, step, "right"))
        yield step
        if step == END:
            return


def go_through(run: Run, tables: Tables, size: int = SIZE) -> Found:
    """Read and compare all logs of a run."""
    paths = {name: where(run.folder, name) for name in LOGS}
    batch = {"contacts": PIECE}
    logs = {name: Rows(path, name, LOGS[name], batch.get(name, BATCH)) for name, path in paths.items() if path.exists()}
    fixed, last = bodies(run), int(run.table("ledger")["step"].max())
    held, outputs, found, samples = fixed.liquid(), plans.plan(run.folder).outputs, Found(), sampled.Samples(run)
    by_log, falling = formations.Held(run), drops.Falling(run)
    run.known["carried"] = carried = weight.Carried(run)
    counts, setup, gone = stored_tables.Count(run), window.read(run.folder), retired.Count(run)
    works, hangar = budget.Budget(run, setup), flights.Hangar(run, setup, outputs)
    run.known["budget"] = works
    run.known["between"] = unseen = between.Between(run, setup, outputs)
    energy, flying = budget.judged(run), flights.judged(run)
    last_row = np.full(len(held), -1)
    before, start = none(), -1
    for step in ends(logs, outputs, len(run.table("spheres")), size):
        began = time.process_time()
        part = _part(run, logs, step)
        events = part.table("events")
        found.now = Before(start, np.union1d(last_row[last_row >= 0], before.row), before.row)
        lives = Lives(before, events, found.events, start)
        inside = outputs[(outputs > start) & (outputs <= step)]
        p = pairs(events, fixed)
        falling.start(part, step)
        draws = coverage.known(run, "formation")
        columns, shots = book(events, p, fixed, tables, lives, held, draws, inside, falling)
        carried.add(part, step)
        found.add("liquid", liquid.check(part, columns, lives))
        found.add("drops", falling.check(liquid.mean_film(run)))
        if start < last <= step:
            found.add("end", liquid.end(part, shots[np.searchsorted(inside, last)], lives))
        found.add("snapshots", missing.check(part, lives, by_log))
        found.add("snapshots", snapshots.check(part, tables, lives, inside, shots))
        by_log.keep(part)
        found.add("snapshots", bridge_ends.check(part))
        found.add("tables", counts.check(part))
        found.add("tables", gone.check(part, inside, shots, liquid.mean_film(run)))
        if energy:
            works.add(part, lives)
        found.add("energy", unseen.add(part, lives))
        if flying:
            hangar.add(part)
        found.add("trajectory", whole.trajectory(whole.places(part), part.table("trajectory")))
        found.moved.add(run, events, p)
        samples.add_events(events, p, found.events)
        contacts_began = time.process_time()
        _contacts(part, logs["contacts"], step, lives, samples, found)
        rows = np.arange(found.events, found.events + len(events))
        for reservoir in reservoirs_of(events, p, fixed):
            np.maximum.at(last_row, reservoir, rows)
        found.events += len(events)
        before, start = lives.active(), step
        found.seconds["events"] += contacts_began - began
        found.seconds["contacts"] += time.process_time() - contacts_began
    found.contacts = logs["contacts"].taken
    found.add("liquid", samples.of_events())
    found.add("forces", samples.of_contacts(), "contacts")
    found.add("between", samples.between_nodes())
    found.add("energy", [*unseen.last_groups(), *works.check(), *hangar.check()])
    return found


def _part(run: Run, logs: dict[str, Rows], step: int) -> Run:
    """Return the next part of the logs, up to a step, except its contacts."""
    note(f"events: {logs['events'].taken} of {logs['events'].rows}")
    part = {name: logs[name].until(step) for name in ("events", *OF_PLACES) if name in logs}
    found = replace(run, tables={**run.tables, **part})
    known(found, ("events", "bridges"))
    return found


def _contacts(part: Run, log: Rows, step: int, lives: Lives, samples: sampled.Samples, found: Found) -> None:
    """Check the contacts of a part in pieces, an empty one if there are none, so that every quantity has its row."""
    row, pieces = log.taken, log.parts(step, PIECE)
    note(f"contacts: {log.taken} of {log.rows}")
    for rows in pieces if "forces" in found.quantities else _or_none(log, pieces):
        all_known(part, "contacts", rows)
        c = forces.contacts(part, rows)
        part.known["between"].windows(rows, lives)
        found.add("forces", [*forces.check(part, c, lives), *impulses.check(part, rows)], "contacts")
        samples.add_contacts(c, row)
        row = log.taken


def _or_none(log: Rows, pieces: Iterator[Columns]) -> Iterator[Columns]:
    yield log.none
    yield from pieces
