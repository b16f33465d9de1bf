"""Small runs whose motion is recorded in every step: pairs, a sphere on walls of all kinds, a moist bed on a shaken floor."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from pywet.cases.small import small
from pywet.geometry.solids import plate, wire
from pywet.geometry.surface import Surface, make_surface
from pywet.scene import ContactPair, Output, Rotation, Slide, Vibration
from reference_impl.motion import newton, window
from reference_impl.replay import io
from reference_impl.replay.compare import Quantity
from tests.engines.liggghts.scenes import WATER, spheres_of

R = 2.5e-3
STEP = 1e-5
DOWN = (0.0, 0.0, -9.81)
SHAKING = Vibration(amplitude_m=(1e-4, 5e-5, 8e-4), phase_rad=(0.5, 1.0, 0.3), frequency_Hz=50.0)


def contacts(n: int) -> list[ContactPair]:
    """Contacts with everything in them: dashpot, friction, rolling resistance; walls differ from spheres."""
    return [
        ContactPair(
            a=a, b=b, normal_stiffness_N_per_m=1e3 if b else 2e3, tangential_stiffness_N_per_m=300.0, friction=0.3,
            rolling_friction_m=5e-5, restitution=0.7,
        )
        for a in range(1, n + 1)
        for b in [0, *range(a, n + 1)]
    ]  # fmt: skip


def moving(surface: Surface, motion: str) -> Surface:
    """Return a surface with another motion."""
    return Surface(**{**surface.__dict__, "motion": motion})


def wires() -> Surface:
    """Two crossing wires, eight-sided: every contact is near some convex edge."""
    ends = [((-0.02, 0.0, 0.0), (0.02, 0.0, 0.0)), ((0.0, -0.02, 0.0), (0.0, 0.02, 0.0))]
    return make_surface("wires", "wires", [(wire(np.array(a), np.array(b), 1e-3, 8, 0.6), 1e-3) for a, b in ends])


def block() -> Surface:
    """A small block with sharp edges and corners."""
    outline = 2e-3 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return make_surface("block", "wall", plate(outline, -0.004, 0.0))


def pair(folder: Path, velocity: tuple[float, float, float], spin: tuple[float, float, float], offset: float) -> Path:
    """Two free spheres of two sizes that meet once, without gravity."""
    spheres = [
        small.Sphere(1, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        small.Sphere(2, (4.52e-3, offset, 0.0), velocity, spin),
    ]
    small.prepare(
        folder, spheres_of(R, 2e-3), spheres, contacts(2), time_step_s=STEP, steps=300, window_trajectories=True
    )
    small.run(folder, spheres)
    return folder


def thrown(count: int, low: float, seed: int = 3, wide: float = 5.4e-3, down: float = 0.0) -> list[small.Sphere]:
    """Spheres of two sizes on a loose lattice, thrown about and `down` [m/s], spinning."""
    random = np.random.default_rng(seed)
    across = math.ceil(math.sqrt(count / 2))
    at = [
        (wide * (i - 0.5 * (across - 1)), wide * (j - 0.5 * (across - 1)), low + wide * k)
        for k in range(2)
        for i in range(across)
        for j in range(across)
    ][:count]
    return [
        small.Sphere(1 + n % 2, p, tuple(random.normal(0, 0.15, 3) - [0.0, 0.0, down]), tuple(random.normal(0, 20, 3)))
        for n, p in enumerate(at)
    ]


def on_walls(folder: Path, surface: Surface, spheres: list[small.Sphere], steps: int = 700, **more: object) -> Path:
    """Dry spheres on one wall."""
    small.prepare(
        folder, spheres_of(R, 2e-3), spheres, contacts(2), walls=[surface], time_step_s=STEP, steps=steps, gravity=DOWN,
        window_trajectories=True, vibration=SHAKING if surface.motion == "vibrates" else None,
        rotation=Rotation(origin_m=(0.0, 0.0, -0.02), axis=(1.0, 0.0, 0.0), period_s=0.5)
        if surface.motion == "turns" else None,
        slide=Slide(velocity_m_per_s=(0.3, 0.0, 0.0), opens_at_s=0.003, travel_s=0.005)
        if surface.motion == "slides" else None, output_interval_s=steps * STEP, **more,
    )  # fmt: skip
    small.run(folder, spheres)
    return folder


def moist_bed(folder: Path, effects: object = small.PAPER, **more: object) -> Path:
    """Thirty wet spheres of two sizes on a shaken floor; four windows of 75 steps of 1600 recorded."""
    spheres = thrown(32, 0.003)
    small.prepare(
        folder, spheres_of(R, 2e-3), spheres, contacts(2), liquid=WATER, effects=effects,
        walls=[moving(small.floor(), "vibrates")], wall_angle_rad=math.radians(45.0), time_step_s=2e-5, steps=1600,
        gravity=DOWN, vibration=SHAKING,
        output=Output(interval_s=0.004, contact_windows=4, contact_window_steps=75, window_trajectories=True), **more,
    )  # fmt: skip
    small.run(folder, spheres)
    return folder


def closed(folder: Path) -> tuple[dict[str, Quantity], list[newton.Forces]]:
    """All quantities of Newton's law, and the forces they came from."""
    setup = window.read(folder)
    found = newton.forces(setup, io.read(folder) if setup.scene["effects"]["bridges"] else None)
    return {q.name: q for q in newton.check(setup, found)}, found
