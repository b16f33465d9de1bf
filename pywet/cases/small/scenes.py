"""Small scenes ready to run: a pull, a collision of two, a bed settling in a box, a rotating drum. `pywet scene NAME`.

Each is a function that prepares a run directory (`small.py`), runs the engine and returns its main results as
numbers; the run directory contains the rest (trajectory, history) as for a screening case.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet import run_folder
from pywet.cases.screening import identity
from pywet.cases.small import bodies, small
from pywet.cases.small.bodies import last
from pywet.errors import PywetError, one_line
from pywet.geometry.surface import Surface
from pywet.laws import registry
from pywet.laws.contact import S_MIN, film_volume
from pywet.laws.hertz import Elastic, Hertz
from pywet.planning import step_choice
from pywet.runs import record
from pywet.runs.rundir import RunDir
from pywet.scene import ContactPair, EngineScene, Liquid, Output, Rotation, SphereClass
from pywet.util.files import read_table, write_json
from pywet.util.notices import notice
from pywet.util.ranges import SCENE

RESULT = "scene_result.json"
SOFT, HARD = 2e3, 1e5
"""Contact stiffness [N/m] of beds, and of colliding pairs."""
CONTACTS, POISSON, IMPACT = ("linear", "hertz"), 0.25, 1.0
"""Dry contact laws, Poisson's ratio of glass, and an upper bound on impact speeds in a bed or drum [m/s]."""
SLOWEST = 0.05
"""Smallest restitution at which the spheres of a collision part within the default time."""
DRAWN, PARTED = 0.02, 1.2
"""Way of a pull in a step over S_min, on which the viscous force decreases; its whole way over the rupture distance."""
DRUM_WIDTH = 8.0
"""Width of the drum over the radius of its spheres."""
HALF_TURN, CARRIED = 0.5, 1.0 / 6.0
"""Least turns of the drum by default, and before the mean of its angle for the bed not merely to be carried along."""


@dataclass(frozen=True)
class Choice:
    """Parameters of a small scene; those that do not apply to a scene are ignored."""

    spheres: int = 500
    radius_m: float = 1.5e-3
    moisture_percent: float = 1.0
    """Mass of liquid over the mass of the spheres."""
    viscosity_Pa_s: float = 1e-3
    speed_m_per_s: float | None = None
    """Speed of the pull (0.05 if not given) or of the collision (0.5)."""
    turns_per_minute: float = 20.0
    seconds: float | None = None
    ranks: int = 1
    seed: int = 1
    viscous_integration: str = "semi_implicit"
    engine: str = "liggghts"
    """Engine: liggghts, or lammps without rolling resistance."""
    contact: str = "linear"
    """Dry contact law: linear springs, or hertz: Hertz–Mindlin with `youngs_modulus_Pa` and a Poisson's ratio of 0.25."""
    youngs_modulus_Pa: float = 1e7
    """Young's modulus of spheres and walls for hertz; far below glass's 6e10, so that an impact lasts some time steps of 1e-5 s.


    """

    def __post_init__(self) -> None:
        for name, limits in SCENE.items():
            if getattr(self, name) is not None:
                limits.read(name, getattr(self, name))
        if self.contact not in CONTACTS:
            raise PywetError(
                f"contact is {one_line(self.contact)}; expected one of {', '.join(CONTACTS)}",
                code="small.contact_model", key="contact", given=self.contact, expected=tuple(CONTACTS),
            )  # fmt: skip

    def glass(self, count: int) -> SphereClass:
        return bodies.sphere_classes(self.radius_m, counts=count, name="glass")[0]

    def liquid(self, sphere: SphereClass) -> Liquid:
        """Water of the chosen viscosity, as the same film on every sphere."""
        return bodies.wetting((sphere,), self.moisture_percent, self.viscosity_Pa_s)

    def time_step(self, sphere: SphereClass, stiffness: float) -> float:
        """Return a tenth of the stable step of a dense packing; explicit drag is limited by its damping time."""
        drag = 0.0 if self.viscous_integration == "semi_implicit" else self.viscosity_Pa_s
        return step_choice.of_packing((sphere,), self.dry(sphere, springs(stiffness)), 0.1, drag, self.hertz)

    @property
    def hertz(self) -> Hertz | None:
        """Return the moduli and the impact speed for planning: the given one, or that of a fall of some radii; None: linear."""
        if self.contact == "linear":
            return None
        glass = Elastic(youngs_modulus_Pa=self.youngs_modulus_Pa, poissons_ratio=POISSON)
        return Hertz(spheres=(glass,), walls=glass, impact_speed_m_per_s=self.speed_m_per_s or IMPACT)

    def dry(self, sphere: SphereClass, pairs: tuple[ContactPair, ...]) -> tuple[ContactPair, ...]:
        """Return these contacts, with Hertz's equivalent stiffness if they are not linear."""
        return pairs if self.hertz is None else bodies.hertzian((sphere,), pairs, self.hertz)


