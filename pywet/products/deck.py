"""A vibrating deck from a few numbers: the walls of a screen, its stroke, its inclination and the outlets of its products.

The deck lies along x and material travels to +x. Its frame is that of the scene: an inclination turns gravity, not the walls.
"""

from __future__ import annotations

import math
from itertools import accumulate, pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from pywet.config.entries import Excusable
from pywet.products.apertures import CROSS, DECKS, of_deck
from pywet.scene import Positive, Vector

G = 9.81
"""Acceleration of gravity [m/s2]."""
BELOW = 6.0
"""Depth of the outlet of the unders below the deck, over the aperture."""
FALLEN = 0.25
"""Of the room under a deck with others: so far below it do its overs belong to it, at its end."""
SIDE_MM = 5.0
"""Thickness of the side walls and of the back wall."""


class Stroke(Excusable):
    """Motion of a deck: a line, a circle or an ellipse in the vertical plane along it."""

    kind: Literal["linear", "circular", "elliptic"] = "linear"
    """Shape of the path."""
    amplitude_mm: Positive
    """Half of the stroke; of an ellipse half of its long axis."""
    frequency_Hz: Positive
    """Turns or strokes per second."""
    angle_deg: Annotated[float, Field(ge=0, le=90)] = 45.0
    """Of the line or of the long axis against the deck: 90, across the deck."""
    ratio: Annotated[float, Field(gt=0, le=1)] = 0.5
    """Of an ellipse: short over long axis."""
    forward: bool = True
    """Of a circle or ellipse: whether its upper part moves with the material."""

    def vibrates(self) -> dict[str, Any]:
        """Amplitude and phase along x and z of a sum of both axes' oscillations, the short axis a quarter of a period behind."""
        short = {"linear": 0.0, "circular": 1.0, "elliptic": self.ratio}[self.kind] * (-1.0 if self.forward else 1.0)
        c, s = math.cos(math.radians(self.angle_deg)), math.sin(math.radians(self.angle_deg))
        # along the long axis (c, s) goes sin, along (s, -c) cos; turned round where the path goes to +x at its top
        x, z = (c, short * s), (s, -short * c)
        amplitudes = [self.amplitude_mm * math.hypot(*part) for part in (x, z)]
        phases = [math.degrees(math.atan2(part[1], part[0])) for part in (x, z)]
        return {
            "amplitude_mm": (amplitudes[0], 0.0, amplitudes[1]),
            "phase_deg": (phases[0], 0.0, phases[1]),
            "frequency_Hz": self.frequency_Hz,
        }


class Beneath(Excusable):
    """A further deck under another, as long and as wide, which moves with it; its overs are the middlings."""

    aperture_mm: Positive
    """Clear opening."""
    wire_mm: Positive
    """Diameter of a wire or bar."""
    mesh: Literal["square", "slotted"] = "square"
    """Wires along and across, or bars along the deck alone."""
    below_mm: Positive
    """Of its upper face below that of the deck above."""

    @property
    def pitch_mm(self) -> float:
        """Distance between the axes of neighbouring wires [mm]."""
        return self.aperture_mm + self.wire_mm


