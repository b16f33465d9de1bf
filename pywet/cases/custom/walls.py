"""Walls of a user-defined scene: an STL file or one of a few solids, fixed or moving."""

from __future__ import annotations

import hashlib
import math
import re
import unicodedata
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, Field, model_validator

from pywet.config.entries import Excusable, only
from pywet.geometry.cad import read_cad
from pywet.geometry.faces import BODIES_DEG, FEATURE_ANGLE_DEG, faces
from pywet.geometry.packing import FeedRegion
from pywet.geometry.punched import SIDES, Punching
from pywet.geometry.solids import Part, bin_solid, plate, polygon, tube, wire, woven
from pywet.geometry.stl import corners_in
from pywet.geometry.surface import Floats, Motion, Surface, make_surface
from pywet.scene import IDENTIFIER, NonNegative, Positive, Rotation, Slide, Title, Vector, Vibration
from pywet.util.notices import notice
from pywet.util.ranges import OF_BODIES, Range

MM = 1e-3
EngineMotion = Vibration | Rotation | Slide
Axis = Literal["x", "y", "z"]


def _given(direction: Vector) -> Vector:
    if not any(direction):
        raise ValueError("a direction, not 0, 0, 0")
    return direction


Direction = Annotated[Vector, AfterValidator(_given)]
Sides = Annotated[int, Field(ge=3, le=96)]
BAR_DEG, MOST_FACETS = 1.1, 200_000
"""Smallest angle [deg] of a bar's triangles, and largest number of triangles of bars."""
LAND = 1.02
"""Smallest distance between the centres of two holes of a plate, over their diameter."""
ORDER = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}
"""Permutation of coordinates that turns a solid drawn along z to another axis."""


class Box(Excusable):
    """Describe a region by its lower and upper corner."""

    low_mm: Vector
    """Corner with the smallest x, y, z."""
    high_mm: Vector
    """Opposite corner."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not all(a < b for a, b in zip(self.low_mm, self.high_mm, strict=True)):
            raise ValueError("each number of low_mm to be less than that of high_mm")
        return self

    def region(self) -> FeedRegion:
        """Convert the box to the region in which spheres are placed."""
        (x, y, z), (u, v, w) = (tuple(MM * c for c in corner) for corner in (self.low_mm, self.high_mm))
        return FeedRegion(
            "square", u - x, z, w, v - y, (0.5 * (x + u), 0.5 * (y + v)), name="box",
            cure="set high_mm of their box higher, widen it, or lower count or mass_g",
        )  # fmt: skip


class Block(Box):
    """A solid cuboid between two corners."""

    def parts(self) -> list[Part]:
        """Make the six faces of the block."""
        (x, y, z), (u, v, w) = (tuple(MM * c for c in corner) for corner in (self.low_mm, self.high_mm))
        return plate(np.array([[x, y], [u, y], [u, v], [x, v]]), z, w)


class Tube(Excusable):
    """An open tube along an axis, round (many sides) or square (4); `origin_mm` is the middle of its lower end."""

    inner_diameter_mm: Positive
    """Inner diameter, between opposite faces."""
    length_mm: Positive
    """Length along the axis."""
    origin_mm: Vector = (0.0, 0.0, 0.0)
    """Middle of the lower end."""
    axis: Axis = "z"
    """Axis of the tube."""
    thickness_mm: Positive = 3.0
    """Thickness of the tube's wall."""
    sides: Sides = 32
    """Number of faces around the axis; 4 for a square tube."""

    def parts(self) -> list[Part]:
        """Make inner face, outer face and rims of the tube."""
        solid = tube(0.5 * MM * self.inner_diameter_mm, MM * self.thickness_mm, self.sides, 0.0, MM * self.length_mm)
        return _placed(solid, self.axis, self.origin_mm)


