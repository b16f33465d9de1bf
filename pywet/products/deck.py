"""A vibrating deck from a few numbers: the walls of a screen, its stroke, its inclination and the outlets of its products.

The deck lies along x and material travels to +x. Its frame is that of the scene: an inclination turns gravity, not the walls.
"""

from __future__ import annotations

import math
from itertools import accumulate, pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from pywet.config.entries import Excusable, only
from pywet.geometry.punched import Punching
from pywet.products.apertures import CROSS, DECKS, of_deck
from pywet.scene import Positive, Vector

G = 9.81
"""Acceleration of gravity [m/s2]."""
BELOW = 6.0
"""Least depth of the outlet of the unders below the deck at the start, over the aperture.

It is also at least one aperture below the lower face of the deck at its lowest.
"""
LEAST_LAND = 0.18
"""Smallest land between round holes over their diameter, since columns of a triangular pattern are closer than holes."""
SIDE_MM = 5.0
"""Thickness of the side walls and of the back wall."""

SLIT_MM = 0.1
"""Gap between the back wall and the deck, and between the back wall and the side walls."""


class Stroke(Excusable):
    """Motion of a deck: a line, a circle or an ellipse in the vertical plane along the deck."""

    kind: Literal["linear", "circular", "elliptic"] = "linear"
    """Shape of the path."""
    amplitude_mm: Positive
    """Half of the stroke; for an ellipse half of its long axis."""
    frequency_Hz: Positive
    """Strokes or revolutions per second."""
    angle_deg: Annotated[float, Field(ge=0, le=90)] = 45.0
    """Angle of the line or of the long axis to the deck: 90 is perpendicular to the deck."""
    ratio: Annotated[float, Field(gt=0, le=1)] = 0.5
    """Short over long axis of an ellipse."""
    forward: bool = True
    """Whether the upper part of a circle or ellipse moves in the direction of transport."""

    @model_validator(mode="after")
    def _of_its_kind(self) -> Self:
        only(self, "with kind: elliptic", self.kind == "elliptic", "ratio")
        only(self, "with kind: circular or elliptic", self.kind != "linear", "forward")
        return self

    def vibrates(self) -> dict[str, Any]:
        """Return amplitude and phase along x and z of the combined oscillation, the short axis a quarter period behind."""
        short = {"linear": 0.0, "circular": 1.0, "elliptic": self.ratio}[self.kind] * (-1.0 if self.forward else 1.0)
        c, s = math.cos(math.radians(self.angle_deg)), math.sin(math.radians(self.angle_deg))
        # sin along the long axis (c, s), cos along (s, -c); reversed if the path moves to +x at its top
        x, z = (c, short * s), (s, -short * c)
        amplitudes = [self.amplitude_mm * math.hypot(*part) for part in (x, z)]
        phases = [math.degrees(math.atan2(part[1], part[0])) for part in (x, z)]
        return {
            "amplitude_mm": (amplitudes[0], 0.0, amplitudes[1]),
            "phase_deg": (phases[0], 0.0, phases[1]),
            "frequency_Hz": self.frequency_Hz,
            "unusual": self.unusual,
        }

    def reach_mm(self, axis: str) -> float:
        """Return how far the deck moves along -x or -z from where it is at the start [mm].

        >>> circle = Stroke(kind="circular", amplitude_mm=4, frequency_Hz=16)
        >>> f"{circle.reach_mm('z'):.2f} {circle.reach_mm('x'):.2f}"
        '6.83 1.17'
        """
        moves, k = self.vibrates(), "xyz".index(axis)
        return float(moves["amplitude_mm"][k] * (1.0 + math.sin(math.radians(moves["phase_deg"][k]))))


