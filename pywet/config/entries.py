"""A number with its origin: `{value: 40, source: paper, table: 1}`, or an assumption with its reason."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pywet.scene import NonNegative, Positive, Strict


class Sourced(Strict):
    """With an origin: the paper (table or section of Elskamp & Kruggel-Emden 2018) or an assumption (reason)."""

    source: Literal["paper", "assumption"]
    table: Annotated[int, Field(ge=1)] | None = None
    section: str | None = None
    reason: Annotated[str, Field(min_length=10)] | None = None

    @model_validator(mode="after")
    def _origin(self) -> Sourced:
        if self.source == "paper" and self.table is None and self.section is None:
            raise ValueError("an entry with `source: paper` and its `table` or `section`")
        if self.source == "assumption" and self.reason is None:
            raise ValueError("an entry with `source: assumption` and its `reason`")
        return self


class Entry(Sourced):
    """Any number; the unit is the end of its key. `tolerance` is plus or minus, in the same unit."""

    value: float
    tolerance: Positive | None = None


class PositiveEntry(Entry):
    """A number above zero."""

    value: Positive


class NonNegativeEntry(Entry):
    """Zero or more."""

    value: NonNegative


class RatioEntry(Entry):
    """Above zero, up to one."""

    value: Annotated[float, Field(gt=0, le=1)]


class AngleEntry(Entry):
    """Contact angle or inclination [deg], zero to below 180."""

    value: Annotated[float, Field(ge=0, lt=180)]


class CountEntry(Sourced):
    """A whole number above zero."""

    value: Annotated[int, Field(ge=1)]


class MaterialEntry(Sourced):
    """The name of a wall material."""

    material: str
