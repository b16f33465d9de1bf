"""The screening cases: cases.csv, one row each (the 18 of table 4, and those that a user adds)."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from pywet.config.entries import Limited
from pywet.scene import Positive

FILE = "cases.csv"
CLASS_NAMES = ("small", "near_mesh", "large")


class Case(Limited):
    """One screening case: material, sizes, aperture, amplitude and moisture."""

    case: Annotated[int, Field(ge=1)]
    material: str
    small_mm: Positive
    near_mesh_mm: Positive
    large_mm: Positive
    aperture_mm: Positive
    set_amplitude_mm: Positive
    liquid_percent: Annotated[float, Field(ge=0, le=100)]
    source: Annotated[str, Field(min_length=1)]
    class_mass_g: Positive | None = None
    """Mass of each class on the sieve of `feed`, in place of that of the reference material."""
    class_volume_cm3: Positive | None = None
    """Solid volume of each class, in place of `class_mass_g`."""
    liquid: Annotated[str, Field(min_length=1)] | None = None
    """Name of one of `liquids` in materials.yaml, in place of its `liquid`."""

    @property
    def name(self) -> str:
        """Name of the run directory, such as `case02`."""
        return f"case{self.case:02d}"

    @property
    def diameters_mm(self) -> tuple[float, float, float]:
        """Return the diameters of the classes small, near_mesh, large [mm]."""
        return self.small_mm, self.near_mesh_mm, self.large_mm

    @model_validator(mode="after")
    def _one_feed(self) -> Case:
        if self.class_mass_g is not None and self.class_volume_cm3 is not None:
            raise ValueError("at most one of class_mass_g and class_volume_cm3")
        return self

    @property
    def has_feed(self) -> bool:
        """Return whether the case specifies the amount of its feed."""
        return self.class_mass_g is not None or self.class_volume_cm3 is not None

    @model_validator(mode="after")
    def _ascending(self) -> Case:
        if not self.small_mm < self.near_mesh_mm < self.large_mm:
            given = ", ".join(f"{d:g}" for d in self.diameters_mm)
            raise ValueError(f"small_mm < near_mesh_mm < large_mm, not {given}")
        return self
