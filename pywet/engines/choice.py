"""Engines in which a scene can run, by name: supported features, and how each is started."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from pywet.errors import PywetError, one_line


@dataclass(frozen=True)
class Engine:
    """A program that runs prepared scenes."""

    name: str
    rolling: bool = True
    """Whether the engine has the scene's model of rolling resistance."""
    retires: bool = False
    """Whether the engine can remove spheres from a run."""
    parallel: bool = True
    """Whether the engine runs in more than one process."""

    def start(
        self, run_dir: Path, ranks: int, progress: bool, mpi: str, extend: Callable[..., object] | None = None
    ) -> None:
        """Run the prepared scene; `mpi`: command that starts the ranks (empty: mpirun); `extend`: see the driver of LIGGGHTS."""
        driver = import_module(f"pywet.engines.{self.name}.driver")
        given = {"ranks": ranks, "keep": True, "mpi": mpi, "extend": extend} if self.parallel else {}
        driver.run(run_dir, progress=progress, **given)


ENGINES = {
    engine.name: engine
    for engine in (
        Engine("liggghts", retires=True),
        Engine("yade", parallel=False),
        Engine("lammps", rolling=False, parallel=False),
    )
}


def chosen(name: str, ranks: int = 1) -> Engine:
    """Return the engine of that name; PywetError if unknown, or if it does not support the number of ranks."""
    if name not in ENGINES:
        raise PywetError(
            f"there is no engine {one_line(name) if name else '(empty)'}; expected {' or '.join(ENGINES)}",
            code="engine.unknown", given=name, expected=tuple(ENGINES),
        )  # fmt: skip
    if ranks > 1 and not ENGINES[name].parallel:
        raise PywetError(
            f"{ranks} ranks were asked for; expected 1, as the engine {name} runs in one process",
            code="engine.one_process", key="ranks", given=ranks, expected=1,
        )  # fmt: skip
    return ENGINES[name]


def refuse_fewer_cores(ranks: int, threads: int) -> None:
    """Refuse a job with fewer cores than configured ranks, because Snakemake caps `threads` without a message.

    Cores allocated by SLURM are counted too, because Snakemake counts only those of its own machine.
    """
    cores = max(threads, int(os.environ.get("SLURM_CPUS_PER_TASK", "1")))
    if cores < ranks:
        raise PywetError(
            f"ranks is {ranks}, but Snakemake gives this job {cores} core{'s' if cores > 1 else ''}; expected as many: call it "
            f"with --cores {ranks} or more, or set ranks: {cores}",
            code="engine.few_cores", key="ranks", given=ranks, expected=cores,
        )  # fmt: skip
