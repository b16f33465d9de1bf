"""Where the defaults stand: a level is beaten when another of its knob is no dearer and no less accurate, beyond doubt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pywet.study.accuracy import knobs

MATTERS = 1e-3
"""Errors closer than this share are the same."""
NOISE = 0.03
"""Prices closer than this are the same."""


@dataclass(frozen=True)
class Standing:
    """Where the default of a knob stands in one group of quantities."""

    knob: str
    kind: str
    group: str
    verdict: str
    """`on the front`, `not told apart` (a cheaper level differs by no more than chance) or `beaten`."""
    by: knobs.Level | None
    said: str


def points(table: dict[str, Any], knob: str, kind: str, group: str, scenes: tuple[str, ...]) -> list[dict[str, Any]]:
    """Levels of a knob with price and the error that is largest in the group; coarse to fine."""
    found = []
    for row in table["knobs"][knob]:
        price = row["price"].get(kind)
        errors = [e for e in row["errors"] if e["group"] == group and e["scene"] in scenes]
        if price is None or not errors:
            continue
        worst = max(errors, key=lambda e: (abs(e["value"]) > e["limit"], abs(e["value"])))
        found.append(
            {
                "level": row["level"],
                "price": price["ratio"],
                "low": price["low"],
                "high": price["high"],
                "value": abs(worst["value"]),
                "limit": max(e["limit"] for e in errors),
                "resolved": abs(worst["value"]) > worst["limit"],
                "quantity": worst["quantity"],
                "errors": {(e["scene"], e["quantity"]): (abs(e["value"]), e["limit"]) for e in errors},
            }
        )
    return found


def standing(table: dict[str, Any], knob: str, kind: str, group: str, scenes: tuple[str, ...]) -> Standing | None:
    """Where the default of a knob stands; None where the group was not measured for it."""
    levels = points(table, knob, kind, group, scenes)
    own = next((p for p in levels if p["level"] == table["default"][knob]), None)
    if own is None or len(levels) < 2:
        return None
    verdict, by, said = "on the front", None, "every cheaper level is less accurate, every more accurate one dearer"
    for other in levels:
        if other is own or other["price"] > own["price"] * (1.0 + NOISE):
            continue
        better = [k for k, e in other["errors"].items() if k in own["errors"] and _less(e, own["errors"][k])]
        worse = [k for k, e in other["errors"].items() if k in own["errors"] and _less(own["errors"][k], e)]
        price = f"{other['price']:.2f} of the price"
        if better and not worse:
            return Standing(
                knob, kind, group, "beaten", other["level"], f"{other['level']} is more accurate at {price}"
            )
        if not worse and other["price"] < own["price"] * (1.0 - NOISE):
            verdict, by = "not told apart", other["level"]
            said = f"{other['level']} costs {price}; within chance the runs do not tell the two apart"
    return Standing(knob, kind, group, verdict, by, said)


def _less(one: tuple[float, float], two: tuple[float, float]) -> bool:
    """Whether the first error is smaller beyond chance."""
    return two[0] - one[0] > max(one[1], two[1], MATTERS)