class Disc(Excusable):
    """A round plate, such as the lid of a drum; `origin_mm` is the middle of its lower face."""

    RANGED: ClassVar[dict[str, Range]] = OF_BODIES

    diameter_mm: Positive
    """Diameter, between opposite faces."""
    origin_mm: Vector = (0.0, 0.0, 0.0)
    """Middle of the lower face."""
    axis: Axis = "z"
    """Axis normal to the faces."""
    thickness_mm: Positive = 3.0
    """Thickness along the axis."""
    sides: Sides = 32
    """Number of faces around the axis."""

    def parts(self) -> list[Part]:
        """Make the two faces and the edge of the disc."""
        solid = plate(polygon(0.5 * MM * self.diameter_mm, self.sides), 0.0, MM * self.thickness_mm)
        return _placed(solid, self.axis, self.origin_mm)


class Vessel(Excusable):
    """An open-topped upright vessel, square (4 sides) or round; `origin_mm` is the middle of its floor's upper face."""

    inner_width_mm: Positive
    """Inner width, between opposite faces."""
    height_mm: Positive
    """Height of the inside."""
    origin_mm: Vector = (0.0, 0.0, 0.0)
    """Middle of the floor's upper face."""
    thickness_mm: Positive = 3.0
    """Thickness of walls and floor."""
    sides: Sides = 4
    """Number of side faces; 4 for a square vessel."""

    def parts(self) -> list[Part]:
        """Make floor, sides and rim of the vessel."""
        solid = bin_solid(0.5 * MM * self.inner_width_mm, MM * self.thickness_mm, self.sides, 0.0, MM * self.height_mm)
        return _placed(solid, "z", self.origin_mm)


class Bars(Excusable):
    """Parallel round bars in a horizontal plane, along x or y: a slotted deck. `origin_mm` is the middle of the plane."""

    diameter_mm: Positive
    """Diameter of a bar."""
    pitch_mm: Positive
    """Distance between the axes of neighbouring bars."""
    length_mm: Positive
    """Length of a bar."""
    count: Annotated[int, Field(ge=1, le=1000)]
    """Number of bars."""
    axis: Literal["x", "y"] = "x"
    """Axis along which the bars extend."""
    origin_mm: Vector = (0.0, 0.0, 0.0)
    """Middle of the plane of the bars."""
    sides: Annotated[int, Field(ge=4, le=32, multiple_of=2)] = 8
    """Number of faces around a bar."""
    crimp_mm: float = 0.0
    """Amplitude of a woven wire, whose period is two pitches: positive for up at the first crossing; neighbours alternate."""
    first_crossing_mm: NonNegative = 0.0
    """Distance from a woven wire's lower end to the middle of the first wire that it crosses; the others follow at one pitch."""

    @model_validator(mode="after")
    def _apart(self) -> Self:
        only(self, "with crimp_mm", bool(self.crimp_mm), "first_crossing_mm")
        if self.pitch_mm <= self.diameter_mm:
            raise ValueError(
                f"pitch_mm more than diameter_mm ({self.pitch_mm:g} is not more than {self.diameter_mm:g})"
            )
        if self.count * self.sides * self.length_mm * math.tan(math.radians(BAR_DEG)) > MOST_FACETS * self.diameter_mm:
            raise ValueError(f"fewer, thicker or shorter bars, which take at most {MOST_FACETS} triangles")
        return self

    def parts(self) -> list[Part]:
        """Make one part of the wall for each bar."""
        along = 0 if self.axis == "x" else 1
        found: list[Part] = []
        for k in range(self.count):
            start, end = (MM * np.array(self.origin_mm) for _ in range(2))
            start[along] -= 0.5 * MM * self.length_mm
            end[along] += 0.5 * MM * self.length_mm
            for point in (start, end):
                point[1 - along] += (k - 0.5 * (self.count - 1)) * MM * self.pitch_mm
            radius = 0.5 * MM * self.diameter_mm
            if self.crimp_mm:
                rise = MM * self.crimp_mm * (-1) ** k
                solid = woven(start, end, radius, self.sides, MM * self.pitch_mm, rise, MM * self.first_crossing_mm)
            else:
                solid = wire(start, end, radius, self.sides, BAR_DEG)
            found.append((solid, radius))
        return found


