"""The page of the table of agreement."""

from pathlib import Path

from pywet import stages
from pywet.evidence.agreement import page

with stages.logged(Path(snakemake.log[0])):
    page.write_page(Path(snakemake.output.page).parent)
