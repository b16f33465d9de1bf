"""The pairs of bodies of the force rows, and what is true of them: laws by the reference, the exact bridge."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pywet import young_laplace
from pywet.agreement.model import Floats
from reference_impl import capillary, laws

R, SIGMA, ETA, ANGLE, V_STAR = 2.5e-3, 0.07275, 1e-3, math.radians(15.0), 1e-2
"""Radius [m], surface tension [N/m], viscosity [Pa s], both contact angles, volume over r_eff³ (at a wall over r³)."""
SHARES = (0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
"""Gaps in the smallest rupture distance of all programs' laws."""
OVERLAPS = (-0.001, -0.01, -0.05)
"""Overlaps in the radius."""
RADII = {"equal": (R, R), "unequal": (R, 2.0 * R), "wall": (R, math.inf)}


@dataclass(frozen=True)
class Pair:
    """Two bodies and the bridge between them."""

    key: str
    ri: float
    rj: float
    volume: float

    @property
    def wall(self) -> bool:
        """Whether j is a large wall."""
        return math.isinf(self.rj)

    @property
    def flags(self) -> tuple[Floats, Floats, Any]:
        """Radii and wall flag as the reference takes them."""
        return np.array([self.ri]), np.array([1.0 if self.wall else self.rj]), np.array([self.wall])

    def paper(self, gaps: Floats) -> Floats:
        """Rabinovich's force by the reference [N]."""
        ri, rj, wall = self.flags
        v, t = np.array([self.volume]), np.array([ANGLE])
        return np.asarray(capillary.LAWS["rabinovich"](gaps, v, ri, rj, wall, t, t, SIGMA))

    def exact(self, gaps: Floats) -> Floats:
        """Exact force [N]; in overlap that at touch."""
        found = [young_laplace.solve(max(s, 0.0), self.volume, self.ri, self.rj, ANGLE, ANGLE) for s in gaps]
        return np.array([math.nan if b is None else b.force(SIGMA) for b in found])

    def limit(self, preset: str) -> float:
        """Static rupture distance [m]: Willett's law by the reference, or the exact limit."""
        if preset == "exact":
            return young_laplace.rupture(self.volume, self.ri, self.rj, ANGLE, ANGLE).separation
        ri, rj, wall = self.flags
        t = np.array([ANGLE])
        return float(laws.willett_rupture(np.array([self.volume]), ri, rj, wall, t, t)[0])

    def points(self, gaps: Floats, what: str = "") -> pd.DataFrame:
        """What the stock programs are asked."""
        return pd.DataFrame({"separation": gaps}).assign(
            volume=self.volume, radius_i=self.ri, radius_j=self.rj, contact_angle=ANGLE, surface_tension=SIGMA,
            pair=self.key, what=what,
        )  # fmt: skip

    @property
    def gaps(self) -> Floats:
        """Gaps at which all programs are compared [m]."""
        return np.array(SHARES) * min(self.limit("paper"), self.limit("exact"))

    @property
    def drawn_gaps(self) -> Floats:
        """Gaps of the picture [m]."""
        far = 1.25 * self.limit("paper")
        return np.concatenate([np.linspace(-0.05 * R, -0.001 * R, 6), np.linspace(1e-3 * far, far, 50)])


def pairs() -> list[Pair]:
    """The three pairs of the table."""
    found = []
    for key, (ri, rj) in RADII.items():
        effective = ri if math.isinf(rj) else 2.0 * ri * rj / (ri + rj)
        found.append(Pair(key, ri, rj, V_STAR * effective**3))
    return found
