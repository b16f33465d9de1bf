"""Figures that follow single collisions of wet spheres, and what accuracy costs."""

import tempfile
from pathlib import Path

from pywet import stages
from pywet.collisions.spheres import cost, engine, plots

folder = Path(snakemake.output.figures[0]).parent
with stages.logged(Path(snakemake.log[0])):
    plots.single_collisions(folder)
    cost.write(folder)
    with tempfile.TemporaryDirectory() as work:
        engine.compare(folder, Path(work))
