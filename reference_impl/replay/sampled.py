"""Records sampled from a whole log for expensive checks: of all records only the data for the choice are stored."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.replay import between_nodes, coverage, exact, forces
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import Pairs, bodies, pairs, shapes
from reference_impl.replay.compare import Quantity
from reference_impl.replay.forces import Contacts
from reference_impl.replay.io import Run, where
from reference_impl.replay.lives import FORMATION
from reference_impl.replay.stream import taken
from reference_impl.replay.transfer import SMALLEST

Parts = list[tuple[Floats, ...]]


def joined(parts: Parts, count: int) -> list[Floats]:
    """Join columns over all parts, which are emptied."""
    found = [np.concatenate([np.zeros(0), *(p[k] for p in parts)]) if not parts else
             np.concatenate([p[k] for p in parts]) for k in range(count)]  # fmt: skip
    parts.clear()
    return found


class Samples:
    """Sampled events and contacts."""

    def __init__(self, run: Run) -> None:
        self.run, self.events, self.ruptures, self.contacts = run, 0, 0, 0
        self._limits: Parts = []
        self._ratios: Parts = []
        self._pulls: Parts = []

    def add_events(self, events: pd.DataFrame, p: Pairs, first: int) -> None:
        """Add a chunk of the event log; `first` is the number of its first row."""
        self.events += len(events)
        volume, broke = events["volume"].to_numpy(float), events["kind"].to_numpy() != FORMATION
        self.ruptures += int(broke.sum())
        if coverage.solved(self.run, "rupture"):
            self._limits.append((events["partner_kind"].to_numpy(np.int8), volume.copy(), p.ri.astype(np.float32)))
        if coverage.law(self.run, "transfer") in between_nodes.PER_ROW:
            kind, type_i, other, v_star = shapes(p, volume, bodies(self.run))
            use = np.flatnonzero(broke & (v_star >= SMALLEST) & (v_star <= between_nodes.LARGEST))
            name = ((kind[use] * 1000 + type_i[use]) * 1000 + other[use]).astype(np.int32)
            self._ratios.append((name, v_star[use], (first + use).astype(np.int64)))

    def add_contacts(self, c: Contacts, first: int) -> None:
        """Add one chunk of the contact log."""
        self.contacts += len(c.table)
        if coverage.solved(self.run, "capillary"):
            part = np.maximum(c.gap, 0.0) / c.column("rupture_distance")
            self._pulls.append((np.asarray(c.table["partner_kind"], dtype=np.int8), part, c.volume.copy()))

    def _rows(self, name: str, rows: Any) -> pd.DataFrame:
        return taken(where(self.run.folder, name), name, np.asarray(rows, np.int64))

    def of_events(self) -> list[Quantity]:
        """Check the static rupture distance of the exact bridge."""
        if not coverage.solved(self.run, "rupture"):
            return []
        kind, volume, ri = joined(self._limits, 3)
        rows = exact.chosen(exact.RUPTURES, kind, np.log(volume), ri) if len(kind) else []
        events = self._rows("events", rows)
        p = pairs(events, bodies(self.run))
        return [replace(exact.check_rupture(events, p.wall, p.ri, p.rj, p.ti, p.tj), sample_of=self.events)]

    def of_contacts(self) -> list[Quantity]:
        """Check the capillary force of the exact bridge."""
        if not coverage.solved(self.run, "capillary"):
            return []
        kind, part, volume = joined(self._pulls, 3)
        rows = exact.chosen(exact.FORCES, kind, part, volume) if len(kind) else []
        table = self._rows("contacts", rows)
        c = forces.contacts(replace(self.run, tables={**self.run.tables, "contacts": table}))
        found = exact.check_force(table, c.gap, self.run.meta["surface_tension"], c.wall, c.ri, c.rj, c.ti, c.tj)
        return [replace(found, sample_of=self.contacts)]

    def between_nodes(self) -> list[Quantity]:
        """Check the interpolated transfer ratios of ruptures spread evenly over V* for each pair of bodies."""
        law = coverage.law(self.run, "transfer")
        if law not in between_nodes.PER_ROW or not self.ruptures:
            return []
        name, v_star, row = joined(self._ratios, 3)
        picked = []
        for one in np.unique(name):
            of = np.flatnonzero(name == one)
            of = of[np.argsort(v_star[of], kind="stable")]
            every = between_nodes.PER_ROW[law]
            of = of[np.unique(((np.arange(every) + 0.5) / every * len(of)).astype(int))]
            picked.append(row[of[np.unique(v_star[of], return_index=True)[1]]])
        if not picked:
            return []
        events = self._rows("events", np.concatenate(picked))
        found = between_nodes.check(replace(self.run, tables={**self.run.tables, "events": events}))
        return [replace(q, sample_of=self.ruptures) for q in found]