class Punched(Excusable):
    """A punched plate with round or square holes in columns along x. `origin_mm` is the middle of its upper face."""

    hole_mm: Positive
    """Diameter or side of a hole."""
    pitch_mm: Positive
    """Distance between the centres of neighbouring holes in a column."""
    length_mm: Positive
    """Length of the plate along x."""
    width_mm: Positive
    """Width of the plate along y."""
    columns: Annotated[int, Field(ge=1, le=1000)]
    """Number of columns, which share the width evenly."""
    thickness_mm: Positive
    """Thickness of the plate."""
    hole: Literal["round", "square"] = "round"
    """Shape of a hole."""
    staggered: bool = True
    """Whether every other column is offset by half a pitch."""
    origin_mm: Vector = (0.0, 0.0, 0.0)
    """Middle of the upper face."""

    @model_validator(mode="after")
    def _solid(self) -> Self:
        least, space = LAND * self.hole_mm, min(self.pitch_mm, self.width_mm / self.columns)
        if space < least:
            raise ValueError(
                f"pitch_mm and width_mm/columns of at least {LAND:g} hole_mm, {least:.4g} mm ({space:.4g} is less)"
            )
        if self.punching.count < 1:
            raise ValueError(f"length_mm of a pitch_mm, half of one more where staggered ({self.length_mm:g} is less)")
        if 8 * SIDES * self.columns * self.punching.count > MOST_FACETS:
            raise ValueError(f"fewer or larger holes, which take at most {MOST_FACETS} triangles")
        return self

    @property
    def punching(self) -> Punching:
        """Return the positions of the holes of a punched plate."""
        length, width, hole, pitch = (MM * x for x in (self.length_mm, self.width_mm, self.hole_mm, self.pitch_mm))
        return Punching(length, width, hole, pitch, self.columns, self.hole, self.staggered)

    def parts(self) -> list[Part]:
        """Make the faces, holes and rim of the plate."""
        return _placed(self.punching.parts(-MM * self.thickness_mm, 0.0), "z", self.origin_mm)


class Vibrates(Excusable):
    """x_k(t) = amplitude_k (sin(2 pi f t + phase_k) - sin(phase_k)), k = x, y, z."""

    amplitude_mm: Vector
    """Amplitude along x, y, z."""
    frequency_Hz: Positive
    """Frequency, the same along x, y and z."""
    phase_deg: Vector = (0.0, 0.0, 0.0)
    """Phase along x, y, z."""

    def engine_motion(self, corners: Floats) -> Vibration:
        """Convert the wall's motion to the engine's description in SI units."""
        x, y, z = (MM * a for a in self.amplitude_mm)
        p, q, r = (math.radians(a) for a in self.phase_deg)
        return Vibration(amplitude_m=(x, y, z), phase_rad=(p, q, r), frequency_Hz=self.frequency_Hz)


class Turns(Excusable):
    """Rotation from the start of the run, right-handed about an axis through `origin_mm`."""

    turns_per_minute: Positive
    """Turns per minute, right-handed about the axis."""
    axis: Direction
    """Direction of the axis."""
    origin_mm: Vector = (0.0, 0.0, 0.0)
    """A point on the axis."""

    def engine_motion(self, corners: Floats) -> Rotation:
        """Convert the wall's motion to the engine's description in SI units."""
        x, y, z = (MM * c for c in self.origin_mm)
        return Rotation(origin_m=(x, y, z), axis=_unit(self.axis), period_s=60.0 / self.turns_per_minute)


class Moves(Excusable):
    """Motion at constant velocity from a given time for a given duration; then the wall is at rest."""

    velocity_m_per_s: Vector
    """Constant velocity of the wall."""
    from_s: NonNegative = 0.0
    """Time at which the motion starts."""
    for_s: Positive
    """Duration of the motion."""

    def engine_motion(self, corners: Floats) -> Slide:
        """Convert the wall's motion to the engine's description in SI units."""
        return Slide(velocity_m_per_s=self.velocity_m_per_s, opens_at_s=self.from_s, travel_s=self.for_s)


