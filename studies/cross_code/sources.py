"""Sources of the table and how one is run: a source that fails writes only its reason into its file."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path

from pywet.errors import PywetError
from studies.cross_code.model import Source


def _of(module: str, function: str = "source", runs: str = "runs") -> Callable[[Path], Source]:
    """Return a function of a module of this package, imported when called; `runs`: the folder passed to it."""
    return lambda folder: getattr(import_module(f"studies.cross_code.{module}"), function)(folder / runs)


SOURCES: dict[str, Callable[[Path], Source]] = {
    "forces": _of("forces"),
    "replayed": _of("replayed"),
    "dry": _of("dry"),
    "single": _of("single"),
    "lammps": _of("lammps", runs="runs/lammps"),
    "screening": _of("replayed", "screening", ".."),
    "engines": _of("engines", runs="../crosscheck"),
}
"""Name -> function of the folder results/agreement; the last two read results of other targets next to it."""
READ = {"screening": "*/case*/replay.json", "engines": "crosscheck/**/*.parquet"}
"""Patterns of the files of other targets that the last two sources read."""


def left_by_others(name: str, results: Path) -> list[str]:
    """Return the files of other targets that a source would read now, with their times: if these change, it must be rerun."""
    pattern = READ.get(name)
    return sorted(f"{p} {p.stat().st_mtime:.0f}" for p in results.glob(pattern)) if pattern else []


def data_file(folder: Path, name: str) -> Path:
    """Return the path of the file with the cells of a source."""
    return folder / "data" / f"{name}.json"


def run_source(name: str, folder: Path) -> Source:
    """Run one source and write its file; a failure is written, not raised."""
    if name not in SOURCES:
        raise PywetError(f"there is no source {name}; expected one of {', '.join(SOURCES)}")
    began = time.monotonic()
    try:
        made = SOURCES[name](folder)
    except PywetError as error:
        made = Source(name, failed=str(error))
    except Exception as error:
        traceback.print_exc()
        made = Source(name, failed=f"fault in the program, {type(error).__name__}: {error}")
    made = replace(made, wall_s=time.monotonic() - began)
    made.write(data_file(folder, name))
    return made
