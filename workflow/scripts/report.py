"""The report on all cases, failed ones included."""

from pathlib import Path

from pywet import config, stages
from pywet.errors import PywetError
from pywet.report import report
from reference_impl.shown import report as shown

out = Path(snakemake.output.report)
with stages.logged(Path(snakemake.log[0])):
    report.write(
        config.load(Path(snakemake.params.config)),
        snakemake.params.scale,
        snakemake.params.cases,
        comparisons=snakemake.params.comparisons,
        folder=out.parent,
        template_dir=Path(snakemake.input.template).parent,
        picture=Path(snakemake.input.picture),
        out=out,
    )
    read = shown.check(out, Path(snakemake.params.config) / "cases.csv")
    print(shown.summary(read))
    if read.faults:
        raise PywetError(f"{out} does not show what the tables hold: {'; '.join(read.faults)}")
