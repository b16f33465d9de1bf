"""Start LIGGGHTS, monitor its output, and report in one sentence why it stopped."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pywet.engines.liggghts.checkpoint import LOG, last_step, latest
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
"""Bytes of a log since the latest checkpoint that indicate an engine in an endless output loop: normal are some hundred lines."""


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

    sizes = _Sizes(folder)

    def look() -> None:
        report(last_step(folder), scene.steps)
        sizes.refuse_flood(scene)
        watch()

    with child_data() as (named, data_of):
        try:
            status, usage = attend(command, folder, environment | named, look)
        except BaseException:
            for path, allowed in sizes.too_large():
                os.truncate(path, allowed)
            raise
        if status != 0:
            raise stopped(scene, folder, status, f" (all messages: {folder / OUTPUT})", data_of())
    return usage


class _Sizes:
    """Sizes of the engine's logs at its latest checkpoint: each adds the messages of a set-up to them."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.step = folder, latest(folder)
        self.then = dict.fromkeys((folder / name for name in LOGS), 0)

    def too_large(self) -> list[tuple[Path, int]]:
        """List the logs that are larger than allowed, with the allowed sizes."""
        if (step := latest(self.folder)) > self.step:
            self.step, self.then = step, {path: _size(path) for path in self.then}
        return [(path, then + LARGEST_LOG) for path, then in self.then.items() if _size(path) > then + LARGEST_LOG]

    def refuse_flood(self, scene: EngineScene) -> None:
        """End a run whose engine prints messages in an endless loop."""
        for path, allowed in self.too_large():
            with open(path, "rb") as log:
                log.seek(allowed - LARGEST_LOG)
                message = log.read(4096).decode(errors="replace").strip().splitlines()
            at = last_step(self.folder)
            raise StoppedRun(
                f"{scene.name}: LIGGGHTS was ended at step {at} of {scene.steps}: it wrote more than "
                f"{LARGEST_LOG // 10**6} MB into {path}, where a few hundred lines were expected; the first is: "
                f"{message[0][:200] if message else ''!r}",
                step=at, code="engine.flood",
            )  # fmt: skip


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


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
