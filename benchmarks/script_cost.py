"""Cost of liquid in a script and in a scene, on one settled bed: milliseconds of the engine's loop a step, and ratios to dry.

`python benchmarks/script_cost.py [--side N]`: a bed of N x N x 6 spheres (13) settles dry; from there the same deck runs dry in
the stock program, moist as a scene (contacts by the plugin, or by the stock loop), and as a script with a line of fix pywet.
The variants run in turn, ROUNDS times; the least loop time that the engine prints counts.
"""

from __future__ import annotations

import argparse
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from glass import FILM, STEP, WATER, lattice, prepare

from pywet.cases.small import small
from pywet.cases.small.bodies import last
from pywet.engines.liggghts import deck
from pywet.scene import EngineScene, Output

SETTLE, STEPS, ROUNDS, LAYERS = 6000, 6000, 3, 6
MOTION = ["x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"]
STOCK, SCENE, SCENE_STOCK, SCRIPT = (
    "stock program, dry",
    "scene, moist",
    "scene, moist, stock contacts",
    "script, moist",
)
VARIANTS = (STOCK, SCENE, SCENE_STOCK, SCRIPT)


def as_script(scene: EngineScene, run_dir: Path, folder: Path, steps: int, liquid: bool) -> None:
    """The deck of a dry scene as a script, with or without the line of fix pywet."""
    deck.write_deck(scene, run_dir, folder)
    text = (folder / "setup.liggghts").read_text().splitlines()
    skin = 2.0 * deck.skin(scene)  # half of it is for films
    rows = [f"neighbor {skin!r} bin" if row.startswith("neighbor ") and liquid else row for row in text]
    rows = [row for row in rows if not row.startswith(("dump", "variable        frame"))]
    line = [f"fix wet all pywet liquid wet.yaml every {steps}"] if liquid else []
    (folder / "in.script").write_text("\n".join([*rows, *line, f"run {steps}"]) + "\n")
    angles = {c.type: math.degrees(c.contact_angle_rad) for c in scene.classes}
    walls = {w.name: math.degrees(w.contact_angle_rad) for w in scene.walls}
    of = f"surface_tension_N_per_m: {WATER.surface_tension_N_per_m}, viscosity_Pa_s: {WATER.viscosity_Pa_s}"
    (folder / "wet.yaml").write_text(
        f"liquid: {{{of}, density_kg_per_m3: {WATER.density_kg_per_m3}, film_um: {1e6 * FILM}}}\n"
        f"contact_angle_deg: {angles}\nviscous_integration: explicit\nwalls: {walls}\n"
    )


def run(folder: Path, variant: str, start: pd.DataFrame, steps: int) -> float:
    """So many steps of a variant, from the places and speeds of `start`; time of the engine's loop [s]."""
    spheres = [small.Sphere(1, row[:3], row[3:6], row[6:]) for row in start[MOTION].itertuples(index=False, name=None)]
    output = Output(interval_s=steps * STEP, contact_windows=0, energy=False)
    if variant in (SCENE, SCENE_STOCK):
        contacts = "stock" if variant == SCENE_STOCK else "planes"
        prepare(folder, spheres, steps, effects=small.PAPER, liquid=WATER, output=output, contacts=contacts)
        small.run(folder, spheres)
        return loop_s(folder / "engine" / "log.liggghts")
    scene = prepare(folder, spheres, steps, effects=small.DRY, output=output)
    as_script(scene, folder, folder, steps, variant == SCRIPT)
    program = [sys.executable, "-m", "pywet.cli.app", "liggghts"] if variant == SCRIPT else ["liggghts"]
    done = subprocess.run(
        [*program, "-in", "in.script"], cwd=folder, capture_output=True, text=True, errors="replace", check=False
    )
    if done.returncode != 0:
        raise SystemExit("\n".join([*done.stdout.splitlines()[-5:], done.stderr]))
    return loop_s(folder / "log.liggghts")


def loop_s(log: Path) -> float:
    """Time of the engine's loop by its log [s]."""
    return float(re.findall(r"^Loop time of (\S+)", log.read_text(errors="replace"), re.MULTILINE)[-1])


def main() -> None:
    """Settle, run all variants in turn, print the least of each."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--side", type=int, default=13)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        places = lattice(asked.side, LAYERS, 2.05, 0.02)
        spheres = [small.Sphere(1, tuple(row)) for row in places]
        prepare(
            folder / "dry",
            spheres,
            SETTLE,
            effects=small.DRY,
            output=Output(interval_s=SETTLE * STEP, contact_windows=0),
        )
        small.run(folder / "dry", spheres)
        start = last(folder / "dry")
        times: dict[str, list[float]] = {}
        for k in range(ROUNDS):
            for n, variant in enumerate(VARIANTS):
                times.setdefault(variant, []).append(1e3 * run(folder / f"{k}-{n}", variant, start, STEPS) / STEPS)
    print(f"{len(places)} spheres, {STEPS} steps, least of {ROUNDS} rounds; ratios to {STOCK}")
    for label, values in times.items():
        print(
            f"{label:30s}{min(values):8.3f} ms a step{min(values) / min(times[STOCK]):7.2f}   of {np.round(values, 3)}"
        )


if __name__ == "__main__":
    main()
