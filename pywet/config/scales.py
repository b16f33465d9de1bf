"""Size, stiffness and duration of a run: scales.yaml. All scales have the same dimensions of the apparatus."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from pywet.config.entries import AngleEntry, CountEntry, Limited, PositiveEntry, RatioEntry
from pywet.scene import Word
from pywet.strict import Strict
from pywet.util.notices import notice

FILE = "scales.yaml"
FORMER_WIRES = "prism"
"""Former value of `wires` -> `analytic`."""


class Apparatus(Limited):
    """Dimensions of the tower around the screen."""

    side_wall_height_mm: PositiveEntry
    feed_bin_height_mm: PositiveEntry
    slide_height_mm: PositiveEntry
    slide_speed_m_per_s: PositiveEntry
    outlet_height_mm: PositiveEntry
    impact_plate_angle_deg: AngleEntry
    collecting_bin_height_mm: PositiveEntry
    wall_thickness_mm: PositiveEntry
    clearance_mm: PositiveEntry


class Scale(Limited):
    """One scale. A square sieve's width is rounded to whole pitches of its screen; the feed is proportional to its area."""

    shape: Literal["square", "cylinder"]
    width_mm: PositiveEntry | None = None
    """Side or diameter of the sieve; only a round one may omit it, for that of `feed` in materials.yaml."""
    wire_sides: CountEntry
    wires: Literal["mesh", "analytic"] = "mesh"
    """Dry contacts with wires: with each of their triangles, as the engine does, or with the analytic wire's closest point."""
    cylinder_sides: CountEntry | None = None
    stiffness_factor: RatioEntry
    duration_s: PositiveEntry
    slide_opens_at_s: PositiveEntry
    output_interval_s: PositiveEntry

    @model_validator(mode="before")
    @classmethod
    def _former_name(cls, given: Any) -> Any:
        """Accept the former name of `analytic` wires with a warning."""
        if not isinstance(given, dict) or given.get("wires") != FORMER_WIRES:
            return given
        notice.warning(
            f"scales: wires: {FORMER_WIRES} is now wires: analytic; this version still accepts {FORMER_WIRES}"
        )
        return {**given, "wires": "analytic"}

    @model_validator(mode="after")
    def _wide(self) -> Scale:
        if self.width_mm is None and self.shape == "square":
            raise ValueError(
                "width_mm together with shape: square (only a round sieve may be that of feed.sieve_diameter_mm)"
            )
        return self

    @model_validator(mode="after")
    def _opens(self) -> Scale:
        opens, duration = self.slide_opens_at_s.value, self.duration_s.value
        if opens >= duration:
            raise ValueError(f"slide_opens_at_s ({opens:g}) below duration_s ({duration:g})")
        if self.output_interval_s.value > duration:
            raise ValueError(f"output_interval_s ({self.output_interval_s.value:g}) at most duration_s ({duration:g})")
        return self

    @property
    def asked_width_mm(self) -> float:
        """Return the configured width [mm], which `Config.scale` has filled in."""
        if self.width_mm is None:
            raise ValueError("a scale of Config.scale was expected: this one has no width of its own")
        return self.width_mm.value

    def sieve_width_m(self, pitch_m: float) -> float:
        """Return the side length or diameter of the sieve [m] for a screen of this pitch [m]."""
        wished = 1e-3 * self.asked_width_mm
        return wished if self.shape == "cylinder" else max(1, round(wished / pitch_m)) * pitch_m

    def sieve_area_m2(self, pitch_m: float) -> float:
        return self.sieve_width_m(pitch_m) ** 2 * (0.25 * math.pi if self.shape == "cylinder" else 1.0)


class Scales(Strict):
    """Content of scales.yaml."""

    apparatus: Apparatus
    scales: Annotated[dict[Word, Scale], Field(min_length=1)]
