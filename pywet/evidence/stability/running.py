"""Runs a batch in the engine; a cell that stops the run by a guard is noted and taken out, and the others run again.

The engine's processes are forked from a server that has everything imported and compiled, so that a run of a few
milliseconds does not wait for seconds of start-up.
"""

from __future__ import annotations

import multiprocessing as mp
import os
import shutil
from pathlib import Path
from typing import Any

from pywet.engines.liggghts import driver, process
from pywet.engines.process import Usage, die_with_parent
from pywet.errors import PywetError, StoppedRun
from pywet.evidence.stability import cells
from pywet.scene import Scene

PRELOAD = ["pywet.evidence.stability.warm"]


def _child(run_dir: str, folder: str, step: str, ranks: str) -> None:
    """In a forked process: what `python -m pywet.engines.liggghts.worker` does."""
    from pywet.engines.liggghts import worker

    log = os.open(str(Path(folder) / "output.log"), os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(log, 1)
    os.dup2(log, 2)
    die_with_parent()
    code = 0
    try:
        worker.run(Path(run_dir), Path(folder), int(step), int(ranks))
    except PywetError as error:
        os.write(2, f"ERROR: {error}\n".encode())
        code = 1
    os._exit(code)


def _forked(command: list[str], folder: Path, scene: Scene, report: Any, watch: Any = None) -> Usage:
    """Stands in for `process.execute` on one rank; what it used is not asked for."""
    if "pywet.engines.liggghts.worker" not in command or command[0] == "mpirun":
        return process.execute(command, folder, scene, report, watch or (lambda: None))
    server = mp.get_context("forkserver")
    server.set_forkserver_preload(PRELOAD)
    child = server.Process(target=_child, args=tuple(command[-4:]))
    child.start()
    child.join()
    if child.exitcode != 0:
        raise process.stopped(scene, folder, child.exitcode or 0)
    return Usage(0.0, None)


def run_cells(batch: cells.Batch, run_dir: Path, allow_unstable: bool = False) -> tuple[cells.Batch, dict[str, str]]:
    """Run until no guard objects; returns the batch as it came through, and the sentences of the cells that were quieted.

    Where the sentence names no sphere, all cells get it.
    """
    stopped: dict[str, str] = {}
    while True:
        shutil.rmtree(run_dir, ignore_errors=True)
        cells.prepare(batch, run_dir)
        try:
            launch(run_dir, batch.ranks, allow_unstable)
            return batch, stopped
        except PywetError as error:
            said, spheres = (error.reason, error.spheres) if isinstance(error, StoppedRun) else ("", ())
            name = batch.owner()[spheres[0]] if spheres else ""
            if not name or name in stopped:
                return batch, {**{c.name: said or str(error) for c in batch.cells}, **stopped}
            stopped[name] = said
            batch = batch.without({name})


def launch(run_dir: Path, ranks: int = 1, allow_unstable: bool = False) -> driver.RunInfo:
    """One engine run, forked where it has one rank."""
    return driver.run(run_dir, ranks, progress=False, allow_unstable=allow_unstable, launch=_forked)
