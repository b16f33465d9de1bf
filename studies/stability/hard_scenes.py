"""Stress tests: a few engine runs of many cells with extreme conditions of user scenes, at small size."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pywet.cases.small import small
from pywet.cases.small.bodies import water
from pywet.cases.small.small import Sphere
from pywet.scene import Vibration
from studies.stability import running
from studies.stability.cells import FCC, Batch, Cell, ball
from studies.stability.maps import DRAWN, spheres, springs
from studies.stability.random_cases import bar, slab

Floats = NDArray[np.float64]
R, RATIO = 2.5e-3, 10.0
TINY = R / RATIO
WIRE = 1e-3
PLATE = tuple(slab(0.01))
ALONG, ACROSS = ((bar(0.014, WIRE, axis, -2.8e-3), bar(0.014, WIRE, axis, 2.8e-3)) for axis in (0, 1))
"""Two wires 5.6 mm apart."""
HERTZ = 50.6
SCREEN = 0.9e-3
"""Vertical amplitude of the paper's screen [m]."""


def of(v_star: float, radius: float = R) -> float:
    """Return the film [m3] of each of two equal spheres whose bridge has that V*."""
    return v_star * radius**3 / DRAWN


def dense(film: float, speed: float, outward: bool = False, kind: int = 1, radius: float = R) -> tuple[Sphere, ...]:
    """Return thirteen spheres that touch exactly (S = 0), with random velocities, or all twelve outward at the same speed."""
    random = np.random.default_rng(4)
    bodies = [ball(kind, (0.0, 0.0, 0.0), film=film)]
    for n in np.array(FCC) / math.sqrt(2.0):
        v = speed * n if outward else random.normal(0.0, speed, 3)
        bodies.append(ball(kind, 2.0 * radius * n, v, film=film))
    return tuple(bodies)


def two(gap: float, speed: float, films: tuple[float, float], kinds: tuple[int, int] = (1, 1)) -> tuple[Sphere, ...]:
    """Return two spheres a gap apart that meet (speed > 0) or separate."""
    radius = {1: R, 2: TINY}
    apart = radius[kinds[0]] + radius[kinds[1]] + gap
    return (
        ball(kinds[0], (0.0, 0.0, 0.0), film=films[0]),
        ball(kinds[1], (0.0, 0.0, apart), (0.0, 0.0, -speed), film=films[1]),
    )


def between(speed: float) -> tuple[Sphere, ...]:
    """Return a tiny wet sphere between two large dry ones that separate."""
    reach = R + TINY
    return (
        ball(2, (0.0, 0.0, 0.0), film=of(0.5, TINY)),
        ball(1, (0.0, 0.0, -reach), (0.0, 0.0, -speed)),
        ball(1, (0.0, 0.0, reach), (0.0, 0.0, speed)),
    )


def hard(name: str, cells: Iterable[Cell], radii: tuple[float, ...] = (R, TINY), **given: Any) -> Batch:
    """Return a batch of the preset paper with water, stiffness of 20 and 2 kN/m, and 45 degrees at walls by default."""
    usual = {
        "classes": spheres(*radii), "pairs": springs([2e4, 2e3][: len(radii)], 0.8), "liquid": water(), "effects": small.PAPER,
        "time_step": 4e-6, "wall_angle": math.radians(45.0),
    }  # fmt: skip
    return Batch(name=f"hard-{name}", cells=tuple(cells), **{**usual, **given})


