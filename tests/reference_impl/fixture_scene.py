"""One small moist run that holds what can go wrong: moving walls of every kind, wires, films on walls, flights, works.

Faults are injected into copies of its tables (injected_fixture.py) or into its plugin (tests/engines/liggghts/injected.py).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from pywet.cases.small import small
from pywet.cases.small.bodies import water
from pywet.geometry.solids import plate, polygon, wire
from pywet.geometry.surface import Surface, make_surface
from pywet.scene import Output, Slide, Vibration
from tests.engines.liggghts.scenes import spheres_of
from tests.reference_impl.newton_scenes import DOWN, R, contacts, moving

SYRUP = water(3e-5, viscosity=4e-3)
"""Drag that counts, and slow enough for many bridges to stand."""
STEP = 2e-5
OPENS, TRAVEL = 0.01, 0.03
STEPS = 4000


def screen() -> Surface:
    """Two wires along x and one across, thinner than the spheres."""
    ends = [((-0.02, y, 0.0), (0.02, y, 0.0)) for y in (-2.2e-3, 2.2e-3)] + [((0.0, -0.02, 0.0), (0.0, 0.02, 0.0))]
    parts = [(wire(np.array(a), np.array(b), 1e-3, 8, 0.6), 1e-3) for a, b in ends]
    return moving(make_surface("screen", "wires", parts), "vibrates")


def floor() -> Surface:
    """Below the screen, of several triangles."""
    return make_surface("floor", "collecting_bin", plate(polygon(0.02, 8), -0.02, -0.0115))


def drawer() -> Surface:
    """A plate next to the screen that is drawn away."""
    outline = np.array([[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 1.0]]) * 0.02 + [0.021, 0.0]
    return moving(make_surface("drawer", "slide", plate(outline, -0.002, 0.0)), "slides")


def spheres() -> list[small.Sphere]:
    """A heap over the screen, some on the drawn plate, some that fall onto the floor, and pairs in flight."""
    random = np.random.default_rng(5)

    def thrown(at: tuple[float, float, float], down: float = 0.0) -> small.Sphere:
        v, w = random.normal(0.0, 0.06, 3) - [0.0, 0.0, down], random.normal(0.0, 15.0, 3)
        return small.Sphere(1 + int(random.integers(2)), at, tuple(v), tuple(w))

    wide = 5.3e-3
    heap = [
        thrown((wide * (i - 1), wide * (j - 1), 4.2e-3 + wide * k), 0.1)
        for k in (0, 1)
        for i in (0, 1, 2)
        for j in (0, 1, 2)
    ]
    drawn = [thrown((0.026 + wide * i, wide * (j - 0.5), 3e-3), 0.1) for i in (0, 1) for j in (0, 1)]
    below = [thrown((wide * (i - 1) + 1e-3, 1e-3, -0.0083), 0.1) for i in (0, 1, 2)]
    flights = []
    for k in range(4):
        y = -0.045 - 0.01 * k
        flights += [
            small.Sphere(1, (0.0, y, 0.03), (0.02, 0.0, 0.3), (0.0, 5.0, 2.0 * k)),
            small.Sphere(2, (0.3e-3, y, 0.03 + 2e-5 + R + 2e-3), (0.0, 0.01, 0.3 + 0.02 + 0.01 * k), (3.0, 0.0, 1.0)),
        ]
    return [*heap, *drawn, *below, *flights]


def prepare(folder: Path, **more: object) -> list[small.Sphere]:
    """Write the run's inputs."""
    bodies = spheres()
    small.prepare(
        folder, spheres_of(R, 2e-3), bodies, contacts(2), liquid=SYRUP, effects=small.PAPER,
        walls=[screen(), floor(), drawer()], wall_angle_rad=math.radians(45.0), time_step_s=STEP, steps=STEPS,
        gravity=DOWN, vibration=Vibration(amplitude_m=(1e-4, 5e-5, 1.5e-3), phase_rad=(0.5, 1.0, 0.3), frequency_Hz=50.0),
        slide=Slide(velocity_m_per_s=(0.25, 0.0, 0.0), opens_at_s=OPENS, travel_s=TRAVEL),
        output=Output(interval_s=50 * STEP, contact_windows=5, contact_window_steps=102, window_trajectories=True),
        **more,
    )  # fmt: skip
    return bodies


def write(folder: Path) -> Path:
    """The sound run."""
    small.run(folder, prepare(folder))
    return folder
