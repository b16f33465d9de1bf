"""Stored tables made by hand: exponential passage, liquid that moves from the coarse material to fines and walls."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.util.files import write_json
from studies.full_scale.stored_runs import StoredRun

TIMES = np.linspace(-0.5, 20.0, 206)
COARSE_SHARE = 0.3


def passage(rate: float, rest: float = 0.0) -> np.ndarray:
    """Share of a class still on the screen."""
    return rest + (1.0 - rest) * np.exp(-rate * np.maximum(TIMES, 0.0))


def make(
    data: Path, case: int, seed: int = 1, rate: float = 0.4, carried: Mapping[str, float] | None = None, **more: float
) -> StoredRun:
    """A run whose small spheres pass at `rate` (1/s), near-mesh ones at `near`, of which `rest` stays.

    `walls`, `fines`: shares of the liquid there at the end; `large`: wedged large spheres; `about`: other entries of run.json.
    """
    near, rest = more.get("near", 0.8 * rate), more.get("rest", 0.0)
    small_now, near_now = passage(rate, rest), passage(near, rest)
    undersize = 0.5 * (small_now + near_now)
    y = COARSE_SHARE + (1.0 - COARSE_SHARE) * undersize
    folder = data / f"case{case:02d}-{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    pd.DataFrame(
        {
            "time_since_opening_s": TIMES,
            "fraction_retained": y,
            "fraction_retained_spheres": y,
            "fraction_retained_small": small_now,
            "fraction_retained_near_mesh": near_now,
        }
    ).to_csv(folder / "fraction_retained.csv", index=False)
    done = 1.0 - passage(0.5)
    fines, walls = more.get("fines", 0.4) * done, more.get("walls", 0.2) * done
    coarse = 1.0 - fines - walls
    columns: Mapping[str, np.ndarray] = {
        "coarse_material_m3": coarse,
        "coarse_material_small_m3": 0.2 * coarse,
        "coarse_material_near_mesh_m3": 0.3 * coarse,
        "coarse_material_large_m3": 0.5 * coarse,
        "fines_m3": fines,
        "fines_small_m3": 0.55 * fines,
        "fines_near_mesh_m3": 0.45 * fines,
        "wires_m3": 0.5 * walls,
        "side_wall_m3": 0.5 * walls,
        "collecting_bin_m3": np.zeros_like(TIMES),
        "initial_m3": np.ones_like(TIMES),
    }
    liquid = pd.DataFrame({"time_since_opening_s": TIMES, **columns})
    liquid.to_csv(folder / "liquid_by_holder.csv", index=False)
    spheres = {"time_s": TIMES + 0.5, "thin_walls": np.full_like(TIMES, 0.9), "thin_wires": np.full_like(TIMES, 0.8)}
    films = {"small": 1e-5, "near_mesh": 2e-5, "large": 3e-5}
    for kind, count, now in (("small", 600, small_now), ("near_mesh", 300, near_now), ("large", 100, 0 * TIMES + 1)):
        spheres[f"above_{kind}"] = np.round(count * now)
        spheres[f"wedged_{kind}"] = np.full_like(TIMES, more.get("large", 5.0) if kind == "large" else 0.0)
        spheres[f"film_m_{kind}"] = np.full_like(TIMES, films[kind])
    pd.DataFrame(spheres).to_csv(folder / "spheres.csv", index=False)
    write_json(
        folder / "run.json",
        {"case": case, "variant": "", "scale": "full", "commit": "", "seed": seed, "time_step_s": 1e-6,
         "normal_stiffness_N_per_m": 1e4, "coarse_share": COARSE_SHARE,
         "ledger_error": 1e-15, "events": {"formations": 10, "ruptures": 5}, "contacts": 7, "replay": {}, "cpu_s": 3600.0,
         "resumed_at_step": None, "carried": carried},
    )  # fmt: skip
    return StoredRun(folder)