class Deck(Excusable):
    """An inclined vibrating deck with side walls, its upper face at z = 0, from x = 0 on; overs leave at its end."""

    length_mm: Positive
    """Along x, in the direction of transport."""
    width_mm: Positive
    """Along y, between the side walls, or of the strip that repeats."""
    periodic: bool = False
    """A strip of a wide deck: it repeats along y in place of side walls."""
    aperture_mm: Positive
    """Clear opening."""
    wire_mm: Positive
    """Diameter of a wire or bar."""
    mesh: Literal["square", "slotted"] = "square"
    """Wires along and across, or bars along the deck alone."""
    inclination_deg: Annotated[float, Field(ge=0, le=45)] = 0.0
    """Downwards in the direction of transport."""
    side_mm: Positive = 40.0
    """Height of the side walls above the deck."""
    stroke: Stroke
    """How it moves."""
    sections: Annotated[int, Field(ge=1, le=20)] = 1
    """Parts of its length whose unders are collected apart, unders_1 first."""
    beneath: Annotated[tuple[Beneath, ...], Field(max_length=2)] = ()
    """Decks under this one, from above."""

    @model_validator(mode="after")
    def _holds_apertures(self) -> Self:
        if min(self.length_mm, self.width_mm) < self.pitch_mm:
            raise ValueError(f"deck: length_mm and width_mm of at least one aperture and wire, {self.pitch_mm:g} mm")
        decks: list[Deck | Beneath] = [self, *self.beneath]
        for deck in decks if self.periodic else ():
            apertures = self.width_mm / deck.pitch_mm
            if abs(apertures - round(apertures)) > 1e-6:
                raise ValueError(
                    f"deck: width_mm of whole apertures and wires with periodic, such as {round(apertures) * deck.pitch_mm:g} mm "
                    f"for a pitch of {deck.pitch_mm:g} mm, not {self.width_mm:g}"
                )
        for k, (above, under) in enumerate(pairwise(decks), start=1):
            if under.aperture_mm >= above.aperture_mm:
                raise ValueError(
                    f"deck: beneath {k}: an aperture_mm below that of the deck above, {above.aperture_mm:g} mm"
                )
            least = 2.0 * above.aperture_mm + above.wire_mm
            if isinstance(under, Beneath) and under.below_mm < least:
                raise ValueError(
                    f"deck: beneath {k}: below_mm of at least two apertures and a wire of the deck above, {least:g} mm"
                )
        return self

    @property
    def pitch_mm(self) -> float:
        """Distance between the axes of neighbouring wires [mm]."""
        return self.aperture_mm + self.wire_mm

    @property
    def gravity(self) -> Vector:
        """Gravity in the frame of the deck [m/s2]."""
        angle = math.radians(self.inclination_deg)
        return G * math.sin(angle), 0.0, -G * math.cos(angle)

    @property
    def strip(self) -> dict[str, Any]:
        """Axis and faces of the scene that repeats [mm]."""
        return {"axis": "y", "low_mm": -0.5 * self.width_mm, "high_mm": 0.5 * self.width_mm}

    @property
    def levels(self) -> list[tuple[Deck | Beneath, float]]:
        """List the deck and those beneath it with the height of their upper faces [mm]."""
        heights = accumulate((-deck.below_mm for deck in self.beneath), initial=0.0)
        return list(zip((self, *self.beneath), heights, strict=True))

    def _bars(self, deck: Deck | Beneath, height: float, axis: str) -> dict[str, Any]:
        """Wires along an axis, so many that no gap at a side is wider than an aperture."""
        along, across = (self.length_mm, self.width_mm) if axis == "x" else (self.width_mm, self.length_mm)
        count = math.ceil((across - deck.aperture_mm) / deck.pitch_mm - 1e-9) + (axis == "y")
        if self.periodic and axis == "x":  # half an aperture at either face
            count = round(across / deck.pitch_mm)
        return {
            "diameter_mm": deck.wire_mm, "pitch_mm": deck.pitch_mm, "length_mm": along, "count": max(1, count), "axis": axis,
            "origin_mm": (0.5 * self.length_mm, 0.0, height - 0.5 * deck.wire_mm),
        }  # fmt: skip

    def walls(self) -> list[dict[str, Any]]:
        """Walls of the description: screen and cross wires of each deck, sides, back; all move with the deck."""
        half, lowest = 0.5 * self.width_mm, self.levels[-1]
        end, low, high = self.length_mm, lowest[1] - lowest[0].wire_mm - 1.0, self.side_mm
        found: list[dict[str, Any]] = []
        for k, (deck, height) in enumerate(self.levels, start=1):
            found.append({"name": of_deck("screen", k), "bars": self._bars(deck, height, "x")})
            if deck.mesh == "square":
                found.append({"name": of_deck(CROSS, k), "bars": self._bars(deck, height, "y")})
        blocks = {
            "left": ((-SIDE_MM, half, low), (end, half + SIDE_MM, high)),
            "right": ((-SIDE_MM, -half - SIDE_MM, low), (end, -half, high)),
            "back": ((-2 * SIDE_MM - 0.1, -half, low), (-SIDE_MM - 0.1, half, high)),
        }
        names = ["back"] if self.periodic else [*blocks]
        found += [
            {"name": name, "block": dict(zip(("low_mm", "high_mm"), blocks[name], strict=True))} for name in names
        ]
        moves = self.stroke.vibrates()
        return [{**wall, "vibrates": moves} for wall in found]

    @property
    def _clearances(self) -> list[float]:
        """Free height under each deck [mm]."""
        return [*(deck.below_mm for deck in self.beneath), BELOW * self.levels[-1][0].aperture_mm]

    def outlets(self) -> list[dict[str, Any]]:
        """Overs beyond the end, unders below, by section; what jumps over a side or the back belongs to no product."""
        away, (lowest, height) = 2.0 * self.aperture_mm, self.levels[-1]
        side, below = 0.5 * self.width_mm + SIDE_MM + away, height - BELOW * lowest.aperture_mm
        sides: list[dict[str, Any]] = [
            {"name": "spilled_left", "low_mm": (None, side, None)},
            {"name": "spilled_right", "high_mm": (None, -side, None)},
        ]
        found = [] if self.periodic else sides
        found.append({"name": "spilled_back", "high_mm": (-2.0 * SIDE_MM - away, None, None)})
        if not self.beneath:
            found.append({"name": "overs", "low_mm": (self.length_mm + away, None, None)})
        for name, (deck, z), clearance in zip(DECKS, self.levels, self._clearances, strict=False):
            if self.beneath:  # taken at the end itself, before it falls to the height of the next deck
                found.append({"name": name, "low_mm": (self.length_mm, None, z - deck.wire_mm - FALLEN * clearance)})
        for k in range(1, self.sections + 1):
            last = k == self.sections
            name = "unders" if self.sections == 1 else f"unders_{k}"
            limit = None if last else self.length_mm * k / self.sections
            found.append({"name": name, "high_mm": (limit, None, below)})
        return found
