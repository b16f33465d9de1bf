"""The page of the wall collision."""

from pathlib import Path

from pywet import stages
from pywet.collisions.wall import buck_page

with stages.logged(Path(snakemake.log[0])):
    buck_page.write_page(Path(snakemake.output.page).parent)
