"""Build the run directory of a case from the configuration."""

from pathlib import Path

from pywet import run_folder, stages

given = snakemake.params
run_dir = Path(snakemake.output.status).parent.parent


def build() -> None:
    config = stages.resolved(Path(given.config), given.preset, given.engine, given.seed)
    stages.build(config, given.number, given.scale, run_dir, given.engine)


with stages.logged(Path(snakemake.log[0])), run_folder.hold(run_dir):
    stages.attempt(run_dir, "scene", build)
