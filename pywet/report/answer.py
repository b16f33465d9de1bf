"""First screen of the report: what passes, how moisture changes it, and whether it was recomputed."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter

from pywet.report.bridge import short
from pywet.report.collect import CaseResult, by_liquid, grouped, named


def rows(results: Sequence[CaseResult]) -> list[list[CaseResult]]:
    """Group cases with results that differ only in the amount of one liquid, the driest first."""
    there = (r for r in results if r.summary is not None and r.retained is not None)
    return [sorted(group, key=lambda r: r.case.liquid_percent) for group in by_liquid(there)]


def passed(dry_ends: Sequence[float], coarse: float) -> list[float]:
    """Per cent of the dry mass of the classes that can pass which has passed, of every seed; 0 if none can.

    >>> passed([0.6], 0.2)
    [50.0]
    """
    return [100.0 * (1.0 - end) / (1.0 - coarse) if coarse < 1.0 else 0.0 for end in dry_ends]


def not_agreeing(results: Sequence[CaseResult]) -> dict[str, list[CaseResult]]:
    """Return moist cases for which the reference disagrees, and those not cross-checked; empty kinds are omitted."""
    bad = [r for r in results if r.bridged and not r.cross_checked]
    kinds = {"disagreeing": [r for r in bad if r.agreement], "missing": [r for r in bad if not r.agreement]}
    return {kind: group for kind, group in kinds.items() if group}


def outcome(results: Sequence[CaseResult]) -> str:
    """Return the outcome of the cross-check: `dry`, `disagrees`, or `agrees`, with the parts not checked."""
    moist = [r for r in results if r.bridged]
    if not moist:
        return "dry"
    if not_agreeing(results):
        return "disagrees"
    in_part = " in part" if any(r.nothing for r in results) else ""
    return f"agrees{in_part}{' but for laws' if any(r.unchecked for r in moist) else ''}"


def agrees(results: Sequence[CaseResult]) -> bool:
    """Return whether every moist case was recomputed and no case disagrees."""
    return not not_agreeing(results) and all(row.ok for r in results for row in r.agreement)


def unchecked(results: Sequence[CaseResult]) -> list[str]:
    """Return lines for cases with the same quantities not compared, not checked, or checked by a user's reference."""
    return [
        f"{named(cases)} {start}: {', '.join(laws)}"
        for start, kind in (
            ("nothing compared", "nothing"),
            ("not checked", "unchecked"),
            ("compared with a reference implementation of the user", "second"),
        )
        for laws, cases in grouped(results, attrgetter(kind)).items()
        if laws
    ]


def laws(results: Sequence[CaseResult]) -> dict[tuple[str, str], list[int]]:
    """Return the cases by the effects and laws that they use; those without a law as `dry contacts`, `none`."""
    found: dict[tuple[str, str], list[int]] = {}
    for r in results:
        rows = r.plan["rows"] if r.plan else []
        used = [(row["effect"], short(row["law"])) for row in rows if row["on"] and row.get("law")]
        for key in used or ([("dry contacts", "none")] if r.plan else []):
            found.setdefault(key, []).append(r.case.case)
    return found
