"""Cost of accuracy: error against wall time over tolerance and integrator, polar against Cartesian pair coordinates.

The error is that of the final velocities against the tightest run, over the largest of them. Wall times are medians
of `REPEATS` runs.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pywet.collisions.spheres.equal import three_equal_spheres
from pywet.collisions.spheres.problem import Problem
from pywet.collisions.spheres.simulate import METHODS, Run, run
from pywet.errors import PywetError
from pywet.report.pictures import GREEN, NAVY, ORANGE, panels

REPEATS = 3
TOLERANCES = tuple(10.0**-k for k in range(4, 11))
COLOURS = dict(zip(METHODS, ("black", NAVY, ORANGE, GREEN), strict=True))


def cases() -> dict[str, Problem]:
    """Return an easy collision, a long one with three mutual contacts, and two whose gap closes to 1e-6 and 1e-8."""
    return {
        "rapid bounce, St 12, 30°": three_equal_spheres(12.0, theta12_deg=30.0, t_end=10.0),
        "transfer (Fig. 15)": three_equal_spheres(2.0, theta23_deg=-45.0, h_min=0.04, t_end=100.0),
        "small gap, St 20, ĥ_m 1e-6": three_equal_spheres(20.0, h_min=1e-6, t_end=60.0),
        "smaller gap, ĥ_a 0.001, ĥ_m 1e-8": three_equal_spheres(30.0, h_a=0.001, h_min=1e-8, t_end=60.0),
    }


def distance(velocity: np.ndarray, exact: Run) -> float:
    """Return the largest difference of the final velocities over the largest velocity."""
    return float(np.abs(velocity - exact.velocity).max() / np.abs(exact.velocity).max())


def measured() -> pd.DataFrame:
    """Return one row per case, integrator, kind of pairs and tolerance; the first run of each case only compiles."""
    rows = []
    for name, problem in cases().items():
        exact = run(problem.with_(rtol=1e-11))
        for method, polar, rtol in ((m, p, t) for m in METHODS for p in (True, False) for t in TOLERANCES):
            try:
                runs = [run(problem.with_(rtol=rtol), method, polar) for _ in range(REPEATS)]
            except PywetError:  # more steps than allowed: no point
                continue
            one, wall = runs[0], float(np.median([r.wall_s for r in runs]))
            residual = abs(one.energy.residual) / one.energy.start
            error = distance(one.velocity, exact)
            rows.append((name, method, polar, rtol, error, wall, one.steps, one.evaluations, residual))
    columns = ["case", "method", "polar", "rtol", "error", "wall_s", "steps", "evaluations", "residual"]
    return pd.DataFrame(rows, columns=columns)


def draw(table: pd.DataFrame) -> Figure:
    """Draw one panel per case: error against wall time, one line per integrator, dashed for Cartesian pairs."""
    figure, axes = panels(len(cases()), 2, (5.0, 3.8))
    for ax, (name, points) in zip(axes, table.groupby("case", sort=False), strict=True):
        for (method, polar), line in points.groupby(["method", "polar"], sort=False):
            style, message = ("o-", "polar") if polar else ("s--", "Cartesian")
            error, colour = line["error"].clip(lower=1e-16), COLOURS[str(method)]
            ax.loglog(1e3 * line["wall_s"], error, style, color=colour, ms=3, lw=1, label=f"{method}, {message}")
        ax.set(xlabel="wall time [ms]", ylabel="error of the final velocities", title=name)
        ax.grid(True, lw=0.3)
    axes[0].legend(fontsize=6)
    return figure
