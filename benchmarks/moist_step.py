"""Cost of a moist step on a settled bed: milliseconds of the engine's time loop, and ratios to the dry step of the same bed.

`python benchmarks/moist_step.py [--side N] [--against CHECKOUT]`: a bed of N x N x 6 spheres (26) settles dry; each variant goes
on from there, in turn, ROUNDS times, and the least time of each counts. `--against` also runs the program of another checkout.
`works`: with `output.energy`. `own law`: a capillary law in a user's file, with the equation of `rabinovich`.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.bench import small
from pywet.laws import capillary
from pywet.scene import ContactPair, Liquid, Output, SphereClass

RADIUS, FILM, STEP, SETTLE, STEPS, ROUNDS, LAYERS = 2.5e-3, 5e-5, 1e-5, 6000, 1000, 3, 6
ANGLE = math.radians(15.0)
WATER = Liquid(
    surface_tension_N_per_m=0.07275, viscosity_Pa_s=1e-3, density_kg_per_m3=998.2, initial_film_thickness_m=FILM
)
EFFECTS = {
    "dry": small.DRY,
    "paper": small.PAPER,
    "exact": small.EXACT,
    "semi-implicit": small.PAPER,
    "paper, works": small.PAPER,
}
VARIANTS = (*EFFECTS, "own law")


def lattice(side: int) -> pd.DataFrame:
    """Spheres on a slightly shaken lattice above the floor; columns x … wz."""
    cells = np.stack(np.meshgrid(*[np.arange(n) for n in (side, side, LAYERS)], indexing="ij"), axis=-1).reshape(-1, 3)
    at = (cells - [0.5 * side, 0.5 * side, -0.55]) * 2.05 * RADIUS
    at += np.random.default_rng(1).uniform(-0.02, 0.02, at.shape) * RADIUS
    return pd.DataFrame(
        np.hstack([at, np.zeros((len(at), 6))]), columns=["x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"]
    )


def run(folder: Path, variant: str, start: pd.DataFrame, steps: int) -> float:
    """Milliseconds a step of a variant of the bed."""
    spheres = [small.Sphere(1, row[:3], row[3:6], row[6:]) for row in start.itertuples(index=False, name=None)]
    effects = EFFECTS.get(variant, small.PAPER)
    if variant == "own law":
        own = folder / "own.py"
        own.write_text(Path(capillary.__file__).read_text())
        effects = effects.model_copy(update={"capillary": f"{own}:rabinovich"})
    sphere = SphereClass(
        name="glass", type=1, radius_m=RADIUS, density_kg_per_m3=2500.0, contact_angle_rad=ANGLE, count=len(spheres)
    )
    pairs = [
        ContactPair(
            a=1, b=b, normal_stiffness_N_per_m=1e4, tangential_stiffness_N_per_m=2857.0, friction=0.4,
            rolling_friction_m=9e-5, restitution=0.5,
        )
        for b in (0, 1)
    ]  # fmt: skip
    ask = {"energy": "works" in variant} if "energy" in Output.model_fields else {}  # another checkout may not know it
    half = float(start[["x", "y"]].abs().to_numpy().max()) + 0.05
    small.prepare(
        folder, [sphere], spheres, pairs, liquid=None if variant == "dry" else WATER, effects=effects,
        walls=[small.floor(half)], wall_angle_rad=ANGLE, time_step_s=STEP, steps=steps, gravity=(0.0, 0.0, -9.81),
        box=half + 0.01,
        viscous_integration="semi_implicit" if variant == "semi-implicit" else "explicit",
        output=Output.model_validate({"interval_s": steps * STEP, "contact_windows": 0} | ask),
    )  # fmt: skip
    info = small.run(folder, spheres)
    return 1e3 * (info.loop_cpu_s or info.cpu_s) / steps


def by_itself(checkout: Path, variant: str, start: Path) -> float:
    """A run in a process of its own, with the program of a checkout."""
    command = [sys.executable, __file__, "--one", variant, str(start)]
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    return float(done.stdout.split()[-1])


def main() -> None:
    """Settle, run all variants in turn, print the least of each."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--side", type=int, default=26)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--variants", nargs="+", default=VARIANTS)
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if asked.one:
            print(run(folder, asked.one[0], pd.read_parquet(asked.one[1]), STEPS))
            return
        start, made = folder / "start.parquet", lattice(asked.side)
        run(folder, "dry", made, SETTLE)
        table = pd.read_parquet(folder / "trajectory.parquet")
        table[table["step"] == table["step"].max()].sort_values("id")[list(made.columns)].to_parquet(start)
        programs = {"": Path(__file__).parents[1]} | ({" (other)": asked.against.resolve()} if asked.against else {})
        found: dict[str, list[float]] = {}
        for _ in range(ROUNDS):
            for variant in asked.variants:
                for label, checkout in programs.items():
                    found.setdefault(variant + label, []).append(by_itself(checkout, variant, start))
    for label, times in found.items():
        print(
            f"{label:24s}{min(times):8.3f} ms a step{min(times) / min(found['dry']):7.2f} x dry   of {np.round(times, 3)}"
        )


if __name__ == "__main__":
    main()
