"""Where the defaults stand: a level is beaten when another of its knob is no dearer and no less accurate, beyond doubt.

Beyond doubt: at the limit for all errors of the study together (`family`), since all of them are looked at.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pywet.evidence.accuracy import knobs

MATTERS = 1e-3
"""Errors closer than this share are the same."""
GAIN, WORTH = 0.05, 1.3
"""A level that is better by this share for no more than this price is a bargain."""


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
    of_levels = []
    for row in table["knobs"].get(knob, ()):
        price = row["price"].get(kind)
        errors = [e for e in row["errors"] if e["group"] == group and e["scene"] in scenes]
        if price is None or not errors:
            continue
        worst = max(errors, key=lambda e: (abs(e["value"]) > e["limit"], abs(e["value"])))
        of_levels.append(
            {
                "level": row["level"],
                "price": price["ratio"],
                "low": price["low"],
                "high": price["high"],
                "value": abs(worst["value"]),
                "limit": max(e["limit"] for e in errors),
                "resolved": abs(worst["value"]) > worst["limit"],
                "errors": {(e["scene"], e["quantity"]): (abs(e["value"]), e["family"]) for e in errors},
            }
        )
    return of_levels


def standing(table: dict[str, Any], knob: str, kind: str, group: str, scenes: tuple[str, ...]) -> Standing | None:
    """Where the default of a knob stands; None where the group was not measured for it."""
    levels = points(table, knob, kind, group, scenes)
    own = next((p for p in levels if p["level"] == table["default"][knob]), None)
    if own is None or len(levels) < 2:
        return None
    verdict, by, said = "on the front", None, "every cheaper level is less accurate, every more accurate one dearer"
    for other in levels:
        if other is own or other["low"] > own["high"]:  # dearer in every round
            continue
        better, worse = _compare(other, own)
        price = f"{other['price']:.2f} of the price ({other['low']:.2f} to {other['high']:.2f})"
        if better and not worse:
            return Standing(
                knob, kind, group, "beaten", other["level"], f"{other['level']} is more accurate at {price}"
            )
        if not worse and other["high"] < own["low"]:
            verdict, by = "not told apart", other["level"]
            said = f"{other['level']} costs {price}; within chance the runs do not tell the two apart"
    return Standing(knob, kind, group, verdict, by, said)


def bargain(table: dict[str, Any], knob: str, kind: str, group: str, scenes: tuple[str, ...]) -> str | None:
    """A level that takes away much of the default's error for little more, as a sentence; None where there is none."""
    levels = points(table, knob, kind, group, scenes)
    own = next((p for p in levels if p["level"] == table["default"][knob]), None)
    if own is None:
        return None
    better = [p for p in levels if p["price"] <= WORTH and own["value"] - p["value"] > GAIN]
    better = [p for p in better if _compare(p, own)[0] and not _compare(p, own)[1]]
    if not better:
        return None
    best = min(better, key=lambda p: p["value"])
    return (
        f"{knobs.KNOBS[knob].title.capitalize()}, {kind}, {group}: the default ({own['level']}) is off by "
        f"{100 * own['value']:.0f} %; {best['level']} takes that to {100 * best['value']:.1g} % "
        f"for {best['price']:.2f} of the price."
    )


def _compare(one: dict[str, Any], two: dict[str, Any]) -> tuple[list[Any], list[Any]]:
    """Quantities in which the first level is better than the second beyond chance, and worse."""
    shared = [k for k in one["errors"] if k in two["errors"]]
    better = [k for k in shared if _less(one["errors"][k], two["errors"][k])]
    return better, [k for k in shared if _less(two["errors"][k], one["errors"][k])]


def _less(one: tuple[float, float], two: tuple[float, float]) -> bool:
    """Whether the first error is smaller beyond chance."""
    return two[0] - one[0] > max(one[1], two[1], MATTERS)
