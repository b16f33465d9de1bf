"""One stage of a case that needs its run directory alone, by the name of its rule: results or vtk."""

from pathlib import Path

from pywet import stages

run_dir = Path(snakemake.output.status).parent.parent
with stages.logged(Path(snakemake.log[0])):
    stages.attempt(run_dir, snakemake.rule, lambda: getattr(stages, snakemake.rule)(run_dir))
