"""Positions of the walls of a run at an output step."""

from __future__ import annotations

import numpy as np

from pywet.runs.rundir import Floats, RunDir, rows_at
from pywet.scene import SCRIPTED, Rotation


def wall_corners(run: RunDir, step: int) -> Floats:
    """Return the corners of all triangles at one output step [m], shape (triangles, 3, 3)."""
    corners = run.corners_at_rest.copy()
    if run.scene.name == SCRIPTED:
        return _by_poses(run, step, corners)
    motion = rows_at(run.mesh_motion, step)
    shift = np.zeros((len(corners), 3))
    for name, *by in motion[["mesh", "dx", "dy", "dz"]].itertuples(index=False):
        shift[run.meshes == name] = by
    for name, way in run.scene.motions.items():
        if isinstance(way, Rotation):
            of_wall = run.meshes == name
            corners[of_wall] = turned(corners[of_wall], way, step * run.scene.time_step_s)
    return np.asarray(corners + shift[:, None, :])


def _by_poses(run: RunDir, step: int, corners: Floats) -> Floats:
    """Return the corners of the meshes of a script's run at the positions in the engine."""
    at = corners.copy()
    for _, pose in run.poses[run.poses["step"] == step].iterrows():
        rows = run.meshes == run.scene.walls[int(pose["mesh"])].name
        shift, *turn = ([pose[f"{of}_{axis}"] for axis in "xyz"] for of in ("shift", "turn_0", "turn_1", "turn_2"))
        at[rows] = corners[rows] @ np.array(turn).T + np.array(shift)
    return np.asarray(at)


def turned(points: Floats, how: Rotation, time: float) -> Floats:
    """Rotate points (…, 3) about an axis for a time."""
    axis = np.asarray(how.axis) / np.linalg.norm(how.axis)
    arm, angle = points - how.origin_m, 2.0 * np.pi * time / how.period_s
    along = (arm @ axis)[..., None] * axis
    return np.asarray(how.origin_m + along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(axis, arm))
