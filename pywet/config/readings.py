"""Alternative readings of ambiguous passages of the paper: one key each, with the default.

docs/readings.md quotes each passage and describes the effect of a reading.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Literal

from pywet.laws.kinds import PRESETS
from pywet.scene import WallFilm
from pywet.strict import Strict

As = Literal["mended", "as_printed"]
RABINOVICH = {
    ("mended", "mended"): "rabinovich",
    ("as_printed", "mended"): "rabinovich_spheres_as_printed",
    ("mended", "as_printed"): "rabinovich_walls_as_printed",
    ("as_printed", "as_printed"): "rabinovich_as_printed",
}
"""Readings of (14) between spheres and of (15) at walls -> capillary law."""


PARABOLA = {
    "at_rupture": "parabola",
    "at_fifth": "parabola_walls_at_fifth",
    "at_tenth": "parabola_walls_at_tenth",
}
OF_LAW = {"capillary": ("capillary_spheres", "capillary_walls"), "transfer": ("wall_transfer",)}
"""Kind of law -> readings that apply to the law of the preset `paper`."""


class Readings(Strict):
    """Readings of Elskamp & Kruggel-Emden (2018) used in a run."""

    capillary_spheres: As = "mended"
    """Reading of equation (14): sin φ, or sin θ_m as printed, in its second term.

    It applies to preset `paper` if no capillary law is named.
    """
    capillary_walls: As = "mended"
    """Reading of equations (15) and (18): the limit of (14) at a wall, or as printed.

    It applies to preset `paper` if no capillary law is named.
    """

    small_wall: Literal["wire_radius", "half_facet"] = "wire_radius"
    """Half width r_w of a wire in (11) to (13): its radius, or half the side of a facet of its polygon."""
    wall_film: WallFilm = "triangle"
    """Area over which the liquid of a wall spreads at once: the triangle touched, its part (wire, face), or the whole wall."""
    wall_transfer: Literal["at_rupture", "at_fifth", "at_tenth"] = "at_rupture"
    """Separation at which (35) to (43) are solved at walls: the rupture distance, a fifth or a tenth of it."""
    liquid_amount: Literal["full", "less_residual"] = "full"
    """Initial liquid on the spheres: `liquid_percent` of a case, or that less `residual_liquid_percent` of its material."""
    sphere_mass: Literal["density", "weighed"] = "density"
    """Mass of a sphere, which determines the number in a class: density times volume, or `mass_g` as weighed (table 1)."""
    amplitude: Literal["zero_to_peak", "peak_to_peak"] = "zero_to_peak"
    """Meaning of the amplitudes of `motion.strokes` in materials.yaml: amplitude of the sine, or its full stroke."""

    @property
    def laws(self) -> dict[str, str]:
        """Return the law that the readings select for each kind, if it differs from that of the preset `paper`."""
        read = {
            "capillary": RABINOVICH[self.capillary_spheres, self.capillary_walls],
            "transfer": PARABOLA[self.wall_transfer],
        }
        return {kind: law for kind, law in read.items() if law != PRESETS["paper"][kind]}

    def without(self, kinds: Iterable[str]) -> Readings:
        """Return a copy in which the readings that apply to these kinds of law have their defaults."""
        left = {key for kind in kinds for key in OF_LAW[kind]}
        return Readings.model_validate(self.model_dump(exclude=left))

    @property
    def stroke_share(self) -> float:
        """Return the amplitude of the sine divided by the configured amplitude."""
        return 0.5 if self.amplitude == "peak_to_peak" else 1.0

    def small_half_width(self, radius_m: float, sides: int) -> float:
        """Return the half width [m] of a wire of this radius and number of facets."""
        return radius_m * math.sin(math.pi / sides) if self.small_wall == "half_facet" else radius_m

    @property
    def lines(self) -> list[str]:
        """Return a line for each non-default reading, for the plan."""
        fields = type(self).model_fields
        changed = [(key, value, fields[key].default) for key, value in self if value != fields[key].default]
        return [f"reading: readings.{key} is {value} (default {default})" for key, value, default in changed]
