"""Single dry contacts of a screening case in both engines: restitution and friction at the case's own time step.

One scene for each engine: head-on collisions of every pair of spheres and of every sphere with a plate, each at several instants
of touch within a step, and one sphere of each class that slides on the plate.
"""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from pywet import config, stages
from pywet.cases.screening import cases
from pywet.cases.small import small
from pywet.cases.small.bodies import last
from pywet.util.files import read_table

SPEED = 0.3
"""Speed of approach [m/s], about the peak speed of the screen."""
PHASES = 6
PITCH = 0.03
GAP = 2e-4
GRAVITY = 9.81
CASE = 1
"""Screening case with these contacts."""
ENGINES = {"LIGGGHTS": "liggghts", "YADE": "yade"}


Site = tuple[int, int, int]
"""One collision: its pair a, b (b = 0: the plate) and the id of the first sphere from 1; the second one follows it."""


def rows(config_dir: Path, folder: Path) -> list[dict[str, Any]]:
    """Return measured coefficients and those of the scene, one row per pair, quantity and engine."""
    made = cases.ingredients(config.load(config_dir).without_rolling(), CASE, "smoke")
    table = []
    for name, engine in ENGINES.items():
        hits, slides = folder / f"collisions_{engine}", folder / f"sliding_{engine}"
        sites = _collisions(made, hits)
        stages.simulate(hits, 1, False, engine)
        _sliding(made, slides)
        stages.simulate(slides, 1, False, engine)
        for (a, b), values in _restitution(hits, sites).items():
            pair = next(p for p in made.pairs if (p.a, p.b) == (a, b))
            what = f"{made.classes[a - 1].name} on {made.classes[b - 1].name if b else 'wall'}"
            table.append(_row("single collisions", f"restitution, {what}", name, values, pair.restitution))
        for kind, value in _friction(slides).items():
            pair = next(p for p in made.pairs if (p.a, p.b) == (kind, 0))
            what = f"friction on a wall, {made.classes[kind - 1].name}"
            table.append(_row("sliding spheres", what, name, np.array([value]), pair.friction))
    return table


def _collisions(made: cases.Ingredients, path: Path) -> list[Site]:
    """Prepare spheres in rows over a plate, the pairs high above it; the touch of each is shifted by a part of a step."""
    spheres: list[small.Sphere] = []
    sites: list[Site] = []
    pairs = sorted((p.a, p.b) for p in made.pairs)
    for k, ((a, b), phase) in enumerate(product(pairs, range(PHASES))):
        x, y = PITCH * (k % 12 - 5.5), PITCH * (k // 12 - 2.0)
        ra = made.classes[a - 1].radius_m
        gap = GAP + phase / PHASES * SPEED * made.time_step_s
        sites.append((a, b, len(spheres) + 1))
        if b == 0:
            spheres.append(small.Sphere(a, (x, y, ra + gap), (0.0, 0.0, -SPEED)))
        else:
            z, rb = 0.1, made.classes[b - 1].radius_m
            spheres.append(small.Sphere(a, (x, y, z), (0.0, 0.0, 0.5 * SPEED)))
            spheres.append(small.Sphere(b, (x, y, z + ra + rb + gap), (0.0, 0.0, -0.5 * SPEED)))
    longest = math.pi * math.sqrt(max(c.mass_kg for c in made.classes) / made.pairs[0].normal_stiffness_N_per_m)
    steps = math.ceil((2.0 * GAP / SPEED + 1.5 * longest) / made.time_step_s)
    _prepare(made, path, spheres, steps, 0.0)
    return sites


def _sliding(made: cases.Ingredients, path: Path) -> None:
    """Prepare one sphere of each class in equilibrium that slides along the plate, for half the time until it rolls."""
    spheres = []
    wall = {p.a: p for p in made.pairs if p.b == 0}
    for c in made.classes:
        sunk = c.mass_kg * GRAVITY / wall[c.type].normal_stiffness_N_per_m
        spheres.append(small.Sphere(c.type, (-0.05, PITCH * c.type, c.radius_m - sunk), (SPEED, 0.0, 0.0)))
    rolling = 2.0 * SPEED / (7.0 * max(p.friction for p in wall.values()) * GRAVITY)
    _prepare(made, path, spheres, math.ceil(0.5 * rolling / made.time_step_s), GRAVITY)


def _prepare(made: cases.Ingredients, path: Path, spheres: list[small.Sphere], steps: int, gravity: float) -> None:
    small.prepare(
        path, made.classes, spheres, made.pairs, effects=made.plan.effects,
        walls=(small.floor(half_side=0.3, thickness=0.03),), time_step_s=made.time_step_s, steps=steps,
        output_interval_s=max(1, steps // 10) * made.time_step_s, gravity=(0.0, 0.0, -gravity), box=0.4,
    )  # fmt: skip


def _restitution(path: Path, sites: list[Site]) -> dict[tuple[int, int], np.ndarray]:
    """Return the relative speed after over that before, of each pair at each instant of touch."""
    end = last(path).set_index("id")["vz"]
    after_over_before: dict[tuple[int, int], list[float]] = {}
    for a, b, first in sites:
        after = end[first + 1] - end[first] if b else end[first]
        after_over_before.setdefault((a, b), []).append(float(after) / SPEED)
    return {pair: np.array(values) for pair, values in after_over_before.items()}


def _friction(path: Path) -> dict[int, float]:
    """Return the deceleration over g of each class, from the second half of the run."""
    table = read_table(path / "trajectory.parquet")
    friction = {}
    for kind, rows_of in table.groupby("type"):
        late = rows_of.iloc[len(rows_of) // 2 :]
        friction[int(kind)] = -float(np.polyfit(late["time"], late["vx"], 1)[0]) / GRAVITY  # type: ignore[arg-type]
    return friction


def _row(scene: str, quantity: str, engine: str, values: np.ndarray, reference: float) -> dict[str, Any]:
    """Return value, reference, relative deviation and its spread."""
    return {
        "scene": scene,
        "quantity": quantity,
        "engine": engine,
        "value": float(values.mean()),
        "reference_value": reference,
        "deviation": float(values.mean()) / reference - 1.0,
        "spread": float(np.ptp(values)) / reference,
        "note": "spread: between instants of touch within a step" if len(values) > 1 else "",
    }
