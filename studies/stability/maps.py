"""Four maps of where runs remain finite, conserve liquid and create no energy, with the advisor's line on each.

A point of a map is judged by pairs of spheres that collide head on through their films (and, over time step and viscosity, by
a pair pressed together by its bridge and let go a little out of balance). It makes energy when it has a hundredth more than
was in play. Each job is one engine run, or a few where guards take cells out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pywet.cases.small import small
from pywet.cases.small.bodies import WETTED, contacts, sphere_classes, water
from pywet.laws import registry
from pywet.laws.contact import film_thickness, film_volume
from pywet.scene import ContactPair, SphereClass
from studies.stability import cells, judge, running
from studies.stability.cells import Batch, Cell, ball

Floats = NDArray[np.float64]
MADE = 0.01
"""Energy created over the energy in play above which a cell counts as creating energy."""
RADIUS, SIGMA = 2.5e-3, 0.07275
SMALL = 1e-3
STEP_STIFFNESS, STEP_FILM = 1e-5, 4e-5
"""Time steps [s] of the map over stiffness and velocity, and of that over film and size ratio."""
STEP_ANGLE = 2e-5
DRAWN = 0.13397459621556135
"""Share of their films that two equal spheres give: 1 - sqrt(3/4)."""


@dataclass(frozen=True)
class Map:
    """Axes of a map, its points, and the function for one of its jobs."""

    name: str
    title: str
    x: tuple[str, Floats]
    y: tuple[str, Floats]
    batch: Callable[[float], Batch]
    """Function for the job of one value of y."""
    limit: Callable[[float, float], float]
    """Function for the advisor's largest step over the actual step at a point; below 1 the advisor refuses or warns."""
    x_log: bool = True
    y_log: bool = True


def springs(stiffness: Sequence[float], restitution: float) -> tuple[ContactPair, ...]:
    """Return dry contacts without rolling resistance; type a against b with the smaller of their stiffnesses."""
    return contacts(len(stiffness), stiffness, friction=0.3, restitution=restitution)


def spheres(*radii: float, angle_rad: float | Sequence[float] = WETTED) -> tuple[SphereClass, ...]:
    """Size classes of the material of the stability maps."""
    return sphere_classes(*radii, angle_rad=angle_rad, name="size{k}")


def map_batch(**given: Any) -> Batch:
    """Make a job of a map: preset paper, space for spheres that fly apart, no window of contacts."""
    return Batch(effects=small.PAPER, windows=(0, 1), margin=4.0, **given)


def head_on(
    name: str, kinds: tuple[int, int], radii: tuple[float, float], films: tuple[float, float], v: float
) -> Cell:
    """Return two spheres that meet at a speed v [m/s]; the films touch after a few steps."""
    reach = sum(film_thickness(f, r) for r, f in zip(radii, films, strict=True))
    apart = sum(radii) + reach + 0.02 * min(radii)
    masses = [r**3 for r in radii]
    share = masses[1] / sum(masses)
    return Cell(
        name,
        (
            ball(kinds[0], (0.0, 0.0, 0.0), (0.0, 0.0, v * share), film=films[0]),
            ball(kinds[1], (0.0, 0.0, apart), (0.0, 0.0, -v * (1.0 - share)), film=films[1]),
        ),
    )


def advised(batch: Batch, film: float, effects: tuple[str, ...] | None = None) -> float:
    """Return the smallest limit [s] of the advisor for two spheres of the batch's classes with that film thickness.

    It is that of stability, or of the named effects.
    """
    limits = cells.advised(replace(batch, cells=()), film)
    return min(m.time_step_s for m in limits if (m.stability if effects is None else m.effect in effects))


# ---- time step and viscosity ----

STEPS_EXPLICIT = np.geomspace(5e-7, 3.2e-4, 12)
STEPS_IMPLICIT = np.geomspace(1.5e-5, 3.2e-4, 8)
VISCOSITIES = np.geomspace(1e-4, 10.0, 6)
FILM = 1e-4


