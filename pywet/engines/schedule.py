"""Schedule of a scene by step: outputs, windows, checkpoints, the slide, and the pieces into which they divide a run.

Every engine takes these numbers from here; `reference_impl` derives them independently from scene.json.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pywet.geometry.motion import slides
from pywet.scene import SHORT_WINDOW, EngineScene

RETIRE_EVERY_S = 0.25
"""Longest time [s] between steps at which spheres are retired: most fines of a sieve pass within some seconds, and a checkpoint
costs as much as some hundred steps."""
SKIPPED = 2.0
"""Longest time between removals in outlets, in intervals between checkpoints: one of two may be within a sampling window."""
OUTLET_EVERY_S = 0.02
"""Longest time [s] between removals at outlets: at 1 m/s a sphere falls at most 2 cm beyond the outlet's plane."""
EARLY = 0.02
"""Share of a run after its last output from which it is reported: the default interval, so that rounding to steps is not."""
Window = tuple[int, int]
"""Half-open range of steps: the first step, and the step after the last."""


@dataclass(frozen=True)
class Piece:
    """A number of steps that the engine runs without interruption."""

    steps: int
    drawn: tuple[str, ...]
    """Walls that start to move out, or continue where the engine was reloaded."""
    stops: tuple[str, ...]
    """Walls that stop at the end of the piece."""
    checkpoint: int | None
    """Step whose state is saved at the end, after which the engine is reloaded; None: the engine continues."""


def windows(scene: EngineScene) -> list[Window]:
    """Return the windows in which all contacts are logged in every step: one in each of as many equal parts of the run.

    Windows of a few steps are samples, each at a random position in its part, drawn from the scene's seed. Longer
    ones show the course of motion and are in the middle of their parts.
    """
    count, length = scene.output.contact_windows, scene.output.contact_window_steps
    if length <= SHORT_WINDOW:
        first = [_drawn_start(scene, k) for k in range(count)]
        return [(start, min(start + length, scene.steps + 1)) for start in first]
    middles = [int(scene.steps * (k + 0.5) / count) for k in range(count)]
    return [(max(0, m - length // 2), min(m - length // 2 + length, scene.steps + 1)) for m in middles]


def _drawn_start(scene: EngineScene, part: int) -> int:
    """Return the first step of a short window.

    The first window is in the first eighth of its part, every fourth one at a checkpoint or an output.
    Bridges act in it. Only its first step may be a checkpoint, and not if that step's forces are evaluated again
    or spheres are retired at it.
    """
    count, length, every = scene.output.contact_windows, scene.output.contact_window_steps, scene.bridges_every
    low, high = (scene.steps * k // count for k in (part, part + 1))
    width = high - low - length if part else high // 8
    start = low + int(drawn(scene.seed, part) * max(1, width))
    start -= start % every
    if part % 4 == 3 and (output := -(-start // scene.output_every) * scene.output_every) < high - length:
        start = output
    if saved := checkpoint_every(scene):
        after = 0 if scene.effects.bridges and not scene.removes else every
        ahead = -(-start // saved) * saved
        if (ahead < start + length or part % 4 == 1) and 0 < ahead < min(high, scene.steps) - after:
            return ahead + after
    return start


def drawn(seed: int, part: int) -> float:
    """Return a pseudo-random number in [0, 1) for a part of a run with this seed."""
    digest = hashlib.sha256(f"window {part} of seed {seed}".encode()).digest()
    return int.from_bytes(digest[:6], "big") / 2.0**48


def recorded(scene: EngineScene) -> list[Window]:
    """Return the windows in which motion is recorded, with overlapping ones joined."""
    joined: list[Window] = []
    for first, last in windows(scene) if scene.output.window_trajectories else []:
        if joined and first <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(last, joined[-1][1]))
        else:
            joined.append((first, last))
    return joined


def outlets_every_s(output_s: float | None) -> float:
    """Return the longest time [s] between removals in outlets, which are at outputs, of this interval if it is given."""
    return max(OUTLET_EVERY_S, output_s or 0.0)


def checkpoint_every(scene: EngineScene) -> int:
    """Return the number of steps between checkpoints, at which bridges act; 0: none.

    If spheres are retired, checkpoints are at outputs and frequent.
    """
    wanted, every = scene.output.checkpoints, scene.output_every if scene.removes else scene.bridges_every
    times = max(1, math.ceil(scene.steps / ((wanted + 1) * every)))
    if scene.removes:
        longest = OUTLET_EVERY_S if scene.outlets else RETIRE_EVERY_S
        times = min(times, max(1, int(longest / (every * scene.time_step_s))))
    return every * times if wanted else 0


def created(scene: EngineScene, enters: np.ndarray) -> np.ndarray:
    """Return the checkpoint at which each sphere is created, from the step at which it enters; 0: present from the start."""
    every = checkpoint_every(scene)
    if scene.created_ahead_s is None or not every:
        return np.zeros_like(enters)
    ahead = max(every, round(scene.created_ahead_s / scene.time_step_s))
    return every * -(-np.maximum(enters - ahead, 0) // every)


def early_end(scene: EngineScene) -> list[str]:
    """Return a warning if the last output, whose numbers are reported as those at the end, is well before it."""
    last = scene.output_steps[-1]
    if scene.steps - last <= EARLY * scene.steps:
        return []
    last_s, end_s = last * scene.time_step_s, scene.steps * scene.time_step_s
    return [
        f"the last output is at {last_s:.3g} s of {end_s:.3g} s, and numbers at the end are its: set an output interval that "
        "divides the duration"
    ]


def checkpoints(scene: EngineScene, avoided: Sequence[Window] = ()) -> list[int]:
    """Steps at which the state is saved, and from which a killed run resumes; a step in a window that is `avoided` is moved to
    the window's last step.
    """
    every = checkpoint_every(scene)
    steps = set(range(every, scene.steps, every) if every else ())
    for first, last in avoided:
        steps = {last - 1 if first <= step < last else step for step in steps}
    return sorted(step for step in steps if step < scene.steps)


def pieces(scene: EngineScene, done: int, plugin: bool) -> list[Piece]:
    """Divide the run where walls start and stop moving out and at checkpoints; after `done` steps only the rest.

    Without the plugin the checkpoints avoid the sampling windows, because the engine computes the forces of a checkpoint
    step twice and the motion of a window is checked against the recorded forces.
    """
    drawn, saved = slides(scene), checkpoints(scene, () if plugin else recorded(scene))
    cut, at = [], 0
    for stop in sorted({*(step for window in drawn.values() for step in window), scene.steps, *saved} - {0}):
        moving = {name: window for name, window in drawn.items() if window[0] <= at < window[1]}
        begin = tuple(name for name, window in moving.items() if at == window[0] or at in saved)
        end = tuple(name for name, window in moving.items() if stop == window[1])
        if at >= done:
            cut.append(Piece(stop - at, begin, end, stop if stop in saved else None))
        at = stop
    return cut
