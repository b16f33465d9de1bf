"""Dry screening in both engines: runs of several seeds, for `pywet compare` and the table of agreement.

Rolling resistance is off in both engines: contacts are the programs' own. A seed is that of the initial arrangement
of the spheres, so both engines start from the same positions; contacts make the two trajectories independent within a
tenth of a second.
"""

from __future__ import annotations

from pathlib import Path

from pywet import stages
from pywet.cases.screening import cases
from pywet.cases.screening.results import write_results
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene


def prepare(config_dir: Path, case: int, scale: str, seed: int, run_dir: Path) -> EngineScene:
    """Prepare the case without rolling resistance, with this seed of the initial arrangement, and write the run directory."""
    return cases.build(stages.resolved(config_dir, engine="yade", seed=seed).without_rolling(), case, scale, run_dir)


def simulate(run_dir: Path, engine: str) -> None:
    """Run a prepared dry scene in an engine and write its tables of results."""
    stages.simulate(run_dir, 1, True, engine)
    write_results(RunDir(run_dir))
