"""The part of a long run's logs in which a fault is looked for: from where they first disagree, as much as memory holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from reference_impl import io
from reference_impl.compare import Floats
from reference_impl.io import Run
from reference_impl.spans import Before, Found
from reference_impl.stream import taken

MOST = 200_000
"""Events, and contacts, that are looked at; logs of no more are looked at as a whole."""


def parts(run: Run, found: Found) -> tuple[Run, Run, str]:
    """For the equations of the event log and for those of the contact log; a sentence on what they are a part of."""
    if max(found.events, found.contacts) <= MOST:
        return run, run, ""
    steps = _steps(run, "events")
    first, second = (_part(run, found.broke.get(log, found.now), steps) for log in ("events", "contacts"))
    contacts = _steps(run, "contacts")
    wrong = [q.first for q in found.of("forces") if q.first is not None]
    start = int(np.searchsorted(contacts, min(wrong, default=second.since + 1)))
    rows = contacts[start : start + MOST]
    if len(rows):
        second.tables["contacts"] = run.rows("contacts", int(rows[0]), min(int(rows[-1]), _last(second, "events")))
    else:
        second.tables["contacts"] = run.rows("contacts", -1, -1)
    ends = [
        f"{name} of steps {p.since + 1} to {_last(p, name)}" for p, name in ((first, "events"), (second, "contacts"))
    ]
    return first, second, f"the fault was looked for in {' and '.join(ends)}, where they first disagree"


def _steps(run: Run, name: str) -> Floats:
    return io.columns(io.where(run.folder, name), ["step"])["step"].to_numpy()


def _last(run: Run, name: str) -> int:
    return int(run.table(name)["step"].max()) if len(run.table(name)) else run.since


def _part(run: Run, at: Before, steps: Floats) -> Run:
    """The run but for contacts, from a place in the event log on; earlier events only where later ones follow from them."""
    before, rows = (-1, at.rows[:0]) if len(steps) <= MOST else (at.step, at.rows)
    start = int(np.searchsorted(steps, before, "right"))
    last = int(steps[min(start + MOST, len(steps)) - 1]) if len(steps) else 0
    there = {name: run.rows(name, before + 1, last) for name in ("bridges", "films", "wall_films", "trajectory")}
    events = run.rows("events", before + 1, last)
    if len(rows):
        events = pd.concat([taken(io.where(run.folder, "events"), "events", rows), events], ignore_index=True)
    ledger = run.table("ledger")
    if start + MOST < len(steps):
        ledger = ledger[ledger["step"] <= last]
    tables = {name: table for name, table in run.tables.items() if name not in io.LOGS}
    return replace(run, tables={**tables, **there, "events": events, "ledger": ledger}, since=before)
