"""Scenes with different requirements: each a setup, its quantities of interest, and a sentence for the page."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pywet import config
from pywet.cases.screening import cases
from pywet.cases.small.bodies import contacts, drum_radius, drum_walls, in_drum, sphere_classes, wetting
from pywet.cases.small.small import Sphere
from pywet.geometry.motion import peak_speed
from pywet.geometry.solids import bin_solid
from pywet.geometry.surface import Surface, make_surface
from pywet.planning.surroundings import Surroundings
from pywet.scene import Effects, EngineScene, Rotation, SphereClass
from pywet.shipped import place
from pywet.util.files import read_table
from studies.effects import measures
from studies.effects.setup import SHAKEN, Setup, jets, lattice, pyramid
from studies.study import configured
from studies.subset import with_spheres

CONFIG = place("config")
"""Default configuration."""
NAMED, ROLLING = "{mm} mm", 2e-5
"""Name of a class of spheres; rolling friction [m] of glass of some millimetres."""
Measure = Callable[[Path], dict[str, float]]


@dataclass(frozen=True)
class StudyScene:
    """`setup(seed, size, config_dir)`: size 1 is that of the study, smaller has fewer spheres or a shorter time.

    Only a case of the configuration uses `config_dir`.
    """

    title: str
    story: str
    setup: Callable[[int, float, Path], Setup]
    wanted: Measure


def _glass(radius_m: float, count: int) -> tuple[SphereClass, ...]:
    return sphere_classes(radius_m, counts=count, name=NAMED)


def _box(half: float, height: float) -> tuple[Surface, ...]:
    return (make_surface("box", "wall", bin_solid(half, 0.25 * half, 4, 0.0, height)),)


def _bed(radii_m: tuple[float, ...], count: int, seed: int, density: float, angle: float, stiffness: float,
         rolling_m: float, friction: float = 0.4, seconds: float = 0.25) -> Setup:  # fmt: skip
    """Return spheres that fall into a box and come to rest; the caller adds liquid."""
    share = count // len(radii_m)
    classes = sphere_classes(*radii_m, counts=share, density=density, angle_rad=math.radians(angle), name=NAMED)
    kinds = [c.type for c in classes for _ in range(share)]
    r = max(c.radius_m for c in classes)
    across = max(3, round((0.7 * len(kinds)) ** (1.0 / 3.0)))
    pitch = 2.2 * r
    half = 0.5 * across * pitch + 0.1 * r
    layers = math.ceil(len(kinds) / across**2)
    walls = _box(half, (layers + 12) * pitch)
    wall_share = min(1.0, 2.5 / across)
    return Setup(
        classes=classes,
        pairs=contacts(len(classes), stiffness, friction=friction, rolling_m=rolling_m),
        liquid=None,
        speed=math.sqrt(9.81 * layers * 0.4 * r),
        surroundings=Surroundings(wall_share=wall_share, duration_s=seconds),
        spheres=lattice(kinds, across, pitch, r + SHAKEN * pitch, seed),
        seconds=seconds,
        walls=walls,
    )


def _wet(setup: Setup, moisture: float) -> Setup:
    return replace(setup, liquid=wetting(setup.classes, moisture))


def dry_glass(seed: int, size: float, config_dir: Path) -> Setup:
    """Return dry glass of 3 mm falling into a box."""
    return _bed((1.5e-3,), max(27, round(220 * size)), seed, 2500.0, 15.0, 3e3, 2e-5)


def moist_pom(seed: int, size: float, config_dir: Path) -> Setup:
    """Return plastic of 3 and 5 mm with 5 % water falling into a box."""
    return _wet(_bed((1.5e-3, 2.5e-3), max(26, round(180 * size)), seed, 1358.0, 40.0, 2e3, 5e-5, 0.35), 5.0)


def micron_powder(seed: int, size: float, config_dir: Path) -> Setup:
    """Return glass of 50 um with 1 % water: the capillary force is thousands of weights."""
    return _wet(_bed((25e-6,), max(27, round(140 * size)), seed, 2500.0, 15.0, 20.0, 2.5e-8, seconds=0.008), 1.0)


def thick_oil(seed: int, size: float, config_dir: Path) -> Setup:
    """Return a pile of glass in a tray, wetted with oil of 2 Pa s, at rest."""
    side, r = (5 if size >= 0.5 else 3), 1.5e-3
    classes = _glass(r, side * (side + 1) * (2 * side + 1) // 6)
    return Setup(
        classes=classes,
        pairs=contacts(1, 3e3, rolling_m=ROLLING),
        liquid=wetting(classes, 2.0, 2.0, 0.03),
        speed=0.0,
        surroundings=Surroundings(state="at_rest", wall_share=0.3, duration_s=0.15),
        spheres=pyramid(side, r, seed),
        seconds=0.15 * max(size, 0.4),
        walls=_box(side * r, 2.0 * side * r),
    )


def fast_dilute(seed: int, size: float, config_dir: Path) -> Setup:
    """Return two clouds of glass of 8 mm with a little solvent that fly through each other at 5 m/s; only motion is evaluated."""
    count, r, speed, pitch = max(32, 2 * round(128 * size)), 4e-3, 5.0, 13e-3
    classes = _glass(r, count)
    seconds = 0.024
    return Setup(
        classes=classes,
        pairs=contacts(1, 1e6, friction=0.2, rolling_m=ROLLING),
        liquid=wetting(classes, 0.5, 3e-4, 0.023),
        speed=speed,
        surroundings=Surroundings(
            state="dilute", gravity_m_per_s2=9.81, duration_s=seconds, solid_fraction=0.06, wall_share=0.0,
            liquid_wanted=False,
        ),
        spheres=jets(count, r, speed, pitch, seed),
        seconds=seconds,
    )  # fmt: skip


def collision(seed: int, size: float, config_dir: Path) -> Setup:
    """Return two wet spheres that meet once, off centre; exact to the last digit, so that the smallest effect is visible."""
    r, speed, gap = 1.5e-3, 1.0, 2e-4
    classes = _glass(r, 2)
    offset = np.random.default_rng(seed).uniform(0.3, 0.7) * r
    along = math.sqrt(4.0 * r**2 - offset**2) + gap
    u, w = math.sqrt(1.0 - (offset / (2 * r)) ** 2), offset / (2 * r)  # the line of centres at touch lies along x
    at, v = np.array([along * u + offset * w, offset * u - along * w]), np.array([u, -w])
    ends = [(-0.5, 1.0), (0.5, -1.0)]
    spheres = tuple(
        Sphere(1, (float(k * at[0]), float(k * at[1]), 0.0), (float(0.5 * d * speed * v[0]), float(0.5 * d * speed * v[1]), 0.0))
        for k, d in ends
    )  # fmt: skip
    seconds = 4e-3
    return Setup(
        classes=classes,
        pairs=contacts(1, 1e5, friction=0.2, rolling_m=ROLLING),
        liquid=wetting(classes, 1.0),
        speed=speed,
        surroundings=Surroundings(
            state="dilute", gravity_m_per_s2=0.0, duration_s=seconds, solid_fraction=0.0, wall_share=0.0, liquid_wanted=False
        ),
        spheres=spheres,
        seconds=seconds,
        gravity=(0.0, 0.0, 0.0),
    )  # fmt: skip


def wet_drum(seed: int, size: float, config_dir: Path) -> Setup:
    """Return glass of 3 mm with 2 % water in a slow drum."""
    count, r = max(60, round(150 * size)), 1.5e-3
    classes = _glass(r, count)
    width = 6.0 * r
    radius = drum_radius(count, r, width)
    return Setup(
        classes=classes,
        pairs=contacts(1, 1e3, rolling_m=ROLLING),
        liquid=wetting(classes, 2.0),
        speed=2.0 * math.pi * radius / 1.5,
        surroundings=Surroundings(wall_share=0.5, duration_s=0.5),
        spheres=in_drum(count, r, radius, width, seed),
        seconds=0.5,
        walls=drum_walls(radius, width, sides=24),
        gravity=(0.0, -9.81, 0.0),
        rotation=Rotation(origin_m=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), period_s=1.5),
    )


def tiny_screening(seed: int, size: float, config_dir: Path) -> Setup:
    """Return sixteen spheres of screening case 2 at smoke scale, selected by the seed."""
    loaded = config.load(config_dir)
    made = cases.ingredients(loaded, 2, "smoke")
    keep = {1: 12, 2: 2, 3: 2}
    classes = tuple(c.model_copy(update={"count": keep[c.type]}) for c in made.classes)
    seconds = 0.7 * max(size, 0.7)

    def build(effects: Effects, run_dir: Path) -> EngineScene:
        scene = cases.build(loaded, 2, "smoke", run_dir)
        spheres = read_table(run_dir / scene.spheres_file)
        random = np.random.default_rng(seed)
        rows = [i for kind, n in keep.items() for i in random.permutation(spheres.index[spheres["type"] == kind])[:n]]
        changed: dict[str, Any] = {} if effects.gravity else {"gravity_m_per_s2": (0.0, 0.0, 0.0)}
        if not effects.bridges:
            changed["liquid"] = None
        output = scene.output.model_copy(update={"checkpoints": 0, "contact_windows": 200, "contact_window_steps": 1})
        chosen = spheres.loc[sorted(rows)]
        return with_spheres(scene, run_dir, chosen, duration_s=seconds, output=output, effects=effects, **changed)

    return Setup(
        classes=classes,
        pairs=made.pairs,
        liquid=made.liquid,
        speed=peak_speed(made.vibration),
        surroundings=Surroundings(wall_share=0.8, duration_s=seconds),
        spheres=(),
        seconds=seconds,
        walls=_box(0.1, 0.1),
        build=build,
        configuration=configured(loaded, 2, "smoke"),
    )


def _and_liquid(first: Measure, *names: str) -> Measure:
    """Combine a measure with the distribution of the liquid."""
    return lambda run_dir: {**first(run_dir), **measures.liquid(run_dir, names)}


ON_WALLS = ("liquid_in_bridges", "liquid_on_walls")
SETTLED = _and_liquid(measures.settled, "bridges_per_sphere", *ON_WALLS)
SCENES: dict[str, StudyScene] = {
    "dry_glass": StudyScene("Dry glass", "Glass beads of 3 mm fall into a box. There is no liquid.", dry_glass, measures.settled),
    "moist_pom": StudyScene("Moist plastic", "Beads of 3 and 5 mm with 5 % water fall into a box.", moist_pom,
     _and_liquid(SETTLED, "liquid_on_small")),
    "thick_oil": StudyScene("Thick oil at rest", "Glass beads under oil of 2 Pa s lie piled in a tray.", thick_oil, SETTLED),
    "fast_dilute": StudyScene("Fast and dilute", "Two clouds of glass beads of 8 mm, moist with a solvent, meet at 5 m/s.",
     fast_dilute, measures.cooled),
    "collision": StudyScene("One collision", "Two wet beads meet once, off centre, at 1 m/s.", collision, measures.rebound),
    "micron_powder": StudyScene("Fine powder", "Moist glass of 50 micrometres falls into a box.", micron_powder, SETTLED),
    "wet_drum": StudyScene("Wet drum", "Glass beads of 3 mm with 2 % water turn in a drum.", wet_drum,
     _and_liquid(measures.turning, "bridges_per_sphere", *ON_WALLS)),
    "screening": StudyScene("Moist screening", "Sixteen moist beads of three sizes on a vibrating screen.", tiny_screening,
     _and_liquid(measures.sieved, *ON_WALLS)),
}  # fmt: skip
"""Name -> scene."""
