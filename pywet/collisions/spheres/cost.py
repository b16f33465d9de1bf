"""What accuracy costs: error against wall time over tolerance and integrator, polar against Cartesian pair coordinates.

The error is that of the final velocities against the tightest run, over the largest of them. Wall times are medians
of `REPEATS` runs.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

from pywet.collisions.spheres.equal import three_equal_spheres
from pywet.collisions.spheres.plots import save
from pywet.collisions.spheres.problem import Problem
from pywet.collisions.spheres.simulate import METHODS, Run, run
from pywet.errors import PywetError
from pywet.files import write_json

REPEATS = 3
TOLERANCES = tuple(10.0**-k for k in range(4, 11))


@dataclass(frozen=True)
class Point:
    """One integrator at one tolerance."""

    case: str
    method: str
    polar: bool
    rtol: float
    error: float
    wall_s: float
    steps: int
    evaluations: int
    residual: float


def cases() -> dict[str, Problem]:
    """An easy collision, a long one with three mutual contacts, and one whose gap closes to 1e-6."""
    return {
        "rapid bounce, St 12, 30°": three_equal_spheres(12.0, theta12_deg=30.0, t_end=10.0),
        "transfer (Fig. 15)": three_equal_spheres(2.0, theta23_deg=-45.0, h_min=0.04, t_end=100.0),
        "small gap, St 20, ĥ_m 1e-6": three_equal_spheres(20.0, h_min=1e-6, t_end=60.0),
        "smaller gap, ĥ_a 0.001, ĥ_m 1e-8": three_equal_spheres(30.0, h_a=0.001, h_min=1e-8, t_end=60.0),
    }


def distance(found: Run, exact: Run) -> float:
    """Largest difference of the final velocities over the largest velocity."""
    return float(np.abs(found.velocity - exact.velocity).max() / np.abs(exact.velocity).max())


def measure(name: str, problem: Problem, method: str, polar: bool, exact: Run) -> list[Point]:
    """Error and wall time over the tolerances; a run that is refused leaves no point."""
    points = []
    for rtol in TOLERANCES:
        try:
            runs = [run(problem.with_(rtol=rtol), method, polar) for _ in range(REPEATS)]
        except PywetError:  # beyond the work bound: no point
            continue
        wall = float(np.median([r.wall_s for r in runs]))
        r = runs[0]
        residual = abs(r.energy.residual) / r.energy.start
        points.append(Point(name, method, polar, rtol, distance(r, exact), wall, r.steps, r.evaluations, residual))
    return points


def points() -> list[Point]:
    """All of them; a run is made first so that compiling is not counted."""
    found = []
    for name, problem in cases().items():
        exact = run(problem.with_(rtol=1e-11))
        for method in METHODS:
            for polar in (True, False):
                found += measure(name, problem, method, polar, exact)
    return found


def draw(found: list[Point], path: Path) -> None:
    """One panel per case: error against wall time, one line per integrator, dashed for Cartesian pairs."""
    names = list(dict.fromkeys(p.case for p in found))
    figure, panels = plt.subplots(2, 2, figsize=(10.0, 7.6), squeeze=False)
    colours = {"auto": "black", "dop853": "#0b3c78", "dopri5": "#d98032", "radau": "#5d8a3a"}
    for ax, name in zip(panels.flat, names, strict=True):
        for method, colour in colours.items():
            for polar, style in ((True, "o-"), (False, "s--")):
                line = [p for p in found if (p.case, p.method, p.polar) == (name, method, polar)]
                label = f"{method}, {'polar' if polar else 'Cartesian'}"
                ax.loglog(
                    [1e3 * p.wall_s for p in line],
                    [max(p.error, 1e-16) for p in line],
                    style,
                    color=colour,
                    ms=3,
                    lw=1,
                    label=label,
                )
        ax.set(xlabel="wall time [ms]", ylabel="error of the final velocities", title=name)
        ax.grid(True, lw=0.3)
    panels[0, 0].legend(fontsize=6)
    figure.tight_layout()
    save(figure, path)


def write(folder: Path) -> None:
    """`accuracy_cost.json` and `accuracy_cost.png`."""
    found = points()
    write_json(folder / "accuracy_cost.json", [p.__dict__ for p in found])
    draw(found, folder / "accuracy_cost.png")
