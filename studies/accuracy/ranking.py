"""Rank of the defaults among the levels of their settings: error against cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pywet.cost import choice
from pywet.cost.edit import Level
from studies.accuracy.parameters import PARAMETERS

MATTERS = 1e-3
"""Difference below which errors count as equal."""
GAIN, WORTH = 0.05, 1.3
"""Reduction of the error above which, and cost ratio up to which, a level is reported as an improvement."""


@dataclass(frozen=True)
class Rank:
    """Rank of the default of a setting among its levels in one group of quantities.

    It is beaten if another level is significantly neither more expensive nor less accurate, at the limit for all
    errors of the study together (`family`).
    """

    setting: str
    kind: str
    group: str
    verdict: str
    """Verdict: `on the front`, `not distinguished` (a cheaper level differs by less than the scatter) or `beaten`."""
    by: Level | None
    verdict_text: str


def points(table: dict[str, Any], setting: str, kind: str, group: str) -> list[dict[str, Any]]:
    """Return the levels of a setting, coarse to fine, with cost and the largest error in the group."""
    of_levels = []
    for row in table["parameters"].get(setting, ()):
        cost = row["cost"].get(kind)
        errors = [e for e in row["errors"] if e["group"] == group and e["scene"] in choice.SCENES[kind]]
        if cost is None or not errors:
            continue
        worst = max(errors, key=lambda e: (abs(e["value"]) > e["limit"], abs(e["value"])))
        of_levels.append(
            {
                "level": row["level"],
                "cost": cost["ratio"],
                "low": cost["low"],
                "high": cost["high"],
                "value": abs(worst["value"]),
                "limit": max(e["limit"] for e in errors),
                "resolved": abs(worst["value"]) > worst["limit"],
                "errors": {(e["scene"], e["quantity"]): (abs(e["value"]), e["family"]) for e in errors},
            }
        )
    return of_levels


def rank(table: dict[str, Any], setting: str, kind: str, group: str) -> Rank | None:
    """Rank the default of a setting among its levels; None if the group was not measured for it."""
    levels = points(table, setting, kind, group)
    at_default = next((p for p in levels if p["level"] == table["default"][setting]), None)
    if at_default is None or len(levels) < 2:
        return None
    verdict, by, verdict_text = (
        "on the front",
        None,
        "every cheaper level is less accurate, every more accurate one dearer",
    )
    for other in levels:
        if other is at_default or other["low"] > at_default["high"]:  # more expensive in every round
            continue
        better, worse = _compare(other, at_default)
        cost = f"{other['cost']:.2f} of the cost ({other['low']:.2f} to {other['high']:.2f})"
        if better and not worse:
            return Rank(setting, kind, group, "beaten", other["level"], f"{other['level']} is more accurate at {cost}")
        if not worse and other["high"] < at_default["low"]:
            verdict, by = "not distinguished", other["level"]
            verdict_text = f"{other['level']} costs {cost}; within chance the runs do not tell the two apart"
    return Rank(setting, kind, group, verdict, by, verdict_text)


def bargain(table: dict[str, Any], setting: str, kind: str, group: str) -> str | None:
    """Describe a level that removes most of the default's error at little cost in a sentence; None if there is none."""
    levels = points(table, setting, kind, group)
    at_default = next((p for p in levels if p["level"] == table["default"][setting]), None)
    if at_default is None:
        return None
    better = [p for p in levels if p["cost"] <= WORTH and at_default["value"] - p["value"] > GAIN]
    better = [p for p in better if _compare(p, at_default)[0] and not _compare(p, at_default)[1]]
    if not better:
        return None
    best = min(better, key=lambda p: p["value"])
    return (
        f"{PARAMETERS[setting].title.capitalize()}, {kind}, {group}: the default ({at_default['level']}) is off by "
        f"{100 * at_default['value']:.0f} %; {best['level']} takes that to {100 * best['value']:.1g} % "
        f"for {best['cost']:.2f} of the cost."
    )


def _compare(one: dict[str, Any], two: dict[str, Any]) -> tuple[list[Any], list[Any]]:
    """Return the quantities in which the first level is significantly better than the second, and significantly worse."""
    shared = [k for k in one["errors"] if k in two["errors"]]
    better = [k for k in shared if _less(one["errors"][k], two["errors"][k])]
    return better, [k for k in shared if _less(two["errors"][k], one["errors"][k])]


def _less(one: tuple[float, float], two: tuple[float, float]) -> bool:
    """Return whether the first error is significantly smaller than the second."""
    return two[0] - one[0] > max(one[1], two[1], MATTERS)
