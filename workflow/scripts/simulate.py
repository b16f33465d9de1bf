"""Run the engine on a prepared case."""

from pathlib import Path

from pywet import run_folder, stages
from pywet.engines.choice import refuse_fewer_cores

ranks, engine, mpi = snakemake.params.ranks, snakemake.params.engine, snakemake.resources.get("mpi", "")
run_dir = Path(snakemake.output.status).parent.parent


def work() -> None:
    refuse_fewer_cores(ranks, snakemake.resources.tasks if mpi else snakemake.threads)
    stages.simulate(run_dir, ranks, progress=True, engine=engine, mpi=mpi)


with stages.logged(Path(snakemake.log[0])), run_folder.hold(run_dir):
    stages.attempt(run_dir, "simulate", work)
