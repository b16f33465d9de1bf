"""Build the run directory of a case from the configuration."""

from pathlib import Path

from pywet import stages

given = snakemake.params
run_dir = Path(snakemake.output.status).parent.parent
with stages.logged(Path(snakemake.log[0])):
    stages.attempt(
        run_dir,
        "scene",
        lambda: stages.build(Path(given.config), given.number, given.scale, run_dir, given.preset, seed=given.seed),
    )
