"""Cost of each effect, measured by `pywet study effects` and stored in costs.json with its conditions."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from pywet.util.files import read_json

STORED = Path(__file__).with_name("costs.json")


@cache
def measured_costs() -> dict[str, float]:
    """Effect -> processor time it adds, over that of the same run without it; median over the scenes that use it."""
    added: dict[str, float] = read_json(STORED)["added"]
    return added


def shown(cost: float | None) -> str:
    """Format a cost in per cent; a cost within the scatter between packings is reported as zero."""
    if cost is None:
        return "-"
    scatter: float = read_json(STORED)["scatter"]
    return f"{100 * cost:+.0f} %" if abs(cost) > scatter else f"<{100 * scatter:.0f} %"
