"""Small scenes of the study: pairs that collide, a pair drawn apart, a moist bed, and the bridge's laws without engine."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from pywet.cases.small import bridge_query, small
from pywet.cases.small.bodies import last, loose_box
from pywet.cases.small.scenes import Choice, springs
from pywet.laws import registry
from pywet.laws.contact import bridge_radius
from pywet.laws.kinds import PRESETS
from pywet.laws.transfer import v_star_grid
from pywet.planning import step_choice
from pywet.runs.rundir import RunDir
from pywet.scene import ContactPair, Effects, Output, SphereClass
from pywet.schema import LARGE_WALL, SPHERE
from pywet.util.files import read_table
from studies.accuracy.parameters import Setting, log_windows
from studies.pair import Pair

PAPER_STIFFNESS = 1e5
"""Contact stiffness of the paper [N/m]."""
PAIRS = 6
"""Number of pairs in one run, which touch at times evenly spread over a time step."""
SPEED = 0.5
BED_S = 0.12
"""Time in which the bed settles [s]."""
BRIDGES = ((0.0025, 40.0, 0.0025, 40.0), (0.0025, 40.0, math.inf, 45.0), (0.0025, 40.0, 0.005, 40.0))
"""Radius [m] and contact angle [deg] of two bodies each: POM on POM, on steel, small on large."""
REDUCED_VOLUME = 0.02
"""Volume of those bridges over the cube of the harmonic mean of the radii."""
Made = tuple[SphereClass, list[small.Sphere], float, int, dict[str, Any]]
"""Class and bodies of a scene, time step [s], steps, and more for `small.prepare`."""


def effects(setting: Setting) -> Effects:
    """Return all effects of a moist scene with the setting's laws."""
    laws: dict[str, Any] = (
        PRESETS["exact"] if setting.capillary == "exact" else {**PRESETS["paper"], "capillary": setting.capillary}
    )
    return Effects(bridges=True, **laws)


def contacts(setting: Setting) -> tuple[ContactPair, ...]:
    """Return dry contacts of glass with the stiffness of the setting."""
    return springs(PAPER_STIFFNESS * setting.stiffness)


def time_step(setting: Setting, sphere: SphereClass, viscosity: float) -> float:
    """Return the time step [s] by the configuration's rule."""
    explicit = setting.integration == "explicit"
    return step_choice.of_collisions(contacts(setting), (sphere,), setting.fraction, viscosity if explicit else 0.0)


def pairs(setting: Setting, moist: bool) -> Made:
    """Return PAIRS colliding pairs, dry or with films of 1 % of water."""
    choice = Choice()
    sphere = choice.glass(2 * PAIRS)
    liquid = choice.liquid(sphere) if moist else None
    step = time_step(setting, sphere, choice.viscosity_Pa_s if moist else 0.0)
    r, v = sphere.radius_m, 0.5 * SPEED
    reach = 2.2 * liquid.initial_film_thickness_m if liquid else 0.0
    bodies, longest = [], 0.0
    for k in range(PAIRS):
        gap = reach + SPEED * step * (5.0 + (k + 0.5) / PAIRS)
        x = (k - 0.5 * (PAIRS - 1)) * 8.0 * r
        bodies += [
            small.Sphere(1, (x, 0.0, -r - 0.5 * gap), (0.0, 0.0, v)),
            small.Sphere(1, (x, 0.0, r + 0.5 * gap), (0.0, 0.0, -v)),
        ]
        longest = max(longest, gap)
    contact = step_choice.collision_time(contacts(setting)[1], (sphere,))
    steps = round(((4.0 * longest + (2.0 * r if moist else 0.0)) / SPEED + 2.0 * contact) / step)
    return sphere, bodies, step, steps, {"liquid": liquid, "log_every_step": False}


def restitutions(folder: Path) -> list[float]:
    """Return the rebound speed over the approach speed of each pair; 0 for a pair that sticks."""
    end = last(folder)
    v, z = end["vz"].to_numpy(), end["z"].to_numpy()
    held: set[int] = set()
    bridges = folder / "history" / "bridges.parquet"
    if bridges.exists():
        table = read_table(bridges)
        held = set(table[table["step"] == table["step"].max()]["i"]) if len(table) else set()
    apart = [z[k + 1] > z[k] and not held & {k + 1, k + 2} for k in range(0, len(v), 2)]
    return [float(v[2 * k + 1] - v[2 * k]) / SPEED if free else 0.0 for k, free in enumerate(apart)]


def pull(setting: Setting) -> Made:
    """Return two wet spheres drawn apart from touch at 0.05 m/s."""
    choice, speed = Choice(), 0.05
    sphere = choice.glass(2)
    r, step = sphere.radius_m, time_step(setting, sphere, choice.viscosity_Pa_s)
    bodies = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(1, (0.0, 0.0, 2.0 * r), (0.0, 0.0, speed), driven=True),
    ]
    return sphere, bodies, step, round(0.8 * r / speed / step), {"liquid": choice.liquid(sphere)}


