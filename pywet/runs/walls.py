"""Positions of the walls of a run at an output step."""

from __future__ import annotations

import numpy as np

from pywet.runs.rundir import Floats, RunDir
from pywet.scene import Rotation


def wall_corners(run: RunDir, step: int) -> Floats:
    """Corners of all triangles at one output step [m], shape (triangles, 3, 3)."""
    table = run.triangles
    names = [f"v{n}_{axis}" for n in range(3) for axis in "xyz"]
    corners = table[names].to_numpy(dtype=float, copy=True).reshape(-1, 3, 3)
    motion = run.mesh_motion[run.mesh_motion["step"] == step].set_index("mesh")
    shift = motion[["dx", "dy", "dz"]].reindex(table["mesh"]).fillna(0.0)
    for wall in run.scene.walls:
        way = run.scene.motion_of(wall)
        if isinstance(way, Rotation):
            own = (table["mesh"] == wall.name).to_numpy()
            corners[own] = turned(corners[own], way, step * run.scene.time_step_s)
    return np.asarray(corners + shift.to_numpy(dtype=float)[:, None, :])


def turned(points: Floats, how: Rotation, time: float) -> Floats:
    """Points (…, 3) after some time of turning about an axis."""
    axis = np.asarray(how.axis) / np.linalg.norm(how.axis)
    arm, angle = points - how.origin_m, 2.0 * np.pi * time / how.period_s
    along = (arm @ axis)[..., None] * axis
    return np.asarray(how.origin_m + along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(axis, arm))
