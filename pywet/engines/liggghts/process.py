"""Start LIGGGHTS, monitor its output, and report in one sentence why it stopped."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pywet.engines.liggghts.checkpoint import LOG, last_step
from pywet.engines.liggghts.departure import KEEP, departure
from pywet.engines.process import OUTPUT, Report, Usage, attend, last_words, surroundings
from pywet.errors import StoppedRun, child_data
from pywet.scene import EngineScene

LOOP_TIME = "loop_cpu_s.json"
"""File in which a moist run's first rank stores the processor time of each piece and of the checkpoint after it [s]."""
LOGS = (OUTPUT, LOG)
LAUNCH = re.compile(r"^srun: error: (.* launch failed: .*)", re.MULTILINE)
"""Message of srun about ranks that could not be started; messages about other killed ranks follow it."""
LARGEST_LOG = 50_000_000
"""Bytes of a log that indicate an engine in an endless output loop: a normal log has some hundred lines."""


def execute(
    command: list[str], folder: Path, scene: EngineScene, report: Report, watch: Callable[[], None] = lambda: None
) -> Usage:
    """Run the engine in `folder` to its end; `watch` is called a few times a second."""
    environment = surroundings(python=True) | {
        "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
        "OMPI_MCA_mpi_yield_when_idle": "1",  # the cores may be shared
        # within a job of SLURM mpirun starts its ranks itself: the srun that it would ask has to wait for the cores of the job
        "OMPI_MCA_plm": "isolated",
        "OMPI_MCA_ras": "^slurm",
    }

    def look() -> None:
        report(last_step(folder), scene.steps)
        _refuse_flood(folder, scene)
        watch()

    with child_data() as (named, data_of):
        try:
            status, usage = attend(command, folder, environment | named, look)
        except BaseException:
            for path in _too_large(folder):
                os.truncate(path, LARGEST_LOG)
            raise
        if status != 0:
            raise stopped(scene, folder, status, f" (all messages: {folder / OUTPUT})", data_of())
    return usage


def _too_large(folder: Path) -> list[Path]:
    """List the engine's logs that are larger than the allowed size."""
    paths = (folder / name for name in LOGS)
    return [path for path in paths if path.exists() and path.stat().st_size > LARGEST_LOG]


def _refuse_flood(folder: Path, scene: EngineScene) -> None:
    """End a run whose engine prints messages in an endless loop."""
    for path in _too_large(folder):
        with open(path, "rb") as log:
            message = log.read(4096).decode(errors="replace").strip().splitlines()
        raise StoppedRun(
            f"{scene.name}: LIGGGHTS was ended at step {last_step(folder)} of {scene.steps}: it wrote more than "
            f"{LARGEST_LOG // 10**6} MB into {path}, where a few hundred lines were expected; the first is: "
            f"{message[0][:200] if message else ''!r}",
            step=last_step(folder), code="engine.flood",
        )  # fmt: skip


def stopped(
    scene: EngineScene, folder: Path, returncode: int, more: str = "", data: Mapping[str, Any] | None = None
) -> StoppedRun:
    """Make the exception of a stopped engine from its output text and the data of its process; numbers are parsed here only."""
    launch = LAUNCH.search((folder / OUTPUT).read_text(errors="replace"))
    if launch:
        sentence = (
            f"{scene.name}: srun did not start all ranks ({launch[1]}); expected nodes that are machines of their own, since two "
            f"nodes on one machine do not start under PMIx: ask for one (simulate:nodes=1), or read slurmd's log on each{more}"
        )
        return StoppedRun(sentence, reason=launch[1], code="engine.not_launched")
    reason = _reason(folder, returncode)
    spheres = [int(n) for pair in re.findall(r"\bspheres? (\d+)(?: and (\d+))?", reason) for n in pair if n]
    step = re.search(r"\bstep (\d+)", reason)
    if "left the simulated box" in reason:
        where = departure(scene, folder, spheres[0] if spheres else None)
        reason += f"; {where}" if where else ""
    sentence = f"{scene.name}: LIGGGHTS stopped: {reason}{more}"
    at = int(step.group(1)) if step else None
    return StoppedRun(sentence, reason=reason, spheres=tuple(spheres), step=at, **(data or {}))


def _reason(folder: Path, returncode: int) -> str:
    """Return the engine's last messages, without positions in its source code."""
    text = last_words((folder / OUTPUT).read_text(errors="replace").splitlines(), returncode)
    text = re.sub(r"\s*\(\.\./\S+\)|\s*\(\S+\.(cpp|h):\d+\)", "", text)
    if "Lost atoms" in text:
        return f"spheres left the simulated box ({text}); {KEEP}"
    return text
