"""Source `dry`: two dry spheres that collide, head on and obliquely, in LIGGGHTS and in YADE, against the contact law solved.

The exact solution is that of the law of both programs (linear spring and dashpot, tangential spring limited by
Coulomb friction), integrated with steps a thousand times shorter than theirs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from pywet.cases.small import small
from pywet.cases.small.bodies import contacts, sphere_classes
from pywet.errors import PywetError
from pywet.laws.contact import damping
from pywet.util.files import read_table
from studies.cross_code.model import Cell, Source, empty, impossible, measured, not_run, truth
from studies.cross_code.replayed import momenta
from studies.cross_code.rows import EASO, EXACT, LIGGGHTS, REFERENCE, SAME, WASHINO, YADE

R, STIFFNESS, RESTITUTION, FRICTION, SPEED = 2.5e-3, 1e7, 0.8, 0.3, 0.2
"""Parameters for which the line of centres, fixed in the exact solution, turns by at most 1e-4 rad in contact."""
TWO = sphere_classes(R, counts=2)
PARTS = 200
"""Number of the programs' steps in a collision."""
FINER = 1000
ANGLES = {"restitution": 0.0, "oblique_stick": 10.0, "oblique_slide": 60.0}
"""Row -> angle of impact [deg]."""
MOVING = np.array([0.3, -0.5, 0.8]) / math.sqrt(0.98)
"""Direction of the line of centres, not in any coordinate plane."""
ACROSS = np.cross(MOVING, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(MOVING, [0.0, 0.0, 1.0]))


class Outcome(NamedTuple):
    """State after the impact over SPEED: relative normal and tangential velocity, and the spin times the radius."""

    normal: float
    tangential: float
    spin: float


def law() -> tuple[float, float, float]:
    """Return reduced mass, damping [N s/m] and duration of the contact [s]; γ from the restitution (E 5)."""
    mass = 0.5 * TWO[0].mass_kg
    dashpot = damping(RESTITUTION, mass, STIFFNESS)
    zeta = dashpot / (2.0 * math.sqrt(mass * STIFFNESS))
    return mass, dashpot, math.pi * math.sqrt(mass / STIFFNESS) / math.sqrt(1.0 - zeta**2)


def exact(angle_deg: float) -> Outcome:
    """Compute the impact of two equal spheres by the contact law, semi-implicit Euler with PARTS × FINER steps."""
    mass, dashpot, duration = law()
    step = duration / PARTS / FINER
    delta, approach = 0.0, SPEED * math.cos(math.radians(angle_deg))
    slide, spin, stretch = SPEED * math.sin(math.radians(angle_deg)), 0.0, 0.0
    spring = 2 / 7 * STIFFNESS
    started = False
    while not started or delta > 0.0:
        started = True
        normal = STIFFNESS * delta + dashpot * approach
        slip = slide - 2.0 * spin  # both spheres rotate in the same direction; spin is R ω
        stretch += slip * step
        force, limit = spring * stretch, FRICTION * abs(normal)
        if abs(force) > limit:
            force = math.copysign(limit, force)
            stretch = force / spring
        approach -= normal / mass * step
        slide -= force / mass * step
        spin += force / (0.4 * 2.0 * mass) * step
        delta += approach * step
    return Outcome(-approach / SPEED, slide / SPEED, spin / SPEED)


def source(folder: Path) -> Source:
    """Compute the cells of the rows on dry contacts."""
    cells: list[Cell] = []
    for row, angle in ANGLES.items():
        best = exact(angle)
        cells += _truths(row)
        for column, drive in ((LIGGGHTS, small.run), (YADE, _yade)):
            run = folder / f"{row}_{column}"
            try:
                drive(run, prepare(run, angle))
            except PywetError as error:
                cells.append(not_run(row, column, str(error)))
                continue
            cells += _judged(row, column, best, run)
    return Source("dry", cells)


def _truths(row: str) -> Iterator[Cell]:
    if row == "restitution":
        yield truth(row, EXACT, f"linear spring and dashpot: e = {RESTITUTION} as configured", 1)
    else:
        yield truth(row, EXACT, f"contact law integrated with steps {FINER} times shorter", 2)
    yield impossible(row, REFERENCE, "the reference replays logged contacts; a dry run on the stock program logs none")
    yield from empty(row, dict.fromkeys((WASHINO, EASO), SAME))
    if row == "oblique_slide":
        yield impossible("momentum_dry", EXACT, "a conserved quantity needs no solution: the deviation is what is lost")
        yield from empty("momentum_dry", dict.fromkeys((REFERENCE, WASHINO, EASO), "not run for this row"))


def _judged(row: str, column: str, best: Outcome, folder: Path) -> Iterator[Cell]:
    """Yield the deviation after the impact, and the momentum of the sliding impact."""
    table = read_table(folder / "trajectory.parquet")
    outcome, link = read(table), f"runs/{folder.name}/"
    note = f"{PARTS} steps in the contact, first order in the step"
    if row == "restitution":
        yield measured(row, column, np.array([outcome.normal]), np.array([RESTITUTION]), note=note, link=link)
        return
    names = ["tangential velocity", "spin"]
    one, other = np.array(outcome[1:]), np.array(best[1:])
    yield measured(row, column, one, other, np.ones(2), at=names, note=note, link=link)
    if row == "oblique_slide":
        linear, _, (size, _) = momenta(table, TWO)
        lost = np.linalg.norm(linear - linear[0], axis=1)
        yield measured(
            "momentum_dry", column, lost, 0.0 * lost, np.full(len(lost), size), note="largest change", link=link
        )


def read(table: pd.DataFrame) -> Outcome:
    """Return velocities and spin after the impact, along the line of centres at the first touch and across it."""
    end = table[table["step"] == table["step"].max()].sort_values("id")
    v, w = (end[[f"{q}{a}" for a in "xyz"]].to_numpy(float) for q in ("v", "w"))
    apart = v[0] - v[1]
    axis = -np.cross(MOVING, ACROSS)
    return Outcome(
        float(-apart @ MOVING) / SPEED, float(apart @ ACROSS) / SPEED, float(w.mean(axis=0) @ axis) * R / SPEED
    )


def prepare(folder: Path, angle_deg: float) -> list[small.Sphere]:
    """Return two spheres that touch in the first step; sphere 1 approaches along MOVING, sideways along ACROSS."""
    _, _, duration = law()
    along, side = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    v = 0.5 * SPEED * (along * MOVING + side * ACROSS)
    step = duration / PARTS
    at = MOVING * (R + 0.25 * SPEED * along * step)  # contact begins half a step after the start
    bodies = [small.Sphere(1, tuple(-at), tuple(v)), small.Sphere(1, tuple(at), tuple(-v))]
    steps = PARTS + 20
    small.prepare(
        folder, TWO, bodies, contacts(1, STIFFNESS, friction=FRICTION, restitution=RESTITUTION),
        effects=small.DRY.model_copy(update={"rolling": False}), time_step_s=step, steps=steps,
        output_interval_s=step * (steps // 10),
    )  # fmt: skip
    return bodies


def _yade(folder: Path, spheres: list[small.Sphere]) -> None:
    from pywet.engines.yade import driver

    driver.run(folder, progress=False)