class Removed(Excusable):
    """Removal of a wall at a given time, such as a gate: it moves twice its length along a direction and stays there."""

    at_s: NonNegative
    """Time at which the removal starts."""
    towards: Direction
    """Direction of the removal."""
    speed_m_per_s: Positive = 1.0
    """Constant speed of the removal."""

    def engine_motion(self, corners: Floats) -> Slide:
        """Convert the wall's motion to the engine's description, given the corners (n, 3) of the wall [m]."""
        way = _unit(self.towards)
        travel = 2.0 * float(np.ptp(corners @ np.array(way)))
        x, y, z = (self.speed_m_per_s * c for c in way)
        return Slide(velocity_m_per_s=(x, y, z), opens_at_s=self.at_s, travel_s=travel / self.speed_m_per_s)


SHAPES = ("stl", "block", "tube", "disc", "vessel", "bars", "punched")
OF_STL = ("stl_unit", "origin_mm", "half_width_mm", "shell_thickness_mm")
"""Keys of a wall that only an STL file has."""
MOTIONS: dict[str, Motion] = {"vibrates": "vibrates", "turns": "turns", "moves": "slides", "removed": "slides"}
"""Key of a motion -> its name in the engine."""


class Wall(Excusable):
    """A wall: its shape (one of `SHAPES`), its contact angle and its motion (one of `MOTIONS`; none for a fixed wall)."""

    name: Title
    """Name in any script; tables and decks use `word` instead."""
    stl: Path | None = None
    """STL file, relative to the folder of the scene."""
    stl_unit: Literal["mm", "m"] = "mm"
    """Unit of the STL file's coordinates."""
    origin_mm: Vector = (0.0, 0.0, 0.0)
    """Point of an STL file's coordinates that becomes the scene's origin."""
    half_width_mm: Positive | None = None
    """Half width of the bodies of an STL file that are wires or bars (a wire's radius): each body is then one part."""
    shell_thickness_mm: Positive | None = None
    """Thickness of the wall made of an STL file that is an open shell, half on either side of its facets."""
    feature_angle_deg: Annotated[float, Field(gt=0, lt=180)] = FEATURE_ANGLE_DEG
    """Angle between facets above which a face ends; a curved face is one face, and a sphere has at most one bridge with it."""
    block: Block | None = None
    """Shape: a cuboid."""
    tube: Tube | None = None
    """Shape: an open tube."""
    disc: Disc | None = None
    """Shape: a round plate."""
    vessel: Vessel | None = None
    """Shape: an open-topped vessel."""
    bars: Bars | None = None
    """Shape: parallel round bars."""
    punched: Punched | None = None
    """Shape: a plate with holes."""
    contact_angle_deg: Annotated[float, Field(ge=0, lt=90)] | None = None
    """Contact angle of the liquid on the wall; by default that of the scene's `wall_material`, or 40 degrees."""
    vibrates: Vibrates | None = None
    """Motion: harmonic."""
    turns: Turns | None = None
    """Motion: about an axis."""
    moves: Moves | None = None
    """Motion: at constant velocity for a time."""
    removed: Removed | None = None
    """Motion: removed, such as a gate."""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        chosen(self, *SHAPES)
        chosen(self, *MOTIONS, needed=False)
        only(self, "with stl", self.stl is not None, *OF_STL)
        only(self, "without bars and half_width_mm", not self.bars and not self.half_width_mm, "feature_angle_deg")
        return self

    @property
    def word(self) -> str:
        """Name of the wall in tables and decks: its own name if an engine can read it, else its Latin letters and a digest."""
        return word_of(self.name)

    @property
    def motion(self) -> Motion:
        """Name of the wall's motion in the engine."""
        key = chosen(self, *MOTIONS, needed=False)
        return MOTIONS[key] if key else "fixed"

    def motion_parameters(self, corners: Floats) -> EngineMotion | None:
        """Convert the wall's motion to SI units; `corners` (n, 3) as it is at the start [m]."""
        way = self.vibrates or self.turns or self.moves or self.removed
        return way.engine_motion(corners) if way else None

    def surface(self, folder: Path) -> Surface:
        """Make the wall's triangles; an STL file is read from `folder`."""
        if self.stl is not None:
            return make_surface(self.word, "wall", self._of_file(folder), self.motion)
        parts = self._shape.parts()
        if self.bars is None:
            parts = faces(np.concatenate([corners for corners, _ in parts]), self.feature_angle_deg)
        return make_surface(self.word, "wall", parts, self.motion)

    def points(self, folder: Path) -> Floats:
        """Return the corners (n, 3) [m] of the wall as described, without repairs."""
        if self.stl is None:
            return np.concatenate([corners.reshape(-1, 3) for corners, _ in self._shape.parts()])
        unit = MM if self.stl_unit == "mm" else 1.0
        return unit * corners_in(folder / self.stl)[0].reshape(-1, 3) - MM * np.array(self.origin_mm)

    @property
    def _shape(self) -> Block | Tube | Disc | Vessel | Bars | Punched:
        shape = self.block or self.tube or self.disc or self.vessel or self.bars or self.punched
        assert shape is not None
        return shape

    @property
    def fold_deg(self) -> float:
        """Feature angle [deg] at which a face of the wall ends."""
        return BODIES_DEG if self.bars or self.half_width_mm is not None else self.feature_angle_deg

    def _of_file(self, folder: Path) -> list[Part]:
        """Return the parts of an STL file and report repairs."""
        assert self.stl is not None
        unit = MM if self.stl_unit == "mm" else 1.0
        shell = None if self.shell_thickness_mm is None else MM * self.shell_thickness_mm
        corners, changes = read_cad(folder / self.stl, unit, MM * np.array(self.origin_mm), shell)
        if changes:
            notice.warning(f"wall {self.name}: {self.stl.name} repaired: {'; '.join(changes)}")
        parts = faces(corners, self.fold_deg)
        if self.half_width_mm is None:
            return parts
        return [(part, MM * self.half_width_mm) for part, _ in parts]