def springs(stiffness: float, rolling_m: float = 2e-5) -> tuple[ContactPair, ...]:
    """Return contacts of glass with itself and walls; accurate while overlaps stay below a few per cent of the radius."""
    return bodies.contacts(1, stiffness, rolling_m=rolling_m)


def pull(run_dir: Path, choice: Choice) -> dict[str, float]:
    """Run two spheres drawn apart from touch: largest force [N], rupture distance [m], nan if none ruptured, work [J]."""
    sphere, speed, r = choice.glass(2), choice.speed_m_per_s or 0.05, choice.radius_m
    step = min(choice.time_step(sphere, SOFT), DRAWN * S_MIN * r / speed)
    seconds = choice.seconds or max(PARTED * _longest(choice, sphere, speed), 0.1 * r) / speed
    drawn = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(1, (0.0, 0.0, 2.0 * r), (0.0, 0.0, speed), driven=True),
    ]
    _run("pull", run_dir, choice, drawn, step, seconds, log_every_step=True, travel=speed * seconds)
    log, events = (read_table(run_dir / "history" / f"{name}.parquet") for name in ("contacts", "events"))
    broken = events[events["kind"] == 1]
    if broken.empty and _ledger(run_dir)["bridge_count"]:
        notice.warning(
            "the bridge has not ruptured after %.3g s; its rupture distance is not known, and the work is that of a part of the "
            "pull: raise --seconds",
            seconds,
        )
    return {
        "largest_force_N": float(np.abs(log["force_i_z"]).max()),
        "rupture_distance_m": float(broken["separation"].iloc[0]) if len(broken) else math.nan,
        "work_J": float(read_table(run_dir / "history" / "energy.parquet")["drive"].iloc[-1]),
    }


def collision(run_dir: Path, choice: Choice) -> dict[str, float]:
    """Run a collision of two wet spheres: coefficient of restitution, nan if they have not parted, and energy by sink [J]."""
    sphere, speed = choice.glass(2), choice.speed_m_per_s or 0.5
    r, v = sphere.radius_m, 0.5 * speed
    gap = 2.2 * choice.liquid(sphere).initial_film_thickness_m + 1e-6
    thrown = [
        small.Sphere(1, (0.0, 0.0, -r - 0.5 * gap), (0.0, 0.0, v)),
        small.Sphere(1, (0.0, 0.0, r + 0.5 * gap), (0.0, 0.0, -v)),
    ]
    step = min(choice.time_step(sphere, HARD), 2e-6)
    seconds = choice.seconds or (4.0 * gap + 2.0 * r + _longest(choice, sphere, SLOWEST * speed) / SLOWEST) / speed
    _run("collision", run_dir, choice, thrown, step, seconds, stiffness=HARD, travel=v * seconds)
    energy = read_table(run_dir / "history" / "energy.parquet").iloc[-1]
    return {
        "restitution": _restitution(run_dir, choice, float(energy["kinetic"] + energy["capillary_stored"]), speed),
        **{f"{name}_J": float(energy[name]) for name in ("contact", "capillary", "viscous_normal")},
    }


def _longest(choice: Choice, sphere: SphereClass, speed: float) -> float:
    """Return the rupture distance [m] of the bridge that two spheres form and that is drawn at a speed [m/s]."""
    kinds = ("formation", "rupture", "dynamic_rupture")
    draw, rupture, factor = (registry.get(kind, small.PAPER.laws[kind]).functions[0] for kind in kinds)
    r, angle, liquid = sphere.radius_m, sphere.contact_angle_rad, choice.liquid(sphere)
    volume = 2.0 * draw(film_volume(liquid.initial_film_thickness_m, r), r, r)
    if volume <= 0.0:
        return 0.0
    faster = factor(speed, liquid.viscosity_Pa_s, liquid.surface_tension_N_per_m)
    return float(rupture(volume, r, r, angle, angle) * faster)


