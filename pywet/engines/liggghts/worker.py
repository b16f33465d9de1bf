"""Run one deck with the plugin in this process: engine library, plugin, compiled laws. Started by driver.py.

It is a child process because an engine error ends in MPI_Abort, which kills its process. Under `mpirun -np N` each
rank runs this program.
"""

from __future__ import annotations

import ctypes as C
import os
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.engines import schedule
from pywet.engines.liggghts import creation, deck, grid, state_file
from pywet.engines.liggghts.border import check_start
from pywet.engines.liggghts.checkpoint import saved
from pywet.engines.liggghts.departure import KEEP
from pywet.engines.liggghts.plugin_api import Plugin
from pywet.engines.liggghts.process import LOOP_TIME
from pywet.engines.liggghts.restart_file import holds
from pywet.engines.process import worker_border
from pywet.errors import PywetError
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene
from pywet.util.files import read_parts, read_table, write_json

LIBRARY = "libliggghts.so.3"
PATH = ("z", "vx", "vy", "vz")
"""Further columns of spheres that are created during the run."""
LINE_BUFFERED = 1
"""Constant _IOLBF of setvbuf(3)."""


def corner_points(triangles: pd.DataFrame) -> dict[str, np.ndarray]:
    """Return the corner points of each mesh, (n, 9), in file order."""
    columns = [f"v{k}_{axis}" for k in range(3) for axis in "xyz"]
    return {str(name): rows[columns].to_numpy(float) for name, rows in triangles.groupby("mesh", sort=False)}


def attach_once(plugin: Plugin, engine: C.c_void_p, scene: EngineScene, run_dir: Path, folder: Path) -> None:
    """Configure the plugin by the tables of a run and attach it to an engine that is not set up again at checkpoints."""
    unbroken = scene.model_copy(update={"output": scene.output.model_copy(update={"checkpoints": 0})})
    spheres, triangles, transfer = (run_dir / "history" / f"{n}.parquet" for n in ("spheres", "triangles", "transfer"))
    plugin.configure(
        unbroken, read_table(spheres), read_table(transfer) if scene.effects.bridges else pd.DataFrame(),
        corner_points(read_table(triangles)) if scene.walls else {},
    )  # fmt: skip
    plugin.set_output(scene.output_steps, schedule.windows(scene))
    plugin.attach(engine, folder)


def part_by_part(path: Path, *columns: str) -> pd.DataFrame:
    """Read some columns of a table of all spheres on every rank, one chunk at a time."""
    return pd.concat(read_parts(path, columns, rows=1 << 14), ignore_index=True)


def run(run_dir: Path, folder: Path, done: int = 0, ranks: int = 1) -> None:
    """Read the scene, set up the engine, attach the plugin, and run the steps after the checkpoint at step `done` (0: all)."""
    scene = RunDir(run_dir).scene
    history = run_dir / "history"
    library = C.CDLL(LIBRARY, mode=C.RTLD_GLOBAL)
    plugin = Plugin()
    transfer = read_table(history / "transfer.parquet") if scene.effects.bridges else pd.DataFrame()
    os.chdir(folder)
    libc = C.CDLL(None)
    libc.setvbuf(C.c_void_p.in_dll(libc, "stdout"), None, LINE_BUFFERED, 0)  # an abort flushes nothing
    words = [b"pywet", b"-log", b"log.liggghts"]
    engine = C.c_void_p()
    library.lammps_open_no_mpi(len(words), (C.c_char_p * len(words))(*words), C.byref(engine))

    def begin(script: bytes, step: int) -> None:
        """Set up engine and plugin; at a checkpoint of an uninterrupted run in the same manner as when a run resumes.

        The tables are read again, because a rank stores no data of the whole bed.
        """
        spheres = part_by_part(history / "spheres.parquet", "id", "type", "film")
        nodes = corner_points(read_table(history / "triangles.parquet")) if scene.walls else {}
        start = part_by_part(
            run_dir / scene.spheres_file, "id", "type", "x", "y", *(PATH if scene.created_ahead_s else ())
        )
        check_start(spheres, start)
        state = Path(saved("state", step))
        places = state_file.places(state) if step else creation.at_start(scene, start)[["x", "y"]]
        tell(f'variable columns string "{grid.words(scene, places, ranks)}"')
        library.lammps_file(engine, script)
        plugin.configure(scene, spheres, transfer, nodes)
        if scene.created_ahead_s:
            plugin.set_coming(creation.to_come(scene, start, spheres, step))
        plugin.set_output(scene.output_steps, schedule.windows(scene))
        plugin.attach(engine, folder)
        if step:
            plugin.resume(state)

    def tell(*lines: str) -> None:
        for line in lines:
            library.lammps_command(engine, line.encode())

    begin(b"setup.liggghts", done)
    gone = state_file.retired(Path(saved("state", done))) if scene.removes and done else np.zeros(0, np.int64)
    spent = []
    for piece in deck.runs(scene, done):
        began = time.process_time()
        tell(*piece.lines)
        ran = time.process_time()
        if piece.checkpoint:
            if scene.removes:
                plugin.wait()  # the first rank writes the state
                before, gone = gone, state_file.retired(Path(saved("state", piece.checkpoint, whole=False)))
                tell(*deck.retirement(np.setdiff1d(gone, before)))  # the engine searches all its spheres for each
            if scene.created_ahead_s:
                plugin.create_due()
            tell(f"write_restart {saved('engine', piece.checkpoint, whole=False)}")
            name_checkpoint(piece.checkpoint)
            plugin.wait()
            plugin.before_clear()
            tell("clear", f"variable at string {piece.checkpoint}")
            begin(b"again.liggghts", piece.checkpoint)
        spent.append({"steps": piece.steps, "run_s": ran - began, "checkpoint_s": time.process_time() - ran})
    held = plugin.held()
    if plugin_rank() == 0:
        write_json(Path(LOOP_TIME), spent)
        write_json(Path("held.json"), held)
    library.lammps_close(engine)
    plugin.finish()


def name_checkpoint(step: int) -> None:
    """Rename both files of a checkpoint, now that they are complete; only the first rank does this."""
    if plugin_rank() != 0:
        return
    engine, state = (Path(saved(name, step, whole=False)) for name in ("engine", "state"))
    data, count = engine.read_bytes(), state_file.count(state)
    if not holds(data, count):  # the engine would read on and on
        if any(holds(data, less) for less in range(1, count)) or data[-4:] == bytes(
            4
        ):  # whole, of fewer spheres or of none
            raise PywetError(f"spheres left the simulated box before step {step}; {KEEP}", code="engine.left_box")
        raise PywetError(
            f"the checkpoint {engine} could not be written; is the disk full?",
            code="checkpoint.unwritten", where=engine,
        )  # fmt: skip
    for path in (engine, state):
        with open(path, "rb") as file:
            os.fsync(file.fileno())
        path.rename(path.with_suffix(""))


def plugin_rank() -> int:
    """Rank of this process according to mpirun or SLURM's srun --mpi=pmix; 0 if neither has started it."""
    return int(os.environ.get("OMPI_COMM_WORLD_RANK") or os.environ.get("PMIX_RANK") or "0")


def main() -> int:
    """Run a deck as `python -m pywet.engines.liggghts.worker RUN_DIR ENGINE_FOLDER STEP RANKS`.

    STEP is that of the checkpoint to resume from, or 0.
    """
    return worker_border(run, STEP=int, RANKS=int)


if __name__ == "__main__":
    sys.exit(main())