def word_of(name: str) -> str:
    """Convert a wall's name to the word used in tables and decks.

    >>> word_of("drum"), word_of("Rüttelsieb 2"), word_of("漏斗")
    ('drum', 'Ruttelsieb_2_5de194', 'wall_895948')
    """
    if re.fullmatch(IDENTIFIER, name):
        return name
    plain = "".join(c for c in unicodedata.normalize("NFKD", name) if not unicodedata.combining(c))
    latin = re.sub(r"[^A-Za-z0-9]+", "_", plain).strip("_")[:20]
    return f"{latin if latin[:1].isalpha() else 'wall'}_{hashlib.sha256(name.encode()).hexdigest()[:6]}"


def chosen(of: BaseModel, *keys: str, needed: bool = True) -> str | None:
    """Return the only key that is given; several keys, or none if one is `needed`, are refused."""
    given = [key for key in keys if getattr(of, key) is not None]
    if len(given) > 1 or (needed and not given):
        raise ValueError(
            f"{'one' if needed else 'at most one'} of {', '.join(keys)}, not {' and '.join(given) or 'none'}"
        )
    return given[0] if given else None


def _placed(parts: Sequence[Part], axis: Axis, origin_mm: Vector) -> list[Part]:
    """Turn a solid drawn along z from the origin to another axis and move it to its position."""
    return [(corners[..., ORDER[axis]] + MM * np.array(origin_mm), half) for corners, half in parts]


def _unit(given: Vector) -> Vector:
    """Return the unit vector in a direction."""
    x, y, z = (c / math.hypot(*given) for c in given)
    return x, y, z
