"""The batch screening apparatus built from a dozen dimensions, with checks of all relations between them."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from pywet.errors import PywetError
from pywet.geometry import tower
from pywet.geometry.packing import FeedRegion
from pywet.geometry.screen import build_wires
from pywet.geometry.solids import Part, bin_solid, plate, polygon, square, tube
from pywet.geometry.surface import Motion, Surface, make_surface
from pywet.scene import Reservoir

BIN_OVERLAP_M = 0.006
"""Height [m] of the collecting bin's rim above the outlet's lower end."""
BOX_MARGIN_M = 0.010
"""Margin [m] between the outermost wall, over its whole motion, and the simulated box."""


@dataclass(frozen=True)
class ApparatusSpec:
    """Dimensions [m, rad]; the screen plane is z = 0. The paper specifies only aperture and wire, see docs/geometry.md."""

    aperture_m: float
    wire_diameter_m: float
    shape: Literal["square", "cylinder"]
    width_m: float
    wire_sides: int = 8
    cylinder_sides: int = 24
    side_wall_height_m: float = 0.040
    feed_bin_height_m: float = 0.120
    slide_height_m: float = 0.048
    outlet_height_m: float = 0.100
    impact_plate_angle_rad: float = math.radians(30.0)
    collecting_bin_height_m: float = 0.060
    wall_thickness_m: float = 0.004
    clearance_m: float = 0.0015

    @property
    def outlet_opening_m(self) -> float:
        """Return the free width next to the impact plate's low edge: three apertures or 40 % of the width, if larger."""
        return max(0.4 * self.width_m, 3.0 * self.aperture_m)

    @property
    def feed_bin_bottom_m(self) -> float:
        """Return the height of the feed bin's lower end: the clearance above the side wall."""
        return self.side_wall_height_m + self.clearance_m


@dataclass(frozen=True)
class Apparatus:
    """Surfaces in scene order and the positions that the scene needs [m]."""

    surfaces: tuple[Surface, ...]
    box_low: tuple[float, float, float]
    box_high: tuple[float, float, float]
    screen_z: float
    bin_z: float
    feed_region: FeedRegion
    slide_travel: float


def build_apparatus(spec: ApparatusSpec) -> Apparatus:
    """Build all surfaces; raises `PywetError` when the dimensions do not go together."""
    _check_numbers(spec)
    _check_heights(spec)
    apothem, sides = tower.equal_area_apothem(spec.shape, spec.width_m, spec.cylinder_sides)
    t, gap = spec.wall_thickness_m, spec.clearance_m
    mid_wall = polygon(apothem + 0.5 * t, sides)  # ends of wires and plates
    z_outlet = -spec.wire_diameter_m
    z_end = z_outlet - spec.outlet_height_m
    z_rim = z_end + BIN_OVERLAP_M
    plate_top = z_outlet - 2.0 * spec.aperture_m  # a space of two apertures below the wires
    half_slide = float(np.abs(mid_wall).max())
    feed_low, feed_high = spec.feed_bin_bottom_m, spec.feed_bin_bottom_m + spec.feed_bin_height_m
    ceiling = feed_high - t
    slope = (apothem - spec.outlet_opening_m, spec.impact_plate_angle_rad)
    walls: list[tuple[str, Reservoir, list[Part], Motion]] = [
        # contains the wires within its thickness
        ("side_wall", "side_wall", tube(apothem, t, sides, z_outlet, spec.side_wall_height_m), "vibrates"),
        ("feed_bin", "feed_bin", tube(apothem, t, sides, feed_low, feed_high), "fixed"),
        # closes the feed bin from below; its edges are inside that wall
        ("slide", "slide", plate(square(half_slide), spec.slide_height_m - t, spec.slide_height_m), "slides"),
        ("outlet", "outlet", tube(apothem, t, sides, z_end, z_outlet), "vibrates"),
        ("impact_plate", "impact_plate", tower.impact_plate(mid_wall, *slope, t, plate_top), "vibrates"),
        # around and below the outlet's lower end
        (
            "collecting_bin",
            "collecting_bin",
            bin_solid(apothem + t + gap, t, sides, z_rim - spec.collecting_bin_height_m, z_rim),
            "fixed",
        ),
        # keeps in what chains of impacts throw up to the feed bin's rim
        ("cover", "feed_bin", plate(square(half_slide), ceiling, feed_high), "fixed"),
    ]
    wires = build_wires(spec.aperture_m, spec.wire_diameter_m, spec.wire_sides, apothem, mid_wall)
    surfaces = (wires, *(make_surface(*wall) for wall in walls))
    travel = 2.0 * half_slide
    low, high = _bounds(surfaces, travel)
    region = FeedRegion(spec.shape, 2.0 * apothem, spec.slide_height_m, ceiling)
    return Apparatus(surfaces, low, high, 0.0, z_end - gap, region, travel)


