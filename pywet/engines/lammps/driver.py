"""Run a prepared scene in LAMMPS with the plugin and write the same tables as a run in LIGGGHTS.

Everything is written into `engine.partial` first and renamed when the run is complete. A run does not resume, has one process,
and records no motion in windows.
"""

from __future__ import annotations

import os
import sys
import time
from dataclasses import asdict
from pathlib import Path

from pywet import run_folder
from pywet.engines.lammps import build, deck
from pywet.engines.liggghts import checkpoint, collecting
from pywet.engines.liggghts.driver import RunInfo
from pywet.engines.liggghts.inputs import write_inputs
from pywet.engines.process import OUTPUT, alone, attend, last_words, progress_bar, start_again
from pywet.errors import StoppedRun
from pywet.planning import time_steps
from pywet.runs import tables
from pywet.scene import EngineScene


def run(
    run_dir: Path,
    ranks: int = 1,
    progress: bool = True,
    *,
    extra: tuple[str, ...] = (),
    integrate: str = "all",
    allow_unstable: bool = False,
) -> RunInfo:
    """Run the scene in `run_dir`/scene.json; writes engine/, trajectory, mesh motion and (moist) history/.

    Raises `PywetError` if LAMMPS is missing or does not support the scene; `extra`, `integrate`, `allow_unstable` as
    for LIGGGHTS.
    """
    run_dir = Path(run_dir).resolve()
    scene = EngineScene.read(run_dir / "scene.json")
    deck.refuse(scene, ranks)
    version, plugin = build.engine_version(), build.plugin_path()
    if not allow_unstable:
        time_steps.refuse_unstable(scene)
    folder = run_dir / "engine.partial"
    mark = checkpoint.fingerprint(run_dir, scene, version, plugin.name, *extra, integrate)
    with alone(run_dir):
        start_again(folder, "LAMMPS")
        run_folder.make_folder(run_dir, folder.name)
        checkpoint.start(folder, mark)
        tables.forget(run_dir)
        deck.write(scene, run_dir, folder, extra, integrate)
        write_inputs(scene, run_dir)
        started = time.monotonic()
        cpu_s, memory = _watch(run_dir, folder, scene, progress)
        wall = time.monotonic() - started
        spheres, error = collecting.make(scene, folder)
        info = RunInfo(
            wall_s=wall, steps=scene.steps, spheres=spheres, ranks=1, engine_version=version, resumed_at_step=None,
            plugin_hash=plugin.stem.removeprefix("libpywet-lammps-"), ledger_error=error, engine="LAMMPS", cpu_s=cpu_s,
            peak_memory_B=memory,
        )  # fmt: skip
        collecting.publish(run_dir, folder, asdict(info), mark)
        return info


def _watch(run_dir: Path, folder: Path, scene: EngineScene, progress: bool) -> tuple[float, int | None]:
    """Start the worker and report its progress; return processor time [s] and largest memory [B]."""
    command = [sys.executable, "-P", "-m", "pywet.engines.lammps.worker", str(run_dir), str(folder)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    with progress_bar(scene, progress) as report:
        status, usage = attend(command, folder, environment, lambda: report(checkpoint.last_step(folder), scene.steps))
    if status != 0:
        reason = last_words((folder / OUTPUT).read_text(errors="replace").splitlines(), status)
        raise StoppedRun(
            f"{scene.name}: LAMMPS stopped: {reason} (all messages: {folder / OUTPUT})",
            reason=reason, code="lammps.stopped",
        )  # fmt: skip
    return usage.cpu_s, usage.peak_memory_B
