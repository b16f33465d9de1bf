"""Forces felt by the films of sampled spheres, recomputed at every step at which drops may fall, and the resulting drops.

The specific force on a sphere is its change of velocity over the time since the previous check, minus gravity; a film
of volume L responds in the time sqrt(3 rho L/(32 pi sigma)) (Rayleigh 1879), from zero at the first check.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd

from reference_impl.replay import coverage, io, plans
from reference_impl.replay.arrays import Floats, size, vectors
from reference_impl.replay.bodies import bodies
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.drops import falls
from reference_impl.replay.io import Run, where

SAMPLES = 8
HALF_STEP = 0.05
"""Share of a velocity that may change in half a step, in the median."""
STANDARD = 9.81
"""Smallest scale of a deviation of the specific force [m/s2]."""


def check(run: Run) -> list[Quantity]:
    """Check force felt, drops and velocities of the sampled spheres; nothing without the closed form."""
    if coverage.law(run, "shedding") not in coverage.CLOSED["shedding"]:
        return []
    path = where(run.folder, "felt")
    table = io.table(path, "felt").sort_values(["id", "step"], ignore_index=True)
    _refuse(run, table)
    if not len(table):
        return []
    expected = recomputed(run, table)
    logged = vectors(table, "felt")
    scale = np.maximum(size(expected), STANDARD)
    found = compare("felt_force", "itself, at least 9.81 m/s2", logged, expected, scale, table)
    fell, due = drops(run, table, expected)
    of_drops = compare("felt_drops", "the larger drop", fell, due, np.maximum(np.maximum(due, fell), 1e-300), table)
    return [found, of_drops, _velocity(run, table)]


def _refuse(run: Run, table: pd.DataFrame) -> None:
    """Refuse a table that lacks a check, or a sampled sphere at one, and drops between checks."""
    ids = run.table("spheres")["id"].to_numpy(np.int64)
    most = (SAMPLES << 32) // max(len(ids), SAMPLES)
    wanted = ids[(ids * 2654435761) % (1 << 32) < most]
    looks, planned = table.groupby("step").size(), plans.plan(run.folder).steps
    every = plans.drops_every(io.scene(run.folder))
    if (run.shed["step"] % every != 0).any():
        raise io.ReplayError(
            f"{where(run.folder, io.SHED)} has drops between the checks, which are every {every} steps: run the case again"
        )
    whole = looks.index.tolist() == list(range(0, planned + 1, every))
    if not whole or sorted(table["id"].unique()) != sorted(wanted) or (looks != len(wanted)).any():
        raise io.ReplayError(
            f"{where(run.folder, 'felt')} holds {len(table)} rows of {table['id'].nunique()} spheres; expected the {len(wanted)} "
            "sampled ones at every step at which drops fall: run the case again"
        )


def recomputed(run: Run, table: pd.DataFrame) -> Floats:
    """Return the specific force felt by each film, from velocities and films alone."""
    scene = io.scene(run.folder)
    density, tension = scene["liquid"]["density_kg_per_m3"], scene["liquid"]["surface_tension_N_per_m"]
    gravity, dt = np.array(scene["gravity_m_per_s2"], dtype=float), float(scene["time_step_s"])
    expected = np.zeros((len(table), 3))
    v, film, step = vectors(table, "v"), table["film"].to_numpy(float), table["step"].to_numpy(np.int64)
    for rows in table.groupby("id").indices.values():
        for before, now in pairwise(rows):
            expected[now] = expected[before]
            if film[now] <= 0.0:
                continue
            span = (step[now] - step[before]) * dt
            force = (v[now] - v[before]) / span - gravity
            time = np.sqrt(3.0 * density * film[now] / (32.0 * np.pi * tension))
            expected[now] += (1.0 - np.exp(-span / time)) * (force - expected[before])
    return expected


def drops(run: Run, table: pd.DataFrame, expected: Floats) -> tuple[Floats, Floats]:
    """Volume shed at each check according to the log of drops, and the volume that must be shed."""
    liquid, radius = io.scene(run.folder)["liquid"], bodies(run).radius
    density, tension = liquid["density_kg_per_m3"], liquid["surface_tension_N_per_m"]
    due = np.array([
        falls(film, radius[i], float(a), density, tension) if film > 0.0 else 0.0
        for i, film, a in zip(table["id"], table["film"], size(expected), strict=True)
    ])  # fmt: skip
    logged = run.shed.set_index(["step", "i"])["volume"]
    fell = logged.reindex(pd.MultiIndex.from_frame(table[["step", "id"]])).fillna(0.0).to_numpy(float)
    return fell, due


def _velocity(run: Run, table: pd.DataFrame) -> Quantity:
    """Compare logged velocities with the trajectory at output steps, in the median: they are half a step old."""
    columns = ["step", "id", "vx", "vy", "vz"]
    both = table.merge(io.columns(where(run.folder, "trajectory"), columns), on=["step", "id"])
    expected = both[["vx", "vy", "vz"]].to_numpy(float)
    if not len(both):
        none = np.zeros(0)
        return compare("felt_velocity", "median velocity", none, none, none, both, HALF_STEP)
    off, typical = float(np.median(size(vectors(both, "v") - expected))), float(np.median(size(expected)))
    one = both.iloc[[int(np.argmax(size(vectors(both, "v") - expected)))]]
    scale = np.array([max(typical, 0.01)])
    return compare("felt_velocity", "median velocity, or 1 cm/s", np.array([off]), np.zeros(1), scale, one, HALF_STEP)
