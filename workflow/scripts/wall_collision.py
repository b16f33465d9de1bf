"""The page of the wall collision."""

from pathlib import Path

from pywet import stages
from pywet.collisions.wall import page

with stages.logged(Path(snakemake.log[0])):
    page.write(Path(snakemake.output.page).parent)
