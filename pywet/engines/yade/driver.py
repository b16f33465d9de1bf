"""Run a prepared scene in YADE with the plugin and write the same tables as a run in LIGGGHTS.

YADE computes contacts, neighbours and integration; the plugin computes bridges, films and rolling resistance. A run
has one process and does not resume.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from pywet.engines.liggghts import deck
from pywet.engines.pipeline import Job, RunInfo, collect, simulate
from pywet.engines.yade import build, worker
from pywet.engines.yade.contacts import contacts
from pywet.engines.yade.solids import convex_pieces
from pywet.errors import PywetError
from pywet.geometry.motion import slides
from pywet.geometry.stl import read_stl
from pywet.planning import time_steps
from pywet.run_folder import alone
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene, Rotation, Slide, Vibration
from pywet.util.files import read_table, write_json

SKIN = 0.1
"""Margin of the bodies' boxes over the smallest radius, between two sorts of the collider; the fastest of 0.3, 0.1 and 0.03."""


def run(run_dir: Path, progress: bool = True, *, driven: tuple[int, ...] = (), allow_unstable: bool = False) -> RunInfo:
    """Run the scene in `run_dir`/scene.json; writes engine/, trajectory, mesh motion and (moist) history/.

    Raises `PywetError` if YADE is missing, of another version, or does not support the scene; `driven`: spheres
    with prescribed velocity.
    """
    run_dir = Path(run_dir).resolve()
    scene = RunDir(run_dir).scene
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
    ways = scene.motions
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
        "drawn": {name: window for name, window in slides(scene).items() if window[1] > window[0]},
        "driven": (),
        "skin": SKIN * min(c.radius_m for c in scene.classes),
        "reach": deck.film_factor(scene),
        "contacts": None,
    }


def _solid(path: Path, name: str) -> list[list[list[float]]]:
    return [piece.tolist() for piece in convex_pieces(read_stl(path, name=name))]


def execute(
    run_dir: Path, scene: EngineScene, task: dict[str, Any], progress: bool, program: str = worker.__name__
) -> RunInfo:
    """Run a task in engine.partial by the worker `program` and make its tables."""
    with alone(run_dir):
        plain, version = worker.as_yade_has_it(scene), build.engine_version()
        job = Job.of(plain, run_dir, build.PROGRAM[0], version, build.plugin_path(), progress=progress)
        command = (sys.executable, "-P", "-m", program)
        return collect(simulate(job, lambda at: write_json(at / "task.json", task), command, code="yade.stopped"))
