"""Run a prepared scene in YADE with the plugin and write the same tables as a run in LIGGGHTS.

YADE computes contacts, neighbours and integration; the plugin computes bridges, films and rolling resistance.
Everything is written into `engine.partial` first and renamed when the run is complete. A run has one process and does
not resume.
"""

from __future__ import annotations

import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pywet import run_folder
from pywet.engines import schedule
from pywet.engines.liggghts import checkpoint, collecting, deck
from pywet.engines.liggghts.driver import RunInfo
from pywet.engines.liggghts.inputs import write_inputs
from pywet.engines.process import OUTPUT, Usage, alone, attend, last_words, progress_bar, start_again, surroundings
from pywet.engines.yade import build, worker
from pywet.engines.yade.contacts import contacts
from pywet.engines.yade.solids import convex_pieces
from pywet.errors import PywetError, StoppedRun
from pywet.geometry.stl import read_stl
from pywet.planning import time_steps
from pywet.runs import tables
from pywet.scene import EngineScene, Rotation, Slide, Vibration
from pywet.util.files import read_table, write_json

WORKER = ["-m", worker.__name__]
SKIN = 0.1
"""Margin of the bodies' boxes over the smallest radius, between two sorts of the collider; the fastest of 0.3, 0.1 and 0.03."""


def run(run_dir: Path, progress: bool = True, *, driven: tuple[int, ...] = (), allow_unstable: bool = False) -> RunInfo:
    """Run the scene in `run_dir`/scene.json; writes engine/, trajectory, mesh motion and (moist) history/.

    Raises `PywetError` if YADE is missing, of another version, or does not support the scene; `driven`: spheres
    with prescribed velocity.
    """
    run_dir = Path(run_dir).resolve()
    scene = EngineScene.read(run_dir / "scene.json")
    refuse(scene)
    build.engine_version()
    if not allow_unstable:
        time_steps.refuse_unstable(scene)
    task = build_task(scene, run_dir)
    task["contacts"], task["driven"] = contacts(scene), driven
    return execute(run_dir, scene, task, progress)


def refuse(scene: EngineScene) -> None:
    """Raise a PywetError in one sentence for what YADE does not support in this scene."""
    reasons = []
    if scene.removes:
        reasons.append("taking spheres out of a run (`retire`, outlets)")
    if scene.periodic is not None:
        reasons.append("walls in a box that is periodic")
    if scene.effects.liquid_weight:
        reasons.append("spheres whose mass changes (`liquid_weight`)")
    if scene.hertz is not None:
        reasons.append("Hertz contacts as LIGGGHTS has them")
    if not scene.effects.tangential_history:
        reasons.append("friction without memory")
    if scene.effects.bridges and scene.output.energy and any(w.motion != "fixed" for w in scene.walls):
        reasons.append("the power of walls that move (of output, energy is true)")
    if reasons:
        raise PywetError(
            f"the engine yade cannot run the scene {scene.name}: it lacks {' and '.join(reasons)}; expected a scene without: "
            "use the engine liggghts",
            code="yade.scene", given=tuple(reasons),
        )  # fmt: skip


def build_task(scene: EngineScene, run_dir: Path) -> dict[str, Any]:
    """Return the scene as plain numbers for in_yade.py, with walls divided into convex solids; without contacts."""
    spheres = read_table(run_dir / scene.spheres_file)
    names = ["id", "type", *"xyz", "vx", "vy", "vz", "wx", "wy", "wz"]
    for name in names:
        if name not in spheres.columns:
            spheres[name] = 0.0
    ways = {w.name: scene.motion_of(w) for w in scene.walls}
    return {
        "name": scene.name,
        "time_step": scene.time_step_s,
        "radius": [c.radius_m for c in scene.classes],
        "density": [c.density_kg_per_m3 for c in scene.classes],
        "spheres": spheres[names].to_numpy(float).tolist(),
        "walls": {w.name: _solid(run_dir / w.stl, w.name) for w in scene.walls},
        "vibrates": {
            name: {"amplitude": v.amplitude_m, "phase": v.phase_rad, "frequency": v.frequency_Hz}
            for name, v in ways.items()
            if isinstance(v, Vibration)
        },
        "turns": {
            name: {"origin": r.origin_m, "axis": r.axis, "period": r.period_s}
            for name, r in ways.items()
            if isinstance(r, Rotation)
        },
        "slides": {name: s.velocity_m_per_s for name, s in ways.items() if isinstance(s, Slide)},
        "drawn": {name: window for name, window in schedule.slides(scene).items() if window[1] > window[0]},
        "driven": (),
        "skin": SKIN * min(c.radius_m for c in scene.classes),
        "reach": deck.film_factor(scene),
        "contacts": None,
        "liquid": None,
    }


def _solid(path: Path, name: str) -> list[list[list[float]]]:
    return [piece.tolist() for piece in convex_pieces(read_stl(path, name=name))]


def execute(run_dir: Path, scene: EngineScene, task: dict[str, Any], progress: bool) -> RunInfo:
    """Run a task in engine.partial and make its tables; with YADE's own bridges (`liquid`), those of a dry scene."""
    version, plugin = build.engine_version(), build.plugin_path()
    scene = worker.as_yade_has_it(scene, task)
    folder = run_dir / "engine.partial"
    mark = checkpoint.fingerprint(run_dir, scene, version, plugin.name)
    with alone(run_dir):
        start_again(folder, build.PROGRAM[0])
        run_folder.make_folder(run_dir, folder.name)
        checkpoint.start(folder, mark)
        tables.forget(run_dir)
        write_inputs(scene, run_dir)
        write_json(folder / "task.json", task)
        started = time.monotonic()
        usage = _watch(run_dir, folder, scene, progress)
        wall = time.monotonic() - started
        spheres, error = collecting.make(scene, folder)
        info = RunInfo(
            wall_s=wall, steps=scene.steps, spheres=spheres, ranks=1, engine_version=version, resumed_at_step=None,
            plugin_hash=plugin.stem.removeprefix("libpywet-yade-"), ledger_error=error, engine=build.PROGRAM[0],
            cpu_s=usage.cpu_s, peak_memory_B=usage.peak_memory_B,
        )  # fmt: skip
        collecting.publish(run_dir, folder, asdict(info), mark)
        return info


def _watch(run_dir: Path, folder: Path, scene: EngineScene, progress: bool) -> Usage:
    """Start the worker and report its progress until it ends."""
    command = [sys.executable, "-P", *WORKER, str(run_dir), str(folder)]
    with progress_bar(scene, progress) as report:
        status, usage = attend(
            command, folder, surroundings(python=True), lambda: report(checkpoint.last_step(folder), scene.steps)
        )
    if status != 0:
        reason = last_words((folder / OUTPUT).read_text(errors="replace").splitlines(), status)
        raise StoppedRun(
            f"{scene.name}: YADE stopped: {reason} (all messages: {folder / OUTPUT})",
            reason=reason, code="yade.stopped",
        )  # fmt: skip
    return usage
