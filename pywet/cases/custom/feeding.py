"""Positions of inserted spheres on the path on which they travel until they enter, and when the engine creates them there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from pywet.cases.custom.description import Scene
from pywet.cases.custom.extent import IMPACT_SPEED_RATIO
from pywet.cases.custom.spheres import Spheres
from pywet.engines.schedule import outlets_every_s
from pywet.errors import ConfigError
from pywet.geometry.packing import refuse_beyond_memory
from pywet.geometry.surface import Floats
from pywet.scene import SphereClass

SPACING = 1.05
"""Smallest distance of centres over that at which spheres and their films touch."""
MOST_PLACES = 10_000_000
"""Largest number of points, one diameter apart, on the paths of a class that are checked against walls."""
TRIES = 2000
"""Largest number of random positions tried for a sphere."""


def ahead_s(scene: Scene, classes: Sequence[SphereClass], wall_speed: float) -> float | None:
    """Return the time [s] before its insertion at which a sphere is created; None: all exist from the start.

    It covers the interval of checkpoints and a path out of reach of the bed: a sphere that leaves a wall at u, the sum of
    `IMPACT_SPEED_RATIO` times the wall's speed and the speed of insertion, rises by u²/(2g). The first sphere exists from the
    start, which the engine needs.
    """
    speeds = [math.hypot(*s.velocity_m_per_s) for s in scene.spheres if s.insertion]
    g = math.hypot(*scene.gravity_m_per_s2)
    if not (scene.outlets and speeds and g):
        return None
    most = max((IMPACT_SPEED_RATIO * wall_speed + v) ** 2 / (2.0 * g * v) for v in speeds)
    clear = most + 2.0 * max(c.radius_m for c in classes) / min(speeds)
    first = min(c.insertion.at(0, c.count) if c.insertion else 0.0 for c in classes if c.count)
    return max(outlets_every_s(scene.results.interval_s) + clear, first)


def waiting(
    classes: Sequence[SphereClass], entries: Sequence[Spheres], films: Sequence[float], seed: int, ahead: float | None
) -> pd.DataFrame:
    """type, x, y, z of all inserted spheres: a random position in their region, minus the path until they enter.

    `entries` and the initial film thicknesses `films` [m] correspond to `classes`.
    """
    for c, entry in zip(classes, entries, strict=True):
        _refuse_narrow(entry, c, ahead)
    random = np.random.default_rng(seed)
    turn = sorted((at, c.type) for c in classes for at in times(c))
    reach = np.array([c.radius_m for c in classes]) + np.array(films)
    places, kinds = np.zeros((len(turn), 3)), np.array([kind for _, kind in turn], dtype=np.int64)
    for n, (at, kind) in enumerate(turn):
        entry, radius = entries[kind - 1], classes[kind - 1].radius_m
        distance = SPACING * (reach[kind - 1] + reach[kinds[:n] - 1])
        for _ in range(TRIES):
            place = _inside(entry.box or entry.cylinder, radius, random) - at * np.array(entry.velocity_m_per_s)
            if (((places[:n] - place) ** 2).sum(axis=1) >= distance**2).all():
                places[n] = place
                break
        else:
            share = _share(entry, classes, entries)
            raise ConfigError(
                f"spheres {entry.name}: no place is left for the sphere that enters at {at:.3g} s, after {n} others; all that "
                f"enter here are {100 * share:.0f} % of the volume that passes per second, and random places hold about 35 %; "
                "expected a lower rate or fewer spheres, a larger region, a longer insertion.for_s or a larger velocity_m_per_s",
                code="scene.crowded_feed",
                key=f"spheres.{entry.name}",
                given=share,
            )
    return pd.DataFrame({"type": kinds, **dict(zip("xyz", places.T, strict=True))})


def _share(entry: Spheres, classes: Sequence[SphereClass], entries: Sequence[Spheres]) -> float:
    """Volume of spheres that enter per second, at most, in the region of an entry, over the volume that it sweeps per second."""
    region = (entry.box or entry.cylinder).region()  # type: ignore[union-attr]
    (x, y), z = region.sides_m, region.z_high_m - region.z_low_m
    across = np.array([y * z, x * z, x * y if region.shape == "square" else math.pi / 4.0 * x * y])
    swept = float(np.abs(entry.velocity_m_per_s) @ across)
    same = [c for c, e in zip(classes, entries, strict=True) if (e.box, e.cylinder) == (entry.box, entry.cylinder)]
    rate = 0.0
    for c, insertion in ((c, c.insertion) for c in same if c.insertion):
        most = {"ramp": 2.0, "pulsed": 1.0 / insertion.pulse_share}.get(insertion.profile, 1.0)
        rate += most * c.count * 4.0 / 3.0 * math.pi * c.radius_m**3 / insertion.for_s
    return rate / swept if swept else math.inf


def _refuse_narrow(entry: Spheres, sphere: SphereClass, ahead: float | None) -> None:
    """Refuse a region that is too small for a sphere, and paths that are too long to be checked."""
    if not sphere.insertion:
        return
    refuse_beyond_memory(sphere.count, f"spheres {entry.name}", "expected a smaller count or mass_g")
    region = (entry.box or entry.cylinder).region()  # type: ignore[union-attr]
    least = min(*region.sides_m, region.z_high_m - region.z_low_m)
    if least <= 2.0 * sphere.radius_m:
        raise ConfigError(
            f"spheres {entry.name}: their region is {1e3 * least:g} mm wide or high, the sphere {2e3 * sphere.radius_m:g} mm; "
            "expected a box or cylinder that holds a sphere",
            code="scene.narrow_region",
            key=f"spheres.{entry.name}",
            given=least,
            expected=2.0 * sphere.radius_m,
        )
    way = min(sphere.insertion.from_s + sphere.insertion.for_s, ahead or math.inf) * math.hypot(*entry.velocity_m_per_s)
    if sphere.count * way / (2.0 * sphere.radius_m) > MOST_PLACES:
        raise ConfigError(
            f"spheres {entry.name}: {sphere.count} of them come {way:.3g} m until the last enters, expected at most "
            f"{MOST_PLACES:.0e} diameters of travel in all: a smaller velocity_m_per_s or an earlier end of feeding",
            code="scene.long_feed",
            key=f"spheres.{entry.name}",
            given=way,
        )


def ways(classes: Sequence[SphereClass], table: pd.DataFrame, ahead: float | None) -> tuple[Floats, Floats]:
    """Positions (n, 3) along the paths of all inserted spheres since their creation, at most a diameter apart, and the radii."""
    found, size = [np.zeros((0, 3))], [np.zeros(0)]
    for c in classes:
        rows = table[table["type"] == c.type]
        starts, speeds = (rows[names].to_numpy(dtype=float) for names in (["x", "y", "z"], ["vx", "vy", "vz"]))
        for start, speed, at in zip(starts, speeds, times(c), strict=False):
            begin = max(0.0, at - (ahead or math.inf))
            time = np.linspace(begin, at, 2 + int((at - begin) * np.linalg.norm(speed) / (2.0 * c.radius_m)))
            found.append(start + time[:, None] * speed)
            size.append(np.full(len(time), c.radius_m))
    return np.concatenate(found), np.concatenate(size)


def times(sphere: SphereClass) -> list[float]:
    """Return the times [s] at which the spheres of a class enter; empty if the class is not inserted during the run."""
    return [sphere.insertion.at(k, sphere.count) for k in range(sphere.count)] if sphere.insertion else []


def _inside(shape: Any, radius: float, random: np.random.Generator) -> Floats:
    """Return a random position of a sphere within a region."""
    region = shape.region()
    half = 0.5 * np.array(region.sides_m) - radius
    while True:
        across = random.uniform(-half, half)
        if region.shape == "square" or np.hypot(*across) <= half[0]:
            break
    return np.array(
        [*(across + np.array(region.centre_m)), random.uniform(region.z_low_m + radius, region.z_high_m - radius)]
    )
