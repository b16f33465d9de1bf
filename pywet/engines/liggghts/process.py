"""Starts the engine's process, watches it, shows progress, and says in one sentence why it stopped."""

from __future__ import annotations

import ctypes
import os
import re
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from pywet.engines.liggghts.checkpoint import LOG, last_step
from pywet.errors import StoppedRun
from pywet.scene import Scene

Report = Callable[[int, int], None]
LOOP_TIME = "loop_cpu_s.txt"
"""File in which a moist run's first rank leaves the processor time of its steps [s]."""
LOGS = ("output.log", LOG)
LARGEST_LOG = 50_000_000
"""Bytes at which a log shows an engine that writes without end: a run of any length writes some hundred lines."""
OUTPUT = "output.log"
"""All that the engine's process printed."""
DEATH_SIGNAL = 1
"""PR_SET_PDEATHSIG of prctl(2)."""


@dataclass(frozen=True)
class Usage:
    """What the engine's process took: processor time [s], largest resident memory [B] (None: too short to be seen)."""

    cpu_s: float
    peak_memory_B: int | None


def peak_memory(pid: int) -> int | None:
    """Largest resident memory of a living process so far [B]; None where it is gone or the system does not say."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return None
    found = next((line.split()[1] for line in lines if line.startswith("VmHWM:")), None)
    return None if found is None else 1024 * int(found)


def _children_cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def die_with_parent() -> None:
    """Let the kernel end this process when the one that started it is gone, so that no orphan writes on."""
    ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGKILL)


@contextmanager
def progress_bar(scene: Scene, wanted: bool) -> Iterator[Report]:
    """A bar with the time to go in a terminal, a line for each tenth of the run in a log file."""
    if not wanted:
        yield lambda done, total: None
    elif sys.stdout.isatty():
        from rich.progress import (
            BarColumn,
            Progress,
            TaskProgressColumn,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
        with Progress(*columns, TimeElapsedColumn(), TextColumn("to go"), TimeRemainingColumn()) as bar:
            task = bar.add_task(scene.name, total=scene.steps)
            yield lambda done, total: bar.update(task, completed=done, total=total)
    else:
        yield _line_reporter(scene)


def _line_reporter(scene: Scene) -> Report:
    started, shown = time.monotonic(), -1

    def report(done: int, total: int) -> None:
        nonlocal shown
        tenth = 10 * done // max(total, 1)
        if tenth == shown:
            return
        shown = tenth
        elapsed = time.monotonic() - started
        tail = f", about {elapsed * (total - done) / done:.0f} s to go" if done and done < total else ""
        print(f"{scene.name}: {100 * done / total:3.0f} % after {elapsed:.0f} s{tail}", flush=True)

    return report


def execute(
    command: list[str], folder: Path, scene: Scene, report: Report, watch: Callable[[], None] = lambda: None
) -> Usage:
    """Run the engine in `folder` to its end; `watch` is called a few times a second."""
    before, peak = _children_cpu(), None
    environment = {
        **os.environ,
        "OMP_NUM_THREADS": "1",
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
        "OMPI_MCA_mpi_yield_when_idle": "1",  # the cores may be shared
    }
    with open(folder / OUTPUT, "w") as output:
        child = subprocess.Popen(
            command,
            cwd=folder,
            stdout=output,
            stderr=subprocess.STDOUT,
            env=environment,
            preexec_fn=die_with_parent,
            start_new_session=True,
        )
        try:
            while child.poll() is None:
                time.sleep(0.1)
                peak = peak_memory(child.pid) or peak
                report(last_step(folder / LOG), scene.steps)
                _refuse_flood(folder, scene)
                watch()
        except BaseException:
            with suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)
            child.wait()
            for path in _too_large(folder):
                os.truncate(path, LARGEST_LOG)
            raise
    if child.returncode != 0:
        raise stopped(scene, folder, child.returncode, f" (all messages: {folder / OUTPUT})")
    return Usage(_children_cpu() - before, peak)


def _too_large(folder: Path) -> list[Path]:
    """Logs beyond their bound."""
    paths = (folder / name for name in LOGS)
    return [path for path in paths if path.exists() and path.stat().st_size > LARGEST_LOG]


def _refuse_flood(folder: Path, scene: Scene) -> None:
    """End a run whose engine writes messages without end."""
    for path in _too_large(folder):
        with open(path, "rb") as log:
            said = log.read(4096).decode(errors="replace").strip().splitlines()
        raise StoppedRun(
            f"{scene.name}: LIGGGHTS was ended at step {last_step(folder / LOG)} of {scene.steps}: it wrote more than "
            f"{LARGEST_LOG // 10**6} MB into {path}, where some hundred lines were expected; the first is: "
            f"{said[0][:200] if said else ''!r}",
            step=last_step(folder / LOG),
        )


def stopped(scene: Scene, folder: Path, returncode: int, more: str = "") -> StoppedRun:
    """What the engine said before it stopped. Text is all that comes from it, so that here, once, numbers are read from it."""
    reason = _reason(folder, returncode)
    spheres = [int(n) for pair in re.findall(r"\bspheres? (\d+)(?: and (\d+))?", reason) for n in pair if n]
    step = re.search(r"\bstep (\d+)", reason)
    sentence = f"{scene.name}: LIGGGHTS stopped: {reason}{more}"
    return StoppedRun(sentence, reason=reason, spheres=tuple(spheres), step=int(step.group(1)) if step else None)


def _reason(folder: Path, returncode: int) -> str:
    """The engine's first ERROR line, without its decoration; else the last line with a word in it."""
    lines = [line for line in (folder / OUTPUT).read_text(errors="replace").splitlines() if re.search(r"\w", line)]
    errors = [line for line in lines if re.search(r"\bERROR\b", line)]
    if not errors:
        if returncode < 0:
            return f"the program was ended by signal {-returncode} ({signal.strsignal(-returncode)})"
        return lines[-1] if lines else "it wrote nothing"
    text = re.sub(r"^.*?ERROR[^:]*:\s*", "", errors[0])
    text = re.sub(r"\s*\(\.\./\S+\)|\s*\(\S+\.(cpp|h):\d+\)", "", text)
    if "Lost atoms" in text:
        return f"spheres left the simulated box ({text}); enlarge the box or lower the time step"
    return text
