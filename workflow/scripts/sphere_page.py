"""The page on sphere collisions."""

from pathlib import Path

from pywet import stages
from pywet.collisions.spheres import page

with stages.logged(Path(snakemake.log[0])):
    page.write(Path(snakemake.output.page).parent)