def _bounds(
    surfaces: tuple[Surface, ...], travel: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return the box around all surfaces, with the slide in both end positions, and a margin."""
    low = np.min([s.vertices.min(axis=0) for s in surfaces], axis=0) - BOX_MARGIN_M
    high = np.max(
        [s.vertices.max(axis=0) + np.array([travel * (s.motion == "slides"), 0.0, 0.0]) for s in surfaces], axis=0
    )
    high = high + BOX_MARGIN_M
    return (float(low[0]), float(low[1]), float(low[2])), (float(high[0]), float(high[1]), float(high[2]))


def _check_numbers(spec: ApparatusSpec) -> None:
    for f in fields(spec):
        value = getattr(spec, f.name)
        if isinstance(value, (int, float)) and not (math.isfinite(value) and value > 0):
            raise PywetError(
                f"apparatus: {_text(spec, f.name)}, expected a positive number; fix scales.yaml",
                code="apparatus.number", key=f.name, given=getattr(spec, f.name),
            )  # fmt: skip
    if spec.shape not in ("square", "cylinder"):
        raise PywetError(
            f"apparatus: shape is {spec.shape!r}, expected 'square' or 'cylinder'; fix scales.yaml",
            code="apparatus.shape", key="shape", given=spec.shape, expected=("square", "cylinder"),
        )  # fmt: skip
    if spec.wire_sides % 2 or not 4 <= spec.wire_sides <= 32:
        raise PywetError(
            f"apparatus: wire_sides is {spec.wire_sides}, expected an even number from 4 to 32",
            code="apparatus.wire_sides", key="wire_sides", given=spec.wire_sides,
        )  # fmt: skip
    if not 8 <= spec.cylinder_sides <= 96:
        raise PywetError(
            f"apparatus: cylinder_sides is {spec.cylinder_sides}, expected 8 to 96",
            code="apparatus.cylinder_sides", key="cylinder_sides", given=spec.cylinder_sides,
        )  # fmt: skip
    if spec.aperture_m < spec.wire_diameter_m:
        raise PywetError(
            f"apparatus: {_text(spec, 'aperture_m')}, smaller than {_text(spec, 'wire_diameter_m', '')}, "
            "expected an aperture at least as wide as the wire; fix the case's screen",
            code="apparatus.aperture", key="aperture_m", given=spec.aperture_m, expected=spec.wire_diameter_m,
        )  # fmt: skip
    if spec.wall_thickness_m < spec.wire_diameter_m:
        raise PywetError(
            f"apparatus: {_text(spec, 'wall_thickness_m')}, less than {_text(spec, 'wire_diameter_m', '')}, "
            "expected at least that, so that wires end inside the wall; fix scales.yaml",
            code="apparatus.wall_thickness", key="wall_thickness_m", given=spec.wall_thickness_m,
            expected=spec.wire_diameter_m,
        )  # fmt: skip


def _check_heights(spec: ApparatusSpec) -> None:
    pitch = spec.aperture_m + spec.wire_diameter_m
    _at_least(spec, "width_m", max(2.0 * pitch, 5.0 * spec.aperture_m), f"for {_text(spec, 'aperture_m', '')}")
    lowest_slide = spec.feed_bin_bottom_m + spec.wall_thickness_m
    highest = spec.feed_bin_bottom_m + spec.feed_bin_height_m - spec.wall_thickness_m
    if not lowest_slide - 1e-9 <= spec.slide_height_m < highest:
        raise PywetError(
            f"apparatus: {_text(spec, 'slide_height_m')}, not within the feed bin, expected {1e3 * lowest_slide:g} "
            f"to {1e3 * highest:g}; fix scales.yaml",
            code="apparatus.slide_height", key="slide_height_m", given=spec.slide_height_m,
            expected=(lowest_slide, highest),
        )  # fmt: skip
    if not spec.impact_plate_angle_rad < math.radians(70.0):
        raise PywetError(
            f"apparatus: {_text(spec, 'impact_plate_angle_rad')}, expected an angle below 70; fix scales.yaml",
            code="apparatus.plate_angle", key="impact_plate_angle_rad", given=spec.impact_plate_angle_rad,
        )  # fmt: skip
    run = spec.width_m - spec.outlet_opening_m + spec.wall_thickness_m
    margin = 2.0 * spec.aperture_m + run * math.tan(spec.impact_plate_angle_rad) + spec.wall_thickness_m
    _at_least(
        spec, "outlet_height_m", margin, f"to hold the impact plate at {_text(spec, 'impact_plate_angle_rad', '')}"
    )
    _at_least(spec, "collecting_bin_height_m", 3.0 * spec.aperture_m + BIN_OVERLAP_M, "for what falls into it")


def _at_least(spec: ApparatusSpec, name: str, least: float, why: str) -> None:
    if getattr(spec, name) < least:
        raise PywetError(
            f"apparatus: {_text(spec, name)}, too small {why}, expected at least {1e3 * least:.4g}; fix scales.yaml",
            code="apparatus.small", key=name, given=getattr(spec, name), expected=least,
        )  # fmt: skip


def _text(spec: ApparatusSpec, name: str, verb: str = "is ") -> str:
    """Describe a dimension by its key and unit in the configuration."""
    stem, _, unit = name.rpartition("_")
    value = getattr(spec, name)
    if unit == "m":
        return f"{stem}_mm {verb}{1e3 * value:g}"
    return f"{stem}_deg {verb}{math.degrees(value):g}" if unit == "rad" else f"{name} {verb}{value}"
