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

from pywet import bridge_engine, bridge_query, young_laplace
from pywet.crosscheck.rows import row
from pywet.engines.stock import liggghts_force, yade_force
from pywet.geometry.surface import Floats

RADIUS, LARGE, VOLUME, ANGLE_DEG, TENSION = 1e-3, 3e-3, 1e-11, 20.0, 0.07275
PAIRS = {"two equal spheres": RADIUS, "spheres 1:3": LARGE, "sphere and wall": math.inf}
"""Scene -> radius of the second body [m]."""
SHARES = (0.02, 0.2, 0.4, 0.6, 0.8)
"""Gaps over the exact rupture distance."""
STOCK: dict[str, Callable[[pd.DataFrame], pd.DataFrame]] = {
    "YADE": lambda points: yade_force(points, "Rabinovich"),
    "washino": lambda points: liggghts_force(points, "washino"),
    "easo": lambda points: liggghts_force(points, "easo"),
}
OURS = "LIGGGHTS+pywet"


def rows() -> list[dict[str, Any]]:
    """All pulls as rows {scene, quantity, engine, value, reference, reference_value, deviation, note}."""
    found = []
    for scene, rj in PAIRS.items():
        angle = math.radians(ANGLE_DEG)
        limit = young_laplace.rupture(VOLUME, RADIUS, rj, angle, angle).separation
        gaps = np.array(SHARES) * limit
        exact = exact_force(gaps, rj)
        closed = reference_force(gaps, rj)
        forces = {"reference": closed, **engine_forces(gaps, rj)}
        for engine, values in forces.items():
            for k, share in enumerate(SHARES):
                quantity = f"force at {share:.0%} of the rupture distance [N]"
                found.append(row(scene, quantity, engine, values[k], "exact", exact[k]))
                if engine in (OURS, "YADE"):
                    found.append(row(scene, quantity, engine, values[k], "Rabinovich, closed form", closed[k]))
        for engine, distance in rupture_distances(rj, limit).items():
            found.append(row(scene, "rupture distance [m]", engine, distance, "exact", limit))
    return found


def points(gaps: Floats, rj: float) -> pd.DataFrame:
    """Points as the stock measurements take them."""
    return pd.DataFrame(
        {
            "separation": gaps,
            "volume": VOLUME,
            "radius_i": RADIUS,
            "radius_j": rj,
            "contact_angle": math.radians(ANGLE_DEG),
            "surface_tension": TENSION,
        }
    )


def exact_force(gaps: Floats, rj: float) -> Floats:
    """Force of the exact bridge [N]; nan where there is none."""
    angle = math.radians(ANGLE_DEG)
    bridges = [young_laplace.solve(float(s), VOLUME, RADIUS, rj, angle, angle) for s in gaps]
    return np.array([math.nan if b is None else b.force(TENSION) for b in bridges])


def reference_force(gaps: Floats, rj: float) -> Floats:
    """Rabinovich's closed form by the reference implementation [N]."""
    from reference_impl.capillary import rabinovich

    wall = np.full(len(gaps), math.isinf(rj))
    full = np.ones(len(gaps))
    angle = math.radians(ANGLE_DEG) * full
    other = RADIUS if math.isinf(rj) else rj
    values = rabinovich(gaps, VOLUME * full, RADIUS * full, other * full, wall, angle, angle, TENSION)
    return np.asarray(values, dtype=float)


def engine_forces(gaps: Floats, rj: float) -> dict[str, Floats]:
    """Attraction at each gap [N], from the engines' binaries; our own plugin runs inside LIGGGHTS."""
    found = {OURS: np.array([math.nan if v is None else v for v in _ours(gaps, rj)["force_N"]["rabinovich"]])}
    for engine, measure in STOCK.items():
        found[engine] = measure(points(gaps, rj))["force"].to_numpy(float)
    return found


def rupture_distances(rj: float, limit: float, fine: int = 300) -> dict[str, float]:
    """Gap at which each engine's bridge ends [m]: halfway between the last gap with a force and the next one."""
    found = {OURS: float(_ours(np.array([0.5 * limit]), rj)["rupture_distance_m"]["willett_unequal"])}
    gaps = np.linspace(0.5, 1.6, fine) * limit
    for engine, measure in STOCK.items():
        force = measure(points(gaps, rj))["force"].to_numpy(float)
        last = int(np.flatnonzero(np.abs(force) > 0).max(initial=-1))
        found[engine] = 0.5 * float(gaps[last] + gaps[last + 1]) if 0 <= last < fine - 1 else math.nan
    return found


def _ours(gaps: Floats, rj: float) -> dict[str, Any]:
    """Measured inside LIGGGHTS with the plugin, by a pull at constant speed."""
    second = {"wall": "large"} if math.isinf(rj) else {"radius_m": rj}
    query = bridge_query.Query.model_validate(
        {
            "bodies": [
                {"radius_m": RADIUS, "contact_angle_deg": ANGLE_DEG},
                {**second, "contact_angle_deg": ANGLE_DEG},
            ],
            "volume_m3": VOLUME,
            "surface_tension_N_per_m": TENSION,
            "separations_m": [float(s) for s in gaps],
            "laws": ["rabinovich", "pitois", "willett_unequal"],
        }
    )
    return bridge_engine.measured(query)


def limits() -> list[dict[str, Any]]:
    """What YADE's bridges leave out, in numbers: overlap, walls, two contact angles."""
    overlap = yade_force(points(np.array([-1e-3 * RADIUS]), RADIUS), "Rabinovich")["force"].iloc[0]
    gap = np.array([1e-5])
    wall, pair = (float(yade_force(points(gap, rj), "Rabinovich")["force"].iloc[0]) for rj in (math.inf, RADIUS))
    touch = float(reference_force(np.array([0.0]), RADIUS)[0])
    two = points(gap, RADIUS).assign(contact_angle_j=0.0)
    refused = yade_force(two, "Rabinovich")["reason"].iloc[0]
    return [
        row("two equal spheres", "force at an overlap of 0.001 r [N]", "YADE", overlap, "Rabinovich at touch", touch),
        row("sphere and wall", "force at a gap of 10 µm [N]", "YADE", wall, "YADE between equal spheres", pair),
        row("two equal spheres", "two contact angles", "YADE", math.nan, "", math.nan, note=refused),
    ]