def pressed(name: str) -> Cell:
    """Return two spheres with contact spring and capillary force in equilibrium; the bridge acts from the second step on."""
    film = film_volume(FILM, RADIUS)
    law = registry.get("capillary", "rabinovich").functions[0]
    force = law(0.0, DRAWN * film, RADIUS, RADIUS, WETTED, WETTED, SIGMA)
    return Cell(
        name,
        (
            ball(1, (0.0, 0.0, 0.0), (1e-3, 0.0, 0.0), film=film),
            ball(1, (0.0, 0.0, 2.0 * RADIUS - force / 1e4), (-1e-3, 0.0, 0.0), film=film),
        ),
    )


def stepping(viscosity: float, step: float, how: str) -> Batch:
    film = film_volume(FILM, RADIUS)
    hit = head_on("hit", (1, 1), (RADIUS, RADIUS), (film, film), 0.2)
    return map_batch(
        name="map-step", classes=spheres(RADIUS), pairs=springs([1e4], 0.8), liquid=water(0.0, viscosity),
        time_step=step, steps=int(min(max(800, 5e-3 / step), 8000)), cells=(hit, pressed("pressed")),
        how=how,
    )  # fmt: skip


ORDER = ("stable", "energy", "ledger", "not finite", "stopped")


def states(batch: Batch, run_dir: Path) -> list[dict[str, Any]]:
    """Run a job and return the state of each of its cells, by the maps' own measure of energy."""
    left, stopped = running.run_cells(batch, run_dir, allow_unstable=True)
    made = {name: {"state": "stopped", "message": message, "made": math.nan} for name, message in stopped.items()}
    if len(stopped) < len(batch.cells):
        for name, v in judge.verdicts(left, run_dir).items():
            by_energy = "energy" if v["raw"] > MADE else "stable"
            state = by_energy if v["state"] in ("stable", "energy") else v["state"]
            made.setdefault(name, {"state": state, "message": "", "made": v["raw"]})
    return [made[c.name] for c in batch.cells]


