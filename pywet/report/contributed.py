"""Table of the report: the contribution of each effect in each case next to the effect plan's prediction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pywet.planning import audit
from pywet.report.collect import CaseResult

CLASS = {audit.OK: "fits", audit.SMALL: "small", audit.WRONG: "wrong", audit.UNKNOWN: "off"}
"""Verdict -> colour of its cell."""
FORCES = {
    "weight": "weight",
    "contact_normal": "dry contacts, normal",
    "contact_tangential": "dry contacts, tangential",
}
"""Rows of forces that always act, first in the table."""


@dataclass(frozen=True)
class Cell:
    """Measured share, prediction, colour, and explanation."""

    share: float | None
    predicted: float | None
    colour: str
    text: str


Row = tuple[str, str, list[Cell | None]]
"""Name of an effect, measured quantity, its cell for each case."""


def rows(results: Sequence[CaseResult]) -> list[Row]:
    """Return forces that always act, then the effects of the plan, by their names in files; empty without measurements."""
    if not any(r.contributions for r in results):
        return []
    found: list[Row] = [(key, audit.IMPULSE, [_force(r, key) for r in results]) for key in FORCES]
    names = list(dict.fromkeys(row.effect for r in results for row in r.audit))
    for name in names:
        if name == "gravity":  # the first row
            continue
        of_case = [next((row for row in r.audit if row.effect == name), None) for r in results]
        measure = next(row.measure for row in of_case if row is not None)
        cells = [_judged(row, r.contributions) for row, r in zip(of_case, results, strict=True)]
        found.append((name, measure, cells))
    return found


def wrong(results: Sequence[CaseResult]) -> list[str]:
    """Write a sentence for every effect that the plan left out wrongly."""
    return [
        f"Case {r.case.case}, {row.effect.replace('_', ' ')}: {row.text}."
        for r in results
        for row in r.audit
        if row.verdict == audit.WRONG
    ]


def _force(result: CaseResult, key: str) -> Cell | None:
    if not result.contributions:
        return None
    entry = result.contributions["effects"][key]
    return Cell(entry["impulse_share"], None, "", _energy(entry))


def _judged(row: audit.AuditRow | None, contributions: dict[str, Any] | None) -> Cell | None:
    if row is None or not contributions:
        return None
    entry = contributions["effects"].get(row.effect, {})
    colour = "off" if not row.on and row.verdict == audit.OK else CLASS[row.verdict]
    return Cell(row.measured, row.predicted, colour, "; ".join(t for t in (row.text, _energy(entry)) if t))


def _energy(entry: dict[str, Any]) -> str:
    share = entry.get("energy_share")
    return "" if share is None else f"{percent(share)} % of the energy turned over"


def percent(share: float | None) -> str:
    """Format a share in per cent with two digits, above 99.5 % in whole per cent; a dash for None."""
    if share is None:
        return "–"
    return f"{100 * share:.2g}" if share < 0.995 else f"{100 * share:.0f}"
