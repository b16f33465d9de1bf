"""Figures 11a and 11b: the run of case 3 three seconds after the opening, whole and close by.

`python -m studies.full_scale.pictures RUN_DIR` draws docs/full_scale/fig11a.webp and fig11b.webp; the page shows them.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from pywet.errors import border
from pywet.report import caption, render
from pywet.report.sketch import colour_limit
from pywet.runs.rundir import RunDir
from pywet.util.files import atomic_write

TIME_S = 3.0
"""Time after the opening of the slide [s]."""
SIZE = 1000, 800
CLOSE_M = 0.045
"""Width of the close-up [m]."""


def draw(run_dir: Path, folder: Path) -> list[Path]:
    """Draw both pictures; VTK draws without a screen."""
    os.environ.setdefault(*next(iter(render.WINDOWS[0].items())))
    run = RunDir(run_dir)
    slide, line = run.scene.slide, run.timeline
    step = int(line.steps[int(np.argmin(np.abs(line.times - TIME_S - (slide.opens_at_s if slide else 0.0))))])
    centre, width = render.view(run, step)
    front = np.array([0.0, -0.35 * run.scene.box_high_m[1], run.scene.screen_z_m - centre[2] + 0.15 * CLOSE_M])
    limit, made = colour_limit(run, step), []
    for name, seen in (("fig11a", (centre, width)), ("fig11b", (centre + front, CLOSE_M))):
        image, mm = render.scene(run, step, seen, limit, SIZE)
        picture = caption.below(image, caption.entries(run), caption.sentence(run, step), mm)
        path = folder / f"{name}.webp"
        with atomic_write(path) as partial:
            picture.save(str(partial), format="WEBP", quality=85)
        made.append(path)
    return made


def main(run_dir: Annotated[Path, typer.Argument(help="Run of case 3 at full scale.")]) -> None:
    """Draw figures 11a and 11b of a run."""
    for path in draw(run_dir, Path("docs/full_scale")):
        typer.echo(str(path))


if __name__ == "__main__":
    with border():
        typer.run(main)
