"""Runs one deck with the plugin inside this process: engine library, plugin, compiled laws. Started by driver.py.

A child process because an engine error ends in MPI_Abort, which kills the process it happens in. Under `mpirun -np N` each
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

from pywet.engines.liggghts.checkpoint import holds
from pywet.engines.liggghts.plugin_api import Plugin
from pywet.engines.liggghts.process import LOOP_TIME
from pywet.engines.process import die_with_parent
from pywet.errors import PywetError
from pywet.files import read_json, read_table
from pywet.scene import Scene

LIBRARY = "libliggghts.so.3"
LINE_BUFFERED = 1
"""_IOLBF of setvbuf(3)."""


def corner_points(triangles: pd.DataFrame) -> dict[str, np.ndarray]:
    """Corner points per mesh, (n, 9), in file order."""
    columns = [f"v{k}_{axis}" for k in range(3) for axis in "xyz"]
    return {str(name): rows[columns].to_numpy(float) for name, rows in triangles.groupby("mesh", sort=False)}


def run(run_dir: Path, folder: Path) -> None:
    """Read the scene, set the engine up, attach the plugin, run all stages."""
    scene = Scene.read(run_dir / "scene.json")
    schedule = read_json(folder / "schedule.json")
    history = run_dir / "history"
    library = C.CDLL(LIBRARY, mode=C.RTLD_GLOBAL)
    plugin = Plugin()
    nodes = corner_points(read_table(history / "triangles.parquet")) if scene.walls else {}
    spheres = read_table(history / "spheres.parquet")
    transfer = read_table(history / "transfer.parquet") if scene.effects.bridges else pd.DataFrame()
    os.chdir(folder)
    libc = C.CDLL(None)
    libc.setvbuf(C.c_void_p.in_dll(libc, "stdout"), None, LINE_BUFFERED, 0)  # an abort flushes nothing
    words = [b"pywet", b"-log", b"log.liggghts"]
    engine = C.c_void_p()
    library.lammps_open_no_mpi(len(words), (C.c_char_p * len(words))(*words), C.byref(engine))

    def begin(deck: str, state: Path | None) -> None:
        """Set engine and plugin up; at a checkpoint of an unbroken run just as where a run goes on."""
        library.lammps_file(engine, deck.encode())
        plugin.configure(scene, spheres, transfer, nodes)
        plugin.set_output(schedule["output_steps"], [tuple(w) for w in schedule["windows"]])
        plugin.attach(engine, folder)
        if state:
            plugin.resume(state)

    begin("setup.liggghts", Path(schedule["resume"]["state"]) if schedule["resume"] else None)
    before, state = time.process_time(), None
    for line in Path("run.liggghts").read_text().splitlines():
        match line.split():
            case ["include", deck]:
                begin(deck, state)
            case ["write_restart", path]:
                library.lammps_command(engine, line.encode())
                state = saved(Path(path), len(spheres))
            case _:
                library.lammps_command(engine, line.encode())
    if plugin_rank() == 0:
        Path(LOOP_TIME).write_text(f"{time.process_time() - before:.6f}\n")
    library.lammps_close(engine)
    plugin.finish()


def saved(engine: Path, spheres: int) -> Path:
    """Give both files of a checkpoint their names, now that both are whole; returns that of the plugin's state."""
    state = engine.with_name(engine.name.replace("engine", "state"))
    if plugin_rank() == 0 and not holds(engine.read_bytes(), spheres):  # the engine would read on and on
        raise PywetError(f"the checkpoint {engine} could not be written; is the disk full?")
    for path in (engine, state) if plugin_rank() == 0 else ():
        with open(path, "rb") as file:
            os.fsync(file.fileno())
        path.rename(path.with_suffix(""))
    return state.with_suffix("")


def plugin_rank() -> int:
    """Rank of this process, 0 without mpirun."""
    return int(os.environ.get("OMPI_COMM_WORLD_RANK", "0"))


def main() -> int:
    """`python -m pywet.engines.liggghts.worker RUN_DIR ENGINE_FOLDER`."""
    die_with_parent()
    try:
        run(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve())
    except PywetError as error:
        print(f"ERROR: {error}", file=sys.stderr, flush=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
