"""Functions that every engine's driver needs: programs, versions, a monitored process, progress."""

from __future__ import annotations

import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pywet.ending import die_with_parent
from pywet.errors import EngineError, arguments, border
from pywet.util.notices import notice

if TYPE_CHECKING:  # the plugin is built while Python's packages are being installed
    from pywet.scene import EngineScene

Report = Callable[[int, int], None]
OUTPUT = "output.log"
"""File with all messages of the engine's process."""
ANSWER_S = 30.0
"""Longest time [s] for a program to print its version."""
FIX = "run it in a terminal to see why, or reinstall its package"


def worker_border(run: Callable[..., object], **more: Callable[[str], Any]) -> int:
    """Call a worker's `run` with the arguments RUN_DIR, ENGINE_FOLDER and `more`; an error becomes a line with ERROR."""
    die_with_parent()
    with border(say=lambda sentence: print(f"ERROR: {sentence}", file=sys.stderr, flush=True)):
        run_dir, folder, *others = arguments(RUN_DIR=Path, ENGINE_FOLDER=Path, **more)
        run(run_dir.resolve(), folder.resolve(), *others)
    return 0


@dataclass(frozen=True)
class Usage:
    """Processor time [s] and largest resident memory [B] of the engine's process; None if too short to be measured."""

    cpu_s: float
    peak_memory_B: int | None


def output_of(command: list[str], given: str = "", folder: Path | None = None) -> str:
    """Return the output of a program called for its version; `PywetError` if it does not start or end in time.

    It runs in a separate process group, so that its child processes end with it.
    """
    try:
        child = subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            errors="replace",
            start_new_session=True,
        )
    except OSError as error:
        raise EngineError(
            f"{command[0]} does not start ({error.strerror}); expected its version: {FIX}",
            code="engine.not_started", given=command[0],
        ) from error  # fmt: skip
    try:
        return child.communicate(given, timeout=ANSWER_S)[0]
    except subprocess.TimeoutExpired as error:
        os.killpg(child.pid, signal.SIGKILL)
        child.wait()
        raise EngineError(
            f"{command[0]} did not answer within {ANSWER_S:g} s; expected it to print its version: {FIX}",
            code="engine.no_answer", given=command[0],
        ) from error  # fmt: skip


def package_version(package: str) -> str | None:
    """Return the installed version of a Debian package, or None."""
    if shutil.which("dpkg-query") is None:
        return None
    status, _, version = output_of(["dpkg-query", "-W", "-f=${Status}|${Version}", package]).partition("|")
    return version if status.endswith("installed") and "not-installed" not in status else None


def installed(name: str, version: str, setup: str) -> str:
    """Return the version of an engine's program from Debian's package of the same name; `EngineError` if it is unsupported."""
    program = name.lower()
    if shutil.which(program) is None:
        raise EngineError(
            f"the program {program} was not found; expected Debian's package {program}: run `{setup}`",
            code="engine.no_program", expected=program,
        )  # fmt: skip
    there = package_version(program)
    if there is not None and not there.startswith(version):
        raise EngineError(
            f"{name} {there} is installed; expected {version} (Debian 12): install that version",
            code="engine.program_version", given=there, expected=version,
        )  # fmt: skip
    return there or version


HUGE_PAGES = {"GLIBC_TUNABLES": "glibc.malloc.hugetlb=1"}
"""Environment variable that requests huge pages by madvise(2); a user's setting takes precedence."""


def surroundings(python: bool = False) -> dict[str, str]:
    """Return the environment of an engine: one thread, MPI allowed for any user; `python`: with this program's Python modules.

    Its memory uses huge pages if available, because all data of a bed are read in every step (docs/engine.md).
    """
    hidden = () if python else ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")
    hidden = (*hidden, "SLURM_STEP_ID")  # by it Open MPI takes a process for one that srun has started as a rank
    stored = {name: value for name, value in os.environ.items() if name not in hidden}
    return (
        HUGE_PAGES
        | stored
        | {"OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    )


def _peak_memory(pid: int) -> int | None:
    """Return the largest resident memory of a running process so far [B]; None if it has ended or is not reported."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return None
    kilobytes = next((line.split()[1] for line in lines if line.startswith("VmHWM:")), None)
    return None if kilobytes is None else 1024 * int(kilobytes)


def _children_cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@contextmanager
def progress_bar(scene: EngineScene, wanted: bool, start: int = 0) -> Iterator[Report]:
    """Provide a progress bar with the remaining time in a terminal, otherwise a notice at each tenth of the run.

    `start`: the step from which the engine resumes.
    """
    if not wanted:
        yield lambda done, total: None
    elif sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            Progress,
            TaskProgressColumn,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        shares = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
        times = (TimeElapsedColumn(), TextColumn("to go"), TimeRemainingColumn())
        with Progress(*shares, *times, console=Console(stderr=True)) as bar:
            task = bar.add_task(scene.name, total=scene.steps, completed=start)
            yield lambda done, total: bar.update(task, completed=max(done, start), total=total)
    else:
        yield _line_reporter(scene, start)


def _line_reporter(scene: EngineScene, start: int) -> Report:
    started, shown = time.monotonic(), -1

    def report(done: int, total: int) -> None:
        nonlocal shown
        done = max(done, start)  # the output of a resumed engine is empty at first
        tenth = 10 * done // max(total, 1)
        if tenth == shown:
            return
        shown = tenth
        elapsed = time.monotonic() - started
        tail = f", about {elapsed * (total - done) / (done - start):.0f} s to go" if start < done < total else ""
        notice.info(f"{scene.name}: {100 * done / max(total, 1):3.0f} % after {elapsed:.0f} s{tail}")

    return report


def last_words(lines: Iterable[str], returncode: int) -> str:
    """Return the reason why a program stopped: its first line with ERROR, else its signal, else its last non-empty message."""
    lines_with_words = [line.strip() for line in lines if re.search(r"\w", line)]
    named = next((line for line in lines_with_words if re.search(r"\bERROR\b", line)), None)
    if named is not None:
        return re.sub(r"^.*?ERROR[^:]*:\s*", "", named)
    if returncode < 0:
        return f"the program was ended by signal {-returncode} ({signal.strsignal(-returncode)})"
    return lines_with_words[-1] if lines_with_words else f"it wrote nothing and ended with status {returncode}"


def attend(
    command: list[str], folder: Path, environment: Mapping[str, str], look: Callable[[], None]
) -> tuple[int, Usage]:
    """Run a program in `folder`; return exit status and resource use.

    `look` is called a few times a second and ends the program by raising.
    """
    before, peak = _children_cpu(), None
    with open(folder / OUTPUT, "w") as output:
        child = subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            env=environment,
            preexec_fn=die_with_parent,
            start_new_session=True,
        )
        try:
            while child.poll() is None:
                time.sleep(0.1)
                peak = _peak_memory(child.pid) or peak
                look()
        except BaseException:
            with suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)
            child.wait()
            raise
    return child.returncode, Usage(_children_cpu() - before, peak)
