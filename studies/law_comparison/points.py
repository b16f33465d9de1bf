"""Bridges on which laws are compared: a grid over radius ratio, contact angles, volume and separation, solved exactly."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from pywet.laws import exact_bridge as young_laplace

RADIUS = 1e-3
"""Radius of the smaller body [m]; errors of laws without a length scale do not depend on it."""
SIGMA = 0.0728
RATIOS = (1.0, 0.5, 0.2, 0.0)
"""Smaller over larger radius; 0 is a wall."""
ANGLES = ((0.0, 0.0), (20.0, 20.0), (40.0, 40.0), (60.0, 60.0), (10.0, 40.0))
"""Contact angles [deg] of the smaller and the larger body."""
VOLUMES = tuple(float(v) for v in np.logspace(-5, -1, 9))
"""Volumes V* = V/r_eff³, r_eff the harmonic mean (2 r at a wall)."""
SHARES = (0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99)
"""Separation over the exact rupture distance."""


@dataclass(frozen=True)
class Comparison:
    """Tables: `forces`, one row per bridge with its exact force; `limits`, one per volume and pair with rupture and split."""

    forces: pd.DataFrame
    limits: pd.DataFrame


def solve(progress: Callable[[int, int], None] = lambda done, of: None) -> Comparison:
    """Solve the grid; `progress(done, all)` after each pair of bodies."""
    forces, limits = [], []
    pairs = [(q, angles) for q in RATIOS for angles in ANGLES]
    for k, (q, (small, large)) in enumerate(pairs):
        radius_j = math.inf if q == 0.0 else RADIUS / q
        body = {"ratio": q, "radius_i": RADIUS, "radius_j": radius_j, "angle_i_deg": small, "angle_j_deg": large}
        body |= {"contact_angle_i": math.radians(small), "contact_angle_j": math.radians(large)}
        r = 2 * RADIUS / (1 + q)
        for v in VOLUMES:
            arguments = (v * r**3, RADIUS, radius_j, math.radians(small), math.radians(large))
            limit = young_laplace.rupture(*arguments)
            row = {**body, "v_star": v, "volume": v * r**3}
            limits.append({**row, "rupture": limit.separation, "kind": limit.kind, "transfer_i": limit.transfer_ratio})
            bridges = [young_laplace.solve(share * limit.separation, *arguments) for share in SHARES]
            for share, bridge in zip(SHARES, bridges, strict=True):
                if bridge is not None:
                    exact = {"share": share, "separation": bridge.separation, "exact": bridge.force(SIGMA)}
                    forces.append({**row, **exact})
        progress(k + 1, len(pairs))
    return Comparison(pd.DataFrame(forces), pd.DataFrame(limits))
