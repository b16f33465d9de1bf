"""Definition of a scene of the study, and initial arrangements of spheres."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from pywet.cases.small.bodies import at_places
from pywet.cases.small.small import Sphere
from pywet.geometry.surface import Surface
from pywet.planning.surroundings import Surroundings
from pywet.scene import ContactPair, Effects, EngineScene, Liquid, Rotation, SphereClass

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Setup:
    """One scene that can be prepared with any choice of effects; `speed` and `surroundings` are for the plan."""

    classes: tuple[SphereClass, ...]
    pairs: tuple[ContactPair, ...]
    liquid: Liquid | None
    speed: float
    surroundings: Surroundings
    spheres: Sequence[Sphere]
    seconds: float
    walls: tuple[Surface, ...] = ()
    gravity: Vector = (0.0, 0.0, -9.81)
    rotation: Rotation | None = None
    build: Callable[[Effects, Path], EngineScene] | None = None
    """Function that prepares the run directory if the scene does not consist of spheres and walls given here."""
    configuration: dict[str, Any] = field(default_factory=dict)
    """Configuration from which it was made, if it is a configured case."""


SHAKEN = 0.04
"""Largest random displacement of a sphere of a lattice, over the pitch."""


def lattice(kinds: Sequence[int], across: int, pitch: float, low: float, seed: int) -> list[Sphere]:
    """Return layers of across x across spheres from height `low` up, displaced at random by SHAKEN of the pitch."""
    random, number = np.random.default_rng(seed), np.arange(len(kinds))
    order = random.permutation(np.asarray(kinds))
    cells = np.column_stack([number % across, number // across % across, number // across**2]).astype(float)
    at = cells - [0.5 * (across - 1), 0.5 * (across - 1), 0.0] + random.uniform(-SHAKEN, SHAKEN, cells.shape)
    return at_places(at * pitch + [0.0, 0.0, low], order)


def pyramid(side: int, radius: float, seed: int) -> list[Sphere]:
    """Return a pyramid of spheres in a square tray: each rests on the four below; the seed moves them by 1e-4 of the radius."""
    at = np.array([
        [2 * i - (side - layer - 1), 2 * j - (side - layer - 1), 1.0 + math.sqrt(2.0) * layer]
        for layer in range(side) for i, j in np.ndindex(side - layer, side - layer)
    ])  # fmt: skip
    shift = np.random.default_rng(seed).uniform(-1.0, 1.0, at.shape) * [1.0, 1.0, 0.0]
    return at_places(at * radius + 1e-4 * radius * shift)


def jets(count: int, radius: float, speed: float, pitch: float, seed: int) -> list[Sphere]:
    """Return two clouds that fly through each other along x, each at half the speed; random positions on a lattice."""
    random = np.random.default_rng(seed)
    across = max(3, round((count / 2) ** (1.0 / 3.0)))
    spheres = []
    for side in (-1, 1):
        cells = np.array(list(np.ndindex(across + 1, across, across)), dtype=float)
        cells = cells[random.permutation(len(cells))[: count // 2]]
        at = (cells - [0.0, 0.5 * (across - 1), 0.5 * (across - 1)]) * pitch
        at += random.uniform(-0.5, 0.5, at.shape) * (pitch - 2.4 * radius)
        at[:, 0] = side * (at[:, 0] + 0.6 * pitch)
        spheres += [replace(s, velocity=(-0.5 * side * speed, 0.0, 0.0)) for s in at_places(at)]
    return spheres
