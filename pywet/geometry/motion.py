"""Motion of walls: displacements at the outputs; the screen's vibration, in closed form and as LIGGGHTS integrates it.

A `Vibration` is x_k(t) = a_k sin(2π f t + φ_k) for k = x, y, z. LIGGGHTS' `fix move/mesh … viblin`
(mesh_mover_linear.cpp) sets in every step, with t = n Δt since the fix was given, n from 1,

    v = −A ω sin(ω t + p),      displacement += v Δt,

so that p = φ_k − π/2 and A = a_k give the velocity a_k ω cos(ω t + φ_k); one mover per axis, and the movers of a mesh
add up. Two consequences: the mesh starts where its STL file is, hence moves as x(t) − x(0); and the sum of steps
differs from the sine by at most a_k ω Δt (0.3 µm for 0.9 mm, 50.6 Hz and 1 µs). `engine_displacement` is that sum,
rounding of the engine's clock included.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pywet.scene import EngineScene, Slide, Vibration

Floats = NDArray[np.float64]


def velocity(vibration: Vibration, time: ArrayLike) -> Floats:
    """Return the velocity dx/dt [m/s], shape (…, 3)."""
    omega = 2.0 * math.pi * vibration.frequency_Hz
    angle = omega * np.asarray(time, dtype=np.float64)[..., None] + np.asarray(vibration.phase_rad)
    return np.asarray(np.asarray(vibration.amplitude_m) * omega * np.cos(angle), dtype=np.float64)


def peak_speed(vibration: Vibration) -> float:
    """Return a bound of the speed [m/s]: 2 pi f times the root of the sum of squared amplitudes."""
    return 2.0 * math.pi * vibration.frequency_Hz * math.hypot(*vibration.amplitude_m)


def engine_displacement(vibration: Vibration, step: ArrayLike, time_step: float) -> Floats:
    """Return the displacement of the engine's mesh after `step` steps [m]: Σ v(t_n) Δt for n = 1 … step, shape (…, 3).

    t_n is the engine's clock, Δt added n times: after three million steps it differs by some 1e-9 s from n Δt.
    """
    wanted = np.asarray(step, dtype=np.int64)
    times, place, done = np.zeros(1), np.zeros(3), 0
    found: dict[int, Floats] = {}
    for n in np.unique(wanted).tolist():
        if n > done:
            times = np.cumsum(np.concatenate([times[-1:], np.full(n - done, time_step)]))
            moves = velocity(vibration, times[1:]) * time_step
            place, done = np.cumsum(np.concatenate([place[None], moves]), axis=0)[-1], n
        found[n] = place
    return np.array([found[n] for n in wanted.ravel().tolist()], dtype=np.float64).reshape(*wanted.shape, 3)


def slides(scene: EngineScene) -> dict[str, tuple[int, int]]:
    """Find the steps at which each sliding wall starts and stops."""
    return {name: _drawn(scene, way) for name, way in scene.motions.items() if isinstance(way, Slide)}


def _drawn(scene: EngineScene, way: Slide) -> tuple[int, int]:
    begins = min(scene.steps, round(way.opens_at_s / scene.time_step_s))
    return begins, min(scene.steps, begins + round(way.travel_s / scene.time_step_s))


def translations(scene: EngineScene) -> dict[str, Floats]:
    """Return the displacement of each mesh from its STL file at the output steps [m], shape (outputs, 3)."""
    steps, drawn = np.asarray(scene.output_steps), slides(scene)

    def of(name: str, way: object) -> Floats:
        if isinstance(way, Vibration):
            return engine_displacement(way, steps, scene.time_step_s)
        if isinstance(way, Slide):
            begins, stops = drawn[name]
            moved = (np.clip(steps, begins, stops) - begins) * scene.time_step_s
            return np.asarray(moved[:, None] * np.asarray(way.velocity_m_per_s))
        return np.zeros((len(steps), 3))

    return {name: of(name, way) for name, way in scene.motions.items()}
