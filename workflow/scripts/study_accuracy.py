"""Table and page of the accuracy study."""

from pathlib import Path

from pywet import stages
from pywet.evidence.accuracy import command

with stages.logged(Path(snakemake.log[0])):
    command.show(Path(snakemake.output.mark).parents[2], snakemake.params.size, Path(snakemake.params.config))
