"""Cost of a step on a settled bed, side by side: milliseconds of processor time, and ratios to the stock program's dry step.

`python benchmarks/step_cost.py [--side N] [--only VARIANT ...] [--against CHECKOUT]`: a bed of N x N x 6 spheres (13) settles
dry; each variant resumes from there, in turn, ROUNDS times, short and long; the least of each length counts. `--against` also
runs another checkout.

Variants: the stock program, dry; the same through this package; the plugin attached without liquid; moist with preset `paper`
and every capillary law there is, preset `exact`, semi-implicit drag, `output.energy`, and the equation of `rabinovich` as a law
in a user's file; the stock program with its own cohesion models `washino` and `easo` (other physics, the same bed); YADE and
LAMMPS (it has no such rolling resistance), where they are installed, dry and moist with preset `paper`. A step's cost is the
difference of both lengths, so that start-up does not count.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from glass import FILM, RADIUS, STEP, WATER, lattice, prepare, spent

from pywet.cases.small import small
from pywet.cases.small.bodies import WETTED, last
from pywet.engines.lammps import build as lammps
from pywet.engines.liggghts import deck
from pywet.laws import capillary, registry
from pywet.scene import Effects, EngineScene, Output

SETTLE, SHORT, STEPS, ROUNDS, LAYERS = 6000, 200, 10_000, 3, 6
MOTION = ["x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"]
STOCK, NOTHING, CUSTOM = "stock dry", "no liquid", "own law"
COHESIONS = {"stock washino": "washino", "stock easo": "easo"}
PEERS = {
    **({"YADE, dry": "yade", "YADE, moist": "yade"} if shutil.which("yade") else {}),
    **({"LAMMPS, dry": "lammps", "LAMMPS, moist": "lammps"} if lammps.PREFIX.exists() else {}),
}
"""Variant -> engine."""
VARIANTS = (
    STOCK, "dry", NOTHING, *registry.names("capillary"), "exact", "semi-implicit", "works", CUSTOM, *COHESIONS, *PEERS,
)  # fmt: skip
COHESION = f"""
fix p_liquid all property/global surfaceLiquidContentInitial scalar {3 * FILM / RADIUS!r}
fix p_tension all property/global surfaceTension scalar {WATER.surface_tension_N_per_m!r}
fix p_viscosity all property/global fluidViscosity scalar {WATER.viscosity_Pa_s!r}
fix p_angle all property/global contactAngle peratomtype {WETTED!r} {WETTED!r}
fix p_least all property/global minSeparationDistanceRatio scalar 1.01
fix p_most all property/global maxSeparationDistanceRatio scalar 1.1
"""


def effects(variant: str, folder: Path) -> Effects:
    """Return the effects that are on in a variant."""
    if variant in (STOCK, "dry", *COHESIONS) or variant.endswith(", dry"):
        return small.DRY
    if variant == CUSTOM:
        law = folder / "own.py"
        law.write_text(Path(capillary.__file__).read_text())
        return small.PAPER.model_copy(update={"capillary": f"{law}:rabinovich"})
    laws = {"capillary": variant} if variant in registry.names("capillary") else {}
    return small.EXACT if variant == "exact" else small.PAPER.model_copy(update=laws)


def run(folder: Path, variant: str, start: pd.DataFrame, steps: int) -> None:
    """So many steps of a variant, from the places and speeds of `start`."""
    spheres = [small.Sphere(1, row[:3], row[3:6], row[6:]) for row in start[MOTION].itertuples(index=False, name=None)]
    on = effects(variant, folder)
    liquid = WATER.model_copy(update={"initial_film_thickness_m": 0.0}) if variant == NOTHING else WATER
    scene = prepare(
        folder, spheres, steps, effects=on, liquid=liquid if on.bridges else None,
        rolling_m=0.0 if PEERS.get(variant) == "lammps" else 9e-5,
        viscous_integration="semi_implicit" if variant == "semi-implicit" else "explicit",
        output=Output(interval_s=steps * STEP, contact_windows=0, energy=variant == "works"),
    )  # fmt: skip
    if variant == STOCK:
        stock(folder, scene)
    elif variant in COHESIONS:
        stock(folder, scene, COHESIONS[variant])
    else:
        small.run(folder, spheres, engine=PEERS.get(variant, "liggghts"))


def stock(folder: Path, scene: EngineScene, model: str = "") -> None:
    """The stock program on the same deck, with a cohesion model of its own or dry."""
    deck.write_deck(scene, folder, folder)
    if model:
        setup = folder / "setup.liggghts"
        text = setup.read_text().replace(
            " tangential history ", f" tangential history cohesion {model}/capillary/viscous "
        )
        setup.write_text(text.replace(" tangential_damping off", "").replace("pair_style", f"{COHESION}pair_style"))
    how = {"capture_output": True, "text": True, "errors": "replace", "check": False}
    done = subprocess.run(["liggghts", "-in", "in.liggghts"], cwd=folder, **how)  # type: ignore[call-overload]
    if done.returncode != 0:
        raise SystemExit("\n".join(done.stdout.splitlines()[-5:]))


def seconds(checkout: Path, variant: str, start: Path, steps: int) -> float:
    """Processor time of a run in a process of its own, with the program of a checkout."""
    before = spent()
    command = [sys.executable, __file__, "--one", variant, str(start), str(steps)]
    done = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": str(checkout)}, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    return spent() - before


def main() -> None:
    """Settle, run all variants in turn, print the least of each."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--side", type=int, default=13)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--only", nargs="+", choices=VARIANTS, default=VARIANTS)
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if asked.one:
            run(folder, asked.one[0], pd.read_parquet(asked.one[1]), int(asked.one[2]))
            return
        start = folder / "start.parquet"
        places = lattice(asked.side, LAYERS, 2.05, 0.02)
        run(folder, "dry", pd.DataFrame(np.hstack([places, np.zeros((len(places), 6))]), columns=MOTION), SETTLE)
        last(folder).to_parquet(start)
        programs = {"": Path(__file__).parents[1]} | ({" (other)": asked.against.resolve()} if asked.against else {})
        times: dict[str, list[tuple[float, float]]] = {}
        for _ in range(ROUNDS):
            for variant in asked.only:
                for label, checkout in programs.items():
                    short, long = (seconds(checkout, variant, start, n) for n in (SHORT, SHORT + STEPS))
                    times.setdefault(variant + label, []).append((short, long))
    print(f"{len(places)} spheres, {STEPS} steps, least of {ROUNDS} rounds; ratios to {asked.only[0]}")
    costs = {label: 1e3 * float(np.diff(np.min(pairs, axis=0))[0]) / STEPS for label, pairs in times.items()}
    for label, cost in costs.items():
        print(
            f"{label:24s}{cost:8.3f} ms a step{cost / costs[asked.only[0]]:7.2f}   s: {np.round(times[label], 2).tolist()}"
        )


if __name__ == "__main__":
    main()
