"""Base class of all typed data read from files; unexpected keys and types are refused."""

from __future__ import annotations

from collections.abc import Container, Iterator
from typing import Any, ClassVar, Self, get_args

from pydantic import BaseModel, ConfigDict, model_validator
from pydantic_core import PydanticCustomError


class Strict(BaseModel):
    """Base class: unknown keys are errors, values are immutable, NaN, inf, and booleans for numbers are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)

    @model_validator(mode="before")
    @classmethod
    def _no_switch_for_a_number(cls, given: Any) -> Any:
        """Refuse a boolean for a number, since True would count as 1 (YAML reads yes, on, y … as true)."""
        for key, field in cls.model_fields.items() if isinstance(given, dict) else ():
            value, kind = given.get(key), field.annotation
            switch = any(v is True or v is False for v in (value if isinstance(value, (list, tuple)) else (value,)))
            if switch and kind is not bool and not any(v is True for v in get_args(kind)):
                raise PydanticCustomError("switch", "a number", {"key": key, "value": value})
        return given


class Computable(Strict):
    """Group of numbers in SI units whose powers stay within double precision: 0, or of size `LEAST` to `MOST`."""

    LEAST: ClassVar[float] = 1e-40
    MOST: ClassVar[float] = 1e20
    RANGED: ClassVar[Container[str]] = ()
    """Keys that have a range of their own."""

    @model_validator(mode="after")
    def _computable(self) -> Self:
        """Check that numbers without a range are neither too large nor too small for double precision."""
        for key, value in self:
            for number in () if key in self.RANGED else _numbers(value):
                if number and not self.LEAST <= abs(number) <= self.MOST:
                    expected = f"0 or a number of size {self.LEAST:g} to {self.MOST:g}"
                    raise PydanticCustomError(
                        "implausible", "to be in range", {"key": key, "value": number, "expected": expected}
                    )
        return self


def _numbers(value: Any) -> Iterator[float]:
    if isinstance(value, float):
        yield value
    elif isinstance(value, (tuple, list)):
        for part in value:
            yield from _numbers(part)
