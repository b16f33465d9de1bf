"""The kinds of law, each defined once in `KINDS`.

Arguments, probe grid, slots of the plugin, switches and presets are derived from it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

Preset = Literal["paper", "exact"]
Probed = dict[str, np.ndarray]
Sense = tuple[str, Callable[[np.ndarray, Probed], np.ndarray]]
"""Requirement on the values on the probe grid: its text, and a function that tells where it holds."""


@dataclass(frozen=True)
class Part:
    """One of the functions that make up a law of a kind."""

    arguments: tuple[str, ...]
    sense: Sense | None = None
    slot: str = ""
    """Name of the part in the plugin; empty: that of the kind."""


@dataclass(frozen=True)
class Kind:
    """Properties that all laws of a kind share."""

    parts: tuple[Part, ...]
    """Parts of a law; empty: the law is a table computed beforehand, and custom ones are not possible."""
    paper: str = ""
    """Law of the preset `paper`; empty: the kind is in no preset, and is used only if named."""
    exact: str = ""
    """Law of the preset `exact`, if different."""
    force: bool = False
    """Whether it is a force on active bridges: evaluated in every step, many bridges at once, all parts in one slot."""
    needed: bool = False
    """Whether bridges require it; other kinds in presets have a switch."""


def _film(at: Probed) -> np.ndarray:
    film_volume = at.get("film_volume_i")
    return at["film_thickness"] * np.pi * (10.0 * at["radius_i"]) ** 2 if film_volume is None else film_volume


BRIDGE = ("volume", "radius_i", "radius_j", "contact_angle_i", "contact_angle_j")
PULLS: Sense = (
    "a force of 0 or more while the bridge is short",
    lambda value, at: (value >= 0) | (at["separation"] > 0.3 * np.cbrt(at["volume"])),
)
DRAGS: Sense = ("a force against the velocity", lambda value, at: value * at["normal_velocity"] <= 0)
BRAKES: Sense = ("a coefficient of 0 or more", lambda value, at: value >= 0)
PARTS: Sense = ("a distance above 0", lambda value, at: value > 0)
STRETCHES: Sense = ("a factor of 1 or more", lambda value, at: value >= 1)
DRAWS: Sense = (
    "a volume from 0 to that of the film",  # the film of a wall counts within ten radii
    lambda value, at: (value >= 0) & (value <= 1.000001 * _film(at)),
)
SHEAR = ("separation", "radius_i", "radius_j", "viscosity")


KINDS: dict[str, Kind] = {
    "capillary": Kind(
        (Part(("separation", *BRIDGE, "surface_tension"), PULLS),), "rabinovich", "young_laplace", force=True
    ),
    "viscous_normal": Kind(
        (Part(("separation", "volume", "radius_i", "radius_j", "normal_velocity", "viscosity"), DRAGS),),
        "pitois",
        force=True,
    ),
    # the rotational part may have either sign
    "viscous_tangential": Kind((Part(SHEAR, BRAKES), Part(SHEAR)), "goldman", force=True),
    "rupture": Kind((Part(BRIDGE, PARTS),), "willett_unequal", "young_laplace", needed=True),
    "dynamic_rupture": Kind((Part(("speed", "viscosity", "surface_tension"), STRETCHES),), "pitois"),
    "formation": Kind(
        (
            Part(("film_volume_i", "radius_i", "radius_j"), DRAWS, "from_sphere"),
            Part(("film_volume_i", "radius_i", "half_width"), DRAWS, "from_sphere_at_wire"),
            Part(("film_thickness", "radius_i"), DRAWS, "from_wall"),
            Part(("film_thickness", "radius_i", "half_width"), DRAWS, "from_wire"),
        ),
        "shi_mccarthy",
        needed=True,
    ),
    "transfer": Kind((), "parabola", "young_laplace", needed=True),
    "shedding": Kind(
        (
            Part(("film_volume_i", "radius_i", "acceleration", "density", "surface_tension"), DRAWS, "shed_drop"),
            Part(("film_volume_i", "density", "surface_tension"), slot="shed_time"),
        )
    ),
}
"""Name of a kind -> common properties of its laws; `law_names.Laws` has a field for each."""
FORCES = tuple(name for name, kind in KINDS.items() if kind.force)
NEEDED = tuple(name for name, kind in KINDS.items() if kind.needed)
SWITCHED = tuple(name for name, kind in KINDS.items() if kind.paper and not kind.needed)
OPT_IN = ("liquid_weight", "shedding")
"""Effects that are in no preset and must be switched on explicitly."""
PRESETS: dict[str, dict[str, str]] = {
    preset: {name: (preset == "exact" and kind.exact) or kind.paper for name, kind in KINDS.items() if kind.paper}
    for preset in get_args(Preset)
}
"""Name of a preset -> law of each kind."""
