"""A continuous run made by hand: who leaves through which outlet, when and how wet, so that every number is known on paper."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet import run_folder
from pywet.cases.small import bodies
from pywet.scene import Effects, EngineScene, Insertion, Outlet, Output, SphereClass
from pywet.schema import TABLES
from pywet.util.files import write_json, write_table
from reference_impl.replay import io
from reference_impl.tables import plant

SIZES_MM = (1.0, 2.0, 3.0, 4.0)
OVERS = (0, 10, 30, 40)
"""Of 40 spheres of each size: T = 0, 1/4, 3/4, 1."""
EACH, STEP, EVERY = 40, 1e-3, 20
FILM = 1e-10
OUTLETS = (
    Outlet(name="overs", low_m=(0.1, None, None), high_m=(None, None, None), product="overs"),
    Outlet(name="unders", low_m=(None, None, None), high_m=(None, None, -0.05), product="unders"),
)


def scene(steps: int = 2000) -> EngineScene:
    """Four sizes of one density, all inserted in the first 2 s."""
    classes = tuple(
        SphereClass(name=f"{d:g} mm", type=k, radius_m=0.5e-3 * d, density_kg_per_m3=2500.0, contact_angle_rad=0.2,
                    count=EACH, insertion=Insertion(from_s=0.0, for_s=2.0))
        for k, d in enumerate(SIZES_MM, start=1)
    )  # fmt: skip
    return EngineScene(
        name="made up", seed=1, classes=classes, pairs=bodies.contacts(4, 1e3), liquid=bodies.water(1e-5), walls=(),
        vibration=None, slide=None, effects=Effects(bridges=False), box_low_m=(-1, -1, -1), box_high_m=(1, 1, 1),
        spheres_file=Path("spheres.parquet"), time_step_s=STEP, duration_s=steps * STEP, bin_z_m=-1.0, outlets=OUTLETS,
        output=Output(interval_s=EVERY * STEP, checkpoints=200, contact_windows=0, energy=False),
    )  # fmt: skip


def make(run_dir: Path, overs: tuple[int, ...] = OVERS, steps: int = 2000) -> Path:
    """Write it, of 40 of each size `overs` to the overs: sphere k leaves 0.1 s after it entered, at the next step at which
    spheres leave, with its film. With fewer steps the run ends before all have entered."""
    run_folder.claim(run_dir)
    made = scene(steps)
    write_json(run_dir / "scene.json", made.model_dump(mode="json"))
    kind = np.repeat(np.arange(1, 5), EACH)
    ids = np.arange(1, len(kind) + 1)
    spheres = pd.DataFrame(
        {"id": ids, "type": kind, "radius": 0.5e-3 * np.array(SIZES_MM)[kind - 1], "film": FILM * kind}
    )
    write_table(spheres, run_dir / "history" / "spheres.parquet")
    enters, nth = np.array(made.enters(kind.tolist())), (ids - 1) % EACH
    step = np.ceil((enters + 100) / EVERY).astype(np.int64) * EVERY
    # the same proportion in every four consecutive spheres
    outlet = np.where(nth % 4 * 10 < np.array(overs)[kind - 1], 1, 2)
    here = step < made.steps
    rows = {"step": step, "time": step * STEP, "id": ids, "type": kind, "outlet": outlet, "pad": 0, "film": FILM * kind}
    x = np.where(outlet == 1, 0.2, 0.0), np.zeros(len(ids)), np.where(outlet == 1, 0.0, -0.1)
    rows |= {f"x_{axis}": values for axis, values in zip("xyz", x, strict=True)} | {f"v_{axis}": 0.0 for axis in "xyz"}
    write_table(pd.DataFrame(rows)[here], run_dir / "history" / "retired.parquet")
    places = [
        (s, s * STEP, int(i), int(t), *([0.0] * 9))
        for s in made.output_steps for i, t, last, stays in zip(ids, kind, step, here, strict=True) if s <= last or not stays
    ]  # fmt: skip
    write_table(pd.DataFrame(places, columns=[*TABLES["trajectory"]]), run_dir / "trajectory.parquet")
    return run_dir


def disagrees(run_dir: Path, given: dict[str, Any]) -> list[str]:
    """Names of the numbers of a deck with which the reference disagrees."""
    of = io.scene(run_dir)
    return [h.name for h in plant.held(run_dir, of, plant.Deck.read(run_dir, of, given)) if h.wrong]
