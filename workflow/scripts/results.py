"""Fraction retained, liquid by holder, checks and summary of a case."""

from pathlib import Path

from pywet import stages

run_dir = Path(snakemake.output.status).parent.parent
with stages.logged(Path(snakemake.log[0])):
    stages.attempt(run_dir, "results", lambda: stages.results(run_dir))
