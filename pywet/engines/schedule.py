"""What happens at which step of a scene: outputs, windows, checkpoints, the slide, and the pieces a run is cut into by them.

The one owner of these numbers for every engine; `reference_impl` derives them anew from scene.json.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from pywet.scene import Scene

DROP_INTERVAL = 1e-3
"""Time [s] over which the specific force on a film is averaged; films of 1 mm3 answer in 0.6 ms, of 10 mm3 in 2 ms."""
Window = tuple[int, int]
"""First step, and the step after the last."""


@dataclass(frozen=True)
class Piece:
    """So many steps in one go."""

    steps: int
    drawn: bool
    """The slide is moving."""
    stops: bool
    """At the end of the piece the slide stops."""
    checkpoint: int | None
    """The step whose state is saved at the end, after which the engine is emptied; None: it goes on."""


def windows(scene: Scene) -> list[Window]:
    """Windows in which all contacts are logged in every step, spread evenly over the run."""
    count, length = scene.output.contact_windows, scene.output.contact_window_steps
    middles = [int(scene.steps * (k + 0.5) / count) for k in range(count)]
    return [(max(0, m - length // 2), min(m - length // 2 + length, scene.steps + 1)) for m in middles]


def recorded(scene: Scene) -> list[Window]:
    """The windows in which motion is recorded, those that overlap joined."""
    joined: list[Window] = []
    for first, last in windows(scene) if scene.output.window_trajectories else []:
        if joined and first <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(last, joined[-1][1]))
        else:
            joined.append((first, last))
    return joined


def slide(scene: Scene) -> Window | None:
    """Step at which the slide begins to be drawn, and at which it stops; None without one."""
    if scene.slide is None or not any(w.motion == "slides" for w in scene.walls):
        return None
    begins = min(scene.steps, round(scene.slide.opens_at_s / scene.time_step_s))
    return begins, min(scene.steps, begins + round(scene.slide.travel_s / scene.time_step_s))


def checkpoint_every(scene: Scene) -> int:
    """Steps between checkpoints, at which bridges act; 0: none."""
    wanted, every = scene.output.checkpoints, scene.bridges_every
    return every * max(1, math.ceil(scene.steps / ((wanted + 1) * every))) if wanted else 0


def drop_every(scene: Scene) -> int:
    """Steps between looks at what drips: about `DROP_INTERVAL`, and a whole number of them between outputs."""
    looks = max(1, round(scene.output_every * scene.time_step_s / DROP_INTERVAL))
    return next(
        scene.output_every // n for n in range(min(looks, scene.output_every), 0, -1) if scene.output_every % n == 0
    )


def checkpoints(scene: Scene, avoided: Sequence[Window] = ()) -> list[int]:
    """Steps at which the state is saved, and from which the run goes on as one that was killed does; none in a window that is
    `avoided`: those wait until its last step."""
    every = checkpoint_every(scene)
    steps = set(range(every, scene.steps, every) if every else ())
    for first, last in avoided:
        steps = {last - 1 if first <= step < last else step for step in steps}
    return sorted(step for step in steps if step < scene.steps)


def pieces(scene: Scene, saved: Sequence[int], done: int = 0) -> list[Piece]:
    """The run cut where the slide begins and ends and where the state is `saved`; after `done` steps, what is left of it."""
    begins, ends = slide(scene) or (scene.steps, scene.steps)
    cut, at = [], 0
    for stop in sorted({begins, ends, scene.steps, *saved} - {0}):
        drawn = begins <= at < ends
        if at >= done:
            cut.append(Piece(stop - at, drawn, drawn and stop == ends, stop if stop in saved else None))
        at = stop
    return cut
