"""Figures that follow single collisions of wet spheres, and what accuracy costs."""

import tempfile
from pathlib import Path

from pywet import stages
from pywet.collisions.spheres import accuracy_cost, davis_figures, engine

folder = Path(snakemake.output.figures[0]).parent
with stages.logged(Path(snakemake.log[0])):
    davis_figures.single_collisions(folder)
    accuracy_cost.write_accuracy_cost(folder)
    with tempfile.TemporaryDirectory() as work:
        engine.compare(folder, Path(work))
