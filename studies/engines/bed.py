"""A small moist bed in every engine, settled in a box or turned in a drum: its density, angle, contacts and bridges.

There are only capillary forces (viscosity zero) and no rolling resistance, which all engines support. Our engine draws each
bridge from the films; in YADE all bridges have the mean volume of ours; `washino` and `easo` have the same liquid per sphere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pywet import run_folder, stages
from pywet.cases.small import small
from pywet.cases.small.bodies import contacts, coordination, last, loose_box
from pywet.cases.small.scenes import Choice, bed_angles, in_a_drum
from pywet.engines.liggghts import deck, process
from pywet.engines.liggghts.collecting import trajectory_parts
from pywet.errors import PywetError
from pywet.laws.kinds import SWITCHED
from pywet.runs import tables
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene, Output
from pywet.util.files import read_table
from studies.stock import moist
from studies.stock.liggghts import LIGGGHTS_MODELS

OURS, DRY = "LIGGGHTS+pywet", "LIGGGHTS, dry"
EFFECTS = small.PAPER.model_copy(
    update={**dict.fromkeys(SWITCHED), "capillary": small.PAPER.capillary, "rolling": False}
)
STIFFNESS = 500.0
COHESION = """fix             p_surfaceTension all property/global surfaceTension scalar {tension}
fix             p_fluidViscosity all property/global fluidViscosity scalar 0
fix             p_contactAngle all property/global contactAngle peratomtype {angle} {angle}
fix             p_liquid all property/global surfaceLiquidContentInitial scalar 0
fix             p_closest all property/global minSeparationDistanceRatio scalar 0.01
fix             p_farthest all property/global maxSeparationDistanceRatio scalar {farthest}
fix             liquidtransfer all transportequation/scalar equation_id liquidtransfer quantity surfaceLiquidContent \
default_value 0 flux_quantity liquidFlux source_quantity liquidSource capacity_quantity none
"""


@dataclass(frozen=True)
class Bed:
    """Spheres and liquid that settle in a box or turn in a drum."""

    spheres: int = 150
    moisture_percent: float = 1.0
    seconds: float = 0.25
    seed: int = 1
    drum: bool = False

    @property
    def choice(self) -> Choice:
        """Return the bed as a scene of `pywet scene`."""
        return Choice(spheres=self.spheres, moisture_percent=self.moisture_percent, seed=self.seed, viscosity_Pa_s=0.0)


def prepare(run_dir: Path, bed: Bed, wet: bool = True) -> EngineScene:
    """Prepare spheres on a loose lattice above the floor of a box, or in a drum, at the same positions for every engine."""
    choice = bed.choice
    sphere = choice.glass(bed.spheres)
    if bed.drum:
        poured, where = in_a_drum(choice)
    else:
        poured, vessel = loose_box(bed.spheres, choice.radius_m, bed.seed)
        where = {"walls": (vessel,), "gravity": (0.0, 0.0, -9.81)}
    step = choice.time_step(sphere, STIFFNESS)
    steps = round(bed.seconds / step)
    return small.prepare(
        run_dir, [sphere], poured, contacts(1, STIFFNESS), liquid=choice.liquid(sphere),
        effects=EFFECTS if wet else small.DRY.model_copy(update={"rolling": False}),
        wall_angle_rad=sphere.contact_angle_rad,  # YADE has a single contact angle
        time_step_s=step, steps=steps, box=1.1 * max(float(np.abs(w.corners).max()) for w in where["walls"]),
        output=Output(interval_s=max(1, steps // (50 if bed.drum else 10)) * step, contact_windows=0, energy=False), **where,
    )  # fmt: skip


def settle(folder: Path, bed: Bed) -> pd.DataFrame:
    """Run the bed in every engine but LAMMPS; one row per engine with its numbers. Each run directory is folder/ENGINE."""
    beds = []
    ours = folder / "pywet"
    scene = prepare(ours, bed)
    small.run(ours, [])
    ledger = read_table(ours / "history" / "ledger.parquet").iloc[-1]
    active = int(ledger["bridge_count"])
    volume = float(ledger["bridges"]) / max(active, 1)
    beds.append({"engine": OURS, **measure(ours)})
    prepare(folder / "pywet_yade", bed)
    small.run(folder / "pywet_yade", [], engine="yade")
    beds.append({"engine": "YADE+pywet", **measure(folder / "pywet_yade")})
    prepare(folder / "yade", bed, wet=False)
    assert scene.liquid is not None
    liquid = moist.Bridges(
        "Rabinovich", volume, scene.liquid.surface_tension_N_per_m, scene.classes[0].contact_angle_rad
    )
    bridges = moist.run(folder / "yade", liquid, progress=False)
    beds.append({"engine": "YADE", **measure(folder / "yade"), "bridges_per_sphere": 2.0 * len(bridges) / bed.spheres})
    for model in LIGGGHTS_MODELS:
        dry = prepare(folder / model, bed, wet=False)
        stock(folder / model, dry, bed, model)
        beds.append({"engine": model, **measure(folder / model)})
    for name, engine in ((DRY, "liggghts"), ("YADE, dry", "yade")):
        path = folder / f"dry_{engine}"
        prepare(path, bed, wet=False)
        stages.simulate(path, 1, False, engine)
        beds.append({"engine": name, **measure(path)})
    return pd.DataFrame(beds).assign(seed=bed.seed)


def measure(run_dir: Path) -> dict[str, float]:
    """Mean height of the centres over the radius, contacts, speed and bridges per sphere at the end, of a drum its angle [deg].

    Two spheres count as in contact at a gap below a hundredth of the radius; bridges are NaN if no ledger is stored.
    """
    scene = RunDir(run_dir).scene
    end = last(run_dir)
    ledger = run_dir / "history" / "ledger.parquet"
    r = scene.classes[0].radius_m
    at = end[["x", "y", "z"]].to_numpy(float)
    return {
        "mean_height_over_radius": float(at[:, 2].mean() / r),
        "contacts_per_sphere": coordination(at, np.full(len(at), r)),
        "mean_speed_m_per_s": float(np.linalg.norm(end[["vx", "vy", "vz"]].to_numpy(float), axis=1).mean()),
        "bridges_per_sphere": 2.0 * float(read_table(ledger)["bridge_count"].iloc[-1]) / len(at)
        if ledger.exists()
        else math.nan,
        **({"dynamic_angle_deg": float(bed_angles(run_dir).mean())} if scene.rotation else {}),
    }


def stock(run_dir: Path, scene: EngineScene, bed: Bed, model: str) -> None:
    """Run a dry scene of one class with a stock cohesion model of LIGGGHTS, the same liquid on every sphere."""
    if model not in LIGGGHTS_MODELS:
        raise PywetError(f"the model {model} was asked for; expected one of {', '.join(LIGGGHTS_MODELS)}")
    folder = run_dir / "engine.partial"
    run_folder.make_folder(run_dir, folder.name)
    deck.write_deck(scene, run_dir, folder)
    setup = folder / "setup.liggghts"
    setup.write_text(_with_cohesion(setup.read_text(), bed, LIGGGHTS_MODELS[model]))
    command = ["liggghts", "-in", "in.liggghts", "-log", "log.liggghts", "-screen", "screen.log"]
    process.execute(command, folder, scene, lambda done, total: None)
    tables.write(trajectory_parts(folder / "trajectory.txt", scene.time_step_s), run_dir / "trajectory.parquet")
    (folder / "trajectory.txt").unlink()
    run_folder.publish(run_dir, folder.name, "engine")


def _with_cohesion(setup: str, bed: Bed, model: str) -> str:
    """Return the set-up of a dry deck with a cohesion model and its parameters."""
    sphere = bed.choice.glass(bed.spheres)
    content = 0.01 * bed.moisture_percent * sphere.density_kg_per_m3 / 1000.0
    # rupture distance of both models, (1 + theta/2) V^(1/3), for all liquid of two spheres
    length = 2.0 * (2.0 * content * sphere.mass_kg / sphere.density_kg_per_m3) ** (1 / 3)
    numbers = COHESION.format(
        tension=bed.choice.liquid(sphere).surface_tension_N_per_m,
        angle=math.degrees(sphere.contact_angle_rad),
        farthest=repr(1.0 + 0.5 * length / sphere.radius_m),
    )
    setup = setup.replace(" tangential history ", f" tangential history cohesion {model} ")
    setup = setup.replace(" tangential_damping off", "").replace("pair_style", f"{numbers}pair_style")
    return f"{setup}run 0\nset group all property/atom surfaceLiquidContent {content!r}\n"
