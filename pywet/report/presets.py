"""One case with two presets of laws, side by side for the report."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import mean, stdev
from typing import Any

from scipy import stats

from pywet.report import plots
from pywet.report.collect import CaseResult


def shown(usual: CaseResult, twin: CaseResult, preset: str) -> dict[str, Any]:
    """What the template shows of a case as configured and its twin, of another preset."""
    said = "; ".join(twin.problems)
    both = usual.summary is not None and twin.summary is not None
    return {
        "case": usual.case.case,
        "preset": preset,
        "said": f"The run with {preset} is not done: {said}" if said else "",
        "figure": plots.preset_curves(usual, twin, preset) if both else [],
        "rows": _numbers(usual, twin) if both else [],
        "apart": apart(ends(usual), ends(twin), preset) if both else "",
    }


ENOUGH = 4
"""Seeds of each preset below which no difference is told: the spread of three is hardly known."""


def ends(result: CaseResult) -> list[float]:
    """Fraction retained at the end, of every seed of a case."""
    tables = [result.retained, *result.seeds]
    return [float(table["fraction_retained"].iloc[-1]) for table in tables if table is not None and len(table)]


def apart(usual: Sequence[float], other: Sequence[float], preset: str) -> str:
    """Whether the presets' fractions retained differ by more than seeds do: Welch's interval of the difference, or that it
    cannot be told.

    >>> apart([0.654], [0.672], "exact")
    'Whether the fraction retained differs cannot be told: 1 seed of paper and 1 of exact; 4 of each are needed.'
    """
    a, b = len(usual), len(other)
    if min(a, b) < ENOUGH:
        return (
            f"Whether the fraction retained differs cannot be told: {a} seed{'s' if a > 1 else ''} of paper and {b} of {preset}; "
            f"{ENOUGH} of each are needed."
        )
    interval = stats.ttest_ind(other, usual, equal_var=False).confidence_interval(0.95)
    low, high = float(interval.low), float(interval.high)
    said = f"{preset} − paper lies between {low:+.3f} and {high:+.3f} (95 %, {a} and {b} seeds)"
    if not (low > 0.0 or high < 0.0):
        return f"Whether the fraction retained differs cannot be told: {said}."
    return f"The fraction retained differs by more than seeds do: {said}."


def _spread(values: Sequence[float]) -> str:
    """Of one seed, or mean and standard deviation over seeds."""
    if len(values) < 2:
        return f"{values[0]:.3f}, one seed" if values else "–"
    return f"{mean(values):.3f} ± {stdev(values):.3f}, {len(values)} seeds"


def _numbers(usual: CaseResult, twin: CaseResult) -> list[dict[str, str]]:
    """Fraction retained, bridges and liquid at the end, and what the run took."""
    rows = [{"name": "fraction retained", "paper": _spread(ends(usual)), "other": _spread(ends(twin))}]
    a, b = ({**(r.summary or {}), **((r.summary or {}).get("events") or {})} for r in (usual, twin))
    for name, key, form in (
        ("bridges formed", "formations", "{:.0f}"),
        ("bridges ruptured", "ruptures", "{:.0f}"),
        ("wall time in s", "wall_s", "{:.1f}"),
    ):
        if key in a and key in b:
            rows.append({"name": name, "paper": form.format(a[key]), "other": form.format(b[key])})
    one, two = usual.liquid, twin.liquid
    if one is not None and two is not None:
        for column, (label, _) in plots.PLACES.items():
            if f"{column}_m3" in one:
                held = [f"{100 * t[f'{column}_m3'].iloc[-1] / t['initial_m3'].iloc[-1]:.2f} %" for t in (one, two)]
                rows.append({"name": f"liquid {label}", "paper": held[0], "other": held[1]})
    return rows
