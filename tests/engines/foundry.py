"""Runs of an engine with injected faults: one process that loads engine, patched plugin and laws once and forks for every run.

A test holds a `Foundry`, which starts such a process and writes lines `FAULT<tab>RUN_DIR<tab>ENGINE_FOLDER` to it; the process
calls `serve`, which answers each with the exit status of its run. The fault reaches the plugin as an environment variable.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from pywet.engines.liggghts import build
from pywet.engines.process import OUTPUT, Usage

VARIABLE = "PYWET_FAULT"
"""Environment variable with the name of the fault that is switched on."""
READY = "ready"
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none", "OMPI_MCA_mpi_yield_when_idle": "1",
}  # fmt: skip


def switch(function: str) -> str:
    """Text of a header with the function, true for the name of the fault that is switched on."""
    return f"""#pragma once
#include <cstdlib>
#include <cstring>
inline bool {function}(const char *name) {{
  static const char *is = getenv("{VARIABLE}");
  return is && !strcmp(is, name);
}}
"""


def replaced(path: Path, old: str, new: str) -> None:
    """Replace text in a source file, where it must be exactly once: a change of it cannot make a fault vanish unseen."""
    text = path.read_text()
    if text.count(old) != 1:
        raise AssertionError(f"{path.name} holds {text.count(old)} places like `{old}`; expected 1: correct PATCHES")
    path.write_text(text.replace(old, new))


class Foundry:
    """The process of a module that calls `serve`, built from patched sources."""

    def __init__(self, module: str, sources: Path) -> None:
        self._worker = subprocess.Popen(
            [sys.executable, "-m", module, str(sources)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env={**os.environ, **ENVIRONMENT}, cwd=Path(__file__).parents[2],
        )  # fmt: skip
        while self._answer() != READY:
            pass

    def _answer(self) -> str:
        assert self._worker.stdout is not None
        line = self._worker.stdout.readline().strip()
        assert line, "the patched plugin does not build or its worker has died"
        return line

    def launch(self, fault: str, run_dir: Path, folder: Path) -> Usage:
        """Run what is prepared in an engine folder with one fault switched on; AssertionError where the run fails."""
        assert self._worker.stdin is not None
        print(fault, run_dir.resolve(), folder, sep="\t", file=self._worker.stdin, flush=True)
        assert self._answer() == "0", (folder / OUTPUT).read_text()[-1000:]
        return Usage(0.0, None)

    def close(self) -> None:
        """End the process."""
        assert self._worker.stdin is not None
        self._worker.stdin.close()
        self._worker.wait(timeout=30)


def quick_build() -> None:
    """Compile with fewer optimisations: a library is used for seconds."""
    build.FLAGS = ["-O1" if flag == "-O3" else flag for flag in build.FLAGS]


def serve(run: Callable[[Path, Path], None]) -> None:
    """Answer lines until the input ends: `run` of run directory and engine folder, each in a child of this process."""
    print(READY, flush=True)
    for line in sys.stdin:
        fault, run_dir, folder = line.rstrip("\n").split("\t")
        print(_forked(run, fault, Path(run_dir), Path(folder)), flush=True)


def _forked(run: Callable[[Path, Path], None], fault: str, run_dir: Path, folder: Path) -> int:
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.environ[VARIABLE] = fault
            os.chdir(folder)
            output = os.open(OUTPUT, os.O_WRONLY | os.O_CREAT)
            os.dup2(output, 1)
            os.dup2(output, 2)
            run(run_dir, folder)
            status = 0
        except Exception as error:
            print(f"ERROR: {error}", file=sys.stderr, flush=True)
        finally:
            os._exit(status)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
