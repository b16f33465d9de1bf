"""Spheres of a user-defined scene: entries of one size, feeds with a size distribution, their regions and insertion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, ClassVar, Self, TypeVar

from pydantic import BaseModel, Field, ValidationError, model_validator

from pywet.cases.custom.materials import Percent
from pywet.cases.custom.walls import MM, Box, chosen
from pywet.config.entries import Excusable, only
from pywet.config.messages import mistake
from pywet.geometry.packing import FeedRegion
from pywet.products.feed import FeedAmount, entries
from pywet.products.size_classes import Sizes
from pywet.scene import NonNegative, Positive, Profile, Title, Vector
from pywet.util.notices import notice
from pywet.util.ranges import OF_BODIES, Range

Entry = TypeVar("Entry", bound=BaseModel)


class Cylinder(Excusable):
    """An upright cylinder; `origin_mm` is the middle of its lower end."""

    RANGED: ClassVar[dict[str, Range]] = OF_BODIES

    diameter_mm: Positive
    """Diameter of the region."""
    height_mm: Positive
    """Height of the region along z."""
    origin_mm: Vector = (0.0, 0.0, 0.0)
    """Middle of the region's lower end."""

    def region(self) -> FeedRegion:
        """Convert the cylinder to the region in which spheres are placed."""
        x, y, z = (MM * c for c in self.origin_mm)
        return FeedRegion(
            "cylinder", MM * self.diameter_mm, z, z + MM * self.height_mm, centre_m=(x, y), name="cylinder",
            cure="raise height_mm or diameter_mm of their cylinder, or lower count or mass_g",
        )  # fmt: skip


class Insertion(Excusable):
    """Insertion of spheres one after the other at random positions in their region, with their `velocity_m_per_s`.

    Until then they move on a straight path, without weight, from an initial position that follows from that
    velocity; keep this path free.
    """

    from_s: NonNegative = 0.0
    """Time at which insertion begins."""
    for_s: Positive
    """Duration of insertion."""
    profile: Profile = "constant"
    """Insertion rate over time: constant, a ramp from zero to twice the mean, or pulsed."""
    pulses: Annotated[int, Field(ge=1)] | None = None
    """Number of pulses, of equal length and mass."""
    pulse_share: Annotated[float, Field(gt=0, le=1)] = 0.5
    """Fraction of a period during which a pulse inserts spheres."""

    @property
    def end_s(self) -> float:
        """Time at which insertion ends [s]."""
        return self.from_s + self.for_s

    @model_validator(mode="after")
    def _has_pulses(self) -> Self:
        pulsed = self.profile == "pulsed"
        only(self, "with profile: pulsed", pulsed, "pulses", "pulse_share")
        if pulsed and self.pulses is None:
            raise ValueError("insertion: pulses with profile: pulsed")
        return self


class Spheres(Excusable):
    """Spheres of one size and material: their number or mass, a region or given positions, and their liquid."""

    name: Title
    """Name of this size class in tables and on the page."""
    material: str
    """Material of the spheres, a key of `materials`."""
    diameter_mm: Positive
    """Diameter of each sphere."""
    count: Annotated[int, Field(ge=1)] | None = None
    """Number of spheres."""
    mass_g: Positive | None = None
    """Mass of the spheres, in place of `count`; rounded to whole spheres over all entries of the same material and region."""
    box: Box | None = None
    """Cuboid of random positions; without `insertion`, its lowest part."""
    cylinder: Cylinder | None = None
    """Cylinder of random positions, in place of `box`, filled likewise."""
    at_mm: Annotated[tuple[Vector, ...], Field(min_length=1)] | None = None
    """Position of each sphere, in place of a region."""
    velocity_m_per_s: Vector = (0.0, 0.0, 0.0)
    """Velocity of the spheres at the start, or on insertion."""
    insertion: Insertion | None = None
    """Insertion during the run, together with the liquid; without it the spheres are present from the start."""
    percent: Percent | None = None
    """Mass of liquid over the mass of these spheres, in place of the scene's amount."""
    film_um: NonNegative | None = None
    """Thickness of the film on these spheres, in place of `percent`."""

    @model_validator(mode="before")
    @classmethod
    def _former_key(cls, given: Any) -> Any:
        """Accept `fed`, the former name of `insertion`, with a warning."""
        if not isinstance(given, dict) or "fed" not in given:
            return given
        notice.warning("spheres: the key fed is now insertion; this version still accepts fed")
        return {"insertion" if key == "fed" else key: value for key, value in given.items()}

    @model_validator(mode="after")
    def _complete(self) -> Self:
        chosen(self, "box", "cylinder", "at_mm")
        if self.at_mm is None:
            chosen(self, "count", "mass_g")
        elif self.count is not None or self.mass_g is not None:
            raise ValueError(
                f"spheres {self.name}: no count and no mass_g together with at_mm, which gives the number of spheres"
            )
        chosen(self, "percent", "film_um", needed=False)
        if self.insertion and (self.at_mm is not None or not any(self.velocity_m_per_s)):
            raise ValueError(f"spheres {self.name}: a box or cylinder and a velocity_m_per_s together with insertion")
        return self

    @property
    def radius_m(self) -> float:
        return 0.5 * MM * self.diameter_mm


class Feed(FeedAmount):
    """Material with a size distribution: it becomes an entry of `spheres` for each size, in whole spheres."""

    name: Title
    """Name of the feed; the names of its size classes start with it."""
    material: str
    """Material of the spheres, a key of `materials`."""
    box: Box | None = None
    """Cuboid of random positions, as of `spheres`."""
    cylinder: Cylinder | None = None
    """Cylinder of random positions, in place of `box`."""
    velocity_m_per_s: Vector = (0.0, 0.0, 0.0)
    """Velocity of the spheres at the start, or on insertion."""
    insertion: Insertion | None = None
    """Interval in which it is inserted at a constant rate; required by `rate_t_per_h`. None: present from the start."""

    @model_validator(mode="after")
    def _placed(self) -> Self:
        chosen(self, "box", "cylinder")
        if self.rate_t_per_h is not None and self.insertion is None:
            raise ValueError(f"feed {self.name}: an insertion for rate_t_per_h")
        if self.insertion and not any(self.velocity_m_per_s):
            raise ValueError(f"feed {self.name}: a velocity_m_per_s together with insertion")
        return self

    def spheres(self, folder: Path) -> tuple[tuple[Spheres, ...], Sizes]:
        """Return the entries of `spheres` that the feed becomes, and its sizes."""
        keys = ("material", "box", "cylinder", "velocity_m_per_s", "insertion", "unusual")
        common = {key: getattr(self, key) for key in keys if getattr(self, key) is not None}
        found, sizes = entries(self.name, self, folder, self.insertion.for_s if self.insertion else None, common)
        return tuple(derived(Spheres, entry, f"feed {self.name}") for entry in found), sizes


def derived(model: type[Entry], given: dict[str, Any], where: str) -> Entry:
    """Build an entry from derived values; invalid values are reported at `where`."""
    try:
        return model(**given)
    except ValidationError as error:
        raise mistake(error, model, where) from error
