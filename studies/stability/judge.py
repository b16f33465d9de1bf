"""Judge each cell of a finished run: finite values, its ledger, its energy, and the independent replay of the run.

The energy of a cell is kinetic and spin energy, contact springs of its touching spheres, capillary energy of its
active bridges. It may fall (drag, dashpot, friction), and changes by known amounts when a bridge forms, ruptures, or
gravity works. Any excess was created by the time stepping. Cells on moving walls are judged by the run's energy
budget instead.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pywet.laws import registry
from pywet.schema import FORMATION, SPHERE, WORKS
from pywet.util.files import read_table
from studies.stability.cells import Batch, reduced_mass

Floats = NDArray[np.float64]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)
LEDGER = 1e-12


class Run:
    """Tables of a finished run and the constant data of its spheres."""

    def __init__(self, batch: Batch, run_dir: Path) -> None:
        self.batch, history = batch, run_dir / "history"
        self.trajectory = read_table(run_dir / "trajectory.parquet")
        self.events = read_table(history / "events.parquet")
        self.bridges = read_table(history / "bridges.parquet")
        self.films = read_table(history / "films.parquet")
        spheres = read_table(history / "spheres.parquet")
        self.first = np.concatenate([[0.0], spheres["film"].to_numpy(float)])
        kinds = np.concatenate([[1], spheres["type"].to_numpy(int)])
        self.kind = kinds
        self.radius = np.array([batch.classes[k - 1].radius_m for k in kinds])
        self.mass = np.array([batch.classes[k - 1].mass_kg for k in kinds])
        self.angle = np.array([batch.classes[k - 1].contact_angle_rad for k in kinds])
        names = {cell.name: n for n, cell in enumerate(batch.cells)}
        self.cell = np.array([0, *(names[owner] for owner in batch.owner()[1:])])
        self.steps = np.sort(self.trajectory["step"].unique())

    def by_cell(self, table: pd.DataFrame, sphere: str, value: Floats) -> Floats:
        """Sum of a value over the rows of each output step and cell, shape (steps, cells)."""
        out = np.zeros((len(self.steps), len(self.batch.cells)))
        at = np.searchsorted(self.steps, table["step"].to_numpy())
        keep = at < len(self.steps)
        np.add.at(out, (at[keep], self.cell[table[sphere].to_numpy(int)][keep]), value[keep])
        return out

    def bridge_law(self, table: pd.DataFrame) -> tuple[Floats, Callable[[Floats], Floats], list[Floats]]:
        """Return each row's gap [m], its capillary force as a function of the gap, and V, r_i, r_j, theta_i, theta_j."""
        i, wall = table["i"].to_numpy(int), table["partner_kind"].to_numpy(int) != SPHERE
        j = np.where(wall, 0, table["j"].to_numpy(int))
        other, angle = np.where(wall, np.inf, self.radius[j]), np.where(wall, self.batch.wall_angle, self.angle[j])
        bridge = [table["volume"].to_numpy(float), self.radius[i], other, self.angle[i], angle]
        law = registry.get("capillary", str(self.batch.effects.capillary)).functions[0]
        sigma = self.batch.liquid.surface_tension_N_per_m
        return table["separation"].to_numpy(float), lambda gap: law._ufunc(gap, *bridge, sigma), bridge


def stored(run: Run, table: pd.DataFrame) -> Floats:
    """Return the capillary energy of each row's bridge [J]: minus the integral of the force from S to static rupture."""
    if table.empty or not run.batch.effects.capillary:
        return np.zeros(len(table))
    rupture = registry.get("rupture", str(run.batch.effects.rupture)).functions[0]
    gap, force, bridge = run.bridge_law(table)
    with np.errstate(all="ignore"):
        low, high = np.sqrt(np.maximum(gap, 0.0)), np.sqrt(rupture._ufunc(*bridge))
        total = np.where(gap < 0.0, -gap * force(0.0 * gap), 0.0)
        for x, w in zip(NODES, WEIGHTS, strict=True):
            u = low + (high - low) * 0.5 * (1.0 + x)
            total += 0.5 * w * (high - low) * 2.0 * u * force(u * u)
    return np.asarray(-total, dtype=np.float64)


