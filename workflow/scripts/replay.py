"""Recompute a moist case by the independent reference."""

from pathlib import Path

from pywet import stages
from pywet.runs import second

run_dir = Path(snakemake.output.status).parent.parent


def replay() -> None:
    second.leave(run_dir, dict(snakemake.params.second))
    stages.replay(run_dir)


with stages.logged(Path(snakemake.log[0])):
    stages.attempt(run_dir, "replay", replay)
