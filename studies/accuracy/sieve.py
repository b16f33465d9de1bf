"""Screening scenes of the study: a dry and a moist case on a narrow sieve for a short time, with any setting."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pywet import config as settings
from pywet.cases.screening import cases
from pywet.cases.screening.results import Results
from pywet.config import Config
from pywet.errors import PywetError
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene
from pywet.util.files import write_json
from studies.accuracy.parameters import SCALE, Setting, Size, with_setting

CASE = {"dry": 1, "moist": 2}
"""Screening case of each scene: POM of 5, 7, 10 mm on 8 mm apertures, dry and with 5 % of water."""
SCREENING = tuple(CASE)
SEEDS = (10007, 10009, 10037, 10039, 10061, 10067)
"""Sizes of the study.

`quick` and `standard`: the smoke scale's stiffness on 4 x 4 apertures; `whole`: the unchanged smoke scale. `reduced`:
the reduced scale's sieve and stiffness for the first second of screening; `reduced_whole`: the unchanged reduced
scale.
"""
Vary = Callable[[Config], Config]
PLACES = ("coarse_material", "fines")
LIQUID = ("coarse_material_m3", "fines_m3", "standing_bridges_m3")


SIZES = {
    "quick": Size("smoke", 40.0, 0.35, 0.08, 2),
    "standard": Size("smoke", 40.0, 0.8, 0.12, 4),
    "whole": Size("smoke", None, None, None, 4),
    "reduced": Size("reduced", None, 1.2, 0.2, 3, 6),
    "reduced_whole": Size("reduced", None, None, None, 3),
}
"""`quick` and `standard`: the smoke scale's springs on 4 x 4 apertures; `whole`: the smoke scale as it is. `reduced`: the reduced
scale's sieve and springs for the first second of screening; `reduced_whole`: as it is."""


def size_named(name: str) -> Size:
    if name not in SIZES:
        raise PywetError(f"size {name} of the accuracy study given, expected one of {', '.join(SIZES)}")
    return SIZES[name]


def prepare(
    folder: Path, kind: str, setting: Setting, size: Size, seed: int, config_dir: Path, vary: Vary = lambda same: same
) -> EngineScene:  # fmt: skip
    """Write the run directory of a screening scene, of the configuration as `vary` changes it."""
    config = vary(with_setting(settings.load(config_dir), setting, size, seed))
    scene = cases.build(config, CASE[kind], SCALE, folder)
    scene = scene.model_copy(update={"transfer_nodes": setting.transfer_nodes})
    write_json(folder / "scene.json", scene.model_dump(mode="json"))
    return scene


def quantities(folder: Path) -> dict[str, Any]:
    """Compute fraction retained (of the feed) and final liquid shares (of the liquid) of a run.

    `curve`: fraction retained over the time since the opening, for the picture.
    """
    run = RunDir(folder)
    made = Results.of(run)
    retained, liquid = made.retained, made.liquid
    since, curve = (retained[name].to_numpy() for name in ("time_since_opening_s", "fraction_retained"))
    opens = -float(since[0])
    # time steps differ between settings, so the last output may differ by one interval; all runs use this one
    end = run.scene.steps * run.scene.time_step_s - opens - run.scene.output.interval_s
    measured: dict[str, Any] = of_curve(since, curve, end)
    if run.moist:
        late = {name: float(np.interp(end + opens, liquid["time_s"], liquid[name])) for name in LIQUID}
        total = float(liquid["initial_m3"].iloc[-1])
        for place in PLACES:
            measured[f"liquid_{place}"] = late[f"{place}_m3"] / total
        measured["liquid_walls"] = 1.0 - sum(measured[f"liquid_{place}"] for place in PLACES)
        measured["liquid_bridges"] = late["standing_bridges_m3"] / total
    return {**measured, "curve": {"time_s": since.round(5).tolist(), "retained": curve.round(6).tolist()}}


def of_curve(since: np.ndarray, retained: np.ndarray, end: float) -> dict[str, float]:
    """Return the fraction retained at a time since the opening, and its mean from the opening to then (trapezium rule)."""
    times = np.concatenate([[0.0], since[(since > 0.0) & (since < end)], [end]])
    values = np.interp(times, since, retained)
    return {"retained_mean": float(np.trapezoid(values, times) / end), "retained_end": float(values[-1])}
