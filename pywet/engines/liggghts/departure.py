"""Where a sphere left the simulated box, from the last output that holds it: the engine itself names no place."""

from __future__ import annotations

from itertools import chain
from pathlib import Path

import numpy as np

from pywet.scene import Scene

SAMPLES = 2000
"""Places on the path of a sphere from its last output to the next."""


def departure(scene: Scene, folder: Path, sphere: int | None) -> str:
    """A sentence's end: sphere, position and face, of the first to leave where no `sphere` is known; empty without an output."""
    rows = _last_frame(folder / "trajectory.txt")
    if sphere is not None:
        rows = rows[rows[:, 0] == sphere]
    if not len(rows):
        return ""
    span = 2.0 * max(scene.output_every * scene.time_step_s, scene.time_step_s)
    t = np.linspace(0.0, span, SAMPLES)[:, None]
    low, high, fall = (np.array(v) for v in (scene.box_low_m, scene.box_high_m, scene.gravity_m_per_s2))
    first: tuple[float, str] | None = None
    for row in rows:
        path = row[2:5] + row[5:8] * t + 0.5 * fall * t**2
        beyond = np.stack([path < low, path > high], axis=2)
        if beyond.any():
            k, axis, end = (int(n) for n in np.argwhere(beyond)[0])
            face = (
                f"{('lower', 'upper')[end]} {'xyz'[axis]} face, {'xyz'[axis]} = {1e3 * (low, high)[end][axis]:.4g} mm"
            )
            place = ", ".join(f"{x:.4g}" for x in 1e3 * path[k])
            if first is None or t[k, 0] < first[0]:
                first = float(t[k, 0]), f"sphere {int(row[0])} at about ({place}) mm through the {face}"
    return first[1] if first else ""


def _last_frame(path: Path) -> np.ndarray:
    """Rows of the last whole frame of a text dump: id, type, x, y, z, vx, vy, vz and more."""
    try:
        text = path.read_text(errors="replace")
        blocks = text.split("ITEM: TIMESTEP\n")[1:]
        for block in reversed(blocks):
            lines = block.splitlines()
            count = int(lines[2])
            if len(lines) >= 8 + count and block.endswith("\n"):
                numbers = np.array([*chain.from_iterable(line.split() for line in lines[8 : 8 + count])], dtype=float)
                return numbers.reshape(count, -1)
    except (OSError, ValueError, IndexError):
        pass
    return np.zeros((0, 8))
