"""Figures over the Stokes number and the impact angle."""

from pathlib import Path

from pywet import stages
from pywet.collisions.spheres import davis_figures

with stages.logged(Path(snakemake.log[0])):
    davis_figures.over_stokes(Path(snakemake.output.figures[0]).parent, snakemake.params.grid, snakemake.threads)
