"""Positions of the walls of a run at an output step."""

from __future__ import annotations

import numpy as np

from pywet.runs.rundir import Floats, RunDir, rows_at
from pywet.scene import SCRIPTED, Rotation


def wall_corners(run: RunDir, step: int) -> Floats:
    """Return the corners of all triangles at one output step [m], shape (triangles, 3, 3)."""
    corners = run.corners_at_rest.copy()
    for name in dict.fromkeys(run.meshes):
        of_wall = run.meshes == name
        corners[of_wall] = moved(run, name, step, corners[of_wall])
    return corners


def moved(run: RunDir, mesh: str, step: int, points: Floats) -> Floats:
    """Return points (…, 3) of a mesh at the start where they are at one output step [m]; in a script's run by its pose."""
    if run.scene.name == SCRIPTED:
        poses = rows_at(run.poses, step)
        for _, pose in poses[poses["mesh"] == [wall.name for wall in run.scene.walls].index(mesh)].iterrows():
            shift, *turn = ([pose[f"{of}_{axis}"] for axis in "xyz"] for of in ("shift", "turn_0", "turn_1", "turn_2"))
            points = points @ np.array(turn).T + np.array(shift)
        return points
    if isinstance(way := run.scene.motions[mesh], Rotation):
        points = turned(points, way, step * run.scene.time_step_s)
    motion = rows_at(run.mesh_motion, step)
    return np.asarray(points + motion.loc[motion["mesh"] == mesh, ["dx", "dy", "dz"]].to_numpy(dtype=float).sum(axis=0))


def turned(points: Floats, how: Rotation, time: float) -> Floats:
    """Rotate points (…, 3) about an axis for a time."""
    axis = np.asarray(how.axis) / np.linalg.norm(how.axis)
    arm, angle = points - how.origin_m, 2.0 * np.pi * time / how.period_s
    along = (arm @ axis)[..., None] * axis
    return np.asarray(how.origin_m + along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(axis, arm))
