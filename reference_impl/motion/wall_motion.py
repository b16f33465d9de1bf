"""Motion of walls in a run, step by step as in the engine: vibration, slide, rotation."""

from __future__ import annotations

import numpy as np

from reference_impl.motion.window import RECORDED, Setup, Wall, slide_steps
from reference_impl.replay.arrays import Floats
from reference_impl.replay.script import Poses


class Motion:
    """Positions of the walls, computed step by step as in the engine: sums of time steps and of velocity times step.

    A closed form would differ by the rounding of these sums, 1e-12 of the time after 50,000 steps, which is
    visible in fast dashpots.
    """

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._total = round(setup.scene["duration_s"] / setup.step)
        self._sums: dict[str, Floats] = {}
        self._drawn = slide_steps(setup.scene)
        self._times: Floats | None = None
        self._poses = Poses(setup.folder) if any(w.motion == RECORDED for w in setup.walls) else None
        self._number = {wall.name: n for n, wall in enumerate(setup.walls)}

    def shift(self, wall: Wall, step: int | Floats) -> Floats:
        """Return the displacement of a translating mesh after `step` steps [m]; for several steps a row each."""
        if self._poses:
            found = self._poses.at(self._number[wall.name], step)["shift"]
            return found if np.ndim(step) else found[0]
        if wall.motion == "vibrates" and wall.way:
            return np.asarray(self._vibrated(wall)[step])
        if wall.name in self._drawn:
            opens, drawn = self._drawn[wall.name]
            speed = np.asarray(wall.way["velocity_m_per_s"], float)
            return np.asarray(speed * self._setup.step * (np.clip(step, opens, drawn) - opens)[..., None])
        return np.zeros((*np.shape(step), 3))

    def velocity(self, wall: Wall, step: int, points: Floats) -> Floats:
        """Return the velocity of points (n, 3) of a mesh in a step [m/s]; zero before the first step."""
        if self._poses:
            pose = self._pose(wall, step)
            return np.asarray(pose["velocity"] + np.cross(pose["spin"], points - pose["shift"]))
        found = np.zeros_like(points)
        if step == 0:
            return found
        if wall.motion == "vibrates" and wall.way:
            found += [self._speed(wall, axis, self._time()[step]) for axis in range(3)]
        elif wall.name in self._drawn:
            opens, drawn = self._drawn[wall.name]
            found += np.asarray(wall.way["velocity_m_per_s"], float) * (opens < step <= drawn)
        elif wall.motion == "turns" and wall.way:
            origin, axis, rate = _rotation(wall)
            found += rate * np.cross(axis, points - origin)
        return found

    def to_rest(self, wall: Wall, step: int, points: Floats) -> Floats:
        """Transform points (n, 3) to the rest frame of the mesh."""
        if self._poses:
            pose = self._pose(wall, step)
            return np.asarray((points - pose["shift"]) @ pose["turn"])
        if wall.motion == "turns" and wall.way:
            return self._turned(wall, points, -1.0, step)
        return points - self.shift(wall, step)

    def to_world(self, wall: Wall, step: int, points: Floats) -> Floats:
        """Transform points from the rest frame of the mesh to the world."""
        if self._poses:
            pose = self._pose(wall, step)
            return np.asarray(points @ pose["turn"].T + pose["shift"])
        if wall.motion == "turns" and wall.way:
            return self._turned(wall, points, 1.0, step)
        return points + self.shift(wall, step)

    def _pose(self, wall: Wall, step: int) -> dict[str, Floats]:
        """Return the logged pose with the rotation as a matrix."""
        assert self._poses
        row = {name: values[0] for name, values in self._poses.at(self._number[wall.name], step).items()}
        return {**row, "turn": np.stack([row[f"turn_{k}"] for k in range(3)])}

    def _turned(self, wall: Wall, points: Floats, sense: float, step: int) -> Floats:
        origin, axis, rate = _rotation(wall)
        angle = sense * rate * self._time()[step]
        d = points - origin
        along = (d @ axis)[:, None] * axis
        return np.asarray(origin + along + np.cos(angle) * (d - along) + np.sin(angle) * np.cross(axis, d))

    def _time(self) -> Floats:
        """Return the time after 0, 1, 2, … steps, summed as in the engine."""
        if self._times is None:
            self._times = np.concatenate([[0.0], np.cumsum(np.full(self._total + 1, self._setup.step))])
        return self._times

    @staticmethod
    def _speed(wall: Wall, axis: int, time: Floats) -> Floats:
        """Return the velocity along one axis: a w cos(w t + phase) [m/s]."""
        v, w = wall.way, 2.0 * np.pi * wall.way["frequency_Hz"]
        return np.asarray(v["amplitude_m"][axis] * w * np.cos(w * time + v["phase_rad"][axis]))

    def _vibrated(self, wall: Wall) -> Floats:
        """Return the displacement of a vibration after 0, 1, 2, … steps [m]."""
        name = repr(wall.way)  # computed once for all walls with this motion
        if name not in self._sums:
            found = self._sums[name] = np.zeros((len(self._time()), 3))
            for axis in range(3):  # each array is 100 MB in a long run
                way = self._speed(wall, axis, self._time())
                way[0] = 0.0
                way *= self._setup.step
                np.cumsum(way, out=found[:, axis])
        return self._sums[name]


def _rotation(wall: Wall) -> tuple[Floats, Floats, float]:
    axis = np.asarray(wall.way["axis"], float)
    return np.asarray(wall.way["origin_m"], float), axis / np.linalg.norm(axis), 2.0 * np.pi / wall.way["period_s"]
