"""One dry run of one engine with one seed, and its table of results."""

from pathlib import Path

from pywet import stages
from studies.engines import screening

run_dir = Path(snakemake.output.table).parent.parent
with stages.logged(Path(snakemake.log[0]), echo=True):
    screening.prepare(
        Path(snakemake.params.config),
        snakemake.params.case,
        snakemake.params.scale,
        int(snakemake.wildcards.seed),
        run_dir,
    )
    screening.simulate(run_dir, snakemake.wildcards.engine)
