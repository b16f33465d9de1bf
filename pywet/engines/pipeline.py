"""A run of any engine in three stages: `prepare` (in the engine's driver) -> Job, `simulate` -> Raw, `collect` -> tables.

Everything is written into `engine.partial` first and published when the run is complete, so that a failed run never
looks like a finished one.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pywet.engines.liggghts import collecting
from pywet.engines.liggghts.checkpoint import last_step
from pywet.engines.liggghts.inputs import write_inputs
from pywet.engines.process import OUTPUT, attend, last_words, progress_bar, surroundings
from pywet.engines.run_store import RunStore, fingerprint
from pywet.errors import NotWhole, StoppedRun
from pywet.runs import tables
from pywet.scene import EngineScene
from pywet.util.files import read_table
from pywet.util.notices import notice


@dataclass(frozen=True)
class RunInfo:
    """Result of the engine's run, also written to engine/run.json."""

    wall_s: float
    steps: int
    spheres: int
    ranks: int
    engine_version: str
    plugin_hash: str | None
    resumed_at_step: int | None
    """Step of the checkpoint from which this run resumed; None if it started from the beginning. `wall_s` counts from there."""
    ledger_error: float | None
    """|Σ films + Σ bridges + Σ walls + left − initial| / initial, the largest over all outputs; None for a dry run."""
    engine: str = "LIGGGHTS"
    cpu_s: float = 0.0
    """Processor time of the engine's process (with more ranks: of all of them)."""
    loop_cpu_s: float | None = None
    """Processor time of the time steps alone, without Python's start and the compilation of laws; None if not known."""
    peak_memory_B: int | None = None
    """Largest resident memory of the engine's process (not known for several ranks)."""


@dataclass(frozen=True)
class Job:
    """A prepared scene: what is to be run, by which program, and where its files go."""

    scene: EngineScene
    store: RunStore
    engine: str
    version: str
    plugin: Path | None
    ranks: int = 1
    progress: bool = True
    mpi: str = ""
    extra: tuple[str, ...] = ()
    """Lines of the script for driven small scenes (two bodies at constant speed)."""
    integrate: str = "all"
    """Group of spheres that the engine moves."""

    @classmethod
    def of(cls, scene: EngineScene, run_dir: Path, engine: str, version: str, plugin: Path | None, **more: Any) -> Job:
        """Write the inputs that plugin and replay read in addition to the scene, and return the job."""
        parts = (version, plugin.name if plugin else "", *more.get("extra", ()), more.get("integrate", "all"))
        store = RunStore(run_dir, fingerprint(run_dir, scene, *parts))
        write_inputs(scene, run_dir)
        return cls(scene, store, engine, version, plugin, **more)


@dataclass(frozen=True)
class Raw:
    """A job whose engine has finished: its raw logs are in the store, `account` has its times and memory."""

    job: Job
    account: dict[str, Any]


def simulate(job: Job, write: Callable[[Path], object], command: Sequence[str], code: str) -> Raw:
    """Run an engine without checkpoints from the start; `write` writes its script, `code` is that of the error if it stops."""
    scene, store = job.scene, job.store
    if store.partial.exists():
        notice.warning(
            f"{store.partial} holds a run in {job.engine} that was stopped; {job.engine} has no checkpoints: it starts again"
        )
    with store.new() as folder:
        write(folder)
    started = time.monotonic()
    with progress_bar(scene, job.progress) as report:
        status, usage = attend(
            [*command, str(store.run_dir), str(store.partial)], store.partial, surroundings(python=True),
            lambda: report(last_step(store.partial), scene.steps),
        )  # fmt: skip
    if status != 0:
        output = store.partial / OUTPUT
        reason = last_words(output.read_text(errors="replace").splitlines(), status)
        raise StoppedRun(
            f"{scene.name}: {job.engine} stopped: {reason} (all messages: {output})", reason=reason, code=code
        )
    times = {"wall_s": time.monotonic() - started, "cpu_s": usage.cpu_s, "peak_memory_B": usage.peak_memory_B}
    return Raw(job, {**times, "ranks": 1, "resumed_at_step": None})


def collect(raw: Raw) -> RunInfo:
    """Convert the raw logs into tables and publish the run."""
    job, store = raw.job, raw.job.store
    store.drop_tables()
    try:
        spheres = collecting.make(job.scene, store.partial, store.put)
    except NotWhole:
        store.disown()
        raise
    moist = job.scene.effects.bridges
    error = tables.ledger_error(read_table(store.made / "history" / "ledger.parquet")) if moist else None
    info = RunInfo(
        steps=job.scene.steps, spheres=spheres, engine=job.engine, engine_version=job.version,
        plugin_hash=job.plugin.stem.rpartition("-")[2] if job.plugin else None, ledger_error=error, **raw.account,
    )  # fmt: skip
    store.publish(asdict(info))
    return info
