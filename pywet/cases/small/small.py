"""Small scenes next to screening: a few spheres, a plane wall, driven or free. Same `EngineScene`, same engine, same logs.

Used by checks in the engine (two bodies at constant speed, dry collisions) and available for user experiments.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.engines.lammps import driver as lammps
from pywet.engines.liggghts import driver
from pywet.engines.pipeline import RunInfo
from pywet.engines.yade import driver as yade
from pywet.geometry.initial import wall_mesh, write_initial
from pywet.geometry.solids import plate, square
from pywet.geometry.surface import Surface, make_surface
from pywet.laws import custom_laws
from pywet.laws.kinds import PRESETS
from pywet.scene import ContactPair, Effects, EngineScene, Liquid, Output, SphereClass

PAPER, EXACT = (Effects.model_validate({"bridges": True, **laws}) for laws in PRESETS.values())
DRY = Effects(bridges=False)


@dataclass(frozen=True)
class Sphere:
    """One sphere of a small scene; `kind` is its type, spins and velocities in SI units."""

    kind: int
    position: tuple[float, float, float]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    driven: bool = False
    """Whether the sphere's velocity is prescribed regardless of forces."""
    wiggle: tuple[tuple[float, float, float], float] | None = None
    """Amplitude [m] and period [s] of a driven motion x + A sin(2 pi t/T) in place of `velocity`."""
    film: float | None = None
    """Liquid on the sphere [m3], if it differs from that of the scene's film thickness."""


def floor(half_side: float = 0.05, top: float = 0.0, thickness: float = 0.01) -> Surface:
    """Return a large flat plate whose upper face is at `top`."""
    return make_surface("floor", "wall", plate(square(half_side), top - thickness, top))


def prepare(
    run_dir: Path,
    classes: Sequence[SphereClass],
    spheres: Sequence[Sphere],
    pairs: Sequence[ContactPair],
    *,
    liquid: Liquid | None = None,
    effects: Effects = DRY,
    walls: Sequence[Surface] = (),
    wall_angle_rad: float = 0.0,
    analytic_wires: Sequence[str] = (),
    time_step_s: float = 1e-5,
    steps: int = 1000,
    log_every_step: bool = True,
    output_interval_s: float | None = None,
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    box: float = 0.1,
    checkpoints: int = 0,
    window_trajectories: bool = False,
    **more: Any,
) -> EngineScene:
    """Write everything a small scene needs into `run_dir` and return it; `more` are further fields of `EngineScene`.

    `analytic_wires`: walls whose parts are analytic wires in dry contacts. Law files named in `effects`,
    `path/to/file.py:function`, are permitted to run from then on.
    """
    named = {kind: custom_laws.placed(law) for kind, law in effects.laws.items()}
    custom_laws.trust(named.values())
    fields: dict[str, Any] = {
        "name": "small",
        "seed": 0,
        "classes": tuple(classes),
        "pairs": tuple(pairs),
        "liquid": liquid,
        "walls": tuple(wall_mesh(w, wall_angle_rad, w.name in analytic_wires) for w in walls),
        "vibration": None,
        "slide": None,
        "effects": effects.model_copy(update=named),
        "gravity_m_per_s2": gravity,
        "box_low_m": (-box, -box, -box),
        "box_high_m": (box, box, box),
        "spheres_file": Path("spheres.parquet"),
        "time_step_s": time_step_s,
        "duration_s": steps * time_step_s,
        "output": Output(
            interval_s=output_interval_s or time_step_s,
            contact_windows=1 if log_every_step else 0,
            contact_window_steps=2 * steps,
            checkpoints=checkpoints,
            window_trajectories=window_trajectories,
        ),
        "bin_z_m": -box,
    }
    scene = EngineScene(**{**fields, **more})
    table = pd.DataFrame({"id": np.arange(1, len(spheres) + 1), "type": [s.kind for s in spheres]})
    for letter, field in (("", "position"), ("v", "velocity"), ("w", "spin")):
        for k, axis in enumerate("xyz"):
            table[f"{letter}{axis}"] = [getattr(s, field)[k] for s in spheres]
    table["film"] = np.array([s.film for s in spheres], dtype=float)
    write_initial(scene, walls, table, run_dir)
    return scene


def drive(spheres: Sequence[Sphere]) -> tuple[tuple[str, ...], str]:
    """Return the deck lines that prescribe the velocity of driven spheres, and the group of the free ones."""
    driven = [k for k, s in enumerate(spheres, start=1) if s.driven]
    if not driven:
        return (), "all"
    lines = []
    for k in driven:
        sphere = spheres[k - 1]
        if sphere.wiggle is None:
            how = "linear " + " ".join(repr(c) for c in sphere.velocity)
        else:
            how = "wiggle " + " ".join(repr(c) for c in (*sphere.wiggle[0], sphere.wiggle[1]))
        lines += [f"group driven_{k} id {k}", f"fix drive_{k} driven_{k} move {how}"]
    lines += [f"group driven id {' '.join(map(str, driven))}", "group free subtract all driven"]
    return tuple(lines), "free"


def run(
    run_dir: Path, spheres: Sequence[Sphere], ranks: int = 1, allow_unstable: bool = False, engine: str = "liggghts"
) -> RunInfo:
    """Run a prepared small scene in `engine`: liggghts, lammps, or yade, in which driven spheres do not wiggle."""
    if engine == "yade":
        driven = tuple(k for k, s in enumerate(spheres, start=1) if s.driven)
        return yade.run(run_dir, progress=False, driven=driven, allow_unstable=allow_unstable)
    extra, free = drive(spheres)
    start = lammps.run if engine == "lammps" else driver.run
    return start(run_dir, ranks, progress=False, extra=extra, integrate=free, allow_unstable=allow_unstable)
