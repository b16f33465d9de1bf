"""Plausible ranges of numbers: one `Range` for each key of configuration and JSON, for each option of the command line.

A value outside the range of its key is most often a mistake of units (mN/m for N/m, g/cm3 for kg/m3), so it is
refused unless `unusual` next to it gives a reason (`config.entries.Limited`).
"""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass
from typing import Any

from pywet.errors import PywetError

RANKS_PER_CORE = 64
MOST_RANKS = RANKS_PER_CORE * (os.cpu_count() or 1)


@dataclass(frozen=True)
class Range:
    """A range from `low` to `high`, inclusive unless `above` (then greater than `low`); `whole`: integers only."""

    low: float
    high: float
    unit: str = ""
    above: bool = False
    whole: bool = False

    def __contains__(self, value: float) -> bool:
        inside = self.low < value <= self.high or (value == self.low and not self.above)
        return inside and (not self.whole or value == math.floor(value))

    def __str__(self) -> str:
        low, high = (f"{int(x)}" if self.whole else f"{x:g}" for x in (self.low, self.high))
        kind = "a whole number from " if self.whole else "more than " if self.above else ""
        return f"{kind}{low} {'and at most' if self.above else 'to'} {high} {self.unit}".strip()

    def read(self, name: str, given: Any) -> Any:
        """Return a number, or parse the text of one, within the range; `name` is its name for the user."""
        try:
            value = float(given)
        except (ValueError, OverflowError):
            value = math.nan
        if value not in self:
            text = str(given) if len(str(given)) < 40 else f"{str(given)[:39]}…"
            raise PywetError(
                f"{name} is {text or 'empty'}{comma(given)}; expected {self}",
                code="option.range", key=name, given=given, expected=str(self),
            )  # fmt: skip
        return int(value) if self.whole else value


def comma(given: Any) -> str:
    """Return a hint for a text that is a number except for its decimal comma; otherwise nothing.

    >>> comma("0,5"), comma("a,b")
    (' (a decimal comma: write 0.5)', '')
    """
    number = isinstance(given, str) and re.fullmatch(r"[-+]?\d+,\d+([eE][-+]?\d+)?", given.strip())
    return f" (a decimal comma: write {given.strip().replace(',', '.')})" if number else ""


SIZE, LENGTH = Range(0.01, 500, "mm"), Range(1, 10_000, "mm")
STIFFNESS, STROKE, PHASE = Range(1, 1e9, "N/m"), Range(0, 100, "mm"), Range(-360, 360, "deg")
LIMITS: dict[str, Range] = {
    "surface_tension_N_per_m": Range(0, 1, "N/m"),  # water 0.07, mercury 0.49
    "viscosity_Pa_s": Range(0, 1e4, "Pa s"),
    "density_kg_per_m3": Range(10, 25_000, "kg/m3"),  # osmium 22,600
    "youngs_modulus_Pa": Range(1e3, 2e12, "Pa"),  # diamond 1.2e12
    **dict.fromkeys(("stiffness_sphere_sphere_N_per_m", "stiffness_sphere_wall_N_per_m"), STIFFNESS),
    "tangential_stiffness_ratio": Range(0.01, 10),
    "rolling_friction_m": Range(0, 0.01, "m"),  # a length, not the dimensionless coefficient
    **{f"{of}_mm": SIZE for of in ("diameter", "small", "near_mesh", "large", "aperture", "wire_diameter")},
    "frequency_Hz": Range(0.01, 1000, "Hz"),
    **{f"{of}_amplitude_mm": STROKE for of in ("set", *"xyz")},
    **{f"{axis}_phase_deg": PHASE for axis in "xyz"},
    "residual_liquid_percent": Range(0, 99, "%"),
    "class_mass_g": Range(1e-3, 1e6, "g"),
    **{f"{part}_height_mm": LENGTH for part in ("side_wall", "feed_bin", "slide", "outlet", "collecting_bin")},
    **dict.fromkeys(("sieve_diameter_mm", "width_mm"), LENGTH),
    "wall_thickness_mm": Range(0.05, 200, "mm"),
    "clearance_mm": Range(0.01, 200, "mm"),
    "slide_speed_m_per_s": Range(1e-3, 100, "m/s"),
    "duration_s": Range(1e-4, 1e5, "s"),
    "output_interval_s": Range(1e-6, 1e4, "s"),
    "stiffness_factor": Range(1e-6, 1),
    "bridges_every": Range(1, 16, whole=True),
    "case": Range(1, 99_999, whole=True),
    "ranks": Range(1, MOST_RANKS, f"({RANKS_PER_CORE} for each core)", whole=True),
    "seed": Range(0, 2**32 - 1, whole=True),
    "contact_windows": Range(0, 1000, whole=True),
    "contact_window_steps": Range(1, 100_000, whole=True),
    "checkpoints": Range(0, 1000, whole=True),
}
"""Key -> its range."""
OF_BODIES = {**LIMITS, "diameter_mm": Range(0.01, 10_000, "mm")}
"""Ranges of a body or region, which may be wider than any sphere."""
SCENE: dict[str, Range] = {
    "spheres": Range(1, 1_000_000, whole=True),
    "radius_m": Range(1e-6, 0.1, "m"),
    "moisture_percent": Range(0, 100, "%"),
    "viscosity_Pa_s": Range(0, 1000, "Pa s"),
    "speed_m_per_s": Range(1e-4, 10, "m/s"),
    "turns_per_minute": Range(0.1, 1000, "per minute"),
    "seconds": Range(0, 3600, "s", above=True),
    "youngs_modulus_Pa": Range(1e4, 2e12, "Pa"),
    "ranks": LIMITS["ranks"],
    "seed": LIMITS["seed"],
}
"""Parameter of a small scene -> its range."""
