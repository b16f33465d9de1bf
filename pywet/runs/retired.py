"""Retired spheres in the tables at outputs: at rest at their last position, with the liquid they had.

Every table therefore contains all spheres, and its readers need not handle retirement.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.runs.rundir import RunDir
from pywet.runs.tables import in_order, read_raw

MOTION = ("vx", "vy", "vz", "wx", "wy", "wz")
ROWS = 1 << 18
"""Number of rows of a part of a table at whose steps all spheres have been retired."""


def records(folder: Path) -> np.ndarray:
    """Return the records of retired spheres, in the order of steps and ids."""
    return in_order(read_raw(folder, "retired"), ["step", "id"])


def with_films(parts: Iterator[np.ndarray], retired: np.ndarray, empty: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the records of films or impulses at complete outputs, with those of the spheres that were retired at or before each.

    `empty`: output steps from the removal of the last sphere on.
    """
    kind: np.dtype | None = None
    for steps, part in chain(((np.unique(part["step"]), part) for part in parts), _after_all(empty, retired)):
        if part is None and kind is None:
            return
        kind = part.dtype if part is not None else kind
        step, gone = _later(steps, retired, with_its_step=True)
        more = np.zeros(len(gone), kind)
        more["step"], more["id"] = step, gone["id"]
        if kind is not None and "film" in (kind.names or ()):
            more["film"] = gone["film"]
        yield more if part is None else np.concatenate([part, more])


def with_places(
    parts: Iterator[pd.DataFrame], retired: np.ndarray, time_step: float, empty: np.ndarray
) -> Iterator[pd.DataFrame]:
    """Yield parts of the trajectory, complete outputs, with the spheres retired before each, at rest at their last position.

    `empty`: output steps after the retirement of the last sphere.
    """
    last = pd.DataFrame()
    for steps, part in chain(((part["step"].unique(), part) for part in parts), _after_all(empty, retired)):
        last = last[:0] if part is None else part
        step, gone = _later(steps, retired, with_its_step=False)
        rows = {"step": step, "time": step * time_step, "id": gone["id"].astype(np.int64)}
        rows |= {"type": gone["type"].astype(np.int64), **{axis: gone["x"][:, k] for k, axis in enumerate("xyz")}}
        more = pd.DataFrame({**rows, **dict.fromkeys(MOTION, 0.0)}, columns=last.columns)
        yield pd.concat([last, more], ignore_index=True).sort_values(["step", "id"], kind="stable", ignore_index=True)


def taken_out(run: RunDir) -> tuple[np.ndarray, np.ndarray]:
    """Find which spheres have left through an outlet before each output, and how much liquid each outlet has removed.

    Returns
    -------
    gone : ndarray of bool, shape (outputs, spheres)
    booked : ndarray of float, shape (outputs, outlets)
        Liquid that has left through each outlet.
    """
    line, outlets = run.timeline, run.scene.outlets
    gone = np.zeros((len(line.steps), len(line.ids)), dtype=bool)
    booked = np.zeros((len(line.steps), len(outlets)))
    if not outlets:
        return gone, booked
    table = run.table("history/retired")
    step, outlet = (table[name].to_numpy(dtype=np.int64) for name in ("step", "outlet"))
    gone[:, np.searchsorted(line.ids, table["id"].to_numpy())] = line.steps[:, None] > step
    films = np.where(line.steps[:, None] >= step, table["film"].to_numpy(dtype=float), 0.0)
    for k in range(len(outlets)):
        booked[:, k] = films[:, outlet == k + 1].sum(axis=1)
    return gone, booked


def _after_all(steps: np.ndarray, retired: np.ndarray) -> Iterator[tuple[np.ndarray, None]]:
    """Divide the steps after the retirement of the last sphere so that a part has about `ROWS` rows."""
    for some in np.array_split(steps, 1 + len(steps) * len(retired) // ROWS) if len(steps) else ():
        yield some, None


def _later(steps: np.ndarray, retired: np.ndarray, with_its_step: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return step and record of every retired sphere at each later output; with `with_its_step` also at the output of its own
    step.
    """
    count = np.searchsorted(retired["step"], steps, "right" if with_its_step else "left")
    which = np.concatenate([np.arange(n) for n in count]) if len(count) else np.zeros(0, int)
    return np.repeat(steps, count), retired[which]
