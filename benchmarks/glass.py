"""What the benchmarks of a step share: wet glass of 5 mm on a lattice above a floor, and processor time of other processes."""

from __future__ import annotations

import resource
from pathlib import Path
from typing import Any

import numpy as np

from pywet.cases.small import bodies, small
from pywet.scene import EngineScene

RADIUS, FILM, STEP = 2.5e-3, 5e-5, 1e-5
WATER = bodies.water(FILM, density=998.2)


def lattice(side: int, layers: int, pitch: float, shaken: float) -> bodies.Floats:
    """Places [m] in layers of side x side above a floor at 0; `pitch` and `shaken`, the most they are moved, in radii."""
    cells = np.stack(np.meshgrid(*map(np.arange, (side, side, layers)), indexing="ij"), axis=-1).reshape(-1, 3)
    at = (cells - [0.5 * (side - 1), 0.5 * (side - 1), -0.5]) * pitch * RADIUS
    return np.asarray(at + np.random.default_rng(1).uniform(-shaken, shaken, at.shape) * RADIUS)


def prepare(folder: Path, spheres: list[small.Sphere], steps: int, rolling_m: float = 9e-5, **more: Any) -> EngineScene:
    """The spheres above a floor that is wide enough; `more` as `small.prepare` takes it."""
    half = float(np.abs([s.position[:2] for s in spheres]).max()) + 4.0 * RADIUS
    thick = max(0.01, 0.04 * half)  # the engine rejects thinner triangles
    return small.prepare(
        folder, bodies.sphere_classes(RADIUS, counts=len(spheres)), spheres,
        bodies.contacts(1, 1e4, friction=0.4, rolling_m=rolling_m, restitution=0.5), walls=[small.floor(half, thickness=thick)],
        wall_angle_rad=bodies.WETTED, time_step_s=STEP, steps=steps, gravity=(0.0, 0.0, -9.81),
        box_low_m=(-half - 0.01, -half - 0.01, -0.01 - thick), box_high_m=(half + 0.01, half + 0.01, 0.07), **more,
    )  # fmt: skip


def spent() -> float:
    """Processor time of all processes that were started here and have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
