"""The workflow: it plans before anything is built, its lint finding is the one answered, a failed case stops nothing else."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of what the workflow is made of, without any result."""
    shutil.copy(ROOT / "Snakefile", tmp_path)
    for name in ("config", "workflow", "liggghts_inputs"):
        shutil.copytree(ROOT / name, tmp_path / name)
    return tmp_path


def _snakemake(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(folder / "cache")}
    command = [sys.executable, "-m", "snakemake", "--cores", "2", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def _jobs(text: str) -> dict[str, int]:
    """Rule -> number of jobs in the job statistics."""
    return {name: int(count) for name, count in re.findall(r"^(\w+) +(\d+)$", text, flags=re.MULTILINE)}


def test_dry_run_plans_all_cases_before_anything_is_built(folder: Path) -> None:
    done = _snakemake(folder, "-n")
    assert done.returncode == 0, done.stderr
    per_case = dict.fromkeys(("scene", "simulate", "replay", "results", "vtk"), 19)  # 18 and one with preset exact
    assert _jobs(done.stdout + done.stderr) == {
        **per_case,
        "picture": 1,
        "report": 1,
        "verdict": 1,
        "all": 1,
        "total": 99,
    }
    assert not (folder / "results").exists()


def test_scale_and_cases_are_chosen_on_the_command_line(folder: Path) -> None:
    done = _snakemake(folder, "-n", "--config", "scale=reduced", "cases=[2,11]")
    text = done.stdout + done.stderr
    assert done.returncode == 0, text
    assert _jobs(text)["simulate"] == 3  # both, and case 2 with preset exact
    assert "results/reduced/case11/status/simulate.json" in text
    assert "results/smoke" not in text


@pytest.mark.parametrize(
    ("choice", "said"),
    [
        ("scale=huge", "there is no scale huge"),
        ("cases=[99]", "there is no case 99"),
        ("ranks=0", "0 is less than the minimum of 1"),
    ],
)
def test_a_wrong_choice_is_refused_before_any_job(folder: Path, choice: str, said: str) -> None:
    done = _snakemake(folder, "-n", "--config", choice)
    assert done.returncode != 0
    assert said in done.stdout + done.stderr


def test_lint_finds_only_what_the_snakefile_answers(folder: Path) -> None:
    done = _snakemake(folder, "--lint")
    findings = {line.strip() for line in (done.stdout + done.stderr).splitlines() if line.startswith("    * ")}
    assert findings <= {"* Specify a conda environment or container for each rule.:"}
    assert "asks for a conda environment or a container" in (folder / "Snakefile").read_text()


def test_failed_cases_stop_nothing_are_reported_and_tried_again(folder: Path) -> None:
    # A feed bin of 20 mm cannot hold the feed: every scene fails, in seconds and without the engine.
    scales = folder / "config" / "scales.yaml"
    text = scales.read_text()
    scales.write_text(text.replace("feed_bin_height_mm: {value: 120", "feed_bin_height_mm: {value: 20"))
    done = _snakemake(folder, "--config", "cases=[1,2]")
    assert done.returncode != 0
    assert "case01: stage scene failed: feed bin:" in done.stderr
    assert "case02: stage scene failed: feed bin:" in done.stderr
    report = (folder / "results" / "smoke" / "report.html").read_text()
    assert "0 of 2" in report
    assert "stage scene failed: feed bin:" in report
    again = _snakemake(folder, "-n", "--config", "cases=[1,2]")
    assert _jobs(again.stdout + again.stderr)["scene"] == 3  # the twin of case 2 as well
