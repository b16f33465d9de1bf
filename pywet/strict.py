"""Base class of all typed data read from files; unexpected keys and types are refused."""

from __future__ import annotations

from collections.abc import Container, Iterator
from typing import Any, ClassVar, Self, get_args

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError


def refuse(model: type[BaseModel], wrong: list[PydanticCustomError]) -> None:
    """Raise all errors of a group in one; nothing if there is none."""
    if wrong:
        raise ValidationError.from_exception_data(
            model.__name__, [InitErrorDetails(type=one, input=None) for one in wrong]
        )


class Strict(BaseModel):
    """Base class: unknown keys are errors, values are immutable, NaN, inf, and booleans for numbers are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)

    @model_validator(mode="before")
    @classmethod
    def _no_switch_for_a_number(cls, given: Any) -> Any:
        """Refuse a boolean for a number, since True would count as 1 (YAML reads yes, on, y … as true)."""
        wrong = []
        for key, field in cls.model_fields.items() if isinstance(given, dict) else ():
            value, kind = given.get(key), field.annotation
            switch = any(v is True or v is False for v in (value if isinstance(value, (list, tuple)) else (value,)))
            if switch and kind is not bool and not any(v is True for v in get_args(kind)):
                wrong.append(PydanticCustomError("switch", "a number", {"key": key, "value": value}))
        refuse(cls, wrong)
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
        expected = f"0 or a number of size {self.LEAST:g} to {self.MOST:g}"
        numbers = [(key, n) for key, value in self if key not in self.RANGED for n in _numbers(value)]
        refuse(type(self), [
            PydanticCustomError("implausible", "to be in range", {"key": key, "value": n, "expected": expected})
            for key, n in numbers if n and not self.LEAST <= abs(n) <= self.MOST
        ])  # fmt: skip
        return self


def _numbers(value: Any) -> Iterator[float]:
    if isinstance(value, float):
        yield value
    elif isinstance(value, (tuple, list)):
        for part in value:
            yield from _numbers(part)
