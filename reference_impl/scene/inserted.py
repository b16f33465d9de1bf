"""Initial positions of spheres that enter during a run: random positions in their region minus their path.

In the order of entry, numpy's generator with the scene's seed gives two numbers across and one along z, repeated if
the position is outside a round region or too near an earlier one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from reference_impl.replay.arrays import Floats
from reference_impl.replay.plans import enter_times

APART = 1.05
"""Smallest distance of centres over that at which spheres and their films touch."""
MOST = 5000
"""Largest number of positions tried for one sphere."""


def places(description: Mapping[str, Any], scene: Mapping[str, Any], films: list[float]) -> dict[int, Floats]:
    """Return positions (n, 3) of each class that enters [m], by type, in the order of entry; none if one cannot be placed."""
    entries, classes = description["spheres"], scene["classes"]
    arrivals = sorted(
        (float(at), c["type"]) for c in classes if c.get("insertion") for at in enter_times(c["insertion"], c["count"])
    )  # fmt: skip
    generator = np.random.default_rng(description["seed"])
    size = [c["radius_m"] + h for c, h in zip(classes, films, strict=True)]
    x, reach = np.zeros((len(arrivals), 3)), np.zeros(len(arrivals))
    found: dict[int, list[int]] = {}
    for n, (time, kind) in enumerate(arrivals):
        entry, radius = entries[kind - 1], classes[kind - 1]["radius_m"]
        reach[n] = size[kind - 1]
        for _ in range(MOST):
            x[n] = _in_region(entry, radius, generator, description["origin_mm"]) - time * np.array(
                entry["velocity_m_per_s"]
            )
            if (((x[:n] - x[n]) ** 2).sum(axis=1) >= (APART * (reach[n] + reach[:n])) ** 2).all():
                break
        else:
            return {}
        found.setdefault(kind, []).append(n)
    return {kind: x[np.array(rows)] for kind, rows in found.items()}


def _in_region(entry: Mapping[str, Any], radius: float, generator: np.random.Generator, origin: list[float]) -> Floats:
    """Return a position for a whole sphere in its box or cylinder."""
    if box := entry["box"]:
        low, high = (1e-3 * (np.array(box[k], dtype=float) - origin) for k in ("low_mm", "high_mm"))
        round_ = False
    else:
        tube = entry["cylinder"]
        bottom = np.array(tube["origin_mm"], dtype=float) - origin
        wide = np.array([0.5 * tube["diameter_mm"], 0.5 * tube["diameter_mm"], 0.0])
        low, high = 1e-3 * (bottom - wide), 1e-3 * (bottom + wide + [0.0, 0.0, tube["height_mm"]])
        round_ = True
    half, middle = 0.5 * (high - low)[:2] - radius, 0.5 * (low + high)[:2]
    while True:
        across = generator.uniform(-half, half)
        if not round_ or np.hypot(across[0], across[1]) <= half[0]:
            break
    return np.array([*(across + middle), generator.uniform(low[2] + radius, high[2] - radius)])
