"""The engines that a scene can be run in, by name: what each can do, and how it is started."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pywet.errors import PywetError, one_line


@dataclass(frozen=True)
class Engine:
    """A program that runs prepared scenes. `start` is given run directory, ranks, whether to show progress, and the words that
    start the ranks (empty: mpirun)."""

    name: str
    start: Callable[[Path, int, bool, str], object]
    rolling: bool = True
    """Whether it has rolling resistance as the scene means it."""
    parallel: bool = True
    """Whether it runs in more than one process."""


def _liggghts(run_dir: Path, ranks: int, progress: bool, mpi: str) -> None:
    from pywet.engines.liggghts import driver

    driver.run(run_dir, ranks, progress, keep=True, mpi=mpi)


def _yade(run_dir: Path, ranks: int, progress: bool, mpi: str) -> None:
    from pywet.engines.yade import driver

    driver.run(run_dir, progress)


def _lammps(run_dir: Path, ranks: int, progress: bool, mpi: str) -> None:
    from pywet.engines.lammps import driver

    driver.run(run_dir, ranks, progress)


ENGINES = {
    engine.name: engine
    for engine in (
        Engine("liggghts", _liggghts),
        Engine("yade", _yade, rolling=False, parallel=False),
        Engine("lammps", _lammps, rolling=False, parallel=False),
    )
}


def chosen(name: str, ranks: int = 1) -> Engine:
    """The engine of that name; PywetError where there is none, or more ranks are asked for than it can have."""
    if name not in ENGINES:
        raise PywetError(f"there is no engine {one_line(name) if name else '(empty)'}; expected {' or '.join(ENGINES)}")
    if ranks > 1 and not ENGINES[name].parallel:
        raise PywetError(f"{ranks} ranks were asked for; expected 1, as the engine {name} runs in one process")
    return ENGINES[name]


def refuse_fewer_cores(ranks: int, threads: int) -> None:
    """Refuse a job that was given fewer cores than ranks are configured: Snakemake caps `threads` at the cores it has, and
    says nothing. What SLURM gave counts as well: Snakemake's own count is of the machine it looks at."""
    cores = max(threads, int(os.environ.get("SLURM_CPUS_PER_TASK", "1")))
    if cores < ranks:
        raise PywetError(
            f"ranks is {ranks}, but Snakemake gives this job {cores} core{'s' if cores > 1 else ''}; expected as many: call it "
            f"with --cores {ranks} or more, or set ranks: {cores}"
        )
