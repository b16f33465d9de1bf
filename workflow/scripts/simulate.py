"""Run the engine on a prepared case."""

from pathlib import Path

from pywet import stages

run_dir = Path(snakemake.output.status).parent.parent
with stages.logged(Path(snakemake.log[0])):
    stages.attempt(run_dir, "simulate", lambda: stages.simulate(run_dir, ranks=snakemake.threads, progress=True))
