"""Collisions per second: sweeps of 1000 wet collisions by the compiled integrator, and single ones by each of scipy's.

python benchmarks/collisions.py
"""

from __future__ import annotations

import statistics
import time

import numpy as np

from pywet.collisions.wall import sweep, wall
from studies.buck2018.curves import problem

ROUNDS, COUNT, SINGLE = 3, 1000, 10


def problems(integrator: str, count: int) -> list[tuple[dict[str, float], object]]:
    """Wet glass at velocities from sticking to the plateau."""
    return [
        (
            {"v": float(v)},
            problem("glass_1.74mm", ("water", 400), normal_velocity_m_per_s=float(v), integrator=integrator),
        )
        for v in np.linspace(0.1, 3.0, count)
    ]


def main() -> None:
    """Print a line for each integrator."""
    for threads in (1, 2):
        rates = []
        for _ in range(ROUNDS + 1):
            given = problems("compiled", COUNT)
            started = time.perf_counter()
            table = sweep.collide_all(given, threads=threads)  # type: ignore[arg-type]
            rates.append(COUNT / (time.perf_counter() - started))
            assert table["refused"].isna().all()
        print(f"compiled, sweep, {threads} thread(s): {statistics.median(rates[1:]):6.0f} collisions per second")
    for method in ("DOP853", "RK45", "LSODA", "Radau", "BDF"):
        given = problems(method, SINGLE)
        wall.collide(given[0][1])  # type: ignore[arg-type]
        started = time.perf_counter()
        for _, case in given:
            wall.collide(case)  # type: ignore[arg-type]
        print(f"{method:<7} of scipy: {SINGLE / (time.perf_counter() - started):6.1f} collisions per second")


if __name__ == "__main__":
    main()
