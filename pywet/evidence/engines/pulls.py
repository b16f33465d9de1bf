"""One bridge drawn apart in every engine: force against gap and rupture distance, sphere on sphere and sphere on wall.

The law is Rabinovich's in the reference, in our engine and in YADE; `washino` and `easo` have their own. The value that all are
set against is the exact bridge (Young-Laplace), so a deviation is what the engine's whole model misses, not a fault of its code:
that one sees in the rows whose reference is the closed form.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from pywet.apparatus.surface import Floats
from pywet.bench import bridge_engine
from pywet.bench.pair import Pair
from pywet.engines.stock.liggghts import liggghts_force
from pywet.engines.stock.yade import yade_force
from pywet.evidence.engines.rows import row

RADIUS, LARGE, VOLUME, ANGLE_DEG, TENSION = 1e-3, 3e-3, 1e-11, 20.0, 0.07275
PAIRS = {
    name: Pair(name, RADIUS, rj, VOLUME, (math.radians(ANGLE_DEG),) * 2, TENSION)
    for name, rj in (("two equal spheres", RADIUS), ("spheres 1:3", LARGE), ("sphere and wall", math.inf))
}
SHARES = (0.02, 0.2, 0.4, 0.6, 0.8)
"""Gaps over the exact rupture distance."""
SCAN = 300
"""Gaps at which the end of a force is looked for."""
STOCK: dict[str, Callable[[pd.DataFrame], pd.DataFrame]] = {
    "YADE": lambda points: yade_force(points, "Rabinovich"),
    "washino": lambda points: liggghts_force(points, "washino"),
    "easo": lambda points: liggghts_force(points, "easo"),
}
OURS = "LIGGGHTS+pywet"


def rows() -> list[dict[str, Any]]:
    """All pulls as rows {scene, quantity, engine, value, reference, reference_value, deviation, note}."""
    made = []
    for scene, pair in PAIRS.items():
        limit = pair.limit("exact")
        gaps = np.array(SHARES) * limit
        exact, closed = pair.exact(gaps), pair.paper(gaps)
        for engine, values in {"reference": closed, **engine_forces(pair, gaps)}.items():
            for k, share in enumerate(SHARES):
                quantity = f"force at {share:.0%} of the rupture distance [N]"
                made.append(row(scene, quantity, engine, values[k], "exact", exact[k]))
                if engine in (OURS, "YADE"):
                    made.append(row(scene, quantity, engine, values[k], "Rabinovich, closed form", closed[k]))
        for engine, distance in rupture_distances(pair, limit).items():
            made.append(row(scene, "rupture distance [m]", engine, distance, "exact", limit))
    return made


def engine_forces(pair: Pair, gaps: Floats) -> dict[str, Floats]:
    """Attraction at each gap [N], from the engines' binaries; our own plugin runs inside LIGGGHTS."""
    forces = {OURS: np.array([math.nan if v is None else v for v in _ours(pair, gaps)["force_N"]["rabinovich"]])}
    for engine, measure in STOCK.items():
        forces[engine] = measure(pair.points(gaps))["force"].to_numpy(float)
    return forces


def rupture_distances(pair: Pair, limit: float) -> dict[str, float]:
    """Gap at which each engine's bridge ends [m]: halfway between the last gap with a force and the next one."""
    distances = {OURS: float(_ours(pair, np.array([0.5 * limit]))["rupture_distance_m"]["willett_unequal"])}
    gaps = np.linspace(0.5, 1.6, SCAN) * limit
    for engine, measure in STOCK.items():
        force = measure(pair.points(gaps))["force"].to_numpy(float)
        last = int(np.flatnonzero(np.abs(force) > 0).max(initial=-1))
        distances[engine] = 0.5 * float(gaps[last] + gaps[last + 1]) if 0 <= last < SCAN - 1 else math.nan
    return distances


def _ours(pair: Pair, gaps: Floats) -> dict[str, Any]:
    """Measured inside LIGGGHTS with the plugin, by a pull at constant speed."""
    return bridge_engine.measured(pair.query(gaps, laws=["rabinovich", "pitois", "willett_unequal"]))


def limits() -> list[dict[str, Any]]:
    """What YADE's bridges leave out, in numbers: overlap, walls, two contact angles."""
    equal, at_wall, gap = PAIRS["two equal spheres"], PAIRS["sphere and wall"], np.array([1e-5])
    overlap = yade_force(equal.points(np.array([-1e-3 * RADIUS])), "Rabinovich")["force"].iloc[0]
    wall, pair = (float(yade_force(p.points(gap), "Rabinovich")["force"].iloc[0]) for p in (at_wall, equal))
    touch = float(equal.paper(np.array([0.0]))[0])
    two = equal.points(gap).assign(contact_angle_j=0.0)
    refused = yade_force(two, "Rabinovich")["reason"].iloc[0]
    return [
        row("two equal spheres", "force at an overlap of 0.001 r [N]", "YADE", overlap, "Rabinovich at touch", touch),
        row("sphere and wall", "force at a gap of 10 µm [N]", "YADE", wall, "YADE between equal spheres", pair),
        row("two equal spheres", "two contact angles", "YADE", math.nan, "", math.nan, note=refused),
    ]
