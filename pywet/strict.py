"""Base class of all typed data read from files; unexpected keys and types are refused."""

from __future__ import annotations

from typing import Any, get_args

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
