"""Find where a sphere left the simulated box from the last output that contains it; the engine reports no position."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import numpy as np

from pywet.engines.liggghts.creation import at_start
from pywet.errors import PywetError
from pywet.runs import retired
from pywet.runs.rundir import RunDir, placed
from pywet.scene import EngineScene
from pywet.util.files import read_table

KEEP = "expected walls or a tray that keep it, or a smaller time step"
FRAME = b"ITEM: TIMESTEP\n"
"""First line of a frame of a dump."""
BLOCK = 1 << 16
"""Number of bytes that are read first."""
SAMPLES = 2000
"""Number of points on the path of a sphere from its last output to the next."""


def departure(scene: EngineScene, folder: Path, sphere: int | None) -> str:
    """Complete a sentence with sphere, position and face of the first to leave, if `sphere` is None; empty without an output."""
    rows = _last_rows(scene, folder)
    if not len(rows):
        rows = _at_start(scene, folder.parent / scene.spheres_file)
    if sphere is not None:
        rows = rows[rows[:, 0] == sphere]
    if not len(rows):
        return ""
    span = 2.0 * max(scene.output_every * scene.time_step_s, scene.time_step_s)
    t = np.linspace(0.0, span, SAMPLES)[:, None]
    low, high, fall = (np.array(v) for v in (scene.box_low_m, scene.box_high_m, scene.gravity_m_per_s2))
    origin = RunDir(folder.parent).origin_mm
    first: tuple[float, str] | None = None
    for row in rows:
        path = row[2:5] + row[5:8] * t + 0.5 * fall * t**2
        beyond = np.stack([path < low, path > high], axis=2)
        if scene.periodic:  # a sphere comes in again on the other side
            beyond[:, "xyz".index(scene.periodic)] = False
        if beyond.any():
            k, axis, end = (int(n) for n in np.argwhere(beyond)[0])
            edge = placed((low, high)[end], origin).split(", ")[axis]
            face, place = (
                f"{('lower', 'upper')[end]} {'xyz'[axis]} face, {'xyz'[axis]} = {edge} mm",
                placed(path[k], origin),
            )
            if first is None or t[k, 0] < first[0]:
                first = float(t[k, 0]), f"sphere {int(row[0])} at about ({place}) mm through the {face}"
    return first[1] if first else ""


def _at_start(scene: EngineScene, path: Path) -> np.ndarray:
    """Return the rows of the spheres at the start of the run: id, type, position, velocity."""
    if not path.exists():
        return np.zeros((0, 8))
    columns = ["id", "type", "x", "y", "z", "vx", "vy", "vz"]
    return np.asarray(at_start(scene, read_table(path)).reindex(columns=columns, fill_value=0.0).to_numpy(dtype=float))


def _last_rows(scene: EngineScene, folder: Path) -> np.ndarray:
    """Return the rows of the last output, and of the one before those of spheres that are missing in it and were not removed."""
    last, before = _last_frames(folder / "trajectory.txt")
    gone = np.zeros(0, dtype=np.int64)
    if scene.removes:
        with suppress(OSError, PywetError):  # cut off, or not there yet
            gone = retired.records(folder)["id"]
    missing = ~np.isin(before[:, 0], [*last[:, 0], *gone])
    return np.concatenate([last, before[missing]])


def _last_frames(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of the last two complete frames of a text dump, the later first: id, type, x, y, z, vx, vy, vz and more."""
    found: list[np.ndarray] = []
    with suppress(OSError):  # not there yet
        for block in reversed(_end(path, 3).split(FRAME)[1:]):
            lines = block.decode(errors="replace").splitlines()
            with suppress(ValueError, IndexError):  # cut off amid a line
                if len(found) < 2 and len(lines) == 8 + int(lines[2]) and block.endswith(b"\n"):
                    found.append(np.array([line.split() for line in lines[8:]], dtype=float))
    one, other = [*found, np.zeros((0, 8)), np.zeros((0, 8))][:2]
    width = max(a.shape[1] if a.ndim == 2 else 0 for a in (one, other))
    return one.reshape(-1, width), other.reshape(-1, width)


def _end(path: Path, frames: int) -> bytes:
    """Return the end of a text dump with at least as many frames, or all of it: a long run has gigabytes of them."""
    length, text = BLOCK, b""
    with open(path, "rb") as file:
        size = file.seek(0, os.SEEK_END)
        while len(text) < size and text.count(FRAME) < frames:
            file.seek(max(0, size - length))
            text, length = file.read(), 2 * length
    return text
