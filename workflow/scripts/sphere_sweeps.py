"""Figures over the Stokes number and the impact angle."""

from pathlib import Path

from pywet import stages
from pywet.collisions.spheres import sweeps

with stages.logged(Path(snakemake.log[0])):
    sweeps.sweeps(Path(snakemake.output.figures[0]).parent, snakemake.params.grid, snakemake.threads)
