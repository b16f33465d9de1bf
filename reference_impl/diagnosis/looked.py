"""The part of a long run's logs in which a fault is sought: from the first disagreement on, as much as memory permits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from reference_impl.replay import io
from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import Run
from reference_impl.replay.spans import OF_PLACES, Before, Found
from reference_impl.replay.stream import END, taken

MOST = 200_000
"""Largest number of events, and of contacts, that are examined; shorter logs are examined completely."""


def parts(run: Run, found: Found) -> tuple[Run, Run, str]:
    """Return the chunks of a run for the equations of events and of contacts, and a sentence that describes them."""
    if max(found.events, found.contacts) <= MOST:
        return run, run, ""
    steps = _steps(run, "events")
    first, _ = _part(run, found.broke.get("events", found.now), steps)
    second, last = _part(run, found.broke.get("contacts", found.now), steps)
    contacts = _steps(run, "contacts")
    wrong = [q.first for q in found.of("forces") if q.first is not None]
    start = int(np.searchsorted(contacts, min(wrong, default=second.since + 1)))
    rows = contacts[start : start + MOST]
    if len(rows):
        second.tables["contacts"] = run.rows("contacts", int(rows[0]), min(int(rows[-1]), last))
    else:
        second.tables["contacts"] = run.rows("contacts", -1, -1)
    logs = {"events": first, "contacts": second}
    ends = [
        f"{n} of steps {p.since + 1} to {_last(p, n)}" for n, p in logs.items() if n in found.broke or not found.broke
    ]
    return first, second, f"the fault was looked for in {' and '.join(ends)}, where they first disagree"


def _steps(run: Run, name: str) -> Floats:
    return io.columns(io.where(run.folder, name), ["step"])["step"].to_numpy()


def _last(run: Run, name: str) -> int:
    return int(run.table(name)["step"].max()) if len(run.table(name)) else run.since


def _part(run: Run, at: Before, steps: Floats) -> tuple[Run, int]:
    """Return the run without contacts, from a position in the event log to a step, and that step.

    It includes the earlier events from which later ones follow.
    """
    before, rows = (-1, at.rows[:0]) if len(steps) <= MOST else (at.step, at.rows)
    start = int(np.searchsorted(steps, before, "right"))
    last = int(steps[start + MOST - 1]) if start + MOST < len(steps) else END
    places = [name for name in OF_PLACES if io.where(run.folder, name).exists()]
    there = {name: run.rows(name, before + 1, last) for name in places}
    events = run.rows("events", before + 1, last)
    if len(rows):
        events = pd.concat([taken(io.where(run.folder, "events"), "events", rows), events], ignore_index=True)
    ledger = run.table("ledger")
    ledger = ledger[ledger["step"] <= last]
    tables = {name: table for name, table in run.tables.items() if name not in io.LOGS}
    # of a bridge that has ended only its formation may be loaded; it is not treated as active
    lives = np.append(np.isin(rows, at.active), np.ones(len(events) - len(rows), dtype=bool))
    known = {**run.known, "lives": lives}
    return replace(run, tables={**tables, **there, "events": events, "ledger": ledger}, since=before, known=known), last
