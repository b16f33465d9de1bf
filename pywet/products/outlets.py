"""Outlets of a user-defined scene: named regions in which spheres leave the run, with their films.

Spheres in an outlet are removed at intervals of at most 0.02 s, or at every output if that is rarer; until then they
continue to fall within the simulated box.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Self, get_args

import numpy as np
from pydantic import model_validator

from pywet import scene as typed
from pywet.config.entries import Excusable, only
from pywet.engines.schedule import SKIPPED, checkpoint_every, outlets_every_s, windows
from pywet.errors import ConfigError
from pywet.geometry.surface import Floats
from pywet.runs.rundir import placed
from pywet.scene import Bound, Identifier, Product, Vector

MM = 1e-3
PRODUCTS: tuple[Product, ...] = get_args(Product)
MOST_REACH = 2.0
"""Largest extension [m] of a box beyond its outlets: faster spheres leave the box, and the run stops."""


class Outlet(Excusable):
    """Region between two corners (`null`: open) in which spheres are removed.

    A sphere is assigned to the first outlet of the scene that contains its centre.
    """

    name: Identifier
    """Name in tables and on the page: letters, digits and _."""
    low_mm: Bound = (None, None, None)
    """Smallest x, y, z; null: open."""
    high_mm: Bound = (None, None, None)
    """Largest x, y, z; null: open."""
    crossing_above_mm: float | None = None
    """Least height z of a sphere at or after its crossing of the plane of the smallest x, such as the end of a deck; null: any.

    It is the largest height on the parabola through position and velocity at the removal; with `moves_with` that above the
    wall at the crossing, or later above its highest position. A sphere that was lower leaves by a later outlet of the list.
    """
    moves_with: str | None = None
    """Wall with whose vibration plane and height of the crossing move, though not the region; null: they are at rest."""
    product: Product | None = None
    """Screen product collected here; by default the one with which its name begins: overs…, middlings…, unders…."""

    @model_validator(mode="after")
    def _holds_something(self) -> Self:
        only(self, "with crossing_above_mm", self.crossing_above_mm is not None, "moves_with")
        pairs = [(a, b) for a, b in zip(self.low_mm, self.high_mm, strict=True) if a is not None and b is not None]
        if not all(a < b for a, b in pairs):
            raise ValueError(f"outlet {self.name}: each number of low_mm to be less than that of high_mm")
        if all(v is None for v in (*self.low_mm, *self.high_mm)):
            raise ValueError(f"outlet {self.name}: a low_mm or high_mm, else every sphere leaves at once")
        if self.crossing_above_mm is not None and self.low_mm[0] is None:
            raise ValueError(
                f"outlet {self.name}: a smallest x in low_mm with crossing_above_mm, the plane that is crossed"
            )
        return self

    def moved(self, origin: Vector) -> Self:
        """Return the outlet with positions counted from another origin [mm]."""
        low, high = (
            tuple(None if v is None else v - o for v, o in zip(corner, origin, strict=True))
            for corner in (self.low_mm, self.high_mm)
        )
        above = None if self.crossing_above_mm is None else self.crossing_above_mm - origin[2]
        return self.model_copy(update={"low_mm": low, "high_mm": high, "crossing_above_mm": above})

    def region(self, words: Mapping[str, str] | None = None) -> typed.Outlet:
        """Convert the outlet to the region that an engine uses [m]; `words`: names of walls in the engine."""
        named = next((p for p in PRODUCTS if self.name.startswith(p)), None)
        product = self.product or named
        above = None if self.crossing_above_mm is None else MM * self.crossing_above_mm
        return typed.Outlet(
            name=self.name,
            low_m=_in_m(self.low_mm),
            high_m=_in_m(self.high_mm),
            crossing_above_m=above,
            moves_with=(words or {}).get(self.moves_with or ""),
            product=product,
        )


def _in_m(corner: Bound) -> Bound:
    x, y, z = (None if v is None else MM * v for v in corner)
    return x, y, z


def reach(speed: float, gravity: Vector, output_s: float | None = None) -> Floats:
    """Bound the distances [m] along x, y, z that a sphere of this speed [m/s] moves into an outlet before it is removed.

    `output_s`: interval of the outputs [s] if it is given.
    """
    longest = SKIPPED * outlets_every_s(output_s)
    return np.minimum(speed * longest + 0.5 * np.abs(np.array(gravity)) * longest**2, MOST_REACH)


def with_reach(
    outlets: Sequence[typed.Outlet],
    low: Floats,
    high: Floats,
    speed: float,
    gravity: Vector,
    output_s: float | None = None,
    sway: Sequence[float] = (0.0, 0.0, 0.0),
) -> tuple[Floats, Floats]:
    """Enlarge the corners of a box for spheres that enter an outlet before they are removed.

    `sway`: largest displacements of the outlets with walls [m].
    """
    if not outlets:
        return low, high
    far = reach(speed, gravity, output_s) + _falls(outlets, speed, gravity, sway[2]) + np.array(sway)
    lows, highs = [low], [high]
    for outlet in outlets:  # spheres enter at the finite bound; at the open end they leave
        lows.append([low[k] if b is None else b for k, b in enumerate(outlet.high_m)] - far)
        highs.append([high[k] if b is None else b for k, b in enumerate(outlet.low_m)] + far)
    return np.minimum.reduce(lows), np.maximum.reduce(highs)


def _falls(outlets: Sequence[typed.Outlet], speed: float, gravity: Vector, raised: float) -> Floats:
    """Bound the distances [m] that a sphere moves while it falls from the height of a crossing to an outlet below."""
    crossings = [o.crossing_above_m for o in outlets if o.crossing_above_m is not None]
    floors = [o.high_m[2] for o in outlets if o.high_m[2] is not None]
    if not crossings or not floors or gravity[2] >= 0.0:
        return np.zeros(3)
    seconds = math.sqrt(2.0 * max(0.0, max(crossings) + raised - min(floors)) / -gravity[2])
    return np.array([min(speed * seconds + 0.5 * abs(gravity[0]) * seconds**2, MOST_REACH), 0.0, 0.0])


def refuse_thin(
    scene: str, outlets: Sequence[Outlet], speed: float, gravity: Vector, output_s: float | None = None
) -> None:
    """Refuse an outlet so thin that spheres can fall through it between two checks."""
    axis = int(np.argmax(np.abs(gravity)))
    way = 1e3 * reach(speed, gravity, output_s)[axis]
    for outlet in outlets:
        low, high = outlet.low_mm[axis], outlet.high_mm[axis]
        if any(gravity) and low is not None and high is not None and high - low < way:
            end, open_ = ("low_mm", low) if gravity[axis] < 0 else ("high_mm", high)
            raise ConfigError(
                f"scene {scene}: outlet {outlet.name} is {high - low:.4g} mm deep along {'xyz'[axis]}, and spheres may fall "
                f"{way:.3g} mm between two checks of it; expected it open below: null in place of {open_:g} in its {end}",
                code="scene.thin_outlet", key=f"outlets.{outlet.name}",
            )  # fmt: skip


def refuse_begins(scene: str, outlets: Sequence[typed.Outlet], at: Floats, origin_mm: Vector) -> None:
    """Refuse positions (n, 3) [m] at which spheres start or enter that are in an outlet."""
    for outlet in outlets:
        (low, high), above = map(np.array, outlet.ends), outlet.crossing_above_m
        taken = ((at >= low) & (at < high)).all(axis=1) & (at[:, 2] >= (-math.inf if above is None else above))
        if taken.any():
            raise ConfigError(
                f"scene {scene}: {int(taken.sum())} of {len(at)} spheres start or enter in outlet {outlet.name}, such as at "
                f"{placed(at[taken][0], origin_mm)} mm, and would leave at once; expected all outside: move their region or "
                "the outlet",
                code="scene.in_outlet", key=f"outlets.{outlet.name}", given=int(taken.sum()), expected=0,
            )  # fmt: skip


def out_of_reach(outlets: Sequence[typed.Outlet], walls: Mapping[str, Floats], radius: float) -> list[str]:
    """Return sentences on walls and outlets so far inside an outlet that spheres are removed before they reach them.

    Parameters
    ----------
    walls : mapping of str to array (n, 3)
        Corners of each wall [m].
    radius : float
        Of the largest sphere [m], which touches a wall that is less far inside.

    Notes
    -----
    An outlet that shares a face with the one around it divides that.
    """
    places = [(f"wall {name}", at.min(axis=0) - radius, at.max(axis=0) + radius) for name, at in walls.items()]
    places += [(f"outlet {o.name}", np.array(o.ends[0]), np.array(o.ends[1])) for o in outlets]
    found = []
    for what, low, high in places:
        around = (
            o.name for o in outlets for a, b in [map(np.array, o.ends)]
            if (((low > a) | np.isneginf(a)) & ((high < b) | np.isposinf(b))).all()
        )  # fmt: skip
        if name := next(around, None):
            found.append(f"{what} is in outlet {name}, in which spheres are removed before they reach it")
    return found


def refuse_skipped(scene: typed.EngineScene) -> None:
    """Refuse sampling windows that contain two successive checks of the outlets: spheres leave within `SKIPPED` intervals."""
    if not scene.outlets:
        return
    every = checkpoint_every(scene)
    skipped = {n for first, last in windows(scene) for n in range(max(1, -(-first // every)), -(-last // every))}
    if twice := [n for n in skipped if n + 1 in skipped]:
        at, after = (every * n * scene.time_step_s for n in (min(twice), min(twice) + 1))
        raise ConfigError(
            f"scene {scene.name}: the checks of the outlets at {at:.4g} and {after:.4g} s are in sampling windows, in which no "
            "sphere leaves; expected no two in succession: lower results.window_steps or results.windows",
            code="scene.outlet_windows", key="results.window_steps",
        )  # fmt: skip
