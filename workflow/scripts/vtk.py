"""Time series of a case for ParaView."""

from pathlib import Path

from pywet import stages

run_dir = Path(snakemake.output.status).parent.parent
with stages.logged(Path(snakemake.log[0])):
    stages.attempt(run_dir, "vtk", lambda: stages.vtk(run_dir))
