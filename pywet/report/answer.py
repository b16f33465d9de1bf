"""The first screen of the report: what passes, how moisture changes it, and whether it is proven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter
from statistics import mean, stdev

from scipy import stats

from pywet.report import presets
from pywet.report.bridge import short
from pywet.report.collect import CaseResult, grouped, named
from pywet.report.plots import title
from pywet.screening.verdict import LEDGER_TOLERANCE


@dataclass(frozen=True)
class Passed:
    """One case at its end."""

    case: int
    liquid_percent: float
    retained: float
    """Of several seeds their mean."""
    of_what_can: float
    """Part of the mass of the classes that can pass, liquid included, which has passed."""
    ends: tuple[float, ...]
    """Fraction retained at the end of every seed."""

    @property
    def interval(self) -> str:
        """Half width of the 95 % confidence interval of the mean (Student), and the number of seeds."""
        if len(self.ends) < 2:
            return ""
        half = stats.t.ppf(0.975, len(self.ends) - 1) * stdev(self.ends) / len(self.ends) ** 0.5
        return f" ± {half:.2g} ({len(self.ends)} seeds)"

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

    @property
    def significance(self) -> str:
        """Whether the driest and the moistest case differ beyond the spread of their seeds (Welch); empty of one case."""
        if len(self.cases) < 2:
            return ""
        one, two = self.cases[0], self.cases[-1]
        if min(len(one.ends), len(two.ends)) < 2:
            return f"{two.name} against {one.name}: inconclusive, two seeds of each are needed (--seeds)"
        interval = stats.ttest_ind(two.ends, one.ends, equal_var=False).confidence_interval(0.95)
        low, high = float(interval.low), float(interval.high)
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
        ends = (r.summary["fraction_retained_end"], *presets.ends(r)[1:])
        end, coarse = mean(ends), r.summary["coarse_share"]
        found.append(Passed(r.case.case, r.case.liquid_percent, end, (1.0 - end) / (1.0 - coarse), ends))
    first = group[0]
    assert first.summary is not None and first.retained is not None
    seconds = float(first.retained["time_since_opening_s"].iloc[-1])
    return Row(title(first), seconds, first.summary["coarse_share"], tuple(found))


def sentence(table: Sequence[Row]) -> str:
    """What passes and how moisture changes it."""
    if not table:
        return "No case has results yet."
    shares: dict[str, list[float]] = {}
    for case in sorted((c for row in table for c in row.cases), key=lambda c: c.liquid_percent):
        moist = "moist" if len(table) > 1 else f"with {case.name}"
        shares.setdefault(moist if case.liquid_percent else case.name, []).append(case.of_what_can)
    parts = ", ".join(f"{_percent(of)} {name}" for name, of in shares.items())
    return f"Of the mass that can pass, this has passed {table[0].seconds:.2g} s after the slide opened: {parts}."


def proof(results: Sequence[CaseResult]) -> tuple[str, bool]:
    """Whether it is proven, in one line; and whether it is."""
    moist, replayed = [r for r in results if r.bridged], [r for r in results if r.agreement]
    if bad := [r for r in moist if not r.cross_checked]:
        return f"Not cross-checked: {named(bad)}.", False
    if not moist:
        return "Nothing moist to cross-check.", all(row.ok for r in replayed for row in r.agreement)
    ledger = [r.summary["ledger_error"] for r in moist if r.summary and r.summary["ledger_error"] is not None]
    whole = "; no liquid is lost" if ledger and max(ledger) <= LEDGER_TOLERANCE else ""
    names = {row.quantity for r in replayed for row in r.agreement}
    agrees = f"an independent reference recomputed every moist case and agrees on all {len(names)} quantities{whole}"
    if any(r.unchecked for r in moist):
        return (
            f"Bookkeeping and forces recomputed but for laws that the reference does not know: of the rest, {agrees}.",
            True,
        )
    return f"Bookkeeping and forces recomputed: {agrees}.", True


def unchecked(results: Sequence[CaseResult]) -> list[str]:
    """A line for cases with the same laws that were not checked, and for those with the same second functions."""
    return [
        f"{named(cases)} {start}: {', '.join(laws)}"
        for start, kind in (("not checked", "unchecked"), ("held against a second function of the user's", "second"))
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


def _percent(shares: Sequence[float]) -> str:
    low, high = (f"{100 * share:.0f}" for share in (min(shares), max(shares)))
    return f"{low} %" if low == high else f"{low} to {high} %"
