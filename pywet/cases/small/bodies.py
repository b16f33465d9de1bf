"""Bodies of small scenes: spheres, dry contacts, liquids, initial arrangements."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pywet.cases.screening.amounts import common_film_thickness, liquid_volume
from pywet.cases.small.small import Sphere
from pywet.errors import PywetError
from pywet.geometry.solids import bin_solid, plate, polygon, tube
from pywet.geometry.surface import Surface, make_surface
from pywet.laws.hertz import Hertz
from pywet.scene import ContactPair, Liquid, SphereClass
from pywet.util.files import read_table

Floats = NDArray[np.float64]
GLASS = 2500.0
"""Density of glass [kg/m3]."""
WETTED = math.radians(15.0)
"""Contact angle of water on glass [rad]."""
FIT_IN_DRUM = 44
"""Smallest number of spheres whose lattice fits into the drum made for them."""


def sphere_classes(
    *radii_m: float, counts: int | Sequence[int] = 1, density: float | Sequence[float] = GLASS,
    angle_rad: float | Sequence[float] = WETTED, name: str = "class{k}",
) -> tuple[SphereClass, ...]:  # fmt: skip
    """One class per radius, of glass; `name` may contain {k}, the number of the class, and {mm}, its diameter."""
    many, densities, angles = (np.broadcast_to(v, len(radii_m)).tolist() for v in (counts, density, angle_rad))
    return tuple(
        SphereClass(name=name.format(k=k + 1, mm=f"{2e3 * r:g}"), type=k + 1, radius_m=r, density_kg_per_m3=densities[k],
                    contact_angle_rad=angles[k], count=many[k])
        for k, r in enumerate(radii_m)
    )  # fmt: skip


def contact(
    a: int, b: int, stiffness: float, *, friction: float = 0.4, rolling_m: float = 0.0, restitution: float = 0.8
) -> ContactPair:
    """Return a dry contact with a tangential-to-normal stiffness ratio of 2/7; b = 0: a wall."""
    return ContactPair(
        a=a, b=b, normal_stiffness_N_per_m=stiffness, tangential_stiffness_N_per_m=2.0 / 7.0 * stiffness, friction=friction,
        rolling_friction_m=rolling_m, restitution=restitution,
    )  # fmt: skip


def contacts(types: int, stiffness: float | Sequence[float], **how: float) -> tuple[ContactPair, ...]:
    """Make the same dry contact for all pairs of types and for walls; for a pair the smaller of two stiffnesses is used."""
    of_each = [stiffness] * types if isinstance(stiffness, float | int) else stiffness
    return tuple(
        contact(a, b, min(of_each[a - 1], of_each[(b or a) - 1]), **how)
        for a in range(1, types + 1)
        for b in (0, *range(a, types + 1))
    )


def hertzian(
    classes: Sequence[SphereClass], pairs: Sequence[ContactPair], hertz: Hertz
) -> tuple[ContactPair, ...]:  # fmt: skip
    """Replace linear springs by springs that are equivalent to Hertz contacts, in a scene with this `hertz`."""
    names = ("normal_stiffness_N_per_m", "tangential_stiffness_N_per_m")
    return tuple(p.model_copy(update=dict(zip(names, hertz.springs(classes, p), strict=True))) for p in pairs)


def water(film_m: float = 0.0, viscosity: float = 1e-3, tension: float = 0.07275, density: float = 1e3) -> Liquid:
    """Water with a film of this thickness on every sphere."""
    return Liquid(
        surface_tension_N_per_m=tension, viscosity_Pa_s=viscosity, density_kg_per_m3=density, initial_film_thickness_m=film_m
    )  # fmt: skip


def wetting(classes: Sequence[SphereClass], percent: float, viscosity: float = 1e-3, tension: float = 0.0728) -> Liquid:
    """Liquid of 1000 kg/m3, a percentage of the spheres' mass, with the same film thickness on all."""
    return water(common_film_thickness(classes, liquid_volume(classes, percent, 1000.0)), viscosity, tension)


def at_places(places: Floats, kinds: Sequence[int] | NDArray[Any] | None = None) -> list[Sphere]:
    """Return spheres at rest at positions of shape (n, 3) [m]."""
    of = np.ones(len(places), int) if kinds is None else kinds
    return [Sphere(int(k), (x, y, z)) for k, (x, y, z) in zip(of, places.tolist(), strict=True)]


