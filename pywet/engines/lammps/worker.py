"""Run one script with the plugin in this process: libraries of MPI and LAMMPS, plugin, compiled laws. Started by driver.py."""

from __future__ import annotations

import ctypes as C
import os
import sys
from pathlib import Path

import pandas as pd

from pywet.ending import die_with_parent
from pywet.engines import schedule
from pywet.engines.lammps import build
from pywet.engines.lammps.deck import SCRIPT
from pywet.engines.liggghts.plugin_api import Plugin
from pywet.engines.liggghts.worker import corner_points
from pywet.errors import PywetError, arguments, border
from pywet.runs.rundir import RunDir
from pywet.util.files import read_table

SENTENCE = 1024
"""Bytes of an error message."""


class Program:
    """Instance of LAMMPS in this process, with the plugin."""

    def __init__(self) -> None:
        mpi, lammps = build.libraries()
        C.CDLL(str(mpi), mode=C.RTLD_GLOBAL)
        self._library = C.CDLL(str(lammps), mode=C.RTLD_GLOBAL)
        self._library.lammps_open_no_mpi.restype = C.c_void_p
        words = [b"pywet", b"-log", b"log.lammps"]
        self.handle = C.c_void_p(self._library.lammps_open_no_mpi(len(words), (C.c_char_p * len(words))(*words), None))

    def tell(self, line: str) -> None:
        """Execute one line of the script; raise PywetError with the program's message if it fails."""
        self._library.lammps_command(self.handle, line.encode())
        if self._library.lammps_has_error(self.handle):
            message = C.create_string_buffer(SENTENCE)
            self._library.lammps_get_last_error_message(self.handle, message, C.c_int(SENTENCE))
            raise PywetError(
                message.value.decode(errors="replace").strip().removeprefix("ERROR: "),
                code="lammps.refused", given=line,
            )  # fmt: skip

    def close(self) -> None:
        """Close LAMMPS; this is the last call but the plugin's `finish`, which ends MPI."""
        self._library.lammps_close(self.handle)


def run(run_dir: Path, folder: Path) -> None:
    """Read the scene, set the engine up, attach the plugin, run."""
    scene = RunDir(run_dir).scene
    unbroken = scene.model_copy(update={"output": scene.output.model_copy(update={"checkpoints": 0})})
    history = run_dir / "history"
    nodes = corner_points(read_table(history / "triangles.parquet")) if scene.walls else {}
    transfer = read_table(history / "transfer.parquet") if scene.effects.bridges else pd.DataFrame()
    os.chdir(folder)
    program = Program()
    plugin = Plugin(build.plugin_path(), build.engine_version())
    for line in Path(SCRIPT).read_text().splitlines():
        program.tell(line)
    plugin.configure(unbroken, read_table(history / "spheres.parquet"), transfer, nodes)
    plugin.set_output(scene.output_steps, schedule.windows(scene))
    plugin.attach(program.handle, folder)
    program.tell(f"run {scene.steps}")
    program.close()
    plugin.finish()


def main() -> int:
    """Run a scene as `python -m pywet.engines.lammps.worker RUN_DIR ENGINE_FOLDER`."""
    die_with_parent()
    with border(say=lambda sentence: print(f"ERROR: {sentence}", file=sys.stderr, flush=True)):
        run_dir, folder = arguments(RUN_DIR=Path, ENGINE_FOLDER=Path)
        run(run_dir.resolve(), folder.resolve())
    return 0


if __name__ == "__main__":
    sys.exit(main())
