"""Compare the snapshots of films and bridges at every output with the events."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reference_impl.motion import impulses, nearest
from reference_impl.replay import coverage, laws, liquid
from reference_impl.replay.arrays import Floats, size, vectors
from reference_impl.replay.bodies import bodies, pairs, shapes
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.formations import setup_steps
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


def outlived(run: Run, lives: Lives) -> tuple[pd.DataFrame, Floats, Floats]:
    """Return the bridges at outputs that have stood a neighbour check, their gaps, and those that none can have.

    A speed at an output differs by half a kick from that of the check.
    """
    bridges, known = run.table("bridges"), coverage.known(run, "dynamic_rupture")
    at = lives.at(keys(bridges), bridges["step"].to_numpy(np.int64), strictly=False)
    step, formed = bridges["step"].to_numpy(np.int64), np.append(lives.all.step, 0)[at]
    rows = np.flatnonzero((at >= 0) & (formed < step - impulses.every(run)) & ~np.isin(step, setup_steps(run)) & known)
    table, static = bridges.iloc[rows].reset_index(drop=True), lives.all.rupture_distance[at[rows]]
    wall, speeds = table["partner_kind"].to_numpy() != laws.SPHERE, run.table("trajectory").set_index(["step", "id"])
    vi, vj = (
        speeds.reindex(pd.MultiIndex.from_arrays([table["step"], table[end]]))[["vx", "vy", "vz"]].to_numpy(
            float, copy=True
        )
        for end in ("i", "j")
    )
    if wall.any():
        of = table[wall]
        vj[wall] = nearest.parts(run).velocity(of["step"].to_numpy(), vectors(of, "xj"), of["j"].to_numpy())
    most = liquid.FASTER * size(vi - vj) + liquid.change(run)
    return table, table["separation"].to_numpy(float), liquid.limits(run, static, most)


def check(run: Run, tables: Tables, lives: Lives, outputs: Floats, shots: Floats) -> list[Quantity]:
    """Check all snapshots in a part of the log."""
    rows, gap, limit = outlived(run, lives)
    wrong, zero = (gap > limit * (1.0 + 1e-9)).astype(float), np.zeros(len(rows))
    late = compare("snapshot_beyond_limit", "bridges that should have ruptured", wrong, zero, zero + 1.0, rows, 0.0)
    return [*films_at_outputs(run, outputs, shots), *active_at_outputs(run, tables, lives), late]
