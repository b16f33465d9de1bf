"""Runs the scenes of examples/scenes and draws the pictures of docs/gallery.md: `python examples/gallery.py [FOLDER] [SCENE…]`.

Runs lie in FOLDER (results/scenes); one that is finished there is not run again. A scene whose replay disagrees raises.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image

import pywet
from pywet.report import render

ROOT = Path(__file__).resolve().parent.parent
MOMENTS = {"hopper": 0.24, "drum": 0.8, "repose": 0.6, "migration": 0.4, "deck": 2.4}
"""Scene -> time of its picture [s]."""
WIDTH, COLOURS = 800, 255


def draw(name: str, folder: Path) -> Path:
    """Run a scene, unless it is there, and draw it small; returns the picture."""
    run = pywet.run(pywet.read_scene(ROOT / "examples" / "scenes" / f"{name}.yaml"), folder / name, progress=True)
    steps = np.unique(run.trajectory["step"])
    step = int(steps[np.argmin(np.abs(steps * run.scene.time_step_s - MOMENTS[name]))])
    large, small = folder / name / "gallery.png", ROOT / "docs" / "pictures" / f"scene_{name}.png"
    render.write(folder / name, large, step)
    picture = Image.open(large).convert("RGB")
    picture = picture.resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.Resampling.LANCZOS)
    palette = picture.quantize(COLOURS, Image.Quantize.MEDIANCUT)
    picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(small, optimize=True)
    return small


if __name__ == "__main__":
    where = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "scenes"
    for scene in sys.argv[2:] or MOMENTS:
        made = draw(scene, where)
        print(made.relative_to(ROOT), f"{made.stat().st_size / 1e3:.0f} kB", flush=True)
