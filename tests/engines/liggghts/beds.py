"""Moist beds between moving walls, and how two runs of one are compared."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.cases.small import bodies, small
from pywet.geometry.solids import plate, square
from pywet.geometry.surface import Surface, make_surface
from pywet.laws.hertz import Elastic, Hertz
from pywet.scene import Effects, EngineScene, Liquid, Output, Slide, Vibration
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of

RADIUS = 2.5e-3
STEP = 2e-5
LOOKS = ["step", "kind", "partner_kind", "i", "j"]


def shaken_floor(half: float) -> Surface:
    """A floor that vibrates."""
    return make_surface("shaken", "wall", plate(square(half), -0.01, 0.0), "vibrates")


def drawn_plate(half: float) -> Surface:
    """A plate in the middle of the bed that is drawn away sideways."""
    return make_surface("drawn", "slide", plate(square(half) * [1.0, 0.2], 0.012, 0.014), "slides")


def bed(side: tuple[int, int, int], seed: int = 1) -> list[small.Sphere]:
    """Spheres of two sizes on a shaken lattice above the floor, thrown about."""
    random = np.random.default_rng(seed)
    spheres = []
    for cell in np.ndindex(*side):
        at = (np.array(cell) - 0.5 * (np.array(side) - 1.0) * [1, 1, 0]) * 2.15 * RADIUS
        at = at + [0, 0, 2.0 * RADIUS] + random.uniform(-0.05, 0.05, 3) * RADIUS
        if 0.012 - RADIUS * 1.1 < at[2] < 0.014 + RADIUS * 1.1 and abs(at[1]) < 0.2 * 0.03 + 1.1 * RADIUS:
            continue  # no sphere inside the plate
        velocity = random.normal(0.0, 0.05, 3)
        spheres.append(small.Sphere(1 + int(random.integers(2)), tuple(at), tuple(velocity)))
    return spheres


def prepare(
    run_dir: Path, spheres: list[small.Sphere], steps: int, checkpoints: int = 0, outputs: int = 10,
    effects: Effects = small.PAPER, liquid: Liquid = WATER,
) -> EngineScene:  # fmt: skip
    """A moist bed of two sizes on a vibrating floor, with a plate drawn through it."""
    half = 0.03
    return small.prepare(
        run_dir,
        spheres_of(RADIUS, 2e-3),
        spheres,
        contacts(2, stiffness=2e3),
        liquid=liquid,
        effects=effects,
        walls=[shaken_floor(0.1), drawn_plate(half)],
        wall_angle_rad=math.radians(45.0),
        time_step_s=STEP,
        steps=steps,
        gravity=(0.0, 0.0, -9.81),
        box=0.15,
        vibration=Vibration(amplitude_m=(1e-4, 0.0, 5e-4), phase_rad=(0.5, 0.0, 0.3), frequency_Hz=50.0),
        slide=Slide(velocity_m_per_s=(0.2, 0.0, 0.0), opens_at_s=0.3 * steps * STEP, travel_s=0.5 * steps * STEP),
        output=Output(
            interval_s=steps // outputs * STEP,
            contact_windows=2,
            contact_window_steps=20,
            checkpoints=checkpoints,
            window_trajectories=True,
        ),
    )


def hertzian(scene: EngineScene) -> EngineScene:
    """Return the bed with Hertz contacts of soft glass, whose impacts last about as long as those of its linear springs."""
    soft = Elastic(youngs_modulus_Pa=1e6, poissons_ratio=0.25)
    hertz = Hertz(spheres=(soft,) * len(scene.classes), walls=soft, impact_speed_m_per_s=0.2)
    pairs = bodies.hertzian(scene.classes, scene.pairs, hertz)
    return scene.model_copy(update={"hertz": hertz, "pairs": pairs, "contacts": "stock"})


def retiring(run_dir: Path, **more: int) -> EngineScene:
    """A bed on a floor that hardly vibrates, which is a bin: spheres of its lowest layer are retired as they come to rest."""
    down = RADIUS - 2.0 * RADIUS
    spheres = [small.Sphere(s.kind, (*s.position[:2], s.position[2] + down), s.velocity) for s in bed((5, 5, 5))]
    scene = prepare(run_dir, spheres, **more)
    shaken = scene.vibration.model_copy(update={"amplitude_m": (1e-5, 0.0, 2e-5)}) if scene.vibration else None
    quiet = scene.output.model_copy(update={"energy": False})
    return scene.model_copy(update={"retire": True, "bin_z_m": 0.016, "vibration": shaken, "output": quiet})


def table(run_dir: Path, name: str) -> pd.DataFrame:
    """A table of a finished run."""
    return pd.read_parquet(run_dir / f"{name}.parquet")


def active_bridges(run_dir: Path) -> pd.DataFrame:
    """Return the active bridges at each output."""
    return table(run_dir, "history/bridges")[["step", "partner_kind", "i", "j"]]


def apart(one: Path, two: Path) -> pd.Series:
    """Largest distance of a sphere between two runs at each output step [m]."""
    a, b = (table(p, "trajectory").set_index(["step", "id"])[["x", "y", "z"]] for p in (one, two))
    return ((a - b) ** 2).sum(axis=1).pow(0.5).groupby("step").max()
