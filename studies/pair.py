"""Two bodies with a bridge, without an engine: the results of laws and of the exact bridge, and a query for other programs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pywet.cases.small.bridge_query import Query
from pywet.laws import exact_bridge as young_laplace
from reference_impl.replay import capillary, laws

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Pair:
    """Radii [m] (rj infinite: a large wall), volume [m3], contact angles [rad], surface tension [N/m]."""

    key: str
    ri: float
    rj: float
    volume: float
    angles: tuple[float, float]
    sigma: float

    @property
    def wall(self) -> bool:
        return math.isinf(self.rj)

    @property
    def bridge(self) -> tuple[float, float, float, float, float]:
        """Volume, radii and contact angles, as arguments of the exact bridge's solvers."""
        return (self.volume, self.ri, self.rj, *self.angles)

    @property
    def flags(self) -> tuple[Floats, Floats, Any]:
        """Return radii and wall flag as arguments of the reference implementation."""
        return np.array([self.ri]), np.array([1.0 if self.wall else self.rj]), np.array([self.wall])

    @property
    def shape(self) -> tuple[Floats, Floats, Floats, Any, Floats, Floats]:
        """Return volume, radii, wall flag and contact angles as arguments of the reference implementation."""
        ti, tj = (np.array([angle]) for angle in self.angles)
        return np.array([self.volume]), *self.flags, ti, tj

    def paper(self, gaps: Floats) -> Floats:
        """Return Rabinovich's force [N] by the reference implementation."""
        return np.asarray(capillary.LAWS["rabinovich"](gaps, *self.shape, self.sigma))

    def exact(self, gaps: Floats) -> Floats:
        """Return the exact force [N], at overlap that at touch; nan where there is no bridge."""
        bridges = [young_laplace.solve(max(float(s), 0.0), *self.bridge) for s in gaps]
        return np.array([math.nan if b is None else b.force(self.sigma) for b in bridges])

    def limit(self, preset: str) -> float:
        """Static rupture distance [m]: Willett's law by the reference (`paper`), or the limit of stability (`exact`)."""
        if preset == "exact":
            return young_laplace.rupture(*self.bridge).separation
        return float(laws.willett_rupture(*self.shape)[0])

    def points(self, gaps: Floats, what: str = "") -> pd.DataFrame:
        """Return the points at which stock programs are evaluated, with one contact angle."""
        return pd.DataFrame({"separation": gaps}).assign(
            volume=self.volume, radius_i=self.ri, radius_j=self.rj, contact_angle=self.angles[0], surface_tension=self.sigma,
            pair=self.key, what=what,
        )  # fmt: skip

    def query(self, gaps: Sequence[float] | Floats, **more: Any) -> Query:
        """Return the query for `pywet bridge`; `more`: additional keys."""
        second = {"wall": "large"} if self.wall else {"radius_m": self.rj}
        ti, tj = (math.degrees(t) for t in self.angles)
        bodies = [{"radius_m": self.ri, "contact_angle_deg": ti}, {**second, "contact_angle_deg": tj}]
        asked = {"bodies": bodies, "volume_m3": self.volume, "surface_tension_N_per_m": self.sigma}
        return Query.model_validate({**asked, "separations_m": [float(s) for s in gaps], **more})