def worst(of_cells: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the worst state, and the largest energy created."""
    return max(of_cells, key=lambda s: (ORDER.index(s["state"]), s["made"]))


def time_step_map(how: str) -> Map:
    """Return the map over time step and viscosity, for one method of integration."""
    steps = STEPS_EXPLICIT if how == "explicit" else STEPS_IMPLICIT
    return Map(
        f"step_{how}", f"Time step and viscosity, {how.replace('_', '-')} drag", ("time step [s]", steps),
        ("viscosity [Pa s]", VISCOSITIES), lambda eta: stepping(eta, 1e-6, how),
        lambda dt, eta: advised(stepping(eta, dt, how), FILM) / dt,
    )  # fmt: skip


# ---- stiffness and velocity ----

STIFFNESSES = np.geomspace(1e2, 1e6, 17)
SPEEDS = np.geomspace(1e-2, 10.0, 7)


def stiffness_batch(v: float) -> Batch:
    """Return all stiffnesses at one speed; elastic spheres of 1 mm, a film of 1 % of the radius, little drag."""
    n = len(STIFFNESSES)
    film = film_volume(0.01 * SMALL, SMALL)
    return map_batch(
        name="map-stiffness", classes=spheres(*[SMALL] * n),
        pairs=springs(STIFFNESSES.tolist(), 1.0), liquid=water(0.0, 1e-4), time_step=STEP_STIFFNESS,
        steps=int(max(400, min(0.25 * SMALL / v / STEP_STIFFNESS + 250, 6000))),
        cells=tuple(head_on(str(k), (k + 1, k + 1), (SMALL, SMALL), (film, film), v) for k in range(n)),
    )  # fmt: skip


def stiffness_limit(k: float, v: float) -> float:
    batch = replace(stiffness_batch(1.0), classes=spheres(SMALL), pairs=springs([k], 1.0))
    return advised(batch, 0.01 * SMALL) / STEP_STIFFNESS


# ---- film and size ratio ----

FILMS = np.geomspace(1e-6, 0.2, 13)
RATIOS = np.array([1.0, 1.5, 2.5, 4.0, 6.0, 8.0, 10.0])
RATIO_VISCOSITY = 0.1


def ratio_batch(ratio: float) -> Batch:
    """Return all films (over the small sphere's radius) at one size ratio; the small sphere has 1 mm."""
    radii = (SMALL, ratio * SMALL)
    films = [tuple(film_volume(thickness * SMALL, r) for r in radii) for thickness in FILMS]
    made = (head_on(str(n), (1, 2), radii, (a, b), 0.2) for n, (a, b) in enumerate(films))
    return map_batch(
        name="map-ratio", classes=spheres(*radii), pairs=springs([2e3, 2e3], 0.9), liquid=water(0.0, RATIO_VISCOSITY),
        time_step=STEP_FILM, steps=1200, cells=tuple(made),
    )  # fmt: skip


def ratio_limit(thickness: float, ratio: float) -> float:
    """Return the advisor's limit for one film and one pair of sizes."""
    return advised(ratio_batch(ratio), thickness * SMALL) / STEP_FILM


# ---- contact angle and volume ----

ANGLES = np.array([0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 89.0])
VOLUMES = np.geomspace(1e-9, 0.5, 15)


def angle_batch(angle: float) -> Batch:
    """Return all bridge volumes at one contact angle; equal spheres of 1 mm that meet slowly, so that capillarity dominates."""
    films = (v_star * SMALL**3 / DRAWN for v_star in VOLUMES)
    made = (head_on(str(n), (1, 1), (SMALL, SMALL), (film, film), 0.02) for n, film in enumerate(films))
    return map_batch(
        name="map-angle", classes=spheres(SMALL, angle_rad=math.radians(angle)), pairs=springs([1e3], 0.9), liquid=water(),
        time_step=STEP_ANGLE, steps=2500, cells=tuple(made),
    )  # fmt: skip


def angle_limit(v_star: float, angle: float) -> float:
    """Return the advisor's resolution limit of the capillary force."""
    film = v_star * SMALL**3 / DRAWN
    return advised(angle_batch(angle), film_thickness(film, SMALL), ("capillary", "passing a bridge")) / STEP_ANGLE


MAPS: dict[str, Map] = {
    m.name: m
    for m in (
        time_step_map("explicit"),
        time_step_map("semi_implicit"),
        Map(
            "stiffness", "Contact stiffness and speed", ("normal stiffness [N/m]", STIFFNESSES), ("speed [m/s]", SPEEDS),
            stiffness_batch, stiffness_limit,
        ),
        Map(
            "ratio", "Film thickness and size ratio", ("film thickness over small radius", FILMS), ("size ratio", RATIOS),
            ratio_batch, ratio_limit, y_log=False,
        ),
        Map(
            "angle", "Bridge volume and contact angle", ("V* of the bridge", VOLUMES), ("contact angle [deg]", ANGLES),
            angle_batch, angle_limit, y_log=False,
        ),
    )
}  # fmt: skip


def row_of(chart: Map, number: int, run_dir: Path) -> pd.DataFrame:
    """Execute one job: the row of a map for the y value with that number."""
    y = float(chart.y[1][number])
    limits = [chart.limit(float(x), y) for x in chart.x[1]]
    if chart.name.startswith("step_"):
        how = chart.name.removeprefix("step_")
        judged = [worst(states(stepping(y, float(x), how), run_dir / str(n))) for n, x in enumerate(chart.x[1])]
    else:
        judged = states(chart.batch(y), run_dir)
    points = zip(chart.x[1], judged, limits, strict=True)
    return pd.DataFrame([{"x": float(x), "y": y, **reported, "limit": limit} for x, reported, limit in points])