def pulled(folder: Path) -> dict[str, float]:
    """Return the force at a gap of a fiftieth of the radius [N], rupture distance [m], work of separation [J].

    The force at touch is not used, because lubrication there depends on the first step.
    """
    log, events = (read_table(folder / "history" / f"{name}.parquet") for name in ("contacts", "events"))
    return {
        "pull_force": float(np.interp(Choice().radius_m / 50.0, log["separation"], log["force_i_z"].abs())),
        "pull_rupture": float(events[events["kind"] == 1]["separation"].iloc[0]),
        "pull_work": float(read_table(folder / "history" / "energy.parquet")["drive"].iloc[-1]),
    }


def bed(setting: Setting, seed: int) -> Made:
    """Return 216 moist spheres that fall into a box."""
    choice = Choice(spheres=216, seed=seed)
    sphere = choice.glass(choice.spheres)
    step = time_step(setting, sphere, choice.viscosity_Pa_s)
    bodies, box = loose_box(choice.spheres, choice.radius_m, seed)
    steps = round(BED_S / step)
    windows, length = log_windows(setting.contact_log)
    output = Output(interval_s=max(1, steps // 20) * step, contact_windows=windows, contact_window_steps=length)
    return sphere, bodies, step, steps, {
        "liquid": choice.liquid(sphere), "walls": [box], "wall_angle_rad": math.radians(40.0),
        "gravity": (0.0, 0.0, -9.81), "box": 0.055, "output": output,
    }  # fmt: skip


def settled(folder: Path) -> dict[str, float]:
    """Return mean height over the diameter, bridges per sphere and the share of the liquid in them, over the last quarter."""
    scene = RunDir(folder).scene
    at = read_table(folder / "trajectory.parquet")
    ledger = read_table(folder / "history" / "ledger.parquet")
    late = ledger[ledger["step"] >= 0.75 * scene.steps]
    height = at[at["step"] >= 0.75 * scene.steps]["z"].mean()
    return {
        "bed_height": float(height) / (2.0 * scene.classes[0].radius_m),
        "bed_bridges": 2.0 * float(late["bridge_count"].mean()) / scene.classes[0].count,
        "bed_liquid": float((late["bridges"] / late["initial"]).mean()),
    }


def prepare(scene: str, folder: Path, setting: Setting, seed: int) -> list[small.Sphere]:
    """Write the run directory of a scene; its spheres."""
    made = bed(setting, seed) if scene == "bed" else pull(setting) if scene == "pull" else None
    sphere, bodies, step, steps, more = made or pairs(setting, scene == "pair_wet")
    moist = more["liquid"] is not None
    small.prepare(
        folder, [sphere], bodies, contacts(setting), effects=effects(setting) if moist else small.DRY, time_step_s=step,
        steps=steps, output_interval_s=steps * step, viscous_integration=setting.integration,
        bridges_every=setting.bridges_every if moist else 1, **more,
    )  # fmt: skip
    return bodies


def quantities(scene: str, folder: Path) -> list[dict[str, Any]]:
    """Compute the quantities of interest of a scene; of colliding pairs for each instant of touch."""
    if scene in ("bed", "pull"):
        return [settled(folder) if scene == "bed" else pulled(folder)]
    return [{"instant": k, "restitution": e} for k, e in enumerate(restitutions(folder))]


def law_errors(setting: Setting) -> dict[str, float]:
    """Return the largest error of force (over that at touch) and of rupture distance against the exact bridge, over BRIDGES."""
    exact = setting.capillary == "exact"
    name = "young_laplace" if exact else setting.capillary
    force, rupture = [], []
    for ri, ti, rj, tj in BRIDGES:
        pair = Pair(
            "", ri, rj, REDUCED_VOLUME * bridge_radius(ri, rj) ** 3, (math.radians(ti), math.radians(tj)), 0.0728
        )
        limit = registry.get("rupture", "willett_unequal").functions[0](*pair.bridge)
        gaps = np.linspace(0.0, 0.9 * limit, 40)
        truth = bridge_query.answer(pair.query(gaps.tolist(), laws=["young_laplace"]))
        law = registry.get("capillary", name)
        law.prepare([pair.angles])
        given = law.functions[0](gaps, *pair.bridge, pair.sigma)
        right = np.array([np.nan if f is None else f for f in truth["force_N"]["young_laplace"]], dtype=float)
        force.append(float(np.nanmax(np.abs(given - right)) / right[0]))
        end = truth["rupture_distance_m"]["young_laplace"]
        rupture.append(0.0 if exact else abs(limit / end - 1.0))
    return {"law_force": max(force), "law_rupture": max(rupture)}


def sharing_error(setting: Setting, finest: int) -> dict[str, float]:
    """Return the largest error of the transfer ratio by interpolation in the table, against the finest table's nodes."""
    at = v_star_grid(finest)
    coarse = v_star_grid(setting.transfer_nodes)
    worst = 0.0
    for ri, ti, rj, tj in BRIDGES[1:]:
        kind, size = (LARGE_WALL, 0.0) if math.isinf(rj) else (SPHERE, rj)
        table = registry.transfer_model("parabola")
        fine, given = (table(ri, size, math.radians(ti), math.radians(tj), kind, grid) for grid in (at, coarse))
        worst = max(worst, float(np.abs(np.interp(at, coarse, given) - fine)[at >= 1e-5].max()))
    return {"sharing_ratio": worst}
