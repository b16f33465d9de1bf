"""Table of the advised time step against the true limit, found by bisection in the engine."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.engines.liggghts import stability

VISCOSITIES = (1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0)


def main() -> None:
    """Both ways of integration, six viscosities."""
    print(
        f"two spheres of radius {stability.R * 1e3} mm, spring {stability.STIFFNESS:g} N/m, pressed together by their bridge"
    )
    print(f"{'viscosity':>10s} {'integration':>14s} {'advised':>10s} {'true':>10s} {'ratio':>6s}  governs")
    for how in ("explicit", "semi_implicit"):
        for viscosity in VISCOSITIES:
            with tempfile.TemporaryDirectory() as folder:
                advised, governs = stability.advised(Path(folder), viscosity, how)
                true = stability.true_limit(Path(folder), viscosity, how, advised)
            print(
                f"{viscosity:10g} {how:>14s} {advised:10.3e} {true:10.3e} {advised / true:6.3f}  {governs}", flush=True
            )


if __name__ == "__main__":
    main()
