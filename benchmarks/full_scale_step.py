"""Bare cost of a step on full-scale beds as a run has them: dry and moist, contacts by the plugin and by the engine.

`python benchmarks/full_scale_step.py [CASE …] [--at SECONDS …] [--steps N] [--rounds N]`, case 2 by default.

Beds are those of a run at 0.5, 2 and 6 s (run_beds.py), the first on the closed slide. Rounds take the variants in turn, and a
ratio is of the same round. A step's cost is the difference of two runs of different length, in user and system time of the
engine's steps, so that neither start-up nor outputs count.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import statistics
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from run_beds import TIMES, bed, run_of

from pywet import config
from pywet.cases.screening import cases
from pywet.engines.liggghts import driver
from pywet.geometry import build_apparatus
from pywet.geometry.initial import write_initial
from pywet.geometry.motion import engine_displacement
from pywet.laws import custom_laws
from pywet.laws.kinds import PRESETS
from pywet.scene import Contacts, Effects, EngineScene, Output

ROOT = Path(__file__).parents[1]
SHORT = 100
DRY = Effects(bridges=False)
CUSTOM_LAW = f"{ROOT / 'pywet' / 'laws' / 'capillary.py'}:rabinovich"
"""The capillary law of `paper` as one in a user's file."""
VARIANTS: dict[str, tuple[dict[str, str] | None, int, bool, Contacts]] = {
    "dry, stock contacts": (None, 1, True, "stock"),
    "dry": (None, 1, True, "planes"),
    "dry, stock program": (None, 1, False, "stock"),
    "paper, stock contacts": (PRESETS["paper"], 1, True, "stock"),
    "paper": (PRESETS["paper"], 1, True, "planes"),
    "paper mesh": (PRESETS["paper"], 1, False, "planes"),
    "paper, every 2nd": (PRESETS["paper"], 2, True, "planes"),
    "paper, every 4th": (PRESETS["paper"], 4, True, "planes"),
    "exact": (PRESETS["exact"], 1, True, "planes"),
    "own": ({**PRESETS["paper"], "capillary": CUSTOM_LAW}, 1, True, "planes"),
}
"""Name -> laws of the bridges or none, at every how many-th step they act, whether wires are analytic, who makes contacts."""


def prepare(
    folder: Path, case: int, at: float, spheres: pd.DataFrame, change: Callable[[EngineScene], dict[str, Any]]
) -> EngineScene:  # fmt: skip
    """A case at full scale from `spheres`, vibrating walls where they are at that time, its slide closed or drawn away.

    `change` gives fields of its scene.
    """
    conf = config.load(ROOT / "config")
    row, scale = conf.case(case), conf.scale("full")
    apparatus = build_apparatus(cases.apparatus_spec(conf, row, scale))
    scene = cases.assemble(conf, row, scale, cases.ingredients(conf, case, "full"), apparatus)
    closed = scene.slide is not None and at <= scene.slide.opens_at_s
    slide = scene.slide.model_copy(update={"opens_at_s": 1e3}) if closed and scene.slide else None
    surfaces = [s for s in apparatus.surfaces if closed or s.motion != "slides"]
    walls = tuple(w for w in scene.walls if closed or w.motion != "slides")
    scene = scene.model_copy(update={"walls": walls, "slide": slide, "retire": False})
    scene = scene.model_copy(update=change(scene))
    if scene.vibration is not None:
        turned = 2.0 * math.pi * scene.vibration.frequency_Hz * at
        shift = engine_displacement(scene.vibration, np.array([round(at / scene.time_step_s)]), scene.time_step_s)[0]
        moved = [(s.vertices + shift).astype(np.float32).astype(float) for s in surfaces]
        surfaces = [
            dataclasses.replace(s, vertices=v) if s.motion == "vibrates" else s
            for s, v in zip(surfaces, moved, strict=True)
        ]
        phases = tuple(phase + turned for phase in scene.vibration.phase_rad)
        scene = scene.model_copy(update={"vibration": scene.vibration.model_copy(update={"phase_rad": phases})})
    write_initial(scene, surfaces, spheres, folder)
    return scene


def quiet(steps: int, time_step: float) -> dict[str, Any]:
    """So many steps and nothing written but the first and the last."""
    output = Output(interval_s=steps * time_step, contact_windows=0, energy=False)
    return {"duration_s": steps * time_step, "output": output}


def seconds(
    case: int, at: float, spheres: pd.DataFrame, laws: dict[str, str] | None, every: int, analytic_wires: bool,
    contacts: Contacts,
    steps: int,
) -> float:  # fmt: skip
    """Processor time of a run's steps."""

    def change(scene: EngineScene) -> dict[str, Any]:
        walls = tuple(
            w.model_copy(update={"analytic_wires": analytic_wires and w.reservoir == "wires"}) for w in scene.walls
        )
        effects = DRY if laws is None else scene.effects.model_copy(update=laws)
        changed = {"walls": walls, "effects": effects, "bridges_every": every, "contacts": contacts}
        return {**changed, **quiet(steps, scene.time_step_s)}

    with tempfile.TemporaryDirectory() as name:
        prepare(Path(name), case, at, spheres, change)
        found = driver.run(Path(name), progress=False).loop_cpu_s
    assert found is not None
    return found


def measure(case: int, at: float, steps: int, rounds: int, names: list[str]) -> None:
    """Print one bed's table; ratios are to the first of `names` in the same round."""
    spheres = bed(run_of(case), at)
    start = {name: seconds(case, at, spheres, *VARIANTS[name], SHORT) for name in names}
    times: dict[str, list[float]] = {name: [] for name in names}
    for turn in range(rounds):
        for name in names:
            times[name].append(1e3 * (seconds(case, at, spheres, *VARIANTS[name], SHORT + steps) - start[name]) / steps)
        print(
            f"round {turn + 1}: " + ", ".join(f"{name} {values[-1]:.3f}" for name, values in times.items()), flush=True
        )
    print(
        f"case {case} at {at:g} s: {len(spheres)} spheres, {steps} steps, {rounds} rounds; ms a step: median (least to most)"
    )
    for name, values in times.items():
        ratios = sorted(value / base for value, base in zip(values, times[names[0]], strict=True))
        spread = f"{statistics.median(values):8.3f} ({min(values):.3f} to {max(values):.3f})"
        print(
            f"{name:24s}{spread}{statistics.median(ratios):8.2f} x {names[0]} ({ratios[0]:.2f} to {ratios[-1]:.2f})",
            flush=True,
        )


def main() -> None:
    """Every case asked for."""
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    words.add_argument("cases", nargs="*", type=int, default=[2])
    words.add_argument("--at", nargs="+", type=float, default=list(TIMES), help="times of the run [s]")
    words.add_argument("--steps", type=int, default=1000)
    words.add_argument("--rounds", type=int, default=3)
    words.add_argument(
        "--only", nargs="+", choices=VARIANTS, default=list(VARIANTS), help="these variants, the first as the base"
    )
    asked = words.parse_args()
    custom_laws.trust([CUSTOM_LAW])
    for case in asked.cases:
        for at in asked.at:
            measure(case, at, asked.steps, asked.rounds, asked.only)


if __name__ == "__main__":
    main()
