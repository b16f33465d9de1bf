"""One row of the cross-check's tables: a program's value of a quantity against a reference."""

from __future__ import annotations

import math
from typing import Any

TWO_ERRORS = "spread: two standard errors of the difference"


def row(
    scene: str, quantity: str, engine: str, value: float, reference: str, reference_value: float, spread: float = math.nan,
    note: str = "",
) -> dict[str, Any]:  # fmt: skip
    """Value, reference, relative deviation and its spread."""
    return {
        "scene": scene,
        "quantity": quantity,
        "engine": engine,
        "value": float(value),
        "reference": reference,
        "reference_value": float(reference_value),
        "deviation": float(value) / float(reference_value) - 1.0 if reference_value else math.nan,
        "spread": float(spread),
        "note": note,
    }
