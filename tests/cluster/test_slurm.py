"""The workflow on a real SLURM of this machine: jobs as configured, one ended at its time limit that goes on, a drained node."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pandas as pd
import pytest

from pywet.engines.liggghts import driver
from tests.cluster import local_slurm
from tests.cluster.local_slurm import Job, ask, jobs, until
from tests.engines.liggghts import beds

ROOT = Path(__file__).parent.parent.parent
RANKS = 2
pytestmark = [
    pytest.mark.slow,
    pytest.mark.engine,
    pytest.mark.skipif(bool(local_slurm.why_not()), reason=local_slurm.why_not() or ""),
]
SMALL = {"width_mm: {value: 50": "width_mm: {value: 40", "duration_s: {value: 1.6": "duration_s: {value: 0.1",
         "slide_opens_at_s: {value: 0.2": "slide_opens_at_s: {value: 0.05"}  # fmt: skip
"""The smoke scale, made smaller."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Copy the files of the workflow into a folder, with a smaller scale."""
    shutil.copy(ROOT / "Snakefile", tmp_path)
    for name in ("config", "workflow", "liggghts_inputs"):
        shutil.copytree(ROOT / name, tmp_path / name)
    scales, settings = (tmp_path / "config" / name for name in ("scales.yaml", "config.yaml"))
    text = scales.read_text()
    for given, instead in SMALL.items():
        text = text.replace(given, instead, 1)
    scales.write_text(text)
    settings.write_text(settings.read_text().replace("checkpoints: 20", "checkpoints: 4"))
    return tmp_path


