"""Bridges across a periodic boundary: as those in the middle of the box, replayed, on two ranks, restarted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.cases.script.scripts import BEFORE, WET, run, write

pytestmark = pytest.mark.engine
SIDE = 0.04
"""Length of the box [m]."""
R = 0.002
TWO = BEFORE[: BEFORE.index("fix             gravi")].replace("f f f", "p p p").replace("0 0.08", "-0.02 0.02")
LINE = "fix wet all pywet liquid wet.yaml every 50 windows 50"


def pair(middle: tuple[float, float, float]) -> str:
    """Two spheres that meet aslant at a place while they drift, touch, and part; both turn."""
    rows = []
    for n, side in ((1, -1.0), (2, 1.0)):
        x = [m + side * d for m, d in zip(middle, (0.0021, 0.0005, 0.0), strict=True)]
        x = [(a + SIDE / 2) % SIDE - SIDE / 2 for a in x]
        rows += [
            f"create_atoms 1 single {' '.join(f'{a:.17g}' for a in x)} units box",
            f"set atom {n} diameter {2 * R} density 2500 vx {0.3 - side * 0.2} vy 0.05 vz {-0.1 * side}",
        ]
    return "\n".join([TWO, *rows, "velocity all set 0 0 0 sum yes units box", "fix integr all nve/sphere\n"])


def wet_run(folder: Path, before: str, after: str, line: str = LINE, wet: str = WET) -> Path:
    """Run a script with liquid, whose folder of tables is given back."""
    folder.mkdir()
    write(folder, before=before, line=line, after=after, wet=wet)
    done = run(folder)
    assert done.returncode == 0, done.stderr + done.stdout[-2000:]
    return folder / "wet"


def table(log: Path, name: str) -> pd.DataFrame:
    return pd.read_parquet(log / "history" / f"{name}.parquet")
