"""Compared choices in a scene: everything on, the plan's choice, each effect off; and how one is run and measured."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from pywet.cases.small import small
from pywet.cases.small.bodies import wetting
from pywet.config.entries import RatioEntry
from pywet.config.settings import EffectSettings, LawSettings
from pywet.engines.liggghts import driver
from pywet.engines.liggghts.inputs import transfer_tables
from pywet.laws.kinds import SWITCHED as BRIDGE_EFFECTS
from pywet.planning import step_choice
from pywet.planning.effect_plan import EffectPlan, plan
from pywet.scene import Effects, EngineScene, Output
from pywet.util.files import read_table
from studies.effects.scenes import StudyScene
from studies.effects.setup import Setup
from studies.study import Row

TOLERANCE = 0.02
"""Change of a quantity of interest that the study considers harmless."""
OF_THE_CONTACT = ("rolling", "tangential_history", "gravity")
"""Effects that act without liquid."""
SWITCHED = (*BRIDGE_EFFECTS, "wall_films", "sharing_by_size", *OF_THE_CONTACT, "bridges")
"""Effects that are switched off one at a time; `bridges`: the whole liquid."""
EVERYTHING, PLANNED, IDLE = "everything on", "plan", "idle plugin"
STEP_FRACTION = 0.2
"""Time step over the dry contact's stable one in a dense packing: about ten steps per collision of two."""
OUTPUTS = 20
SAMPLES = 200
"""Number of steps of a run at which all bridge forces are logged, for the shares of impulse."""
BRIDGE_B, TRIANGLE_B, CANDIDATE_B = 248, 100, 40
"""Bytes that the plugin stores for a bridge, a wall triangle, a near pair (sizes of its records)."""


def plan_of(setup: Setup, **switches: Any) -> EffectPlan:
    """Return the plan of a scene at the study's tolerance."""
    entry = RatioEntry(value=TOLERANCE, source="assumption", reason="two per cent of a wanted quantity")
    settings = EffectSettings(tolerance=entry, **switches)
    return plan(setup.classes, setup.pairs, setup.liquid, setup.speed, settings, LawSettings(), setup.surroundings)


def variants(setup: Setup) -> dict[str, Effects]:
    """Return everything on, the plan's choice, each active effect off, and, for a dry scene, the plugin without work."""
    full = plan_of(setup).effects
    there = {
        "wall_films": bool(setup.walls),
        "sharing_by_size": bool(setup.walls) or len(setup.classes) > 1,
        "gravity": any(setup.gravity),
    }
    chosen = {EVERYTHING: full, PLANNED: plan_of(setup, decide="tolerance").effects}
    for effect in SWITCHED:
        without = plan_of(setup, **{effect: False}).effects
        if without != full and there.get(effect, True):
            chosen[f"no {effect}"] = without
    return {**chosen, IDLE: small.PAPER} if setup.liquid is None else chosen


def measure(scene: StudyScene, setup: Setup, effects: Effects) -> Row:
    """Prepare and run a scene with a choice of effects; return its results with the quantities of interest."""
    with tempfile.TemporaryDirectory(prefix="pywet-study-") as name:
        run_dir = Path(name)
        made = prepare(setup, effects, run_dir)
        info = small.run(run_dir, setup.spheres) if setup.spheres else driver.run(run_dir, progress=False)
        return {
            **scene.wanted(run_dir), "effects": effects.model_dump(), "cpu_s": info.cpu_s, "loop_cpu_s": info.loop_cpu_s,
            "wall_s": info.wall_s, "steps": info.steps, "spheres": info.spheres, "plugin": info.plugin_hash is not None,
            "peak_memory_B": info.peak_memory_B, "plugin_arrays_B": plugin_arrays(made, run_dir),
            "shares": measured_shares(made, run_dir), "plan": plan_of(setup, decide="tolerance").as_dict()["rows"],
        }  # fmt: skip


def prepare(setup: Setup, effects: Effects, run_dir: Path) -> EngineScene:
    """Make the run directory of one choice."""
    if setup.build is not None:
        return setup.build(effects, run_dir)
    # of all choices, so that times are comparable
    step = step_choice.of_packing(setup.classes, setup.pairs, STEP_FRACTION)
    steps = round(setup.seconds / step)
    reach = 1.1 * max([float(np.abs(w.corners).max()) for w in setup.walls], default=0.0)
    reach = max(reach, 3.0 * max(abs(c) for s in setup.spheres for c in s.position))
    liquid = setup.liquid
    if effects.bridges and liquid is None:  # the plugin in a dry scene: a liquid without films
        liquid = wetting(setup.classes, 0.0)
    windows: dict[str, Any] = {"contact_windows": min(SAMPLES, steps), "contact_window_steps": 1}
    return small.prepare(
        run_dir, setup.classes, setup.spheres, setup.pairs, liquid=liquid, effects=effects, walls=setup.walls,
        wall_angle_rad=0.7, time_step_s=step, steps=steps, gravity=setup.gravity if effects.gravity else (0.0, 0.0, 0.0),
        box=reach, output=Output(interval_s=max(1, steps // OUTPUTS) * step, **windows), rotation=setup.rotation,
        viscous_integration="semi_implicit", largest_overlap=0.9,
    )  # fmt: skip


def measured_shares(scene: EngineScene, run_dir: Path) -> dict[str, float] | None:
    """Return shares of sum |F| dt by weight and bridge forces, from the sampled steps; None for a run without bridges."""
    if not scene.effects.bridges:
        return None
    log = read_table(run_dir / "history" / "contacts.parquet")
    gravity = float(np.linalg.norm(scene.gravity_m_per_s2))
    spheres = read_table(run_dir / "history" / "spheres.parquet")
    mass = float(spheres["type"].map({c.type: c.mass_kg for c in scene.classes}).sum())
    side = np.sqrt(sum(log[f"viscous_tangential_{axis}"] ** 2 for axis in "xyz"))
    total = {
        "gravity": min(SAMPLES, scene.steps) * mass * gravity,
        "capillary": float(log["capillary"].abs().sum()),
        "viscous_normal": float(log["viscous_normal"].abs().sum()),
        "viscous_tangential": float(side.sum()),
    }
    everything = sum(total.values())
    return {k: v / everything for k, v in total.items()} if everything > 0 else None


def plugin_arrays(scene: EngineScene, run_dir: Path) -> int:
    """Return the bytes that the plugin stores for this scene at its end; 0 if it is not loaded."""
    if not scene.effects.bridges:
        return 0
    bridges = int(read_table(run_dir / "history" / "ledger.parquet")["bridge_count"].max())
    triangles = len(read_table(run_dir / "history" / "triangles.parquet")) if scene.walls else 0
    spheres = sum(c.count for c in scene.classes)
    nodes = len(transfer_tables(scene)) if scene.effects.transfer == "half" else 201 * len(scene.classes) ** 2
    return (
        bridges * BRIDGE_B
        + (triangles * TRIANGLE_B if scene.effects.wall_films else 0)
        + spheres * (8 * 3 + 8 + CANDIDATE_B * 6)
        + nodes * 16
    )
