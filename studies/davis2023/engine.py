"""Collision of three wet spheres in LIGGGHTS with the laws of `pywet.laws.davis`.

The engine's solid contact is a stiff spring at S = 0, the model's a hard impact at h = h_min: h = S + S_min with
S_min = 0.001 r_eff corresponds to h_min, films of total thickness δ − S_min to δ, and the model's centres are S_min
further apart. The plane of the collision is tilted, so that nothing depends on two dimensions.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pywet.cases.small import bodies, small
from pywet.collisions.spheres.equal import three_equal_spheres
from pywet.collisions.spheres.simulate import Run, run
from pywet.report.pictures import GRID, NAVY, RED, panels
from pywet.run_folder import claim
from pywet.scene import Effects
from pywet.util.files import atomic_write, read_table
from studies.davis2023.accuracy_cost import distance

RADIUS, DENSITY, SPEED, H_A, H_MIN = 1e-3, 2000.0, 0.4, 0.01, 0.05
"""Radius [m], density [kg/m3], normal speed [m/s], and δ/(2r), of which h_min/δ = 0.001 r/δ = 0.05 follows."""
PAIRS = ((0, 1), (0, 2), (1, 2))
PART = 30
"""Number of the engine's steps in a dry collision."""
STIFFNESS = (1e7, 1e8, 1e9, 1e10)
"""Stiffness of the compared contacts [N/m]."""
LAWS = "from pywet.laws.davis import tangential\n\nfilm = tangential({over_a!r})\n"
TILT = np.linalg.qr(np.array([[1.0, 0.3, -0.2], [0.4, 1.0, 0.5], [0.1, -0.6, 1.0]]))[0]
"""Rotation of the collision's plane in space."""


