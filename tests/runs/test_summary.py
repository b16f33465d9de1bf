"""Energies that a dry run's summary tells from its trajectory alone."""

from __future__ import annotations

import math
import subprocess
from pathlib import Path

import pytest

from pywet.runs import summary
from pywet.runs.rundir import RunDir
from pywet.util.files import write_table
from tests.cases.screening import synthetic


def test_energies_of_a_dry_run(tmp_path: Path) -> None:
    """Three spheres of which the large one turns at 30/s at the end: m v²/2 and (2/5) m r² w²/2 by hand."""
    folder = synthetic.make(tmp_path / "run", moist=False)
    at = synthetic._trajectory()
    at.loc[(at["step"] == at["step"].max()) & (at["id"] == 1), ["wx", "wz"]] = 18.0, 24.0
    write_table(at, folder / "trajectory.parquet")
    large, small = (1400.0 * 4.0 / 3.0 * math.pi * r**3 for r in (4e-3, 2e-3))
    reported = summary.general(RunDir(folder))["energy_J"]
    assert reported["spin"] == pytest.approx(0.5 * 0.4 * large * 4e-3**2 * 30.0**2, rel=1e-12)
    assert reported["kinetic"] == pytest.approx(0.5 * (large + 2 * small) * 0.1**2, rel=1e-12)


@pytest.mark.parametrize(("status", "expected"), [(0, "abc1234"), (1, "")])
def test_the_commit_is_what_git_describes(monkeypatch: pytest.MonkeyPatch, status: int, expected: str) -> None:
    """Expect nothing outside a checkout, where git ends with another status."""
    done = subprocess.CompletedProcess([], status, stdout="abc1234\n")
    monkeypatch.setattr(summary.shutil, "which", lambda name: "git")
    monkeypatch.setattr(summary.subprocess, "run", lambda *words, **named: done)
    assert summary.commit() == expected
