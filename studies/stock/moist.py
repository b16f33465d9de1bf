"""A moist scene in YADE with simplified bridges: a fixed volume per bridge, formed at touch, removed at rupture, no film.

The liquid differs from that of the scene: nothing is drawn from spheres or returned. This function is for comparisons
only, and the driver of dry scenes refuses moist ones. The contact is `ViscElCapMat`: linear spring and dashpot with kn,
ks, cn of the scene, but without the attraction of the dashpot at the end of a collision. Stiffness, damping and friction
of a pair follow from one number per material; scenes with one class of spheres can be represented exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.engines.yade.build import engine_version
from pywet.engines.yade.driver import build_task, execute
from pywet.errors import PywetError
from pywet.laws.contact import leapfrog_damping, pair_mass
from pywet.runs.rundir import RunDir
from pywet.scene import ContactPair, EngineScene
from pywet.shipped import open_studies
from pywet.util.files import read_json
from studies.stock import yade_worker
from studies.stock.yade import YADE_LAWS


@dataclass(frozen=True)
class Bridges:
    law: str
    volume_m3: float
    surface_tension_N_per_m: float
    contact_angle_rad: float


def run(run_dir: Path, liquid: Bridges, progress: bool = True) -> pd.DataFrame:
    """Run `run_dir`/scene.json, a dry scene, with these bridges; return the final bridges: volume, gap, wall.

    Writes trajectory, mesh motion and engine/ like a dry run. PywetError for features that YADE does not support.
    """
    run_dir = Path(run_dir).resolve()
    scene = RunDir(run_dir).scene
    if liquid.law not in YADE_LAWS:
        raise PywetError(f"the law {liquid.law} was asked for; expected one of {', '.join(YADE_LAWS)}")
    if len(scene.classes) != 1 or scene.effects.rolling or scene.effects.bridges:
        raise PywetError(
            f"the scene {scene.name} has {len(scene.classes)} classes of spheres, rolling "
            f"{'on' if scene.effects.rolling else 'off'} and bridges {'on' if scene.effects.bridges else 'off'}; "
            "expected one class and both off, which YADE can express"
        )
    if scene.hertz is not None:
        raise PywetError(
            f"the moist scene {scene.name} has Hertz contacts; expected linear springs, which it runs with"
        )
    engine_version()
    open_studies()  # the worker is started in a folder elsewhere
    task = build_task(scene, run_dir)
    # the largest rupture distance of YADE's rule, r (1 + theta/2)(V*^1/3 + 0.1 V*^2/3), with a margin
    radius = scene.classes[0].radius_m
    reduced = liquid.volume_m3 / radius**3
    length = (1.0 + 0.5 * liquid.contact_angle_rad) * (reduced ** (1 / 3) + 0.1 * reduced ** (2 / 3))
    task["reach"] = 1.0 + 0.6 * length
    task["liquid"] = {
        "law": liquid.law,
        "volume": liquid.volume_m3,
        "surface_tension": liquid.surface_tension_N_per_m,
        "angle_deg": math.degrees(liquid.contact_angle_rad),
        "materials": materials(scene),
    }
    execute(run_dir, scene, task, progress, yade_worker.__name__)
    bridges = read_json(run_dir / "engine" / "bridges.json")
    return pd.DataFrame(bridges, columns=["volume", "gap", "wall", "rupture"])


def materials(scene: EngineScene) -> list[dict[str, Any]]:
    """kn, ks, cn, cs and friction angle of the walls and of the one class.

    YADE connects a and b as springs in a row, a b/(a + b): the sphere gets twice its pair's number p, the wall w with
    w 2p/(w + 2p) = q of the pair with the wall, w = 2 p q/(2 p − q). Friction is the smaller of the two angles.
    """
    between_spheres, wall = (next(p for p in scene.pairs if p.b == b) for b in (1, 0))
    sphere: dict[str, Any] = {}
    other: dict[str, Any] = {}
    for name in ("kn", "ks", "cn"):
        p, q = _number(scene, between_spheres, name), _number(scene, wall, name)
        if q >= 2.0 * p:
            raise PywetError(
                f"{name} of scene {scene.name} is {q:g} at the walls and {p:g} between spheres; expected less than twice "
                "as much, which YADE's rule for two materials can give"
            )
        sphere[name], other[name] = 2.0 * p, 2.0 * p * q / (2.0 * p - q)
    if wall.friction > between_spheres.friction:
        raise PywetError(
            f"friction of scene {scene.name} is larger at the walls ({wall.friction:g}) than between spheres "
            f"({between_spheres.friction:g}); expected the same or less, as YADE takes the smaller one"
        )
    for target, pair in ((sphere, between_spheres), (other, wall)):
        target["frictionAngle"] = math.atan(pair.friction)
        target["cs"] = 0.0
    return [other, sphere]


def _number(scene: EngineScene, pair: ContactPair, name: str) -> float:
    if name == "kn":
        return pair.normal_stiffness_N_per_m
    if name == "ks":
        return pair.tangential_stiffness_N_per_m
    mass = pair_mass(scene.classes, pair)
    return leapfrog_damping(pair.restitution, mass, pair.normal_stiffness_N_per_m, scene.time_step_s)
