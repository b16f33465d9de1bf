"""A number with its origin: `{value: 40, source: paper, table: 1}`, or an assumption with its reason."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import BaseModel, Field, model_validator
from pydantic_core import PydanticCustomError

from pywet.scene import NonNegative, Positive
from pywet.strict import Computable, Strict, refuse
from pywet.util.ranges import LIMITS, Range

Why = Annotated[str, Field(min_length=1)] | None
"""Reason for a value outside the range of its key."""


class Limited(Computable):
    """Group of keys whose numbers are within their plausible ranges or have a reason under `unusual`."""

    MOST: ClassVar[float] = 1e15
    RANGED: ClassVar[Mapping[str, Range]] = LIMITS

    @model_validator(mode="after")
    def _plausible(self) -> Self:
        wrong = []
        for name, given in self:
            limits, reservoir = self.RANGED.get(name), given if isinstance(given, BaseModel) else self
            value = getattr(given, "value", given)
            if limits is None or not isinstance(value, (int, float)) or value in limits:
                continue
            if getattr(reservoir, "unusual", None) is None:
                key = name if reservoir is self else f"{name}.value"
                excuse = (
                    " unless `unusual: why` next to it says so" if "unusual" in type(reservoir).model_fields else ""
                )
                context = {"key": key, "value": value, "expected": f"{limits}{excuse}"}
                wrong.append(PydanticCustomError("implausible", "to be in range", context))
        refuse(type(self), wrong)
        return self


class Excusable(Limited):
    """Group of plain numbers with a key for the reason why one is outside its range."""

    unusual: Why = None
    """Reason for a number outside the plausible range of its key."""


def only(of: BaseModel, how: str, met: bool, *keys: str) -> None:
    """Refuse keys with another value than their default if the condition is not met under which they have an effect."""
    fields = type(of).model_fields
    given = [key for key in keys if getattr(of, key) != fields[key].get_default(call_default_factory=True)]
    if given and not met:
        raise ValueError(f"{' and '.join(given)} only {how}")


def doubled(what: str, keys: Iterable[str]) -> list[str]:
    """Return a mistake for each key of several entries of a list, of which a look-up would find the first."""
    return [f"{what} ({key} is there {n} times)" for key, n in sorted(Counter(keys).items()) if n > 1]


class Sourced(Strict):
    """Value with its source: the paper (table or section), measured or assumed, with a reason if known."""

    source: Literal["paper", "measured", "assumption"]
    table: Annotated[int, Field(ge=1)] | None = None
    section: str | None = None
    reason: Why = None
    unusual: Why = None

    @model_validator(mode="after")
    def _origin(self) -> Sourced:
        if self.source == "paper" and self.table is None and self.section is None:
            raise ValueError("an entry with `source: paper` and its `table` or `section`")
        return self


class Entry(Sourced):
    """A number; the unit is the suffix of its key. `tolerance` is plus or minus, in the same unit."""

    value: float
    tolerance: Positive | None = None


class PositiveEntry(Entry):
    """A configured number above zero, with its source."""

    value: Positive


class NonNegativeEntry(Entry):
    """A configured number of zero or more, with its source."""

    value: NonNegative


class RatioEntry(Entry):
    """A configured number above zero and up to one, with its source."""

    value: Annotated[float, Field(gt=0, le=1)]


class FrictionEntry(Entry):
    """A configured coefficient of friction from zero to ten, with its source."""

    value: Annotated[float, Field(ge=0, le=10)]


class PoissonEntry(Entry):
    """A configured Poisson's ratio, above -1 and at most 0.5 (incompressible), with its source."""

    value: Annotated[float, Field(gt=-1, le=0.5)]


class AngleEntry(Entry):
    """Contact angle or inclination [deg], zero to below 180."""

    value: Annotated[float, Field(ge=0, lt=180)]


class CountEntry(Sourced):
    """A configured whole number above zero, with its source."""

    value: Annotated[int, Field(ge=1)]


class MaterialEntry(Sourced):
    """The name of a wall material."""

    material: str
