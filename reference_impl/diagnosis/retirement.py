"""Faults of retired spheres: which spheres, their positions, and which bridges ended with them (see diagnosis.py).

Their films are checked with those of the snapshots (chain.py).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reference_impl.diagnosis.diagnosis import Link, Suspect
from reference_impl.replay import retired
from reference_impl.replay.io import Run

FAULTS = {
    "retired_who": "it does not qualify: it lies too high or is too fast",
    "retired_missed": "it qualifies and was not retired",
    "retired_place": "its place is not that of the output at which it was retired",
    "retired_speed": "its speed is not that of the output at which it was retired",
    "retired_rest": "it moves after it was retired",
    "retired_events": "it ends by retirement where no sphere of it is retired, or happens to a sphere that was retired before",
    "retired_bridges": "it exists although a sphere of it was retired",
}
WHAT = {"retired_events": "event of a bridge", "retired_bridges": "bridge in a snapshot"}


def links(run: Run) -> Iterator[Link]:
    """Diagnose each deviation of retired spheres separately."""
    for q, rows, deviation, limit in retired.Count(run).deviations(run):

        def suspects(broken: np.ndarray, name: str = q, logged: np.ndarray = deviation) -> Iterator[Suspect]:
            yield Suspect(FAULTS[name], logged, general=True)

        table = rows.rename(columns={"id": "i"})
        one = np.ones(len(rows))
        yield Link(q, WHAT.get(q, "retired sphere"), table, deviation, 0.0 * one, one, suspects, max(limit, 1e-300),
                   says=lambda _, q=q: FAULTS[q])  # type: ignore[misc]  # fmt: skip
