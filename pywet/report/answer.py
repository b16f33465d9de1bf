"""The first screen of the report: what passes, how moisture changes it, and whether it is proven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pywet.report.collect import CaseResult
from pywet.report.plots import title
from pywet.screening.verdict import LEDGER_TOLERANCE


@dataclass(frozen=True)
class Passed:
    """One case at its end."""

    case: int
    liquid_percent: float
    retained: float
    of_what_can: float
    """Part of the mass of the classes that can pass, liquid included, which has passed."""

    @property
    def name(self) -> str:
        """Its liquid in words."""
        return f"{self.liquid_percent:g} % liquid" if self.liquid_percent else "dry"


@dataclass(frozen=True)
class Row:
    """Cases that differ only in moisture, the driest first."""

    title: str
    seconds: float
    coarse: float
    cases: tuple[Passed, ...]


def rows(results: Sequence[CaseResult]) -> list[Row]:
    """One row per configuration of which a case has results."""
    groups: dict[Any, list[CaseResult]] = {}
    for r in results:
        if r.summary is not None and r.retained is not None:
            groups.setdefault(r.configuration, []).append(r)
    return [_row(sorted(group, key=lambda r: r.case.liquid_percent)) for group in groups.values()]


def _row(group: Sequence[CaseResult]) -> Row:
    found = []
    for r in group:
        assert r.summary is not None
        end, coarse = r.summary["fraction_retained_end"], r.summary["coarse_share"]
        found.append(Passed(r.case.case, r.case.liquid_percent, end, (1.0 - end) / (1.0 - coarse)))
    first = group[0]
    assert first.summary is not None and first.retained is not None
    seconds = float(first.retained["time_since_opening_s"].iloc[-1])
    return Row(title(first), seconds, first.summary["coarse_share"], tuple(found))


def sentence(table: Sequence[Row]) -> str:
    """What passes and how moisture changes it."""
    if not table:
        return "No case has results yet."
    seconds = f"{table[0].seconds:.2g} s after the slide opened"
    if len(table) == 1:
        words = [
            f"{_percent([c.of_what_can])} {'dry' if not c.liquid_percent else 'with ' + c.name}" for c in table[0].cases
        ]
        return f"Of the mass that can pass, this has passed {seconds}: {', '.join(words)}."
    dry = [c.of_what_can for row in table for c in row.cases if not c.liquid_percent]
    moist = [c.of_what_can for row in table for c in row.cases if c.liquid_percent]
    parts = [f"{_percent(shares)} {name}" for name, shares in (("dry", dry), ("moist", moist)) if shares]
    return f"Of the mass that can pass, this has passed {seconds}: {', '.join(parts)}."


def proof(results: Sequence[CaseResult]) -> tuple[str, bool]:
    """Whether it is proven, in one line; and whether it is."""
    moist, replayed = [r for r in results if r.bridged], [r for r in results if r.agreement]
    bad = [str(r.case.case) for r in moist if not r.cross_checked]
    if bad:
        return f"Not cross-checked: case{'s' if len(bad) > 1 else ''} {', '.join(bad)}.", False
    if not moist:
        return "Nothing moist to cross-check.", all(row.ok for r in replayed for row in r.agreement)
    ledger = [r.summary["ledger_error"] for r in moist if r.summary and r.summary["ledger_error"] is not None]
    whole = "; no liquid is lost" if ledger and max(ledger) <= LEDGER_TOLERANCE else ""
    names = {row.quantity for r in replayed for row in r.agreement}
    agrees = f"an independent reference recomputed every moist case and agrees on all {len(names)} quantities{whole}"
    if any(r.unchecked for r in moist):
        return f"Proven but for laws that the reference does not know: of the rest, {agrees}.", True
    return f"Proven: {agrees}.", True


def unchecked(results: Sequence[CaseResult]) -> list[str]:
    """A line for cases with the same laws that were not checked, and for those with the same second functions."""
    lines = []
    for start, kind in (("not checked: ", "unchecked"), ("held against a second function of the user's: ", "second")):
        groups: dict[tuple[str, ...], list[str]] = {}
        for r in results:
            if getattr(r, kind):
                groups.setdefault(getattr(r, kind), []).append(str(r.case.case))
        lines += [f"case{'s' if len(n) > 1 else ''} {', '.join(n)} {start}{', '.join(g)}" for g, n in groups.items()]
    return lines


def laws(results: Sequence[CaseResult]) -> list[tuple[str, str]]:
    """Cases with the same laws, and these: `capillary rabinovich, …`."""
    groups: dict[str, list[str]] = {}
    for r in results:
        if r.plan:
            used = [
                f"{row['effect'].replace('_', ' ')}: {row['law'].rpartition('/')[2]}"
                for row in r.plan["rows"]
                if row["on"] and row.get("law")
            ]
            groups.setdefault(", ".join(used) or "dry contacts only", []).append(str(r.case.case))
    return [(f"case{'s' if len(cases) > 1 else ''} {', '.join(cases)}", text) for text, cases in groups.items()]


def _percent(shares: Sequence[float]) -> str:
    low, high = (f"{100 * share:.0f}" for share in (min(shares), max(shares)))
    return f"{low} %" if low == high else f"{low} to {high} %"
