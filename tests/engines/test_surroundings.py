"""The environment of an engine: a run of one rank within a step of SLURM is no rank that srun has started."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from pywet.engines.process import surroundings

STEP = {"SLURM_NODELIST": "first", "SLURM_JOBID": "1", "SLURM_JOB_ID": "1", "SLURM_STEP_ID": "0", "SLURM_STEPID": "0"}
"""What a process of a job's step finds: Open MPI asks SLURM for its rank then, and ends where SLURM's PMI is not its own."""


@pytest.mark.engine
def test_an_engine_of_one_rank_starts_within_a_step_of_slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in STEP.items():
        monkeypatch.setenv(name, value)
    (tmp_path / "in.liggghts").write_text("units si\n")
    command = ["liggghts", "-in", "in.liggghts"]
    done = subprocess.run(command, cwd=tmp_path, env=surroundings(), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert surroundings()["SLURM_JOB_ID"] == "1" and "SLURM_STEP_ID" not in surroundings(python=True)
