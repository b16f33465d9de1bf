"""Dimensions of the screening tower by the configuration: plan and heights, as in docs/geometry.md [m]."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from reference_impl.replay.arrays import Floats
from reference_impl.scene.configuration import number, pitch_m, reading, screen, width_m

MOTION = {
    "wires": "vibrates", "side_wall": "vibrates", "feed_bin": "fixed", "slide": "slides", "outlet": "vibrates",
    "impact_plate": "vibrates", "collecting_bin": "fixed", "cover": "fixed",
}  # fmt: skip
"""Parts of the tower in the scene's order, and their motions."""
RIM_ABOVE_END = 0.006
"""Height [m] of the collecting bin's rim above the outlet's lower end."""
CYLINDER_SIDES = 24


@dataclass(frozen=True)
class Plan:
    """Plan view: a regular polygon of `sides`, `apothem` from the axis to the inner face."""

    sides: int
    apothem: float
    thickness: float
    pitch: float
    aperture: float
    wire: float
    wire_sides: int
    clearance: float
    width: float
    small_half_width: float
    """Half width r_w of a wire: by the configuration's reading its radius, or half the side of its polygon."""

    @classmethod
    def of(cls, config: Mapping[str, Any]) -> Plan:
        """Return the plan; a round sieve is a polygon of the circle's area."""
        scale, tower, width, sides = config["scale"], config["apparatus"], width_m(config), 4
        apothem = 0.5 * width
        if scale["shape"] == "cylinder":
            sides = int(number(scale, "cylinder_sides")) if scale.get("cylinder_sides") else CYLINDER_SIDES
            apothem *= math.sqrt(math.pi / (sides * math.tan(math.pi / sides)))
        thickness, clearance = (1e-3 * number(tower, f"{name}_mm") for name in ("wall_thickness", "clearance"))
        aperture, wire = (1e-3 * number(screen(config), f"{name}_mm") for name in ("aperture", "wire_diameter"))
        wire_sides = int(number(scale, "wire_sides"))
        facet = 0.5 * wire * math.sin(math.pi / wire_sides)
        half = {"wire_radius": 0.5 * wire, "half_facet": facet}[reading(config, "small_wall", "wire_radius")]
        return cls(sides, apothem, thickness, pitch_m(config), aperture, wire, wire_sides, clearance, width, half)

    @property
    def half_slide(self) -> float:
        """Return half the extent of the slide: up to the middle of the wall along x or y."""
        angle = 2.0 * math.pi * (np.arange(self.sides) + 0.5) / self.sides
        around = max(np.abs(np.cos(angle)).max(), np.abs(np.sin(angle)).max()) / math.cos(math.pi / self.sides)
        return float((self.apothem + 0.5 * self.thickness) * around)

    @property
    def wires(self) -> Floats:
        """Return the positions of parallel wires in the tower: one pitch apart, with one at the axis or one on either side."""
        first = 0.5 * self.pitch if round(2.0 * self.apothem / self.pitch) % 2 else 0.0
        reach = self.apothem + 0.5 * self.wire * (1.0 - 1e-6)
        right = first + self.pitch * np.arange(math.ceil(reach / self.pitch) + 2)
        right = right[right < reach]
        return np.unique(np.concatenate([-right, right]))


@dataclass(frozen=True)
class Heights:
    """Heights above the screen's plane, from the lowest to the highest."""

    bin_rim: float
    outlet_end: float
    outlet_top: float
    plate_top: float
    side_wall_top: float
    feed_bin_low: float
    feed_bin_top: float
    ceiling: float
    slide_top: float
    bin_floor: float
    bin: float
    """Height below which a sphere has passed."""

    @classmethod
    def of(cls, config: Mapping[str, Any]) -> Heights:
        """Return the heights: outlet under the wires, plate two apertures below, feed bin a clearance above the side wall."""
        plan, tower = Plan.of(config), config["apparatus"]
        side, feed, slide, outlet, vessel = (
            1e-3 * number(tower, f"{name}_height_mm")
            for name in ("side_wall", "feed_bin", "slide", "outlet", "collecting_bin")
        )
        end = -plan.wire - outlet
        rim, low = end + RIM_ABOVE_END, side + plan.clearance
        return cls(
            bin_rim=rim, outlet_end=end, outlet_top=-plan.wire, plate_top=-plan.wire - 2.0 * plan.aperture, side_wall_top=side,
            feed_bin_low=low, feed_bin_top=low + feed, ceiling=low + feed - plan.thickness, slide_top=slide,
            bin_floor=rim - vessel, bin=end - plan.clearance,
        )  # fmt: skip
