"""Run a prepared scene in LAMMPS with the plugin and write the same tables as a run in LIGGGHTS.

A run does not resume, has one process, and records no motion in windows.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from pywet.engines.lammps import build, deck
from pywet.engines.pipeline import Job, RunInfo, collect, simulate
from pywet.planning import time_steps
from pywet.run_folder import alone
from pywet.runs.rundir import RunDir

WORKER = (sys.executable, "-P", "-m", "pywet.engines.lammps.worker")


def run(run_dir: Path, ranks: int = 1, progress: bool = True, *, allow_unstable: bool = False, **more: Any) -> RunInfo:
    """Run the scene in `run_dir`/scene.json; writes engine/, trajectory, mesh motion and (moist) history/.

    Raises `PywetError` if LAMMPS is missing or does not support the scene; `allow_unstable` and `more` as for LIGGGHTS.
    """
    run_dir = Path(run_dir).resolve()
    with alone(run_dir):
        scene = RunDir(run_dir).scene
        deck.refuse(scene, ranks)
        version, plugin = build.engine_version(), build.plugin_path()
        if not allow_unstable:
            time_steps.refuse_unstable(scene)
        job = Job.of(scene, run_dir, "LAMMPS", version, plugin, progress=progress, **more)

        def write(folder: Path) -> None:
            deck.write(scene, run_dir, folder, job.extra, job.integrate)

        return collect(simulate(job, write, WORKER, code="lammps.stopped"))
