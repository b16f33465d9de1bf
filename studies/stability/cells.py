"""Many small experiments in one engine run: cells far apart in one box, each with its own spheres and walls.

Properties common to an engine run (time step, liquid, laws) belong to the `Batch`; those of a sphere (type, position,
speed, film) or of a cell (a plate, wires) belong to the `Cell`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pywet.cases.small import small
from pywet.cases.small.small import Sphere
from pywet.geometry.initial import wall_mesh
from pywet.geometry.motion import peak_speed
from pywet.geometry.surface import Surface, make_surface
from pywet.laws.contact import effective_mass
from pywet.planning import time_steps
from pywet.scene import ContactPair, Effects, EngineScene, Liquid, Output, SphereClass, Vibration

Floats = NDArray[np.float64]
Part = tuple[Floats, float | None]
FCC = tuple(p for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1)) for p in ((a, b, 0), (a, 0, b), (0, a, b)))
"""Positions of the twelve neighbours in a face-centred cubic packing, over half the edge of a cell."""


def ball(
    kind: int, at: Iterable[float], velocity: Iterable[float] = (0.0, 0.0, 0.0), spin: Iterable[float] = (0.0, 0.0, 0.0),
    film: float = 0.0,
) -> Sphere:  # fmt: skip
    """Return one sphere of a cell: type, position relative to the cell's middle [m], speed [m/s], spin [1/s], film [m3]."""
    (x, y, z), (vx, vy, vz), (wx, wy, wz) = ([float(c) for c in v] for v in (at, velocity, spin))
    return Sphere(kind, (x, y, z), (vx, vy, vz), (wx, wy, wz), film=film)


@dataclass(frozen=True)
class Cell:
    """One experiment; `walls` are parts (corner points of triangles, half width) around the cell's middle."""

    name: str
    bodies: tuple[Sphere, ...]
    walls: tuple[Part, ...] = ()
    says: dict[str, Any] = field(default_factory=dict)
    """Parameters, for the table of cases."""


