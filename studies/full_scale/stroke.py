"""Draw Fig. 9: the path of the screen over one period, as configured."""

from __future__ import annotations

import numpy as np

from pywet.cases.screening import cases
from pywet.config import Config
from pywet.report.pictures import NAVY, ORANGE, STYLE, plt, svg
from pywet.runs.rundir import Floats
from pywet.scene import Vibration

AMPLITUDES = {1.0: NAVY, 0.8: ORANGE}
"""Set amplitude of table 4 [mm] -> colour."""
POINTS = 200


def position(vibration: Vibration, time: Floats) -> Floats:
    """Return the positions x(t) about the centre of the motion [m], shape (times, 3)."""
    angle = 2.0 * np.pi * vibration.frequency_Hz * time[:, None] + np.asarray(vibration.phase_rad)
    return np.asarray(np.asarray(vibration.amplitude_m) * np.sin(angle), dtype=np.float64)


def path_mm(config: Config, set_amplitude_mm: float) -> Floats:
    """Return the positions over one period [mm], shape (POINTS, 3)."""
    case = next(c for c in config.cases.values() if c.set_amplitude_mm == set_amplitude_mm)
    motion = cases.vibration_of(config, case)
    return 1e3 * position(motion, np.linspace(0.0, 1.0 / motion.frequency_Hz, POINTS))


def fig9(config: Config) -> str:
    """Draw (a) z over x on one scale, (b) z over x and over y with the horizontal axis stretched; as SVG text."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(7.0, 3.2), layout="constrained", sharey=True)
        for amplitude, colour in AMPLITUDES.items():
            x, y, z = path_mm(config, amplitude).T
            for place, across in zip(axes, (x, x, y), strict=True):
                place.plot(across, z, color=colour, label=f"set amplitude {amplitude:g} mm")
        axes[0].set(aspect="equal", xlim=(-1.1, 1.1), xlabel="x in mm", ylabel="z in mm", title="(a) one scale")
        axes[1].set(xlim=(-0.12, 0.12), xticks=(-0.1, 0.0, 0.1), xlabel="x in mm", title="(b) x stretched")
        axes[2].set(xlim=(-0.12, 0.12), xticks=(-0.1, 0.0, 0.1), xlabel="y in mm", title="y stretched")
        axes[0].legend(loc="upper center", bbox_to_anchor=(0.5, -0.25))
        return svg(figure, transparent=True)
