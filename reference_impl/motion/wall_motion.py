"""How walls move in a run, step by step as the engine moves them: vibration, slide, turning."""

from __future__ import annotations

import numpy as np

from reference_impl.motion.window import Setup, Wall, slide_steps
from reference_impl.replay.compare import Floats


class Motion:
    """Where walls are, step by step as the engine moves them: time is a sum of steps, a place a sum of velocity times step.

    A closed form differs by the rounding of these sums, 1e-12 of the time after 50,000 steps, which shows in fast dashpots.
    """

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._total = round(setup.scene["duration_s"] / setup.step)
        self._sums: tuple[Floats, Floats] | None = None
        self._times: Floats | None = None

    def shift(self, wall: Wall, step: int) -> Floats:
        """Displacement of a translating mesh after `step` steps [m]."""
        scene, dt = self._setup.scene, self._setup.step
        if wall.motion == "vibrates" and scene["vibration"]:
            return np.asarray(self._vibrated()[1][step])
        if wall.motion == "slides" and scene["slide"]:
            opens, drawn = slide_steps(scene, dt, self._total)
            return np.asarray(scene["slide"]["velocity_m_per_s"], float) * dt * (np.clip(step, opens, drawn) - opens)
        return np.zeros(3)

    def velocity(self, wall: Wall, step: int, points: Floats) -> Floats:
        """Velocity of points (n, 3) of a mesh in a step [m/s]; at rest before the first step."""
        scene, dt = self._setup.scene, self._setup.step
        found = np.zeros_like(points)
        if step == 0:
            return found
        if wall.motion == "vibrates" and scene["vibration"]:
            found += self._vibrated()[0][step]
        elif wall.motion == "slides" and scene["slide"]:
            opens, drawn = slide_steps(scene, dt, self._total)
            found += np.asarray(scene["slide"]["velocity_m_per_s"], float) * (opens < step <= drawn)
        elif wall.motion == "turns" and scene["rotation"]:
            origin, axis, rate = self._rotation()
            found += rate * np.cross(axis, points - origin)
        return found

    def to_rest(self, wall: Wall, step: int, points: Floats) -> Floats:
        """Points (n, 3) as the mesh at rest would see them."""
        if wall.motion == "turns" and self._setup.scene["rotation"]:
            return self._turned(points, -1.0, step)
        return points - self.shift(wall, step)

    def to_world(self, wall: Wall, step: int, points: Floats) -> Floats:
        """The way back."""
        if wall.motion == "turns" and self._setup.scene["rotation"]:
            return self._turned(points, 1.0, step)
        return points + self.shift(wall, step)

    def _turned(self, points: Floats, sense: float, step: int) -> Floats:
        origin, axis, rate = self._rotation()
        angle = sense * rate * self._time()[step]
        d = points - origin
        along = (d @ axis)[:, None] * axis
        return np.asarray(origin + along + np.cos(angle) * (d - along) + np.sin(angle) * np.cross(axis, d))

    def _time(self) -> Floats:
        """Time after 0, 1, 2, … steps, as the engine adds it up."""
        if self._times is None:
            self._times = np.concatenate([[0.0], np.cumsum(np.full(self._total + 1, self._setup.step))])
        return self._times

    def _vibrated(self) -> tuple[Floats, Floats]:
        """Velocity and displacement of the vibration after 0, 1, 2, … steps: v = a w cos(w t + phase)."""
        if self._sums is None:
            v, dt = self._setup.scene["vibration"], self._setup.step
            w = 2.0 * np.pi * v["frequency_Hz"]
            time = self._time()
            speed = np.asarray(v["amplitude_m"]) * w * np.cos(w * time[:, None] + np.asarray(v["phase_rad"]))
            speed[0] = 0.0
            self._sums = speed, np.cumsum(speed * dt, axis=0)
        return self._sums

    def _rotation(self) -> tuple[Floats, Floats, float]:
        r = self._setup.scene["rotation"]
        axis = np.asarray(r["axis"], float)
        return np.asarray(r["origin_m"], float), axis / np.linalg.norm(axis), 2.0 * np.pi / r["period_s"]