@dataclass(frozen=True)
class EngineRun:
    """A collision in the engine: trajectory in the model's units (t̂, δ, v_n0), wall time."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    wall_s: float

    @property
    def gap(self) -> np.ndarray:
        """Return h/δ of the pairs 1-2, 1-3, 2-3, shape (times, 3)."""
        apart = [np.linalg.norm(self.position[:, i] - self.position[:, j], axis=1) for i, j in PAIRS]
        return np.stack(apart, 1) - (1.0 / H_A - H_MIN)  # h = S + S_min


def model(stokes: float, theta12_deg: float, ca: float | None, t_end: float) -> Run:
    """Compute the collision by the model of hard spheres."""
    problem = three_equal_spheres(stokes, ca, H_A, H_MIN, theta12_deg, t_end=t_end)
    return run(problem, times=np.linspace(0.0, t_end, 401)[1:])


def in_engine(
    run_dir: Path,
    stokes: float,
    theta12_deg: float,
    ca: float | None,
    t_end: float,
    stiffness: float,
    friction: float = 0.0,
    engine: str = "liggghts",
) -> EngineRun:
    """Compute the collision in an engine, liggghts or lammps; `stiffness` of the contact [N/m]."""
    delta, s_min, a = 2.0 * RADIUS * H_A, 1e-3 * RADIUS, 0.5 * RADIUS
    kinds = bodies.sphere_classes(RADIUS, counts=3, density=DENSITY, angle_rad=0.0)
    reduced = 0.5 * kinds[0].mass_kg
    viscosity = reduced * SPEED / (6.0 * math.pi * a**2 * stokes)
    tension = 3.0 * viscosity * a * SPEED / (ca * delta) if ca else 0.05
    contact = math.pi * math.sqrt(reduced / stiffness)
    steps = math.ceil(t_end * delta / SPEED / (contact / PART))
    step = t_end * delta / SPEED / steps
    p = three_equal_spheres(stokes, theta12_deg=theta12_deg, h_a=H_A, t_end=t_end)
    reach = 2.0 * RADIUS + (delta - s_min) * (1.0 - 1e-9)  # a bridge forms where films overlap, not where they touch
    plane = p.position / np.linalg.norm(p.position, axis=1).clip(1e-300)[:, None] * reach
    plane[1] = 0.0
    spheres = [
        small.Sphere(1, tuple(TILT[:, :2] @ plane[k]), tuple(TILT[:, :2] @ p.velocity[k] * SPEED)) for k in range(3)
    ]
    claim(run_dir)
    with atomic_write(run_dir / "law.py") as temporary:
        temporary.write_text(LAWS.format(over_a=(delta - s_min) / a))
    small.prepare(
        run_dir, kinds, spheres, bodies.contacts(1, stiffness, friction=friction, restitution=1.0),
        liquid=bodies.water(0.5 * (delta - s_min), viscosity, tension),
        effects=Effects(
            bridges=True, capillary="davis" if ca else None, viscous_normal="davis",
            viscous_tangential=f"{(run_dir / 'law.py').resolve()}:film", rupture="davis", formation="davis", transfer="parabola",
        ),
        time_step_s=step, steps=steps, log_every_step=False, output_interval_s=max(steps // 400, 1) * step, box=0.02,
    )  # fmt: skip
    began = time.perf_counter()
    small.run(run_dir, spheres, engine=engine)
    wall_s = time.perf_counter() - began
    table = read_table(run_dir / "trajectory.parquet").sort_values(["step", "id"])
    at, v = (table[[f"{q}{axis}" for axis in "xyz"]].to_numpy().reshape(-1, 3, 3) for q in ("", "v"))
    moments = table["time"].to_numpy().reshape(-1, 3)[:, 0]
    # rotated into the plane of the problem
    return EngineRun(moments * SPEED / delta, at @ TILT / delta, v @ TILT / SPEED, wall_s)


def error(seen: EngineRun, exact: Run) -> float:
    """Return the largest difference of the final velocities over the largest velocity."""
    return distance(seen.velocity[-1, :, :2], exact)


def compare() -> pd.DataFrame:
    """Lines of the figure as rows `line`, `x`, `y`, at St 12 and 30°: gaps over time [t̂] in the model and in the stiffest run of
    the engine, and for both the error over the wall time [s] and `setting`: the contact's stiffness [N/m], the tolerance.
    """
    given = (12.0, 30.0, None, 8.0)
    exact = model(*given)
    with TemporaryDirectory() as work:
        comparisons = {k: in_engine(Path(work) / f"k{k:.0e}", *given, k) for k in STIFFNESS}
    seen, record = comparisons[STIFFNESS[-1]], exact.record
    parts = [
        pd.DataFrame({"line": f"{name} {side}", "x": x, "y": y[:, pair]})
        for pair, name in ((0, "1-2"), (2, "2-3"))
        for side, x, y in (("engine", seen.time, seen.gap), ("model", record["time"], record["gap"]))
    ]
    rows = [("engine, stiffer contact →", made.wall_s, error(made, exact), k) for k, made in comparisons.items()]
    for rtol in (1e-3, 1e-6, 1e-9):
        one = run(exact.problem.with_(rtol=rtol))
        rows.append(("model, smaller tolerance ↓", one.wall_s, distance(one.velocity, exact), rtol))
    return pd.concat([*parts, pd.DataFrame(rows, columns=["line", "x", "y", "setting"])], ignore_index=True)


def draw(table: pd.DataFrame) -> Figure:
    """Draw gaps over time in the model and in the stiffest run of the engine, and the cost of accuracy in both."""
    figure, (left, right) = panels(2, 2, (5.0, 4.0))
    colours = {"1-2": NAVY, "2-3": RED, "engine,": NAVY, "model,": RED}
    for name, points in table.groupby("line", sort=False):
        colour = colours[str(name).split()[0]]
        if points["setting"].notna().all():
            right.loglog(points["x"], points["y"].clip(lower=1e-12), "o-", color=colour, label=name)
        else:
            style = "." if str(name).endswith("engine") else "-"
            left.plot(points["x"], points["y"], style, ms=2, lw=0.8, color=colour, label=name)
    left.axhline(H_MIN, color=GRID, ls=":", lw=0.8)
    left.set(xlabel="t̂", ylabel="ĥ", ylim=(0, 1.5), xlim=(0, 6), title="St 12, 30°")
    right.set(xlabel="wall time [s]", ylabel="error of the final velocities")
    for ax in (left, right):
        ax.legend(fontsize=7)
    return figure
