"""Trials without start-up: this process has everything imported and compiled, and each trial is a copy of it (fork).

A copy forgets the changed module and all that import it, so that they are read again, and nothing else. The engine's process is a
copy of the copy. Not here: what a trial does and what its outcome means (`trial.py`, `follow.py`).
"""

from __future__ import annotations

import ctypes
import json
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from tests.faults import reach
from tests.import_graph import modules

CRASH = "crash.txt"
"""Next to the engine's messages: how its process ended, where that was no sentence of the program's own."""
REACHED = "reached.json"
"""There too: the lines that it came to, where they are asked for."""


def in_copy(work: Callable[[], dict[str, Any]], limit_s: float) -> dict[str, Any]:
    """Return the result of `work` in a fork of this process; `{"crash": …}` if it raises, dies or does not end."""
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / "answer.json"
        child = os.fork()
        if not child:
            os.setsid()
            _quiet(Path(folder) / "message.log")
            os._exit(_answered(work, answer))
        ended = _wait(child, limit_s)
        if answer.exists():
            given: dict[str, Any] = json.loads(answer.read_text())
            return given
        return {"crash": ended}


def _answered(work: Callable[[], dict[str, Any]], answer: Path) -> int:
    try:
        given = work()
    except BaseException as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        given = {"crash": f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"}
    answer.write_text(json.dumps(given))
    return 0


def _wait(child: int, limit_s: float) -> str:
    """Wait for a copy and end it, with all it started, after `limit_s`; how it ended."""
    begun = time.monotonic()
    while True:
        pid, status = os.waitpid(child, os.WNOHANG)
        if pid:
            return f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else "it ended without an answer"
        if time.monotonic() - begun > limit_s:
            os.killpg(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return f"no end within {limit_s:.0f} s"
        time.sleep(0.02)


def _quiet(path: Path) -> None:
    file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(file, 1)
    os.dup2(file, 2)


@cache
def _importers(root: Path) -> dict[str, set[str]]:
    """Module -> the modules that import it."""
    back: dict[str, set[str]] = {}
    for name, imported in modules(root).items():
        for other in imported:
            back.setdefault(other, set()).add(name)
    return back


def forget(name: str, root: Path) -> None:
    """Forget a module, what imports it, directly or not, and for a law all laws, which are compiled into each other."""
    importers = _importers(root)
    ahead = [name, *(m for m in sys.modules if name.startswith("pywet.laws.") and m.startswith("pywet.laws"))]
    gone: set[str] = set()
    while ahead:
        one = ahead.pop()
        if one not in gone:
            gone.add(one)
            ahead += importers.get(one, set())
    for one in gone:
        module = sys.modules.pop(one, None)
        package, _, last = one.rpartition(".")
        if module is not None and getattr(sys.modules.get(package), last, None) is module:
            delattr(sys.modules[package], last)


def engine_in_copy(keep_counts: bool = False) -> None:
    """Let the engine's process be a copy of this one; `keep_counts` ends it so that gcov's counters are written."""
    from pywet.engines import process as watched
    from pywet.engines.liggghts import process

    started = process.attend

    def attend(command: list[str], folder: Path, environment: Any, look: Callable[[], None]) -> tuple[int, Any]:
        if "pywet.engines.liggghts.worker" not in command:
            return started(command, folder, environment, look)
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        child = os.fork()
        if not child:
            os.environ.update(environment)
            _quiet(folder / watched.OUTPUT)
            _worker(command[command.index("pywet.engines.liggghts.worker") :], folder, keep_counts)
        while not (ended := os.waitpid(child, os.WNOHANG))[0]:
            time.sleep(0.05)
            look()
        status = os.waitstatus_to_exitcode(ended[1])
        if status < 0:
            (folder / CRASH).write_text(f"signal {-status}")
        return status, watched.Usage(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, None)

    process.attend = attend


def _worker(arguments: list[str], folder: Path, keep_counts: bool) -> None:
    code = 1
    try:
        from pywet.engines.liggghts import worker

        sys.argv = arguments
        code = worker.main()
    except BaseException as error:
        (folder / CRASH).write_text(f"{type(error).__name__}: {error}")
    sys.stdout.flush()
    if keep_counts:
        reach.keep(folder / REACHED)
        ctypes.CDLL(None).exit(code)
    os._exit(code)
