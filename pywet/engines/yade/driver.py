"""Runs a prepared scene in YADE and writes the same tables as the LIGGGHTS driver: trajectory, mesh motion, engine/run.json.

Dry scenes without rolling resistance, with walls that rest, vibrate, slide or turn. Everything is written into `engine.partial`
first and renamed when the run is complete. The program runs in_yade.py; no module of YADE is imported here.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet import run_folder
from pywet.engines import schedule
from pywet.engines.process import OUTPUT, Report, alone, attend, installed, last_words, progress_bar, surroundings
from pywet.engines.yade.contacts import contacts
from pywet.engines.yade.solids import convex_pieces
from pywet.errors import PywetError, StoppedRun
from pywet.geometry.stl import read_stl
from pywet.planning import time_steps
from pywet.runs import tables
from pywet.scene import Scene
from pywet.util.files import read_json, read_table, write_json, write_table

PROGRAM = ("YADE", "2023.02a", "make peers")
"""Its name, its version, and what installs it."""
SCRIPT = Path(__file__).with_name("in_yade.py")
COLUMNS = ("step", "id", "type", "x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz")
SKIN = 0.3
"""Margin of the bodies' boxes over the smallest radius, between two sorts of the collider."""


def run(run_dir: Path, progress: bool = True) -> None:
    """Run the dry scene in `run_dir`/scene.json; writes engine/, trajectory and mesh motion.

    Raises `PywetError` where YADE is missing, of another version, or cannot do what the scene asks for.
    """
    run_dir = Path(run_dir).resolve()
    scene = Scene.read(run_dir / "scene.json")
    refuse(scene)
    version = installed(*PROGRAM)
    time_steps.refuse_unstable(scene)
    task = build_task(scene, run_dir)
    task["contacts"] = contacts(scene)
    wall = execute(run_dir, scene, task, progress)
    # solids: convex ones, of the walls; damping_miss: largest relative error of a pair's damping
    solids = sum(len(pieces) for pieces in task["walls"].values())
    finish(run_dir, task, version, wall, solids=solids, damping_miss=task["contacts"]["largest_miss"])


def refuse(scene: Scene) -> None:
    """PywetError in one sentence for what YADE cannot do as this scene has it."""
    reasons = []
    if scene.effects.bridges:
        reasons.append("liquid that moves between films and bridges (Debian's build has no liquid migration)")
    if scene.effects.rolling:
        reasons.append("rolling resistance with a constant torque (its own is proportional to the spin)")
    if scene.is_fed:
        reasons.append("spheres that enter during the run")
    if scene.hertz is not None:
        reasons.append("Hertz contacts as LIGGGHTS has them")
    if any(w.own_motion for w in scene.walls):
        reasons.append("walls with motions of their own")
    if reasons:
        raise PywetError(
            f"the engine yade cannot run the scene {scene.name}: it lacks {' and '.join(reasons)}; expected a dry scene "
            "without rolling resistance (`effects: rolling: off` in config.yaml): take the engine liggghts"
        )


