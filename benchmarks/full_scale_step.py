"""Bare cost of a step on settled full-scale beds: dry and moist, with wires as meshes and as prisms.

`python benchmarks/full_scale_step.py [CASE …] [--steps N] [--rounds N]`, case 2 by default, some five minutes.

A loose fill settles on the vibrating screen with soft springs, which are then stiffened in stages (springs stiffened at once
throw the spheres apart); each stage lasts whole strokes, since the next one begins with the screen where its file says. The bed
is kept under results/benchmarks. Rounds take the variants in turn. A step's cost is the difference of two runs of different
length, in user and system time of the engine's steps, so that neither start-up nor outputs count.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import math
import statistics
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd

from pywet import config
from pywet.cases.screening import cases
from pywet.engines.liggghts import driver
from pywet.geometry import build_apparatus, fill
from pywet.geometry.initial import write_initial
from pywet.laws import own
from pywet.planning import PRESETS
from pywet.scene import Effects, Output, Scene
from pywet.util.files import write_table

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "results" / "benchmarks"
STAGES = ((0.01, 20), (0.1, 3), (1.0, 1))
"""Share of the stiffness and number of strokes."""
SHORT = 100
DRY = Effects(bridges=False)
OWN = f"{ROOT / 'pywet' / 'laws' / 'capillary.py'}:rabinovich"
"""The capillary law of `paper` as one in a user's file."""
VARIANTS: dict[str, tuple[dict[str, str] | None, int, bool]] = {
    "dry mesh": (None, 1, False),
    "dry prism": (None, 1, True),
    "paper mesh": (PRESETS["paper"], 1, False),
    "paper prism": (PRESETS["paper"], 1, True),
    "paper prism, every 2nd": (PRESETS["paper"], 2, True),
    "paper prism, every 4th": (PRESETS["paper"], 4, True),
    "exact prism": (PRESETS["exact"], 1, True),
    "own prism": ({**PRESETS["paper"], "capillary": OWN}, 1, True),
}
"""Name -> laws of the bridges or none, at every how many-th step they act, whether wires are prisms."""


def prepare(folder: Path, case: int, spheres: pd.DataFrame | None, change: Callable[[Scene], dict[str, Any]]) -> Scene:
    """A case at full scale without its slide, from `spheres` or a loose fill; `change` gives fields of its scene."""
    conf = config.load(ROOT / "config")
    row, scale = conf.case(case), conf.scale("full")
    apparatus = build_apparatus(cases.apparatus_spec(conf, row, scale))
    scene = cases.assemble(conf, row, scale, cases.ingredients(conf, case, "full"), apparatus)
    surfaces = [s for s in apparatus.surfaces if s.motion != "slides"]
    walls = tuple(w for w in scene.walls if w.motion != "slides")
    scene = scene.model_copy(update={"walls": walls, "slide": None})
    scene = scene.model_copy(update=change(scene))
    wire = 1e-3 * conf.materials.screen(row.aperture_mm).wire_diameter_mm.value
    low = dataclasses.replace(apparatus.feed_region, z_low_m=wire)
    table = fill(scene.classes, low, scene.seed) if spheres is None else spheres
    write_initial(scene, surfaces, table, folder)
    return scene


def softer(scene: Scene, share: float) -> dict[str, Any]:
    """Contacts with that share of the stiffness, dry, at the same number of steps a collision."""
    pairs = tuple(
        p.model_copy(
            update={
                "normal_stiffness_N_per_m": share * p.normal_stiffness_N_per_m,
                "tangential_stiffness_N_per_m": share * p.tangential_stiffness_N_per_m,
            }
        )
        for p in scene.pairs
    )
    return {"pairs": pairs, "time_step_s": scene.time_step_s / math.sqrt(share), "effects": DRY}


