"""Build the run directory of a case from the configuration."""

from pathlib import Path

from pywet import stages
from pywet.runs import record

given = snakemake.params
run_dir = Path(snakemake.output.status).parent.parent


def build() -> None:
    config = stages.resolved(Path(given.config), given.preset, given.engine, given.seed)
    stages.build(config, given.number, given.scale, run_dir, given.engine)


with stages.logged(Path(snakemake.log[0])), record.held(run_dir, Path(snakemake.input.fingerprint).read_text()):
    stages.attempt(run_dir, "scene", build)