def build_task(scene: Scene, run_dir: Path) -> dict[str, Any]:
    """The scene as plain numbers for in_yade.py, walls cut into convex solids; without contacts."""
    spheres = read_table(run_dir / scene.spheres_file)
    names = ["id", "type", *"xyz", "vx", "vy", "vz", "wx", "wy", "wz"]
    for name in names:
        if name not in spheres.columns:
            spheres[name] = 0.0
    vibration, slide, turning = scene.vibration, scene.slide, scene.rotation
    drawn = next(iter(schedule.slides(scene).values()), None)
    every = scene.output_every
    return {
        "name": scene.name,
        "time_step": scene.time_step_s,
        "steps": scene.steps,
        "every": every,
        "marks": list(range(0, scene.steps, max(1, scene.steps // 200))),
        "gravity": scene.gravity_m_per_s2,
        "radius": [c.radius_m for c in scene.classes],
        "density": [c.density_kg_per_m3 for c in scene.classes],
        "spheres": spheres[names].to_numpy(float).tolist(),
        "walls": {w.name: _solid(run_dir / w.stl, w.name) for w in scene.walls},
        "vibrates": [w.name for w in scene.walls if w.motion == "vibrates"],
        "vibration": vibration
        and {"amplitude": vibration.amplitude_m, "phase": vibration.phase_rad, "frequency": vibration.frequency_Hz},
        "turns": [w.name for w in scene.walls if w.motion == "turns"],
        "rotation": turning and {"origin": turning.origin_m, "axis": turning.axis, "period": turning.period_s},
        "slides": [w.name for w in scene.walls if w.motion == "slides"],
        "slide_steps": drawn if drawn is not None and drawn[1] > drawn[0] else [],
        "slide_velocity": slide.velocity_m_per_s if slide else (0.0, 0.0, 0.0),
        "skin": SKIN * min(c.radius_m for c in scene.classes),
        "reach": 1.0,
        "box_low": scene.box_low_m,
        "box_high": scene.box_high_m,
        "contacts": None,
        "liquid": None,
    }


def _solid(path: Path, name: str) -> list[list[list[float]]]:
    return [piece.tolist() for piece in convex_pieces(read_stl(path, name=name))]


def execute(run_dir: Path, scene: Scene, task: dict[str, Any], progress: bool) -> float:
    """Run a task in engine.partial and read its frames into trajectory and mesh motion; wall time of the program [s]."""
    folder = run_dir / "engine.partial"
    with alone(run_dir):
        tables.forget(run_dir)
        run_folder.make_folder(run_dir, folder.name)
        write_json(folder / "task.json", task)
        started = time.monotonic()
        with progress_bar(scene, progress) as report:
            _watch(folder, scene, report)
        wall = time.monotonic() - started
        _collect(scene, run_dir, folder)
    return wall


def finish(run_dir: Path, task: dict[str, Any], version: str, wall_s: float, **more: object) -> None:
    """The run is whole: run.json says what it was, and its folder gets its name."""
    folder = run_dir / "engine.partial"
    info = {"engine": PROGRAM[0], "engine_version": version, "wall_s": wall_s, "steps": task["steps"]}
    write_json(folder / "run.json", {**info, "spheres": len(task["spheres"]), "ranks": 1, **more})
    run_folder.publish(run_dir, folder.name, "engine")


def _watch(folder: Path, scene: Scene, report: Report) -> None:
    """Start the program and report its progress to its end."""
    command = ["yade", "-j1", "-x", "-n", str(SCRIPT), "task.json"]
    status, _ = attend(
        command, folder, surroundings(), lambda: report(_last_step(folder / "progress.txt"), scene.steps)
    )
    if not (folder / "done").exists():
        reason = last_words((folder / OUTPUT).read_text(errors="replace").splitlines(), status)
        raise StoppedRun(f"{scene.name}: YADE stopped: {reason} (all messages: {folder / OUTPUT})", reason=reason)


def _last_step(path: Path) -> int:
    try:
        return int(path.read_text() or 0)
    except FileNotFoundError:
        return 0


def _collect(scene: Scene, run_dir: Path, folder: Path) -> None:
    """Tables from the frames, in the schema of the LIGGGHTS driver."""
    rows = np.fromfile(folder / "frames.bin").reshape(-1, len(COLUMNS))
    table = pd.DataFrame(rows, columns=list(COLUMNS)).astype({"step": np.int64, "id": np.int64, "type": np.int64})
    table.insert(1, "time", table["step"] * scene.time_step_s)
    write_table(table.sort_values(["step", "id"], ignore_index=True), run_dir / "trajectory.parquet")
    (folder / "frames.bin").unlink()
    moved = read_json(folder / "walls.json")
    write_table(pd.DataFrame(moved, columns=["step", "mesh", "dx", "dy", "dz"]), run_dir / "mesh_motion.parquet")
