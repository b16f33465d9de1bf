"""One figure or table of the wall collision."""

from pathlib import Path

from pywet import stages
from pywet.collisions.wall import buck_page

out = Path(snakemake.output.table)
with stages.logged(Path(snakemake.log[0])):
    buck_page.write_item(snakemake.params.item, out.parent)
