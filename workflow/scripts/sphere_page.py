"""The page on sphere collisions."""

from pathlib import Path

from pywet import stages
from pywet.collisions.spheres import davis_page

with stages.logged(Path(snakemake.log[0])):
    davis_page.write_page(Path(snakemake.output.page).parent)