def plain() -> Batch:
    """Return the batch with water, explicit, spheres of 2.5 and 0.25 mm."""
    thin, thick = of(1e-9), of(0.5)
    cells = [
        Cell("size ratio 10, collision", two(2e-4, 0.3, (of(0.05), of(0.05, TINY)), (1, 2))),
        Cell("size ratio 10, film on the small one only", two(0.0, -0.05, (0.0, of(0.3, TINY)), (1, 2))),
        Cell("V* = 1e-9", two(0.0, -0.002, (thin, thin))),
        Cell("V* = 0.5", two(0.0, -0.3, (thick, thick))),
        Cell("V* = 0.5, fast", two(5e-4, 1.0, (thick, thick))),
        Cell("one film is zero", two(0.0, -0.2, (of(0.05), 0.0))),
        Cell("no film at all", two(1e-5, 0.3, (0.0, 0.0))),
        Cell("one sphere alone", (ball(1, (0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (5.0, 3.0, 1.0), of(0.1)),)),
        Cell("dense lattice, S = 0", dense(of(0.02), 0.05)),
        Cell("twelve bridges break in one step", dense(of(0.002), 0.2, outward=True)),
        Cell("a film that runs dry", dense_dry()),
        Cell("tiny sphere between two large ones", between(0.05)),
        Cell("edge of a plate", (ball(1, (0.009, 0.0, R + 2e-5), (0.3, 0.05, 0.0), film=of(0.05)),), PLATE),
        Cell(
            "on three wires at once",
            (ball(1, (0.0, 0.0, R + WIRE + 2e-5), (0.25, 0.02, 0.0), film=of(0.3)),),
            (bar(0.014, WIRE, 0), bar(0.014, WIRE, 1, 1.2e-3), bar(0.014, WIRE, 1, -1.2e-3)),
        ),
        Cell("around a wire", (ball(1, (0.0, 2e-4, R + WIRE + 1e-5), (0.0, 0.15, 0.0), film=of(0.2)),), (bar(0.014, WIRE, 0),)),
        Cell("stuck between two wires", wedged(of(0.1)), ALONG),
        Cell("spin without slide", (ball(1, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 80.0, 0.0), of(0.05)),
                                    ball(1, (0.0, 0.0, 2.0 * R), film=of(0.05)))),
    ]  # fmt: skip
    return hard("plain", cells, time_step=2e-6, steps=3000)


def dense_dry() -> tuple[Sphere, ...]:
    """Return thirteen spheres of which only the middle one has a film: twelve bridges draw from it, then separate and return."""
    bodies = dense(0.0, 0.1, outward=True)
    return (ball(1, (0.0, 0.0, 0.0), film=of(0.05)), *bodies[1:])


def wedged(film: float, gap: float = 2e-6) -> tuple[Sphere, ...]:
    """Return a sphere in the gap of two wires 5.6 mm apart."""
    height = math.sqrt((R + WIRE + gap) ** 2 - 2.8e-3**2)
    return (ball(1, (0.0, 0.0, height), film=film),)


def shaken(times: float, name: str) -> Batch:
    """Return a batch with walls that vibrate like a screen, `times` the paper's amplitude: wedged, resting, and stuck spheres."""
    deep = math.sqrt((R + WIRE + 2e-6) ** 2 - 2.8e-3**2)
    below = (ball(2, (0.0, 0.0, -TINY - WIRE - 5e-6), film=of(0.2, TINY)),)
    cells = (
        Cell("sphere wedged between two shaken wires", wedged(of(0.1)), ALONG),
        Cell(
            "sphere in a square aperture of shaken wires", (ball(1, (0.0, 0.0, deep), film=of(0.3)),), (*ALONG, *ACROSS)
        ),
        Cell("tiny sphere stuck below a wire, torn off", below, (bar(0.014, WIRE, 0),)),
        Cell("sphere on a shaken plate", (ball(1, (0.0, 0.0, R + 2e-5), film=of(0.1)),), PLATE),
        Cell(
            "two spheres on a shaken plate",
            (ball(1, (0.0, 0.0, R + 2e-5), film=of(0.1)), ball(2, (0.0, 0.0, 2 * R + TINY + 4e-5), film=of(0.1, TINY))),
            PLATE,
        ),
    )
    amplitude = (1e-4 * times, 0.0, SCREEN * times)
    motion = Vibration(amplitude_m=amplitude, phase_rad=(0.0, 0.0, 0.0), frequency_Hz=HERTZ)
    return hard(name, cells, pairs=springs([5e4, 5e3], 0.6), steps=7500, gravity=(0.0, 0.0, -9.81), vibration=motion)


TEN_G = 10.0 * 9.81 / (SCREEN * (2.0 * math.pi * HERTZ) ** 2)
"""Factor on the screen's amplitude for an acceleration of ten times gravity."""


