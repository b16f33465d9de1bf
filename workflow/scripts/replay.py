"""Recompute a moist case by the independent reference."""

from pathlib import Path

from pywet import stages

run_dir = Path(snakemake.output.status).parent.parent
with stages.logged(Path(snakemake.log[0])):
    stages.attempt(run_dir, "replay", lambda: stages.replay(run_dir))
