"""The same collision in the discrete element engine: three wet spheres in LIGGGHTS with the laws of `pywet.laws.davis`.

The engine's solid contact is a stiff spring at S = 0, the model's a hard impact at h = h_min: h = S + S_min with
S_min = 0.001 r_eff plays h_min, films of δ − S_min together play δ, and the model's centres are S_min further apart. The plane
of the collision is tilted, so that nothing hangs on two dimensions.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pywet.bench import bodies, small
from pywet.collisions.spheres.accuracy_cost import distance
from pywet.collisions.spheres.equal import three_equal_spheres
from pywet.collisions.spheres.simulate import Run, run
from pywet.files import atomic_write, read_table, write_json
from pywet.report.pictures import GRID, NAVY, RED, panels, save_png
from pywet.scene import Effects

RADIUS, DENSITY, SPEED, H_A, H_MIN = 1e-3, 2000.0, 0.4, 0.01, 0.05
"""Radius [m], density [kg/m3], normal speed [m/s], and δ/(2r), of which h_min/δ = 0.001 r/δ = 0.05 follows."""
PAIRS = ((0, 1), (0, 2), (1, 2))
LAWS = "from pywet.laws.davis import tangential\n\nfilm = tangential({over_a!r})\n"
TILT = np.linalg.qr(np.array([[1.0, 0.3, -0.2], [0.4, 1.0, 0.5], [0.1, -0.6, 1.0]]))[0]
"""Rotation of the collision's plane in space."""


@dataclass(frozen=True)
class Twin:
    """A collision in the engine: trajectory in the model's units (t̂, δ, v_n0), wall time."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    wall_s: float
    steps: int

    @property
    def gap(self) -> np.ndarray:
        """h/δ of the pairs 1-2, 1-3, 2-3, shape (times, 3)."""
        apart = [np.linalg.norm(self.position[:, i] - self.position[:, j], axis=1) for i, j in PAIRS]
        return np.stack(apart, 1) - (1.0 / H_A - H_MIN)  # h = S + S_min


def model(stokes: float, theta12_deg: float, ca: float | None, t_end: float) -> Run:
    """The collision by the model of hard spheres."""
    problem = three_equal_spheres(stokes, ca, H_A, H_MIN, theta12_deg, t_end=t_end)
    return run(problem, times=np.linspace(0.0, t_end, 401)[1:])


def twin(
    run_dir: Path, stokes: float, theta12_deg: float, ca: float | None, t_end: float, stiffness: float, part: int = 30
) -> Twin:
    """The collision in the engine; `stiffness` of the contact [N/m], `part` steps per dry collision."""
    delta, s_min, a = 2.0 * RADIUS * H_A, 1e-3 * RADIUS, 0.5 * RADIUS
    kinds = bodies.sphere_classes(RADIUS, counts=3, density=DENSITY, angle_rad=0.0)
    reduced = 0.5 * kinds[0].mass_kg
    viscosity = reduced * SPEED / (6.0 * math.pi * a**2 * stokes)
    tension = 3.0 * viscosity * a * SPEED / (ca * delta) if ca else 0.05
    contact = math.pi * math.sqrt(reduced / stiffness)
    steps = math.ceil(t_end * delta / SPEED / (contact / part))
    step = t_end * delta / SPEED / steps
    p = three_equal_spheres(stokes, theta12_deg=theta12_deg, h_a=H_A, t_end=t_end)
    reach = 2.0 * RADIUS + (delta - s_min) * (1.0 - 1e-9)  # a bridge forms where films overlap, not where they touch
    plane = p.position / np.linalg.norm(p.position, axis=1).clip(1e-300)[:, None] * reach
    plane[1] = 0.0
    spheres = [
        small.Sphere(1, tuple(TILT[:, :2] @ plane[k]), tuple(TILT[:, :2] @ p.velocity[k] * SPEED)) for k in range(3)
    ]
    with atomic_write(run_dir / "law.py") as temporary:
        temporary.write_text(LAWS.format(over_a=(delta - s_min) / a))
    small.prepare(
        run_dir, kinds, spheres, bodies.contacts(1, stiffness, friction=0.0, restitution=1.0),
        liquid=bodies.water(0.5 * (delta - s_min), viscosity, tension),
        effects=Effects(
            bridges=True, capillary="davis" if ca else None, viscous_normal="davis",
            viscous_tangential=f"{(run_dir / 'law.py').resolve()}:film", rupture="davis", formation="davis", transfer="parabola",
        ),
        time_step_s=step, steps=steps, log_every_step=False, output_interval_s=max(steps // 400, 1) * step, box=0.02,
    )  # fmt: skip
    began = time.perf_counter()
    small.run(run_dir, spheres)
    return trajectory(run_dir, delta, time.perf_counter() - began, steps)


def trajectory(run_dir: Path, delta: float, wall_s: float, steps: int) -> Twin:
    """The trajectory in the model's units, back in its plane."""
    table = read_table(run_dir / "trajectory.parquet").sort_values(["step", "id"])
    at, v = (table[[f"{q}{axis}" for axis in "xyz"]].to_numpy().reshape(-1, 3, 3) for q in ("", "v"))
    moments = table["time"].to_numpy().reshape(-1, 3)[:, 0]
    return Twin(moments * SPEED / delta, at @ TILT / delta, v @ TILT / SPEED, wall_s, steps)


def error(seen: Twin, exact: Run) -> float:
    """Largest difference of the final velocities over the largest velocity."""
    return distance(seen.velocity[-1, :, :2], exact)


def compare(folder: Path, work: Path, stiffness: tuple[float, ...] = (1e7, 1e8, 1e9, 1e10)) -> None:
    """`engine.json` and `engine.png`: gaps over time in both, and the error over the contact's stiffness (and so wall time)."""
    given = (12.0, 30.0, None, 8.0)
    exact, twins = model(*given), {k: twin(work / f"k{k:.0e}", *given, k) for k in stiffness}
    rows = [(k, error(seen, exact), seen.wall_s, seen.steps) for k, seen in twins.items()]
    table = pd.DataFrame(rows, columns=["stiffness_N_per_m", "error", "wall_s", "steps"])
    write_json(folder / "engine.json", table.to_dict(orient="records"))
    save_png(draw(table, twins[stiffness[-1]], exact), folder / "engine.png")


def draw(table: pd.DataFrame, seen: Twin, exact: Run) -> Figure:
    """Gaps over time in the model and in the stiffest run of the engine; what accuracy costs in either."""
    figure, (left, right) = panels(2, 2, (5.0, 4.0))
    for pair, colour, name in ((0, NAVY, "1-2"), (2, RED, "2-3")):
        left.plot(seen.time, seen.gap[:, pair], ".", ms=2, color=colour)
        gap = exact.record["gap"][:, pair]
        left.plot(exact.record["time"], gap, color=colour, lw=0.8, label=f"{name}: line model, dots engine")
    left.axhline(H_MIN, color=GRID, ls=":", lw=0.8)
    left.set(xlabel="t̂", ylabel="ĥ", ylim=(0, 1.5), xlim=(0, 6), title="St 12, 30°")
    right.loglog(table["wall_s"], table["error"], "o-", color=NAVY, label="engine, stiffer contact →")
    for rtol in (1e-3, 1e-6, 1e-9):
        one = run(exact.problem.with_(rtol=rtol))
        right.loglog(
            [one.wall_s], [max(distance(one.velocity, exact), 1e-12)], "s", color=RED, label=f"model, rtol {rtol:g}"
        )
    right.set(xlabel="wall time [s]", ylabel="error of the final velocities")
    for ax in (left, right):
        ax.legend(fontsize=7)
    return figure
