"""Beds that a full-scale run has at given times: places, speeds, spins and films, the liquid of bridges given back to the films.

A run of the case, retired spheres left out, is made once and stored under results/benchmarks (case 2: a quarter of an hour).
"""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pandas as pd

from pywet import config
from pywet.cases.screening import cases
from pywet.engines.liggghts import driver
from pywet.scene import EngineScene
from pywet.util.files import write_json

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "results" / "benchmarks"
TIMES = (0.5, 2.0, 6.0)
"""On the closed slide; while spheres pass; near the end of the passage [s]."""


def run_of(case: int) -> Path:
    """The folder of the case's run to the last of TIMES; a run that was cut off goes on."""
    conf = config.load(ROOT / "config")
    mark = hashlib.sha256((ROOT / "config" / "scales.yaml").read_bytes()).hexdigest()[:8]
    folder = RESULTS / f"run-{case:02d}-{mark}"
    if not (folder / "scene.json").exists():
        scene = cases.build(conf, case, "full", folder)
        output = scene.output.model_copy(update={"contact_windows": 0})
        change = {"duration_s": max(TIMES) + scene.output.interval_s, "output": output, "retire": True}
        write_json(folder / "scene.json", scene.model_copy(update=change).model_dump(mode="json"))
    driver.run(folder, keep=True)
    return folder


def bed(folder: Path, time: float) -> pd.DataFrame:
    """id, type, x … wz and film [m3] of the spheres that are in the run at its output nearest to `time`."""
    scene = EngineScene.read(folder / "scene.json")
    step = min(scene.output_steps, key=lambda n: abs(n * scene.time_step_s - time))

    def at(name: str) -> pd.DataFrame:
        table = pd.read_parquet(folder / f"{name}.parquet")
        return table[table["step"] == step]

    spheres = at("trajectory").drop(columns=["step", "time"])
    gone = pd.read_parquet(folder / "history" / "retired.parquet").query("step <= @step")["id"]
    spheres = spheres[~spheres["id"].isin(gone)]
    held = pd.Series(0.0, index=range(int(spheres["id"].max()) + 1))
    films, bridges = at("history/films").set_index("id")["film"], at("history/bridges")
    held = held.add(films, fill_value=0.0).add(bridges.groupby("i")["share_i"].sum(), fill_value=0.0)
    pairs = bridges[bridges["partner_kind"] == 0]
    held = held.add((pairs["volume"] - pairs["share_i"]).groupby(pairs["j"]).sum(), fill_value=0.0)
    spheres["film"] = held[spheres["id"]].to_numpy()
    spheres["id"] = np.arange(1, len(spheres) + 1)
    return spheres.reset_index(drop=True)
