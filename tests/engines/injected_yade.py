"""Faults injected into the host that YADE has for the plugin: a patched copy of its source, where each is switched on by name.

Run as a program it is the process of a `Foundry`.
"""

from __future__ import annotations

import math
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from pywet.cases.small import small
from pywet.cases.small.bodies import contacts, sphere_classes, water
from pywet.engines.yade import build, driver, worker
from pywet.geometry.solids import plate
from pywet.geometry.surface import make_surface
from pywet.scene import Output, Slide, Vibration
from tests.engines import foundry

R = 2.5e-3
PATCHES: tuple[tuple[str, str], ...] = (
    ('#include "host.h"', '#include "host.h"\n#include "injected.h"'),
    ("f[a] = pushed + 3 * a;",
     "static std::vector<double> nowhere(f.size() * 3, 0.0);\n"
     '      const size_t of = injected("forces of the next sphere") && a > 3 ? a ^ 1 : a;\n'
     '      f[a] = injected("forces lost") ? &nowhere[3 * a] : pushed + 3 * of;'),
    ("torque[a] = twisted + 3 * a;", 'torque[a] = (injected("torques into the forces") ? pushed : twisted) + 3 * a;'),
    ("std::memcpy(omega[a],", 'if (!injected("spins left out")) std::memcpy(omega[a],'),
    ("std::memcpy(x[a], given.state[a] + given.at.position, 3 * sizeof(double));",
     'static int times = 0;\n'
     '      if (!injected("places of the start") || times++ < int(3 * x.size()))\n'
     "        std::memcpy(x[a], given.state[a] + given.at.position, 3 * sizeof(double));"),
    ("mesh.shift = place - lmp_->wall_start[m];",
     'if (!injected("walls at rest")) mesh.shift = place - lmp_->wall_start[m];'),
    ("mesh.velocity = velocity;", 'if (!injected("walls without speed")) mesh.velocity = velocity;'),
    ("const char *state = given.wall_state[m];",
     'const char *state = given.wall_state[injected("walls exchanged") ? m ^ 1 : m];'),
    ("if (a >= 0 && b >= 0) pairs.push_back({a, b});",
     'if (a >= 0 && b >= 0 && !(injected("a pair left out") && (a + b) % 2)) pairs.push_back({a, b});'),
    ("host.sorted = sorted != 0;", 'host.sorted = sorted != 0 && !(injected("lists of the start") && n > 0);'),
    ("if (n == 0) host.take_back();", 'if (n == 0 && !injected("no half kick at the start")) host.take_back();'),
    ("const double half = step == 0 ? 0.0 : 0.5;",
     'const double half = step == 0 || injected("speeds of half a step") ? 0.0 : 0.5;'),
    ('fprintf(file, "%d", tag[a]);',
     'fprintf(file, "%d", tag[injected("numbers exchanged") && !forces && step > 0 ? a ^ 1 : a]);'),
    ("return pywet::Vec(v[a]) + (half * given.dt / mass[a])",
     'return pywet::Vec(v[a]) + ((injected("mass of another") && a % 2 ? 1.1 : 1.0) * half * given.dt / mass[a])'),
    ("host.weigh();", 'if (!injected("weightless")) host.weigh();'),
)  # fmt: skip
"""Text that must be there once, text in its place."""
FAULTS = {
    "forces lost": "newton_force",
    "forces of the next sphere": "newton_force",
    "torques into the forces": "newton_torque",
    "spins left out": "newton_torque",
    "places of the start": "newton_drift",
    "walls at rest": "wall_closest_point",
    "walls without speed": "wall_velocity",
    "walls exchanged": "wall_closest_point",
    "a pair left out": "formation_missed",
    "lists of the start": "formation_missed",
    "no half kick at the start": "newton_kick",
    "speeds of half a step": "window_velocity",
    "numbers exchanged": "trajectory_in_windows",
    "mass of another": "newton_kick",
    "weightless": "newton_force",
}
"""Fault, and the quantity in which the replay sees it."""


def scene(run_dir: Path) -> None:
    """A sphere on a vibrating plate, one on a plate that is drawn away, and four that meet in flight; motion in every step."""
    square = 0.008 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    walls = (
        make_surface("table", "wires", plate(square, -0.002, 0.0), "vibrates"),
        make_surface("belt", "slide", plate(square + np.array([0.03, 0.0]), -0.002, 0.0), "slides"),
    )
    gap = 2 * R + 4e-4
    bodies = [
        small.Sphere(1, (0.0, 0.001, R + 3e-5)),
        small.Sphere(1, (0.03, 0.0, R + 3e-5)),
        small.Sphere(1, (-0.02, 0.0, 0.03), (0.05, 0.0, 0.0), (0.0, 20.0, 3.0)),
        small.Sphere(1, (-0.02 + gap, 0.001, 0.03), (-0.05, 0.0, 0.02)),
        small.Sphere(1, (-0.02, 0.02, 0.03), (0.0, 0.0, 0.0)),
        small.Sphere(1, (-0.02, 0.02 + 3 * R, 0.03), (0.0, -0.2, 0.0), (5.0, 0.0, 0.0)),
    ]
    steps = 700
    small.prepare(
        run_dir, sphere_classes(R), bodies, contacts(1, 1e3, friction=0.2, rolling_m=2e-5), liquid=water(1e-4),
        effects=small.PAPER, walls=walls, wall_angle_rad=math.radians(45.0), gravity=(0.0, 0.0, -9.81),
        time_step_s=2e-5, steps=steps,
        output=Output(interval_s=2e-3, contact_windows=1, contact_window_steps=2 * steps, energy=False, window_trajectories=True),
        vibration=Vibration(amplitude_m=(2e-4, 0.0, 3e-4), phase_rad=(0.3, 0.0, 0.1), frequency_Hz=50.0),
        slide=Slide(velocity_m_per_s=(0.3, 0.0, 0.0), opens_at_s=0.004, travel_s=0.006),
    )  # fmt: skip


def patched(folder: Path) -> Path:
    """A copy of the host's sources with the switches injected."""
    shutil.copytree(build.SOURCES, folder)
    for old, new in PATCHES:
        foundry.replaced(folder / "engine.cpp", old, new)
    (folder / "injected.h").write_text(foundry.switch("injected"))
    return folder


class Foundry(foundry.Foundry):
    """Runs scenes with the patched host."""

    def __init__(self, folder: Path) -> None:
        super().__init__(__name__, patched(folder / "sources"))

    def run(self, run_dir: Path, fault: str) -> None:
        """Run a prepared scene with one fault switched on."""
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(driver, "_watch", lambda of, folder, *_: self.launch(fault, of, folder))
            driver.run(run_dir, progress=False)


def main() -> None:
    """Build, then answer until the input ends."""
    build.SOURCES = Path(sys.argv[1])
    foundry.quick_build()
    build.plugin_path()
    worker.reach_yade()
    foundry.serve(worker.run)


if __name__ == "__main__":
    main()
