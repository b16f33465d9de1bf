"""The template of a user's law, copied as a user would: its own test passes, and the engine gives what the law gives."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """A copy of the template elsewhere."""
    return Path(shutil.copytree(ROOT / "examples" / "plugin_template", tmp_path / "mine"))


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def test_the_test_of_the_template_passes(copied: Path) -> None:
    done = run(copied, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_my_capillary.py")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "4 passed" in done.stdout


@pytest.mark.engine
def test_the_engine_gives_the_law(copied: Path) -> None:
    done = run(copied, "run_two_spheres.py")
    assert done.returncode == 0, done.stdout + done.stderr
    rows = [line.split() for line in done.stdout.splitlines()[1:]]
    assert len(rows) == 5
    assert rows[-1][1] == "ruptured"
    for _, engine, python in rows[:-1]:
        assert float(engine) == pytest.approx(float(python), rel=1e-6)  # six digits printed


def test_it_publishes_what_it_holds() -> None:
    text = (ROOT / "examples" / "plugin_template" / "pyproject.toml").read_text()
    assert '[project.entry-points."pywet.laws"]' in text
    assert 'my_capillary = "my_capillary:my_capillary"' in text