@dataclass(frozen=True)
class Batch:
    """Cells that share one engine run."""

    name: str
    classes: tuple[SphereClass, ...]
    pairs: tuple[ContactPair, ...]
    liquid: Liquid
    effects: Effects
    time_step: float
    steps: int
    cells: tuple[Cell, ...]
    how: str = "explicit"
    wall_angle: float = 0.0
    ranks: int = 1
    vibration: Vibration | None = None
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    outputs: int = 40
    margin: float = 1.2
    """Width of a cell over the displacement of its spheres."""
    windows: tuple[int, int] = (3, 60)
    """Number and length [steps] of the windows in which every contact is logged."""

    def without(self, names: set[str]) -> Batch:
        """Return the batch with those cells quiet (dry spheres at rest, apart), since the engine requires every type."""
        apart = 4.0 * max(c.radius_m for c in self.classes)
        still = {
            c.name: replace(c, bodies=tuple(ball(b.kind, (k * apart, 0.0, 0.0)) for k, b in enumerate(c.bodies)), walls=())
            for c in self.cells if c.name in names
        }  # fmt: skip
        return replace(self, cells=tuple(still.get(c.name, c) for c in self.cells))

    @property
    def every(self) -> int:
        return max(1, self.steps // self.outputs)

    @property
    def extent(self) -> float:
        """Half the size of a cell [m]: that of its spheres, their displacements, and a margin beyond any bridge."""
        radius = max(c.radius_m for c in self.classes)
        seconds = self.time_step * self.steps
        thrown = 2.0 * peak_speed(self.vibration) * seconds if self.vibration else 0.0
        ways = (np.abs(b.position).max() + np.linalg.norm(b.velocity) * seconds for c in self.cells for b in c.bodies)
        walls = (np.abs(corners).max() for c in self.cells for corners, _ in c.walls)
        reach = float(max([*ways, *walls], default=0.0))
        fall = 0.5 * float(np.linalg.norm(self.gravity)) * seconds**2
        return self.margin * (reach + thrown) + fall + 5.0 * radius

    def middles(self) -> Floats:
        """Return the middle of each cell in the plane z = 0, on a square grid around the origin, shape (n, 3) [m].

        A column of cells is on x = 0, where two ranks meet.
        """
        across = math.ceil(math.sqrt(len(self.cells))) // 2 * 2 + 1
        k = np.arange(len(self.cells))
        pitch = 2.0 * self.extent
        x, y = (k % across - across // 2) * pitch, (k // across - (len(k) - 1) // across / 2.0) * pitch
        return np.stack([x, y, np.zeros(len(k))], axis=1)

    def owner(self) -> list[str]:
        """Return the name of the cell of each sphere id (index 0 unused)."""
        return ["", *(cell.name for cell in self.cells for _ in cell.bodies)]


def bodies_of(batch: Batch) -> list[Sphere]:
    """Return all spheres, in the order of their ids."""
    return [
        ball(b.kind, middle + np.asarray(b.position), b.velocity, b.spin, b.film or 0.0)
        for cell, middle in zip(batch.cells, batch.middles(), strict=True) for b in cell.bodies
    ]  # fmt: skip


def surface_of(batch: Batch) -> list[Surface]:
    """Return the walls of all cells as one mesh, a part for each wall of each cell."""
    parts = [
        (corners + middle, width)
        for cell, middle in zip(batch.cells, batch.middles(), strict=True)
        for corners, width in cell.walls
    ]
    if not parts:
        return []
    return [make_surface("cells", "wall", parts, "vibrates" if batch.vibration else "fixed")]


def counted(classes: Sequence[SphereClass], cells: Sequence[Cell]) -> list[SphereClass]:
    """Return the classes with the number of their spheres."""
    kinds = [body.kind for cell in cells for body in cell.bodies]
    return [c.model_copy(update={"count": kinds.count(c.type)}) for c in classes]


def thickest_film(batch: Batch) -> float:
    """Return the initial film [m] stated in the scene, which determines the allowed film growth."""
    return 0.4 * min(c.radius_m for c in batch.classes)


def prepare(batch: Batch, run_dir: Path) -> EngineScene:
    """Write scene, spheres and their own films into `run_dir`."""
    middles, extent = batch.middles(), batch.extent
    low, high = middles.min(axis=0) - 1.5 * extent, middles.max(axis=0) + 1.5 * extent
    number, length = batch.windows
    return small.prepare(
        run_dir, counted(batch.classes, batch.cells), bodies_of(batch), batch.pairs,
        liquid=batch.liquid.model_copy(update={"initial_film_thickness_m": thickest_film(batch)}), effects=batch.effects,
        walls=surface_of(batch), wall_angle_rad=batch.wall_angle, time_step_s=batch.time_step, steps=batch.steps,
        gravity=batch.gravity, name=batch.name, box_low_m=tuple(low.tolist()), box_high_m=tuple(high.tolist()),
        bin_z_m=float(low[2]), vibration=batch.vibration, viscous_integration=batch.how,
        output=Output(interval_s=batch.every * batch.time_step, contact_windows=number, contact_window_steps=length),
    )  # fmt: skip


def advised(batch: Batch, film: float) -> Sequence[time_steps.Limit]:
    """Return the advisor's limits for the batch's spheres (without cells: one of each class) with that film thickness [m]."""
    scene = EngineScene(
        name=batch.name, seed=0, classes=tuple(counted(batch.classes, batch.cells) if batch.cells else batch.classes),
        pairs=batch.pairs, liquid=batch.liquid.model_copy(update={"initial_film_thickness_m": film}),
        walls=tuple(wall_mesh(w, batch.wall_angle) for w in surface_of(batch)) if batch.cells else (),
        vibration=None, slide=None, effects=batch.effects, viscous_integration=batch.how,  # type: ignore[arg-type]
        box_low_m=(-1.0, -1.0, -1.0), box_high_m=(1.0, 1.0, 1.0), spheres_file=Path("spheres.parquet"),
        time_step_s=1e-9, duration_s=1e-6, output=Output(interval_s=1e-9), bin_z_m=-1.0,
    )  # fmt: skip
    return time_steps.advise(scene).limits


def reduced_mass(classes: Sequence[SphereClass], a: int, b: int) -> float:
    """Mass of the relative motion of two types [kg]; a wall (b = 0) does not move."""
    return effective_mass(classes[a - 1].mass_kg, classes[b - 1].mass_kg if b else math.inf)
