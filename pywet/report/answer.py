"""The first screen of the report: what passes, how moisture changes it, and whether it was recomputed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter
from statistics import mean

from pywet.cases.screening.verdict import LEDGER_TOLERANCE
from pywet.report.bridge import short
from pywet.report.collect import CaseResult, grouped, named
from pywet.report.plots import title
from pywet.runs.spread import difference, with_interval


@dataclass(frozen=True)
class Passed:
    """Result of one screening case at its end."""

    case: int
    liquid_percent: float
    coarse: float
    """Mass share of the classes that cannot pass."""
    ends: tuple[float, ...]
    """Fraction retained at the end of every seed."""

    @property
    def retained(self) -> str:
        """Fraction retained at the end, of several seeds with the interval of their mean and their number."""
        return with_interval(self.ends) + (f" ({len(self.ends)} seeds)" if len(self.ends) > 1 else "")

    @property
    def passed(self) -> str:
        """Per cent of the mass of the classes that can pass, liquid included, which has passed."""
        shares = [100.0 * (1.0 - end) / (1.0 - self.coarse) for end in self.ends]
        return with_interval(shares) if len(shares) > 1 else f"{shares[0]:.0f}"

    @property
    def name(self) -> str:
        """Name of the case by its liquid, such as "5 % liquid" or "dry"."""
        return f"{self.liquid_percent:g} % liquid" if self.liquid_percent else "dry"


@dataclass(frozen=True)
class Row:
    """Cases that differ only in moisture, the driest first."""

    title: str
    seconds: float
    coarse: float
    cases: tuple[Passed, ...]

    @property
    def significance(self) -> str:
        """Whether the driest and the moistest case differ beyond the spread of their seeds (Welch); empty of one case."""
        if len(self.cases) < 2:
            return ""
        one, two = self.cases[0], self.cases[-1]
        if min(len(one.ends), len(two.ends)) < 2:
            return f"{two.name} against {one.name}: inconclusive, two seeds of each are needed (--seeds)"
        low, high = difference(two.ends, one.ends)
        verdict = "significant" if low > 0.0 or high < 0.0 else "not significant"
        return f"{two.name} against {one.name}: {verdict}, difference from {low:+.3f} to {high:+.3f} (95 %)"


def rows(results: Sequence[CaseResult]) -> list[Row]:
    """One row per configuration of which a case has results."""
    there = (r for r in results if r.summary is not None and r.retained is not None)
    groups = grouped(there, attrgetter("configuration")).values()
    return [_row(sorted(group, key=lambda r: r.case.liquid_percent)) for group in groups]


def _row(group: Sequence[CaseResult]) -> Row:
    found = []
    for r in group:
        assert r.summary is not None
        found.append(Passed(r.case.case, r.case.liquid_percent, r.summary["coarse_share"], tuple(r.ends)))
    first = group[0]
    assert first.summary is not None and first.retained is not None
    seconds = float(first.retained["time_since_opening_s"].iloc[-1])
    return Row(title(first), seconds, first.summary["coarse_share"], tuple(found))


def sentence(table: Sequence[Row]) -> str:
    """State which share of the feed passes and how moisture changes it."""
    if not table:
        return "No case has results yet."
    shares: dict[str, list[Passed]] = {}
    for case in sorted((c for row in table for c in row.cases), key=lambda c: c.liquid_percent):
        moist = "moist" if len(table) > 1 else f"with {case.name}"
        shares.setdefault(moist if case.liquid_percent else case.name, []).append(case)
    parts = ", ".join(f"{_range(cases)} {name}" for name, cases in shares.items())
    text = f"Of the mass that can pass, this has passed {table[0].seconds:.2g} s after the slide opened: {parts}."
    compared = [row.significance for row in table if row.significance]
    if len(table) == 1:
        return " ".join([text, *(f"{message}." for message in compared)])
    clear = sum(": significant" in message for message in compared)
    return (
        f"{text} Moisture makes a significant difference in {clear} of {len(compared)} comparisons."
        if compared
        else text
    )


def proof(results: Sequence[CaseResult]) -> tuple[str, bool]:
    """What was recomputed and whether it agrees, in one line; and whether all of it does."""
    moist, replayed = [r for r in results if r.bridged], [r for r in results if r.agreement]
    if bad := [r for r in moist if not r.cross_checked]:
        wrong, missing = [r for r in bad if r.agreement], [r for r in bad if not r.agreement]
        message = [f"The independent reference disagrees: {named(wrong)}."] if wrong else []
        return " ".join([*message, *([f"Not cross-checked: {named(missing)}."] if missing else [])]), False
    if not moist:
        return "Nothing moist to cross-check.", all(row.ok for r in replayed for row in r.agreement)
    ledger = [error for r in moist if (error := r.ledger_error) is not None]
    whole = "; no liquid is lost" if ledger and max(ledger) <= LEDGER_TOLERANCE else ""
    names = {row.quantity for r in replayed for row in r.agreement}
    start = "Bookkeeping and forces recomputed" + (" in part" if any(r.nothing for r in results) else "")
    if any(r.unchecked for r in moist):
        start += " but for laws that the reference does not know: of the rest,"
    else:
        start += ":"
    agrees = f"an independent reference recomputed every moist case and agrees on all {len(names)} quantities{whole}"
    return f"{start} {agrees}.", True


def unchecked(results: Sequence[CaseResult]) -> list[str]:
    """A line for cases of which the same was not compared, not checked, or checked by the user's own reference."""
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


def laws(results: Sequence[CaseResult]) -> list[tuple[str, str]]:
    """Cases with the same laws, and these: `capillary rabinovich, …`."""
    return [(named(cases), used) for used, cases in grouped((r for r in results if r.plan), _used).items()]


def _used(result: CaseResult) -> str:
    rows = result.plan["rows"] if result.plan else []
    laws = [f"{row['effect'].replace('_', ' ')}: {short(row['law'])}" for row in rows if row["on"] and row.get("law")]
    return ", ".join(laws) or "dry contacts only"


def _range(cases: Sequence[Passed]) -> str:
    """Per cent that has passed, from the least to the most of several cases."""
    least, most = (way(cases, key=lambda c: -mean(c.ends)).passed for way in (min, max))
    return f"{least} %" if least == most else f"{least} to {most} %"
