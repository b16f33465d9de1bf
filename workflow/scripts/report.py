"""The report on all cases, failed ones included."""

from pathlib import Path

from pywet import config, stages
from pywet.report import report

out = Path(snakemake.output.report)
with stages.logged(Path(snakemake.log[0])):
    report.write(
        config.load(Path(snakemake.params.config)),
        snakemake.params.scale,
        snakemake.params.cases,
        twins=snakemake.params.twins,
        folder=out.parent,
        template_dir=Path(snakemake.input.template).parent,
        picture=Path(snakemake.input.picture),
        out=out,
    )
