"""Run one script with the plugin in this process: libraries of MPI and LAMMPS, plugin, compiled laws. Started by driver.py."""

from __future__ import annotations

import ctypes as C
import os
import sys
from pathlib import Path

from pywet.engines.lammps import build
from pywet.engines.lammps.deck import SCRIPT
from pywet.engines.liggghts.plugin_api import Plugin
from pywet.engines.liggghts.worker import attach_once
from pywet.engines.process import worker_border
from pywet.errors import PywetError
from pywet.runs.rundir import RunDir

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
    os.chdir(folder)
    program = Program()
    plugin = Plugin(build.plugin_path(), build.engine_version())
    for line in Path(SCRIPT).read_text().splitlines():
        program.tell(line)
    attach_once(plugin, program.handle, scene, run_dir, folder)
    program.tell(f"run {scene.steps}")
    program.close()
    plugin.finish()


def main() -> int:
    """Run a scene as `python -m pywet.engines.lammps.worker RUN_DIR ENGINE_FOLDER`."""
    return worker_border(run)


if __name__ == "__main__":
    sys.exit(main())
