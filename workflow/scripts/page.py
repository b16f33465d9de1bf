"""A page, by its module, from what the rules before it left in its folder."""

from importlib import import_module
from pathlib import Path

from pywet import stages

with stages.logged(Path(snakemake.log[0])):
    import_module(snakemake.params.module).write_page(Path(snakemake.output.page).parent)
