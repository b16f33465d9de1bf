"""Find the bridge of a record: the events of a part of the log, and the bridges active at its start, by their ends."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from reference_impl.replay import laws
from reference_impl.replay.arrays import Floats, Table

FORMATION, RUPTURE, RETIREMENT = 0, 1, 2
"""Kinds of events; RETIREMENT: a bridge ends because a sphere is retired."""
WORD = (1 << 31) - 1
"""Bits of an end in a key."""


def keys(table: Table) -> Floats:
    """Return one number for the ends of each row's bridge; j of a wall and of a sphere are distinguished."""
    wall = (np.asarray(table["partner_kind"]) != laws.SPHERE).astype(np.int64)
    i, j = (np.asarray(table[name], dtype=np.int64) for name in "ij")
    return (wall << 62) | (i << 31) | j


@dataclass(frozen=True)
class ActiveBridges:
    """Active bridges: data logged at their formation, and the volume that they should have."""

    key: Floats
    step: Floats
    row: Floats
    """Index of the formation in the whole log."""
    volume: Floats
    rupture_distance: Floats
    speed: Floats
    """Relative speed of the two ends at the formation [m/s]."""
    recomputed: Floats

    def __len__(self) -> int:
        return len(self.key)

    def ends(self) -> Floats:
        """Return the spheres of each bridge, shape (n, 2), read from its key; -1 for a wall."""
        j = np.where(self.key >> 62, -1, self.key & WORD)
        return np.column_stack([(self.key >> 31) & WORD, j])

    def of(self, at: Floats) -> ActiveBridges:
        """Select some of the active bridges."""
        return ActiveBridges(*(getattr(self, name)[at] for name in ActiveBridges.__dataclass_fields__))


def none() -> ActiveBridges:
    """Make an empty list of active bridges, as at the start of a run."""
    whole, real = np.zeros(0, np.int64), np.zeros(0)
    return ActiveBridges(whole, whole, whole, real, real, real, real)


class Lives:
    """Active bridges and events as one list `all`: first those active at the start, then every event in its order."""

    def __init__(self, before: ActiveBridges, events: pd.DataFrame, first_row: int, start: int) -> None:
        n, self.start = len(events), start
        key, step = keys(events), events["step"].to_numpy(np.int64)
        kind = events["kind"].to_numpy()
        columns = (key, step, np.arange(first_row, first_row + n), events["volume"].to_numpy(float),
                   events["rupture_distance"].to_numpy(float), events["speed"].to_numpy(float), np.full(n, np.nan))  # fmt: skip
        earlier = (getattr(before, name) for name in ActiveBridges.__dataclass_fields__)
        self.all = ActiveBridges(*(np.concatenate(both) for both in zip(earlier, columns, strict=True)))
        self.formation = np.concatenate([np.ones(len(before), dtype=bool), kind == FORMATION])
        self._order = np.argsort(self.all.key, kind="stable")
        sorted_key = self.all.key[self._order]
        new = np.ones(len(sorted_key), dtype=bool)
        new[1:] = sorted_key[1:] != sorted_key[:-1]
        self._keys, rank = sorted_key[new], np.cumsum(new) - 1
        # bridge and step are encoded as one number; bridges active at the start count as formed before it
        self._span = max(int(step.max(initial=start)) - start, 0) + 2
        self._code = rank * self._span + np.maximum(self.all.step[self._order] - start, 0)
        self._ends = np.append(new[1:], True)[: len(new)]
        self._last, self._formed = np.flatnonzero(self._ends), self.formation[self._order]
        previous = np.full(len(sorted_key), -1)
        previous[1:] = np.where(new[1:], -1, self._order[:-1])
        previous = np.where((previous >= 0) & self.formation[previous], previous, -1)
        before_of = np.empty(len(sorted_key), np.int64)
        before_of[self._order] = previous
        self.previous = before_of[len(before) :]
        """Formation of each event's bridge in `all`, -1 if none was active."""

    @cached_property
    def _in_order(self) -> tuple[Floats, Floats]:
        """Return volume and static rupture distance in the order of the keys, and NaN for no bridge."""
        volume, distance = (np.append(v[self._order], np.nan) for v in (self.all.volume, self.all.rupture_distance))
        return volume, distance

    def formed_with(self, key: Floats, step: Floats, strictly: bool) -> tuple[Floats, Floats]:
        """Return volume and static rupture distance at the formation of each bridge that `at` finds; NaN if none is active."""
        if not len(self._keys):
            return np.full(len(key), np.nan), np.full(len(key), np.nan)
        place, there = self._places(key, step, strictly)
        place = np.where(there, place, -1)
        volume, distance = self._in_order
        return volume[place], distance[place]

    def at(self, key: Floats, step: Floats, strictly: bool) -> Floats:
        """Return the index in `all` of the formation of each bridge that is active at a step, -1 for none.

        `strictly`: events of that step itself have not happened yet.
        """
        if not len(self._keys):
            return np.full(len(key), -1)
        place, there = self._places(key, step, strictly)
        return np.where(there, self._order[place], -1)

    def _places(self, key: Floats, step: Floats, strictly: bool) -> tuple[Floats, Floats]:
        """Return the last record of each bridge up to a step, in the order of the keys, and whether it is a formation."""
        rank = np.minimum(np.searchsorted(self._keys, key), len(self._keys) - 1)
        first = rank * self._span
        until = first + np.minimum(step - self.start, self._span - 1) + (0 if strictly else 1)
        place = self._last[rank]
        # search backward from the bridge's last record: a chunk has few records of one bridge
        late = np.flatnonzero(self._code[place] >= until)
        while len(late):
            place[late] -= 1
            late = late[(place[late] >= 0) & (self._code[place[late]] >= until[late])]
        place_or_0 = np.maximum(place, 0)
        there = (place >= 0) & (self._code[place_or_0] >= first) & (self._keys[rank] == key) & self._formed[place_or_0]
        return place_or_0, there

    def active(self, step: int | None = None) -> ActiveBridges:
        """Return the bridges that are active after a step (None: at the end)."""
        if step is None:
            last = self._order[self._ends]
            return self.all.of(np.sort(last[self.formation[last]]))
        at = self.at(self._keys, np.full(len(self._keys), step), strictly=False)
        return self.all.of(at[at >= 0])