class Mesh(Excusable):
    """Openings of a deck: wires, bars, or a punched plate."""

    aperture_mm: Positive
    """Clear opening: side, width, or diameter of a round hole."""
    wire_mm: Positive
    """Diameter of a wire or bar; for a punched plate the land between two holes."""
    mesh: Literal["square", "woven", "slotted", "punched_round", "punched_square"] = "square"
    """Kind of openings.

    Wires along and across in one plane, or woven; bars along the deck only; a plate with round holes in staggered
    columns, or with square ones.
    """
    plate_mm: Positive | None = None
    """Thickness of a punched plate; by default that of the land."""

    @model_validator(mode="after")
    def _a_plate(self) -> Self:
        only(self, "with mesh: punched_round or punched_square", self.is_plate, "plate_mm")
        if self.mesh == "punched_round" and self.wire_mm < LEAST_LAND * self.aperture_mm:
            raise ValueError(
                f"deck: wire_mm of at least {LEAST_LAND * self.aperture_mm:.4g} mm between round holes of "
                f"{self.aperture_mm:g} mm, not {self.wire_mm:g}"
            )
        return self

    @property
    def pitch_mm(self) -> float:
        """Return the distance between the axes of neighbouring wires, or the centres of holes [mm]."""
        return self.aperture_mm + self.wire_mm

    @property
    def is_plate(self) -> bool:
        """Return whether it is a punched plate."""
        return self.mesh.startswith("punched")

    @property
    def thick_mm(self) -> float:
        """Return the height from the upper face down [mm]."""
        plate = self.plate_mm or self.wire_mm
        return plate if self.is_plate else self.wire_mm * (2.0 if self.mesh == "woven" else 1.0)


class Beneath(Mesh):
    """A deck under another one, of the same length and width, which moves with it; its overs are the middlings."""

    below_mm: Positive
    """Distance of its upper face below that of the deck above."""


