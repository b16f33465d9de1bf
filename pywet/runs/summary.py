"""Write summary.json of any run: settings, versions, speed, liquid, events, energy."""

from __future__ import annotations

import platform
import shutil
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.errors import PywetError
from pywet.runs.rundir import RunDir
from pywet.runs.shapes import EngineRun
from pywet.runs.tables import ledger_error
from pywet.scene import EngineScene
from pywet.schema import WORKS
from pywet.util.files import AGAIN

PACKAGES = ("pywet", "numpy", "scipy", "pandas", "pyarrow", "numba", "meshio", "pydantic")


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that the numbers depend on."""
    installed = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            installed[name] = version(name)
        except PackageNotFoundError:
            installed[name] = "not installed as a package"
    return installed


def commit() -> str:
    """Return the state of the checkout of this program; empty outside one."""
    git = shutil.which("git")
    command = [str(git), "-C", str(Path(__file__).parent), "describe", "--always", "--dirty", "--exclude", "*"]
    done = subprocess.run(command, capture_output=True, text=True, check=False) if git else None
    return done.stdout.strip() if done and done.returncode == 0 else ""


def general(run: RunDir) -> dict[str, Any]:
    """Summarise a run of any scene; times in s, volumes in m3, masses in kg; of the spheres that have entered by its end."""
    scene, line = run.scene, run.timeline
    there = line.entered_by_end
    engine: dict[str, Any] = run.json("engine/run.json", EngineRun) or {}
    wall = float(engine.get("wall_s") or 0.0)
    steps = scene.steps - int(engine.get("resumed_at_step") or 0)
    return {
        "name": scene.name,
        "seed": scene.seed,
        "versions": {
            **versions(),
            str(engine.get("engine", "LIGGGHTS")).lower(): engine.get("engine_version"),
            "plugin": engine.get("plugin_hash"),
        },
        "ranks": engine.get("ranks"),
        "wall_s": wall,
        "steps": scene.steps,
        "time_step_s": scene.time_step_s,
        "simulated_s": scene.duration_s,
        "resumed_at_step": engine.get("resumed_at_step"),
        "particle_steps_per_s": steps * int(there.sum()) / wall if wall > 0 else None,
        "spheres": {c.name: int((line.types[there] == c.type).sum()) for c in scene.classes},
        "amounts": (run.plan or {}).get("amounts", []),
        "mass_kg": float(line.mass[there].sum()),
        "initial_liquid_m3": float(line.put_in[-1]),
        "effects": scene.effects.model_dump(),
        "events": _events(run),
        "ledger_error": ledger_error(run.ledger) if run.moist else None,
        "energy_J": _energy(run),
    }


def _energy(run: RunDir) -> dict[str, float | None]:
    """Return energies at the end and works since the start [J]; `unaccounted` is the residual of a moist run.

    For a dry run on the stock program, and without `output.energy`, only kinetic energy and the work of gravity
    are known; contacts, bridges and walls are their difference.
    """
    scene = run.scene
    if run.moist and scene.output.energy:
        rows = run.table("history/energy").sort_values("step")
        if rows.empty:
            raise PywetError(
                f"{run.path}: history/energy.parquet holds no row; expected one at each output: {AGAIN}",
                code="run.no_energy", where=run.path,
            )  # fmt: skip
        first, last = rows.iloc[0], rows.iloc[-1]
        energies: dict[str, float | None] = {str(k): float(v) for k, v in last.drop(["step", "time"]).items()}
        works = sum(float(last[name]) for name in WORKS)
        energies["unaccounted"] = float(last["kinetic"] + last["spin"] - first["kinetic"] - first["spin"]) - works
        return energies
    classes, steps = {c.type: c for c in scene.classes}, run.timeline.steps
    table = pd.concat([run.at_step("trajectory", int(step)) for step in sorted({steps[0], steps[-1]})])
    if scene.outlets:  # of spheres that left, as they left
        ends = run.trajectory.drop_duplicates("id", keep="last").assign(step=steps[-1])
        table = pd.concat([table[table["step"] == steps[0]], ends])
    table = table.sort_values(["step", "id"])
    mass = table["type"].map({t: c.mass_kg for t, c in classes.items()})
    inertia = mass * 0.4 * table["type"].map({t: c.radius_m for t, c in classes.items()}) ** 2
    at = table.assign(
        kinetic=0.5 * mass * (table[["vx", "vy", "vz"]] ** 2).sum(axis=1),
        spin=0.5 * inertia * (table[["wx", "wy", "wz"]] ** 2).sum(axis=1),
        gravity=mass * (table[["x", "y", "z"]] * list(scene.gravity_m_per_s2)).sum(axis=1),
    )
    sums = at.groupby("step")[["kinetic", "spin", "gravity"]].sum()
    change = sums.iloc[-1] - sums.iloc[0]
    change["gravity"] -= _path_of_inserted(scene, at[at["step"] == steps[0]], int(steps[-1]))
    rest = float(change["kinetic"] + change["spin"] - change["gravity"])
    return {
        "kinetic": float(sums["kinetic"].iloc[-1]),
        "spin": float(sums["spin"].iloc[-1]),
        "gravity": float(change["gravity"]),
        "contact_bridges_and_wall_motion" if run.moist else "contact_and_wall_motion": rest,
        "unaccounted": None,
    }


def _path_of_inserted(scene: EngineScene, start: pd.DataFrame, last: int) -> float:
    """Return the work [J] that gravity would have done on spheres before their insertion along their straight path."""
    waited = np.minimum(scene.enters(start["type"].tolist()), last) * scene.time_step_s
    mass = start["type"].map({c.type: c.mass_kg for c in scene.classes}).to_numpy(dtype=float)
    speed = start[["vx", "vy", "vz"]].to_numpy(dtype=float) @ np.array(scene.gravity_m_per_s2)
    return float((mass * waited * speed).sum())


def _events(run: RunDir) -> dict[str, int] | None:
    if not run.moist:
        return None
    last = run.ledger.sort_values("step").iloc[-1]
    return {
        "formations": int(last["formations"]),
        "ruptures": int(last["ruptures"]),
        "standing_bridges": int(last["bridge_count"]),
    }