def test_srun_starts_the_ranks_of_a_run(tmp_path: Path) -> None:
    """Two ranks started by `srun --mpi=pmix`: the very events and ways of the run that mpirun starts.

    On one node: two that are one machine cannot tell PMIx apart.
    """
    spheres, runs = beds.bed((4, 4, 3)), [tmp_path / "srun", tmp_path / "mpirun"]
    for run_dir in runs:
        beds.prepare(run_dir, spheres, 400)
    code = f"from pywet.engines.liggghts import driver; driver.run({str(runs[0])!r}, 2, progress=False, mpi='srun --mpi=pmix')"
    job = ["sbatch", "--wait", "--time=60", "--nodes=1", "--ntasks=2", f"--output={tmp_path}/job.log", "--wrap"]
    with local_slurm.running():
        done = subprocess.run(
            [*job, shlex.join([sys.executable, "-c", code])], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr + (tmp_path / "job.log").read_text()
    driver.run(runs[1], 2, progress=False)
    for name in ("history/events", "history/films", "trajectory"):
        one, two = (pd.read_parquet(run_dir / f"{name}.parquet") for run_dir in runs)
        assert len(one)
        pd.testing.assert_frame_equal(one, two, check_exact=True)


def _snakemake(folder: Path) -> subprocess.Popen[str]:
    """Three cases on the cluster, as docs/cluster.md says; there is no accounting database here to ask for states."""
    command = [
        sys.executable,
        "-m",
        "snakemake",
        "--profile",
        "workflow/profiles/slurm",
        "--slurm-status-command",
        "squeue",
    ]
    command += ["--slurm-init-seconds-before-status-checks", "2", "--seconds-between-status-checks", "2"]
    command += ["--config", "cases=[1,2,11]", f"ranks={RANKS}", "both_presets=false", "--"]
    command += [f"results/smoke/{case}/status/simulate.json" for case in ("case01", "case02", "case11")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with open(folder / "snakemake.log", "w") as log:
        return subprocess.Popen(command, cwd=folder, env=environment, stdout=log, stderr=log, text=True)


def _ranks_of(folder: Path) -> list[int]:
    """Processes of the engine that work on a run."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
            if "pywet.engines.liggghts.worker" in words and str(folder) in words and "mpirun" not in words[0]:
                found.append(int(entry.name))
    return found


def _simulating(case: str) -> list[Job]:
    return [job for job in jobs() if job.name == f"rule_simulate_wildcards_{case}"]


def _hang_until_killed(run_dir: Path, alive: subprocess.Popen[str]) -> tuple[Job, Job]:
    """Stop the ranks of case 2 once a checkpoint is whole, drain their node, let their limit pass; the job before and after."""
    until(
        lambda: [*run_dir.glob("engine.partial/checkpoint/sums.*.json")] or None,
        "a checkpoint",
        lambda: alive.poll() is None,
    )
    for rank in _ranks_of(run_dir):
        os.kill(rank, signal.SIGSTOP)
    job = _simulating("case02")[-1]
    assert job.state == "RUNNING" and run_dir.joinpath("engine.partial").exists()
    ask("scontrol", "update", f"NodeName={job.node}", "State=DRAIN", "Reason=test")
    ask("scontrol", "update", f"JobId={job.number}", "EndTime=now")
    killed = until(
        lambda: next((j for j in _simulating("case02") if j.state == "TIMEOUT"), None), "the end of the hanging job"
    )
    return job, killed


def test_killed_job_is_submitted_again_and_goes_on_while_a_node_is_drained(folder: Path) -> None:
    """Three cases with two ranks. The node that is drained gets no job any more; the job ended at its limit gets twice the
    time and memory on the other, resumes from its checkpoint and ends with the very events of a run that was left alone."""
    run_dir = folder / "results" / "smoke" / "case02"
    with local_slurm.running():
        snakemake = _snakemake(folder)
        try:
            asked, killed = _hang_until_killed(run_dir, snakemake)
            before = max(job.number for job in jobs())
            status = snakemake.wait(local_slurm.PATIENCE_S)
            table = jobs()
            print(*table, sep="\n")
            assert status == 0, (folder / "snakemake.log").read_text()
        finally:
            snakemake.terminate()
            snakemake.wait()
    again = [job for job in table if job.name == killed.name][-1]
    assert (killed.state, again.state, killed.cores, again.cores) == ("TIMEOUT", "COMPLETED", RANKS, RANKS)
    assert again.minutes == 2 * asked.minutes
    assert {job.state for job in table if job != killed} == {"COMPLETED"}
    assert len(table) == 7 and not any(job.node == killed.node for job in table if job.number > before)
    info = json.loads((run_dir / "engine" / "run.json").read_text())
    assert info["ranks"] == RANKS and info["resumed_at_step"] > 0

    alone = folder / "alone"
    shutil.copytree(run_dir, alone, ignore=shutil.ignore_patterns("engine*", "status"))
    driver.run(alone, RANKS, progress=False)
    for name in ("history/events", "history/films", "trajectory"):
        pd.testing.assert_frame_equal(
            pd.read_parquet(run_dir / f"{name}.parquet"), pd.read_parquet(alone / f"{name}.parquet"), check_exact=True
        )


def test_a_sweep_is_jobs_of_the_cluster(folder: Path) -> None:
    """Four drums, a job each, with memory and time of their prediction; the page and the verdict are made here."""
    shutil.copytree(ROOT / "examples" / "sweeps", folder / "sweeps")
    drum = folder / "sweeps" / "small_drum.yaml"
    text = drum.read_text().replace("[0.02, 0.035, 0.05, 0.07]", "[0.02, 0.07]")
    drum.write_text(text.replace("{logspace: [1.0e-3, 1.0e-2, 3]}", "[1.0e-3]"))
    command = [
        sys.executable,
        "-m",
        "snakemake",
        "--profile",
        "workflow/profiles/slurm",
        "--slurm-status-command",
        "squeue",
    ]
    command += ["--slurm-init-seconds-before-status-checks", "2", "--seconds-between-status-checks", "2"]
    command += ["sweep", "--config", "sweep=sweeps/small_drum.yaml"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with local_slurm.running():
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        table = [job for job in jobs() if job.name.startswith("rule_sweep_run")]
    assert len(table) == 4 and {job.state for job in table} == {"COMPLETED"}
    made = pd.read_parquet(folder / "results" / "sweeps" / "small_drum" / "sweep.parquet")
    assert made["status"].tolist() == ["done"] * 4 and made["ruptures"].gt(0).all()
