"""Compare the snapshots of films and bridges at every output with the events."""

from __future__ import annotations

import numpy as np

from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import bodies, pairs, shapes
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run
from reference_impl.replay.lives import Lives, keys
from reference_impl.replay.transfer import Tables


def active_at_outputs(run: Run, tables: Tables, lives: Lives) -> list[Quantity]:
    """Check volumes and shares of the bridges at every output."""
    bridges, fixed = run.table("bridges"), bodies(run)
    at = lives.at(keys(bridges), bridges["step"].to_numpy(np.int64), strictly=False)
    volume = np.append(lives.all.recomputed, np.nan)[at]
    share = volume * tables.ratios(*shapes(pairs(bridges, fixed), volume, fixed))
    logged_volume, logged_share = (bridges[name].to_numpy(float) for name in ("volume", "share_i"))
    return [
        compare("snapshot_volume", "itself", logged_volume, volume, volume, bridges),
        compare("snapshot_share", "volume of the bridge", logged_share, share, volume, bridges),
    ]


def films_at_outputs(run: Run, outputs: Floats, shots: Floats) -> list[Quantity]:
    """Check films of spheres and walls at every output; `shots`: all liquid at the output steps by reservoir."""
    fixed, found = bodies(run), []
    for name, number, first in (("films", "id", 0), ("wall_films", "triangle", fixed.walls_from)):
        table = run.table(name)
        at = table[number].to_numpy()
        of, part = (fixed.film_of[at], fixed.share_of(at)) if first else (at, 1.0)
        mine = shots[np.searchsorted(outputs, table["step"].to_numpy()), first + of] * part
        size = np.full(len(table), float(run.table("spheres")["film"].mean()))
        logged = table["film"].to_numpy(float)
        found.append(compare(f"snapshot_{name}", "mean film of a sphere", logged, mine, size, table))
    return found


def check(run: Run, tables: Tables, lives: Lives, outputs: Floats, shots: Floats) -> list[Quantity]:
    """Check all snapshots in a part of the log."""
    return [*films_at_outputs(run, outputs, shots), *active_at_outputs(run, tables, lives)]
