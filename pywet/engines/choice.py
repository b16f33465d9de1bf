"""Engines in which a scene can run, by name: supported features, and how each is started."""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from pywet.errors import PywetError, one_line


@dataclass(frozen=True)
class Engine:
    """A program that runs prepared scenes."""

    name: str
    rolling: bool = True
    """Whether it has rolling resistance as the scene means it."""
    retires: bool = False
    """Whether it can take spheres out of a run."""
    parallel: bool = True
    """Whether it runs in more than one process."""

    def start(self, run_dir: Path, ranks: int, progress: bool, mpi: str) -> None:
        """Run the scene there; `mpi` are the words that start the ranks (empty: mpirun)."""
        driver = import_module(f"pywet.engines.{self.name}.driver")
        driver.run(run_dir, progress=progress, **({"ranks": ranks, "keep": True, "mpi": mpi} if self.parallel else {}))


ENGINES = {
    engine.name: engine
    for engine in (
        Engine("liggghts", retires=True),
        Engine("yade", parallel=False),
        Engine("lammps", rolling=False, parallel=False),
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
