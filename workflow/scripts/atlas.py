"""Make the law atlas."""

from pathlib import Path

from pywet import stages
from pywet.evidence.atlas import page

with stages.logged(Path(snakemake.log[0])):
    page.write_page(Path(snakemake.output.page).parent, lambda what, share: print(f"{100 * share:3.0f} % {what}", flush=True))
