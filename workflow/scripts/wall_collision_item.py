"""One figure or table of the wall collision."""

from pathlib import Path

from pywet import stages
from pywet.collisions.wall import page

out = Path(snakemake.output.table)
with stages.logged(Path(snakemake.log[0])):
    page.make(snakemake.params.item, out.parent)
