"""Walls of one scene that move each in its own way, against closed forms; the replay moves them a second time."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pywet
from tests.cases.custom.conftest import beads

CUP: dict[str, Any] = {"inner_width_mm": 12, "height_mm": 14}
TOSS = {"amplitude_mm": (0, 0, 0.4), "frequency_Hz": 60}
SWAY = {"amplitude_mm": (0.5, 0, 0), "frequency_Hz": 40, "phase_deg": (90, 0, 0)}


def cup(name: str, x: float, **motion: Any) -> dict[str, Any]:
    return {"name": name, "vessel": {**CUP, "origin_mm": (x, 0, 0)}, **motion}


@pytest.mark.engine
def test_every_wall_has_its_motion(tmp_path: Path) -> None:
    """Two vibrations, two walls that move at different times (one across a checkpoint), two that turn, and beads in all cups."""
    walls = [
        cup("tossed", 0, vibrates=TOSS),
        cup("swayed", 40, vibrates=SWAY),
        cup("lifted", 80, moves={"velocity_m_per_s": (0, 0, 0.2), "from_s": 0.004, "for_s": 0.012}),
        cup("pushed", 120, moves={"velocity_m_per_s": (0, 0.3, 0), "from_s": 0.009, "for_s": 0.02}),
        cup("slow", 160, turns={"turns_per_minute": 60, "axis": (0, 0, 1), "origin_mm": (160, 0, 0)}),
        cup("quick", 200, turns={"turns_per_minute": 300, "axis": (0, 0, -1), "origin_mm": (200, 0, 0)}),
    ]
    at = [(x + dx, dy, 1.6) for x in range(0, 201, 40) for dx, dy in ((-2, -2), (2, 2))]
    entry = {"name": "beads", "material": "glass", "diameter_mm": 3, "at_mm": at}
    scene = pywet.Scene(
        **beads(spheres=[entry], walls=walls, liquid={"percent": 1}, duration_s=0.024, results={"checkpoints": 3})
    )
    run = pywet.run(scene, tmp_path)
    assert run.replay["ok"] and run.replay["newton"]["windows"]
    moved = run._run.mesh_motion
    dt = run.scene.time_step_s
    ways = {
        "tossed": lambda t: (0, 0, 4e-4 * math.sin(2 * math.pi * 60 * t)),
        "swayed": lambda t: (5e-4 * (math.cos(2 * math.pi * 40 * t) - 1), 0, 0),
        "lifted": lambda t: (0, 0, 0.2 * min(max(t - 0.004, 0), 0.012)),
        "pushed": lambda t: (0, 0.3 * min(max(t - 0.009, 0), 0.02), 0),
    }
    fastest = {"tossed": 0.16, "swayed": 0.13, "lifted": 0.2, "pushed": 0.3}
    for name, way in ways.items():
        rows = moved[moved["mesh"] == name]
        want = np.array([way(step * dt) for step in rows["step"]])
        # the engine moves walls in whole steps: the error is at most one and a half steps at the highest speed
        assert np.abs(rows[["dx", "dy", "dz"]].to_numpy() - want).max() < 1.5 * fastest[name] * dt
    last = run.trajectory[run.trajectory["step"] == run.trajectory["step"].max()]
    lowest = last.groupby((last["x"] + 0.02) // 0.04)["z"].min()
    assert lowest[2] > 0.0015 + 0.0024 - 2e-4  # above the floor of the cup, which has risen by 2.4 mm