def quiet(steps: int, time_step: float) -> dict[str, Any]:
    """So many steps and nothing written but the first and the last."""
    output = Output(interval_s=steps * time_step, contact_windows=0, energy=False)
    return {"duration_s": steps * time_step, "output": output}


def settled(case: int) -> pd.DataFrame:
    """Spheres of the settled bed, from the cache where it is known."""
    mark = hashlib.sha256((ROOT / "config" / "scales.yaml").read_bytes() + repr(STAGES).encode()).hexdigest()[:8]
    path = KEPT / f"bed-{case:02d}-{mark}.parquet"
    if path.exists():
        return pd.read_parquet(path)
    spheres: pd.DataFrame | None = None
    for share, strokes in STAGES:

        def change(scene: Scene, share: float = share, strokes: int = strokes) -> dict[str, Any]:
            assert scene.vibration is not None
            soft = softer(scene, share)
            steps = round(strokes / scene.vibration.frequency_Hz / soft["time_step_s"])
            return {**soft, **quiet(steps, soft["time_step_s"])}

        with tempfile.TemporaryDirectory() as name:
            scene = prepare(Path(name), case, spheres, change)
            driver.run(Path(name), progress=False)
            frames = pd.read_parquet(Path(name) / "trajectory.parquet")
        spheres = frames[frames["step"] == scene.steps].drop(columns=["step", "time"]).reset_index(drop=True)
        print(f"case {case}: {share:g} of the stiffness, {scene.steps} steps, {len(spheres)} spheres", flush=True)
    assert spheres is not None
    write_table(spheres, path)
    return spheres


def seconds(
    case: int, spheres: pd.DataFrame, laws: dict[str, str] | None, every: int, prisms: bool, steps: int
) -> float:
    """Processor time of a run's steps."""

    def change(scene: Scene) -> dict[str, Any]:
        walls = tuple(w.model_copy(update={"prisms": prisms and w.holder == "wires"}) for w in scene.walls)
        effects = DRY if laws is None else scene.effects.model_copy(update=laws)
        changed = {"walls": walls, "effects": effects, "bridges_every": every}
        return {**changed, **quiet(steps, scene.time_step_s)}

    with tempfile.TemporaryDirectory() as name:
        prepare(Path(name), case, spheres, change)
        found = driver.run(Path(name), progress=False).loop_cpu_s
    assert found is not None
    return found


def measure(case: int, steps: int, rounds: int, names: list[str]) -> None:
    """Print one bed's table; ratios are to the first of `names`, least of each."""
    spheres = settled(case)
    start = {name: seconds(case, spheres, *VARIANTS[name], SHORT) for name in names}
    times: dict[str, list[float]] = {name: [] for name in names}
    for turn in range(rounds):
        for name in names:
            times[name].append(1e3 * (seconds(case, spheres, *VARIANTS[name], SHORT + steps) - start[name]) / steps)
        print(
            f"round {turn + 1}: " + ", ".join(f"{name} {values[-1]:.3f}" for name, values in times.items()), flush=True
        )
    print(f"case {case}: {len(spheres)} spheres, {steps} steps, {rounds} rounds; ms a step: median (least to most)")
    for name, values in times.items():
        ratio = min(values) / min(times[names[0]])
        spread = f"{statistics.median(values):8.3f} ({min(values):.3f} to {max(values):.3f})"
        print(f"{name:24s}{spread}{ratio:8.2f} x {names[0]}", flush=True)


def main() -> None:
    """Every case asked for."""
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    words.add_argument("cases", nargs="*", type=int, default=[2])
    words.add_argument("--steps", type=int, default=1000)
    words.add_argument("--rounds", type=int, default=3)
    words.add_argument(
        "--only", nargs="+", choices=VARIANTS, default=list(VARIANTS), help="these variants, the first as the base"
    )
    asked = words.parse_args()
    own.trust([OWN])
    for case in asked.cases:
        measure(case, asked.steps, asked.rounds, asked.only)


if __name__ == "__main__":
    main()