def _restitution(run_dir: Path, choice: Choice, energy: float, speed: float) -> float:
    """Return the coefficient of restitution of two spheres at the end of a run.

    It is 0 if the bridge between them is active and takes more work to rupture than they have: `energy` [J], kinetic and
    capillary, only decreases.
    """
    end = last(run_dir)
    parting, overlap = float(end["vz"].diff().iloc[-1]), 2.0 * choice.radius_m - float(end["z"].diff().iloc[-1])
    if overlap > 0.0:  # energy of the contact
        energy += 0.5 * max(p.normal_stiffness_N_per_m for p in choice.dry(choice.glass(2), springs(HARD))) * overlap**2
    bridged = bool(_ledger(run_dir)["bridge_count"])
    if bridged and energy < 0.0:
        return 0.0
    if bridged or parting <= 0.0:
        ended = EngineScene.read(run_dir / "scene.json").duration_s
        notice.warning(
            "the spheres have not parted after %.3g s; their restitution is not known: raise --seconds", ended
        )
        return math.nan
    return parting / speed


def bed(run_dir: Path, choice: Choice) -> dict[str, float]:
    """Run moist spheres that fall into a box and come to rest: solid fraction, bridges per sphere, liquid in bridges."""
    count, r = choice.spheres, choice.radius_m
    poured, vessel = bodies.loose_box(count, r, choice.seed)
    step = choice.time_step(choice.glass(count), SOFT)
    _run("bed", run_dir, choice, poured, step, choice.seconds or 0.4, walls=(vessel,), gravity=(0.0, 0.0, -9.81))
    end, ledger = last(run_dir), _ledger(run_dir)
    across = max(4, round(count ** (1.0 / 3.0)))
    top = float(np.sort(end["z"].to_numpy())[-across * across // 2 :].mean()) + r
    side = 2.0 * (1.15 * r * across + 0.5 * r)
    return {
        "solid_fraction": count * 4.0 / 3.0 * math.pi * r**3 / (side**2 * top),
        "bridges_per_sphere": 2.0 * float(ledger["bridge_count"]) / count,
        "liquid_in_bridges": _share(ledger, "bridges"),
        "mean_speed_m_per_s": float(np.sqrt((end[["vx", "vy", "vz"]] ** 2).sum(axis=1)).mean()),
    }


def drum(run_dir: Path, choice: Choice) -> dict[str, float]:
    """Run moist spheres in a drum that turns about the horizontal z axis: the bed's dynamic angle [deg].

    Mean and standard deviation over the second half of the run, see `bed_angles`.
    """
    poured, where = in_a_drum(choice)
    step, turn = choice.time_step(choice.glass(choice.spheres), SOFT), 60.0 / choice.turns_per_minute
    seconds = choice.seconds or max(1.5, HALF_TURN * turn)
    _run("drum", run_dir, choice, poured, step, seconds, **where)
    if 0.5 * seconds < CARRIED * turn:
        notice.warning(
            "the drum turned by %.3g° before its angle was averaged; the bed may only have been carried along: raise --seconds",
            180.0 * seconds / turn,
        )
    angle, ledger = bed_angles(run_dir), _ledger(run_dir)
    return {
        "dynamic_angle_deg": float(angle.mean()),
        "dynamic_angle_deviation_deg": float(angle.std()),
        "drum_radius_m": bodies.drum_radius(choice.spheres, choice.radius_m, DRUM_WIDTH * choice.radius_m),
        "bridges_per_sphere": 2.0 * float(ledger["bridge_count"]) / choice.spheres,
        "liquid_on_walls": _share(ledger, "walls"),
    }


def in_a_drum(choice: Choice) -> tuple[list[small.Sphere], dict[str, Any]]:
    """Return spheres at rest in a drum, and its walls, motion and gravity as arguments of `small.prepare`."""
    r, width = choice.radius_m, DRUM_WIDTH * choice.radius_m
    radius = bodies.drum_radius(choice.spheres, r, width)
    return bodies.in_drum(choice.spheres, r, radius, width, choice.seed), {
        "walls": bodies.drum_walls(radius, width),
        "gravity": (0.0, -9.81, 0.0),
        "rotation": Rotation(origin_m=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), period_s=60.0 / choice.turns_per_minute),
    }


def bed_angles(run_dir: Path) -> bodies.Floats:
    """Return the angle [deg] by which a turning wall has carried the bed, at the outputs of the second half of the run.

    It is the angle between gravity and the line from the axis to the spheres' centre: the slope of a flat surface.
    """
    scene = RunDir(Path(run_dir)).scene
    motion = next((m for m in scene.motions.values() if isinstance(m, Rotation)), None)
    if motion is None:
        raise PywetError(
            f"no wall of {run_dir} turns; expected a drum for the angle of its bed",
            code="small.not_turning", where=run_dir,
        )  # fmt: skip
    centre = read_table(run_dir / "trajectory.parquet").groupby("step")[[*"xyz"]].mean().to_numpy() - motion.origin_m
    down, axis = np.array(scene.gravity_m_per_s2), np.array(motion.axis) / np.linalg.norm(motion.axis)
    angle = np.degrees(np.arctan2(centre @ np.cross(axis, down), centre @ (down - (down @ axis) * axis)))
    return np.asarray(angle[len(angle) // 2 :])


SCENES: dict[str, Callable[[Path, Choice], dict[str, float]]] = {
    "pull": pull,
    "collision": collision,
    "bed": bed,
    "drum": drum,
}
"""Function that runs each scene, by name."""


def run(name: str, run_dir: Path, choice: Choice | None = None) -> dict[str, float]:
    """Run a scene by name and leave its numbers in scene_result.json."""
    if name not in SCENES:
        raise PywetError(
            f"there is no scene named {name}; expected one of {', '.join(SCENES)}",
            code="small.unknown_scene", given=name, expected=tuple(SCENES),
        )  # fmt: skip
    choice, run_dir = choice or Choice(), Path(run_dir)
    with run_folder.hold(run_dir):
        numbers = SCENES[name](run_dir, choice)
        write_json(run_dir / RESULT, {k: None if math.isnan(v) else v for k, v in numbers.items()})
    return numbers


def _ledger(run_dir: Path) -> pd.Series:
    """Read the last row of the liquid ledger of a run."""
    return read_table(run_dir / "history" / "ledger.parquet").iloc[-1]


def _share(ledger: pd.Series, reservoir: str) -> float:
    """Return the share of the liquid in a reservoir; 0 without liquid."""
    return float(ledger[reservoir] / ledger["initial"]) if ledger["initial"] > 0 else 0.0


def _run(
    name: str, run_dir: Path, choice: Choice, spheres: list[small.Sphere], step: float, seconds: float, *,
    stiffness: float = SOFT, walls: tuple[Surface, ...] = (), log_every_step: bool = False, travel: float = 0.0, **more: Any,
) -> None:  # fmt: skip
    """Prepare and run this scene, in which spheres move out by `travel` [m]; `more`: further arguments of `small.prepare`."""
    steps = round(seconds / step)
    if steps < 1:
        raise PywetError(
            f"{choice.seconds or 0:g} s are less than half a time step of {step:g} s; expected more: raise --seconds",
            code="small.short", key="--seconds", given=choice.seconds, expected=step,
        )  # fmt: skip
    sphere = choice.glass(len(spheres))
    output = Output(
        interval_s=max(1, steps // 50) * step,
        contact_windows=1 if log_every_step else 2,
        contact_window_steps=2 * steps if log_every_step else 20,
        checkpoints=0 if steps < 5000 else 20,
    )
    dry = springs(stiffness, 0.0) if choice.engine == "lammps" else springs(stiffness)
    hertz = choice.hertz
    record.begin(run_dir, identity.of(name, asdict(choice)))
    small.prepare(
        run_dir, [sphere], spheres, choice.dry(sphere, dry), liquid=choice.liquid(sphere), effects=small.PAPER, walls=walls,
        wall_angle_rad=math.radians(40.0), time_step_s=step, steps=steps, output=output,
        box=1.1 * max([0.05, 3.0 * choice.radius_m + travel, *(float(np.abs(w.corners).max()) for w in walls)]),
        viscous_integration=choice.viscous_integration, hertz=hertz, **more,
    )  # fmt: skip
    small.run(run_dir, spheres, choice.ranks, engine=choice.engine)
