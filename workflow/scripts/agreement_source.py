"""One source of the table of agreement."""

from pathlib import Path

from pywet import stages
from studies.cross_code import sources

with stages.logged(Path(snakemake.log[0])):
    sources.run_source(snakemake.params.source, Path(snakemake.output.data).parent.parent)