class Deck(Mesh):
    """An inclined vibrating deck with side walls, its upper face at z = 0, from x = 0 on; overs leave at its end."""

    length_mm: Positive
    """Length along x, in the direction of transport."""
    width_mm: Positive
    """Width along y, between the side walls, or of the periodic strip."""
    periodic: bool = False
    """Whether the deck is a strip of a wide one, periodic along y in place of side walls."""
    inclination_deg: Annotated[float, Field(ge=0, le=45)] = 0.0
    """Downward inclination in the direction of transport."""
    side_mm: Positive = 40.0
    """Height of the side walls above the deck."""
    stroke: Stroke
    """Motion of the deck."""
    sections: Annotated[int, Field(ge=1, le=20)] = 1
    """Number of sections of its length whose unders are collected separately, unders_1 first."""
    beneath: Annotated[tuple[Beneath, ...], Field(max_length=2)] = ()
    """Decks under this one, from the top."""

    @model_validator(mode="after")
    def _holds_apertures(self) -> Self:
        if min(self.length_mm, self.width_mm) < self.pitch_mm:
            raise ValueError(f"deck: length_mm and width_mm of at least one aperture and wire, {self.pitch_mm:g} mm")
        decks: list[Deck | Beneath] = [self, *self.beneath]
        for deck in decks if self.periodic else ():
            if deck.is_plate:  # the engine's force at a seam of a plate differs from the replay's
                raise ValueError(f"deck: mesh square, woven or slotted with periodic, not {deck.mesh}")
            every = deck.pitch_mm * (2.0 if deck.mesh == "woven" else 1.0)  # adjacent woven wires alternate
            times = self.width_mm / every
            if abs(times - round(times)) > 1e-6:
                raise ValueError(
                    f"deck: width_mm of whole apertures and wires with periodic, such as {max(1, round(times)) * every:g} mm "
                    f"for a pitch of {deck.pitch_mm:g} mm and mesh: {deck.mesh}, not {self.width_mm:g}"
                )
        for k, (above, under) in enumerate(pairwise(decks), start=1):
            if under.aperture_mm >= above.aperture_mm:
                raise ValueError(
                    f"deck: beneath {k}: an aperture_mm below that of the deck above, {above.aperture_mm:g} mm"
                )
            least = 2.0 * above.aperture_mm + above.thick_mm
            if isinstance(under, Beneath) and under.below_mm < least:
                raise ValueError(
                    f"deck: beneath {k}: below_mm of at least two apertures and a wire of the deck above, {least:g} mm"
                )
        return self

    @property
    def gravity(self) -> Vector:
        """Return the gravity in the frame of the deck [m/s2]."""
        angle = math.radians(self.inclination_deg)
        return G * math.sin(angle), 0.0, -G * math.cos(angle)

    @property
    def acceleration_ratio(self) -> float:
        """Return the throw number: largest acceleration of the deck normal to itself over that of gravity."""
        normal = 1e-3 * self.stroke.vibrates()["amplitude_mm"][2] * (2.0 * math.pi * self.stroke.frequency_Hz) ** 2
        return normal / -self.gravity[2]

    def adhesion_number(
        self, radius_m: float, density_kg_per_m3: float, angle_rad: float, tension_N_per_m: float
    ) -> float:
        """Return the capillary force of two equal spheres at touch over the force with which the deck throws one off.

        2 pi r sigma cos(theta) over m g cos(beta) (throw number - 1); infinite if the deck does not throw. In the runs of
        docs/screens.md no deck was blocked up to 1, with spheres of 0.8 apertures.

        >>> deck = Deck(length_mm=60, width_mm=35, aperture_mm=5, wire_mm=2, stroke={"amplitude_mm": 2, "frequency_Hz": 20})
        >>> f"{deck.acceleration_ratio:.2f} {deck.adhesion_number(0.002, 2650.0, 0.0, 0.072):.2f}"
        '2.28 0.81'
        """
        force = 2.0 * math.pi * radius_m * tension_N_per_m * math.cos(angle_rad)
        mass = density_kg_per_m3 * 4.0 / 3.0 * math.pi * radius_m**3
        thrown = mass * -self.gravity[2] * (self.acceleration_ratio - 1.0)
        return force / thrown if thrown > 0.0 else math.inf

    @property
    def strip(self) -> dict[str, Any]:
        """Return axis and faces of the periodic scene [mm]."""
        return {"axis": "y", "low_mm": -0.5 * self.width_mm, "high_mm": 0.5 * self.width_mm}

    @property
    def levels(self) -> list[tuple[Deck | Beneath, float]]:
        """List the deck and those beneath it with the height of their upper faces [mm]."""
        heights = accumulate((-deck.below_mm for deck in self.beneath), initial=0.0)
        return list(zip((self, *self.beneath), heights, strict=True))

    def _wires(self, deck: Mesh, axis: str) -> tuple[int, float]:
        """Return the number of wires along an axis and the position of the first.

        No gap at a border is wider than an aperture. Wires along the deck are symmetric about its middle,
        those across start at its back.
        """
        if axis == "y":
            return math.ceil(self.length_mm / deck.pitch_mm - 1e-9), 0.5 * deck.wire_mm
        count = max(1, math.ceil((self.width_mm - deck.aperture_mm) / deck.pitch_mm - 1e-9))
        if self.periodic:  # half an aperture at each face
            count = round(self.width_mm / deck.pitch_mm)
        return count, -0.5 * (count - 1) * deck.pitch_mm

    def _bars(self, deck: Mesh, height: float, axis: str) -> dict[str, Any]:
        """Return the wires along an axis."""
        (count, first), (_, across) = self._wires(deck, axis), self._wires(deck, "y" if axis == "x" else "x")
        middle = first + 0.5 * (count - 1) * deck.pitch_mm if axis == "y" else 0.5 * self.length_mm
        found = {
            "diameter_mm": deck.wire_mm, "pitch_mm": deck.pitch_mm, "count": count, "axis": axis,
            "length_mm": self.length_mm if axis == "x" else self.width_mm,
            "origin_mm": (middle, 0.0, height - 0.5 * deck.thick_mm), "unusual": deck.unusual or self.unusual,
        }  # fmt: skip
        if deck.mesh != "woven":
            return found
        crimp = 0.5 * deck.wire_mm * (1.0 if axis == "x" else -1.0)
        return {
            **found,
            "crimp_mm": crimp,
            "first_crossing_mm": across if axis == "x" else across + 0.5 * self.width_mm,
        }

    def _plate(self, deck: Mesh, height: float) -> dict[str, Any]:
        """Return a plate with as many columns of holes as fit."""
        staggered = deck.mesh == "punched_round"
        across = deck.pitch_mm * (math.sqrt(0.75) if staggered else 1.0)
        columns = int(self.width_mm / across + 1e-9)
        return {
            "hole_mm": deck.aperture_mm, "pitch_mm": deck.pitch_mm, "length_mm": self.length_mm, "width_mm": self.width_mm,
            "columns": max(1, columns), "thickness_mm": deck.thick_mm, "hole": deck.mesh.removeprefix("punched_"),
            "staggered": staggered, "origin_mm": (0.5 * self.length_mm, 0.0, height), "unusual": deck.unusual or self.unusual,
        }  # fmt: skip

    def punching(self, deck: Mesh) -> Punching:
        """Return the positions of the holes of a punched deck, in mm."""
        plate = self._plate(deck, 0.0)
        length, width, hole, pitch = (plate[key] for key in ("length_mm", "width_mm", "hole_mm", "pitch_mm"))
        return Punching(length, width, hole, pitch, plate["columns"], plate["hole"], plate["staggered"])

    def open_area(self, deck: Mesh) -> float:
        """Return the open share of the area of one of its decks; of wires that of the net, at sides and ends too.

        >>> stroke = {"amplitude_mm": 2, "frequency_Hz": 20}
        >>> deck = Deck(length_mm=60, width_mm=35, aperture_mm=5, wire_mm=2, stroke=stroke)
        >>> f"{deck.open_area(deck):.4f}"
        '0.5102'
        """
        if not deck.is_plate:
            return (deck.aperture_mm / deck.pitch_mm) ** (1 if deck.mesh == "slotted" else 2)
        one = deck.aperture_mm**2 * (0.25 * math.pi if deck.mesh == "punched_round" else 1.0)
        return len(self.punching(deck).centres) * one / (self.length_mm * self.width_mm)

    def walls(self) -> list[dict[str, Any]]:
        """Return the walls of the description: screen and cross wires of each deck, sides, back; all move with the deck."""
        half, lowest = 0.5 * self.width_mm, self.levels[-1]
        end, low, high = self.length_mm, lowest[1] - lowest[0].thick_mm - 1.0, self.side_mm
        found: list[dict[str, Any]] = []
        for k, (deck, height) in enumerate(self.levels, start=1):
            if deck.is_plate:
                found.append({"name": of_deck("screen", k), "punched": self._plate(deck, height)})
                continue
            found.append({"name": of_deck("screen", k), "bars": self._bars(deck, height, "x")})
            if deck.mesh != "slotted":
                found.append({"name": of_deck(CROSS, k), "bars": self._bars(deck, height, "y")})
        slit = 0.0 if self.periodic else SLIT_MM
        blocks = {
            "left": ((-SIDE_MM, half, low), (end, half + SIDE_MM, high)),
            "right": ((-SIDE_MM, -half - SIDE_MM, low), (end, -half, high)),
            "back": ((-SIDE_MM - SLIT_MM, slit - half, low), (-SLIT_MM, half - slit, high)),
        }
        names = ["back"] if self.periodic else [*blocks]
        found += [
            {"name": name, "block": dict(zip(("low_mm", "high_mm"), blocks[name], strict=True))} for name in names
        ]
        moves = self.stroke.vibrates()
        return [{**wall, "vibrates": moves} for wall in found]

    def outlets(self) -> list[dict[str, Any]]:
        """Return the outlets of a deck: overs beyond the end, unders below by section, and no product over a side.

        Overs of a deck are spheres that cross its end above its lower face, wherever both then are.
        """
        away, (lowest, height) = 2.0 * self.aperture_mm, self.levels[-1]
        side, back = 0.5 * self.width_mm + SIDE_MM + away, SIDE_MM + away
        back += max(SIDE_MM, SLIT_MM + self.stroke.reach_mm("x"))
        down = lowest.thick_mm + self.stroke.reach_mm("z") + lowest.aperture_mm
        below = height - max(BELOW * lowest.aperture_mm, down)
        sides: list[dict[str, Any]] = [
            {"name": "spilled_left", "low_mm": (None, side, None)},
            {"name": "spilled_right", "high_mm": (None, -side, None)},
        ]
        found = [] if self.periodic else sides
        found.append({"name": "spilled_back", "high_mm": (-back, None, None)})
        for k, (name, (deck, z)) in enumerate(zip(DECKS, self.levels, strict=False), start=1):
            end = {"low_mm": (self.length_mm, None, None), "crossing_above_mm": z - deck.thick_mm}
            found.append({"name": name, **end, "moves_with": of_deck("screen", k)})
        for k in range(1, self.sections + 1):
            last = k == self.sections
            name = "unders" if self.sections == 1 else f"unders_{k}"
            limit = None if last else self.length_mm * k / self.sections
            found.append({"name": name, "high_mm": (limit, None, below)})
        return found
