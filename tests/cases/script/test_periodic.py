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


PLATE = "solid plate\n{}endsolid plate\n".format(
    "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {x} {y} .001\n" for x, y in corners)
        + "endloop\nendfacet\n"
        for corners in (
            ((-0.02, -0.02), (0.02, -0.02), (0.02, 0.02)),
            ((-0.02, -0.02), (0.02, 0.02), (-0.02, 0.02)),
        )
    )
)
WALLS = WET.replace("dry", "{plate: 30, y1: dry, y2: dry, z1: dry}") + "wall_film: part\n"
PLANES = [row for row in BEFORE.splitlines() if row.startswith(("fix y", "fix z"))]
SHAKES = """fix plate all mesh/surface/stress file plate.stl type 1
fix meshwall all wall/gran model hertz tangential history mesh n_meshes 1 meshes plate
fix shake all move/mesh mesh plate wiggle amplitude 0.001 0. 0.0005 period 0.02
"""


def bed(shift: float = 0.0, moves: str = SHAKES) -> str:
    """A bed of 192 spheres that is thrown and sheared, in a box periodic along x; shifted along x by a part of the box."""
    draw = np.random.default_rng(5)
    places = [(x, y, z) for z in range(3) for y in range(8) for x in range(8)]
    rows = []
    for n, place in enumerate(places, start=1):
        x, y, z = 0.005 * (np.array(place) + 0.5) + draw.uniform(-0.0004, 0.0004, 3) - (0.02, 0.02, 0.0) + (0, 0, 0.002)
        vx, vy, vz = draw.normal(0.0, 0.1, 3) + (0.4 * z / 0.015, 0.0, 0.0)
        x = (x + shift * SIDE + SIDE / 2) % SIDE - SIDE / 2
        rows += [
            f"create_atoms 1 single {x:.17g} {y:.17g} {z:.17g} units box",
            f"set atom {n} diameter {2 * R} density 2500 vx {vx:.17g} vy {vy:.17g} vz {vz:.17g}",
        ]
    start = TWO.replace("p p p", "p f f").replace("-0.02 0.02 units", "0 0.08 units")
    gravity = "fix gravi all gravity 9.81 vector 0 0 -1"
    return "\n".join([start, gravity, *PLANES, moves, *rows, "fix integr all nve/sphere\n"])
