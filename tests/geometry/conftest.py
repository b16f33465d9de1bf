"""Apparatuses of the smoke and full scale, built once, and a runner for the stock engine."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from pywet.geometry import Apparatus, ApparatusSpec, build_apparatus

SPECS = {
    "square_8": ApparatusSpec(0.008, 0.002, "square", 0.050, wire_sides=6),
    "square_5.6": ApparatusSpec(0.0056, 0.0016, "square", 7 * 0.0072, wire_sides=6),
    "cylinder_8": ApparatusSpec(0.008, 0.002, "cylinder", 0.200),
    "cylinder_5.6": ApparatusSpec(0.0056, 0.0016, "cylinder", 0.200),
}


@pytest.fixture(scope="session", params=list(SPECS))
def spec(request: pytest.FixtureRequest) -> ApparatusSpec:
    return SPECS[request.param]


@pytest.fixture(scope="session")
def apparatus(spec: ApparatusSpec) -> Apparatus:
    return build_apparatus(spec)


@pytest.fixture
def liggghts(tmp_path: Path) -> Callable[[str], str]:
    """Run a deck in tmp_path with the stock engine; returns what it printed, fails with its last words."""

    def run(deck: str) -> str:
        (tmp_path / "in.liggghts").write_text(deck)
        done = subprocess.run(
            ["liggghts", "-in", "in.liggghts", "-screen", "screen.txt", "-log", "log.txt"],
            cwd=tmp_path,
            capture_output=True,
            timeout=120,
        )
        printed = (tmp_path / "screen.txt").read_text()
        assert done.returncode == 0, printed[-2000:]
        return printed

    return run