def thick() -> Batch:
    """Return the batch with 10 Pa s, semi-implicit, contact angles of 0 and 89 degrees; the second size is half the first."""
    half, film = 0.5 * R, of(0.1, 0.5 * R)
    classes = spheres(R, half, angle_rad=(math.radians(89.0), 0.0))
    unlike = (ball(1, (0.0, 0.0, 0.0), film=of(0.1)), ball(2, (0.0, 0.0, R + half), (0.0, 0.0, 0.3), film=film))
    lying = (ball(1, (0.0, 0.0, R + 5e-5), (0.1, 0.0, -0.05), film=of(0.2)),)
    cells = (
        Cell("10 Pa s, dense lattice", dense(of(0.05, half), 0.05, kind=2, radius=half)),
        Cell("10 Pa s, 89 degrees, dense lattice", dense(of(0.05), 0.02)),
        Cell("10 Pa s, collision at 1 m/s", two(1e-3, 1.0, (of(0.5), of(0.5)))),
        Cell("10 Pa s, pulled apart", two(0.0, -0.5, (of(0.05), of(0.05)))),
        Cell("angles of 0 and 89 degrees", unlike),
        Cell("89 degrees at a plate", lying, PLATE),
    )
    how: dict[str, Any] = {"liquid": water(0.0, 10.0), "how": "semi_implicit", "wall_angle": math.radians(89.0)}
    return hard("thick", cells, classes=classes, steps=1200, **how)


def unwetted() -> Batch:
    """Return the batch with contact angles of 89 degrees and the exact bridge, whose force changes sign with the gap."""
    classes = spheres(R, TINY, angle_rad=math.radians(89.0))
    near = (ball(1, (0.0, 0.0, R + 5e-5), (0.1, 0.0, -0.05), film=of(0.2)),)
    cells = (
        Cell("exact, 89 degrees, dense lattice", dense(of(0.05), 0.02)),
        Cell("exact, 89 degrees, collision", two(1e-3, 0.3, (of(0.5), of(0.5)))),
        Cell("exact, 89 degrees, pulled apart", two(0.0, -0.1, (of(0.05), of(0.05)))),
        Cell("exact, 89 degrees, size ratio 10", two(0.0, -0.1, (of(0.1), of(0.1, TINY)), (1, 2))),
        Cell("exact, 89 degrees, at a plate", near, PLATE),
    )
    return replace(
        thick(), name="hard-unwetted", classes=classes, cells=cells, effects=small.EXACT, liquid=water(), how="explicit"
    )


def mismatch() -> Batch:
    """Return the batch with contact angles of 0 and 89 degrees on one bridge, for which the parabola has no meridian."""
    classes = spheres(R, TINY, angle_rad=(0.0, math.radians(89.0)))
    cells = (Cell("angles of 0 and 89 degrees, size ratio 10", two(0.0, -0.3, (of(0.1), of(0.1, TINY)), (1, 2))),)
    return replace(thick(), name="hard-mismatch", classes=classes, cells=cells)


def bare() -> Batch:
    """Return the batch without surface tension and viscosity: liquid is only exchanged."""
    cells = (
        Cell("nothing holds, collision", two(2e-4, 0.3, (of(0.05), of(0.05)))),
        Cell("nothing holds, dense lattice", dense(of(0.02), 0.05)),
        Cell("nothing holds, plate", (ball(1, (0.0, 0.0, R + 2e-5), (0.1, 0.0, -0.1), film=of(0.1)),), PLATE),
    )  # fmt: skip
    return hard("bare", cells, (R,), pairs=springs([2e4], 1.0), liquid=water(0.0, 0.0, 0.0), steps=1500, wall_angle=0.0)


def out_of_the_box() -> Batch:
    """Return the batch with one sphere faster than the guard allows and one pressed too deep, which stop the run."""
    cells = (
        Cell("too fast for the step", (ball(1, (0.0, 0.0, 0.0), (100.0, 0.0, 0.0), film=of(0.1)),)),
        Cell("pressed too deep", two(-0.6 * R, 0.0, (of(0.1), of(0.1)))),
        Cell("a quiet pair next to them", two(0.0, 0.0, (of(0.1), of(0.1)))),
    )
    return hard("guards", cells, (R,), steps=500, wall_angle=0.0, windows=(1, 60))


SCENES: dict[str, Callable[[], Batch]] = {
    "plain": plain,
    "ten_g": lambda: shaken(TEN_G, "ten-g"),
    "ten_times": lambda: shaken(10.0, "ten-times"),
    "thick": thick,
    "unwetted": unwetted,
    "mismatch": mismatch,
    "bare": bare,
    "guards": out_of_the_box,
}
MEANT_TO_STOP = ("too fast for the step", "pressed too deep", "angles of 0 and 89 degrees, size ratio 10")


def judged(name: str, run_dir: Path) -> pd.DataFrame:
    """Run a batch of stress tests and judge every cell of it."""
    batch = SCENES[name]()
    table = running.judged(batch, run_dir, allow_unstable=name == "guards")
    table["expected"] = ["stopped" if c in MEANT_TO_STOP else "stable" for c in table["case"]]
    return table
