"""Diagnose all links of a run; called only if a replay disagrees."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from reference_impl.diagnosis import contacts as links_contacts
from reference_impl.diagnosis import diagnosis
from reference_impl.diagnosis import liquid as links_liquid
from reference_impl.diagnosis.diagnosis import Link, Suspect
from reference_impl.diagnosis.suspects import factor
from reference_impl.replay import coverage, transfer
from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import Run


def find(events: Run, contacts: Run, tables: transfer.Tables, failed: list[str]) -> dict[str, Any]:
    """Return the named faults of a run whose quantities `failed` are beyond their limits, for replay.json.

    For a long run only a part of each log is given (looked.py).
    """
    with np.errstate(all="ignore"):
        return diagnosis.diagnose(_links(events, contacts, tables, failed), failed)


def _links(run: Run, other: Run, tables: transfer.Tables, failed: list[str]) -> Iterator[Link]:
    wrong = "transfer_table" in failed
    if wrong:
        yield _table(run)
    e = links_liquid.events(run)
    expected = links_liquid.expected_shares(run, e, tables)
    for link in links_liquid.links(run, e, tables, expected, not wrong):
        yield link if link.quantity == "ledger" else replace(link, since=run.since)
    if other is not run:
        expected = links_liquid.expected_shares(other, links_liquid.events(other), tables)
    yield from links_contacts.links(other, expected[0] + expected[1])


def _table(run: Run) -> Link:
    """Return the link of the table of transfer ratios to the independent solution."""
    (where, logged, expected, tolerance), used = transfer.solved_nodes(run), coverage.law(run, "transfer")

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield Suspect("the transfer ratio is swapped (i gets what j should)", 1.0 - expected)
        yield Suspect("the liquid is shared half and half", np.full(len(expected), 0.5))
        for law in transfer.WALL_STRETCH.keys() - {used}:
            yield Suspect(f"the law is {law}, not {used}", transfer.of_law(run, where, law))
        yield from factor(logged, expected, rows)

    kinds = {"between spheres": 0, "at large walls": 1, "at wires": 2}
    marks = {name: (where["partner_kind"] == k).to_numpy() for name, k in kinds.items()}
    table = where.assign(step=0)
    return Link("transfer_table", "table of transfer ratios", table, logged, expected, np.ones(len(expected)), suspects,
                tolerance, marks=marks)  # fmt: skip