def loose_box(count: int, radius: float, seed: int) -> tuple[list[Sphere], Surface]:
    """Return spheres 2.3 radii apart in layers, displaced at random by a tenth of a radius, and the box around them."""
    across = max(4, round(count ** (1.0 / 3.0)))
    number = np.arange(count)
    cells = np.column_stack([number % across, number // across % across, number // across**2]).astype(float)
    at = (cells - [0.5 * (across - 1), 0.5 * (across - 1), 0.0]) * 2.3 * radius
    at += np.random.default_rng(seed).uniform(-0.1, 0.1, at.shape) * radius + [0.0, 0.0, 1.5 * radius]
    height = 2.5 * radius * (math.ceil(count / across**2) + 2)
    half = 1.15 * radius * across + 0.5 * radius
    return at_places(at), make_surface("box", "wall", bin_solid(half, 0.004, 4, 0.0, height))


def drum_radius(count: int, radius: float, width: float) -> float:
    """Radius [m] of a drum that these spheres fill to 35 % at a solid fraction of 0.55."""
    return math.sqrt(count * 4.0 / 3.0 * radius**3 / (0.55 * 0.35 * width))


def drum_walls(radius: float, width: float, sides: int = 32) -> tuple[Surface, ...]:
    """Mantle and two lids of a drum about the z axis, turning."""
    low, high, thickness = -0.5 * width, 0.5 * width, 0.003
    outline = polygon(radius + thickness, sides)
    return (
        make_surface("mantle", "wall", tube(radius, thickness, sides, low, high), "turns"),
        make_surface("lid_low", "wall", plate(outline, low - thickness, low), "turns"),
        make_surface("lid_high", "wall", plate(outline, high, high + thickness), "turns"),
    )


def in_drum(count: int, sphere_radius: float, radius: float, width: float, seed: int) -> list[Sphere]:
    """Spheres on a lattice inside a drum, from the bottom up."""
    pitch = 2.15 * sphere_radius
    n, layers = int(radius // pitch), int(width // pitch)
    grid = np.array([(i, j) for j in range(-n, n + 1) for i in range(-n, n + 1)], dtype=float) * pitch
    grid = grid[np.hypot(grid[:, 0], grid[:, 1]) < 0.98 * radius - 1.2 * sphere_radius]
    z = (np.arange(layers) - 0.5 * (layers - 1)) * pitch
    at = np.array([(x, y, h) for x, y in grid for h in z])[:count]
    if len(at) < count:
        raise PywetError(
            f"{count} spheres do not fit into their drum of {radius:g} m, only {len(at)}; expected {FIT_IN_DRUM} "
            "or more: fix spheres",
            code="small.crowded_drum", key="spheres", given=count, expected=FIT_IN_DRUM,
        )  # fmt: skip
    return at_places(at + np.random.default_rng(seed).uniform(-0.05, 0.05, at.shape) * sphere_radius)


def last(run_dir: Path) -> pd.DataFrame:
    """The spheres at the end of a run, by id."""
    table = read_table(run_dir / "trajectory.parquet")
    return table[table["step"] == table["step"].max()].sort_values("id").reset_index(drop=True)


def coordination(at: NDArray[Any], radius: NDArray[Any], gap: float | None = None) -> float:
    """Mean number of spheres in touch with a sphere: up to a gap [m], or up to a hundredth of the larger radius.

    >>> round(coordination(np.array([[0.0, 0, 0], [2.0, 0, 0], [9.0, 0, 0]]), np.ones(3)), 3)
    0.667
    """
    reach = 1e-2 * radius.max() if gap is None else gap
    pairs = cKDTree(at).query_pairs(2.0 * radius.max() + 2.0 * reach, output_type="ndarray")
    if len(pairs) == 0:
        return 0.0
    i, j = pairs.T
    apart = np.linalg.norm(at[i] - at[j], axis=1) - radius[i] - radius[j]
    most = 1e-2 * np.maximum(radius[i], radius[j]) if gap is None else gap
    return 2.0 * float(np.count_nonzero(apart <= most)) / len(at)