def pull(run: Run, table: pd.DataFrame) -> Floats:
    """Return the capillary force of each row's bridge at its separation [N]."""
    if table.empty or not run.batch.effects.capillary:
        return np.zeros(len(table))
    gap, force, _ = run.bridge_law(table)
    with np.errstate(all="ignore"):
        return np.asarray(force(gap), dtype=np.float64)


def springs(run: Run) -> Floats:
    """Return the energy stored in the contact stiffness between touching spheres, shape (steps, cells) [J]."""
    stiffness = {(p.a, p.b): p.normal_stiffness_N_per_m for p in run.batch.pairs}
    out = np.zeros((len(run.steps), len(run.batch.cells)))
    where = run.trajectory.pivot_table(index="step", columns="id", values=["x", "y", "z"])
    for n in range(len(run.batch.cells)):
        members = np.flatnonzero(run.cell == n)
        members = members[members > 0]
        at = np.stack([where[a][members].to_numpy(float) for a in "xyz"], axis=2)
        for (p, a), (q, b) in combinations(enumerate(members), 2):
            gap = np.linalg.norm(at[:, p] - at[:, q], axis=1) - run.radius[a] - run.radius[b]
            k = stiffness[tuple(sorted((int(run.kind[a]), int(run.kind[b]))))]  # type: ignore[index]
            out[:, n] += 0.5 * k * np.minimum(gap, 0.0) ** 2
    return out


def moving(run: Run) -> Floats:
    """Return the kinetic and spin energy, shape (steps, cells) [J]."""
    t = run.trajectory
    i = t["id"].to_numpy(int)
    speed = (t[["vx", "vy", "vz"]].to_numpy(float) ** 2).sum(axis=1)
    spin = (t[["wx", "wy", "wz"]].to_numpy(float) ** 2).sum(axis=1)
    return run.by_cell(t, "id", 0.5 * run.mass[i] * (speed + 0.4 * run.radius[i] ** 2 * spin))


def falling(run: Run) -> Floats:
    """Return the potential energy in gravity, shape (steps, cells) [J]."""
    t = run.trajectory
    height = t[["x", "y", "z"]].to_numpy(float) @ np.asarray(run.batch.gravity)
    return run.by_cell(t, "id", -run.mass[t["id"].to_numpy(int)] * height)


def ledgers(run: Run) -> Floats:
    """Return the error of each cell's liquid over its liquid, the largest over all outputs, shape (cells,)."""
    films = run.by_cell(run.films, "id", run.films["film"].to_numpy(float))
    active = run.by_cell(run.bridges, "i", run.bridges["volume"].to_numpy(float))
    wall = run.events[run.events["partner_kind"] != SPHERE]
    sign = np.where(wall["kind"] == FORMATION, -1.0, 1.0)
    on_walls = np.cumsum(run.by_cell(_at_output(run, wall), "i", sign * wall["share_j"].to_numpy(float)), axis=0)
    first = np.zeros(len(run.batch.cells))
    np.add.at(first, run.cell[1:], run.first[1:])
    error = np.abs(films + active + on_walls - first).max(axis=0)
    return np.asarray(error / np.where(first > 0.0, first, 1.0), dtype=np.float64)


def _at_output(run: Run, events: pd.DataFrame) -> pd.DataFrame:
    """Return the events with the step of the first output that includes them."""
    at = np.searchsorted(run.steps, events["step"].to_numpy())
    known = np.append(run.steps, run.steps[-1] + 1)[at]
    return events.assign(step=known)


