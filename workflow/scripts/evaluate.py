"""Results, replay and files for ParaView of a case, in one process, which loads their libraries once."""

from pathlib import Path

from pywet import run_folder, stages
from pywet.runs import record

run_dir = Path(snakemake.output.results).parent.parent


def replay() -> None:
    record.leave_reference(run_dir, dict(snakemake.params.second))
    stages.replay(run_dir)


with stages.logged(Path(snakemake.log[0])), run_folder.hold(run_dir, shared=True):
    stages.attempt(run_dir, "results", lambda: stages.results(run_dir))
    stages.attempt(run_dir, "replay", replay)
    stages.attempt(run_dir, "vtk", lambda: stages.vtk(run_dir))