def energies(run: Run) -> tuple[Floats, Floats, Floats]:
    """Return the spurious energy over the energy in play, its bound by the order of the method, and all spurious energy.

    Each has the shape (cells,). Allowed are the force at each event times the displacement of one step (a bridge acts from the
    step after its formation on), a third of k dt²/m of the energy in play (the oscillation of leapfrog integration), and
    round-off of positions.
    """
    kinetic, touching, potential = moving(run), springs(run), falling(run)
    active = run.by_cell(run.bridges, "i", stored(run, run.bridges))
    energy_of = stored(run, run.events)
    sign = np.where(run.events["kind"] == FORMATION, 1.0, -1.0)
    known = _at_output(run, run.events)
    booked = np.cumsum(run.by_cell(known, "i", sign * energy_of), axis=0)
    total = kinetic + touching + potential + active - booked
    lag = pull(run, run.events) * run.events["speed"].to_numpy(float) * run.batch.time_step
    late = np.cumsum(run.by_cell(known, "i", 1.5 * lag), axis=0)
    gained = total - total[0] - late
    inside = potential - potential.min(axis=0)
    swing = np.cumsum(run.by_cell(known, "i", np.abs(energy_of)), axis=0)
    play = np.maximum.accumulate(kinetic + touching + inside, axis=0) + np.abs(active) + swing
    stiffest = max(p.normal_stiffness_N_per_m for p in run.batch.pairs)
    play = np.maximum(play, 0.5 * stiffest * (1e-9 * run.radius.min()) ** 2)  # positions below this are round-off
    made, raw = np.max(gained / play, axis=0), np.max((total - total[0]) / play, axis=0)
    held = (touching + np.abs(active)).max(axis=0) / play.max(axis=0)
    return made, np.array([order(run, n) for n in range(len(run.batch.cells))]) + held * rounding(run, kinetic), raw


def rounding(run: Run, kinetic: Floats) -> Floats:
    """Return the last digit of a position over the displacement of one step, the relative error of ranges, shape (cells,)."""
    coordinate = float(np.abs(run.trajectory[["x", "y", "z"]].to_numpy(float)).max())
    way = np.sqrt(2.0 * kinetic.max(axis=0) / run.mass.min()) * run.batch.time_step
    return np.asarray(np.minimum(1.0, np.spacing(coordinate) / np.maximum(way, 1e-300)), dtype=np.float64)


def order(run: Run, cell: int) -> float:
    """Return a third of the largest k dt²/m of a cell's contacts, plus 1e-9 for round-off."""
    kinds = {b.kind for b in run.batch.cells[cell].bodies}
    walls = bool(run.batch.cells[cell].walls)
    largest = 0.0
    for p in run.batch.pairs:
        if p.a in kinds and (p.b in kinds or (p.b == 0 and walls)):
            m = reduced_mass(run.batch.classes, p.a, p.b)
            largest = max(largest, p.normal_stiffness_N_per_m * run.batch.time_step**2 / m)
    return largest / 3.0 + 1e-9


def verdicts(batch: Batch, run_dir: Path) -> dict[str, dict[str, Any]]:
    """Return the verdict on each cell of a finished run, by its name.

    ledger: largest error of its liquid over its liquid. made: energy created over the energy in play; below zero:
    all of it was lost or stored. allowed: its limit by the order of the method. raw: `made` with nothing
    subtracted for the step between a bridge's formation and its first force. message: nothing, as no guard stopped
    it.
    """
    run = Run(batch, run_dir)
    columns = ["x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"]
    good = np.isfinite(run.trajectory[columns].to_numpy(float)).all(axis=1).astype(float)
    finite = run.by_cell(run.trajectory, "id", 1.0 - good).sum(axis=0) == 0.0
    ledger = ledgers(run)
    made, allowed, raw = energies(run)
    if batch.vibration is not None:  # moving walls add energy, so the energy budget of the run is used
        made, raw = 0.0 * made, 0.0 * raw
    count = np.bincount(run.cell[run.events["i"].to_numpy(int)], minlength=len(batch.cells))
    fine = np.where(made <= allowed, "stable", "energy")  # NaN counts as energy created
    state = np.select([~finite, ledger > LEDGER], ["not finite", "ledger"], fine)
    names = [cell.name for cell in batch.cells]
    reported = {
        "state": state,
        "message": "",
        "ledger": ledger,
        "made": made,
        "allowed": allowed,
        "events": count,
        "raw": raw,
    }
    return pd.DataFrame(reported, index=names).to_dict("index")  # type: ignore[return-value]


def budget(run_dir: Path) -> dict[str, float]:
    """Return the residual of the run's energy budget, which the integrator's identity leaves, and the work of the normal drag
    (never above zero).
    """
    energy = read_table(run_dir / "history" / "energy.parquet")
    moved = energy["kinetic"] + energy["spin"]
    left = moved - moved.iloc[0] - energy[WORKS].sum(axis=1) - energy["half_kick"]
    turnover = max(float(energy[WORKS].abs().sum(axis=1).max() + moved.max()), 1e-300)
    return {
        "identity": float(left.abs().max() / turnover),
        "drag": float(max(energy["viscous_normal"].max(), 0.0) / turnover),
    }
