"""One case with two presets of laws, side by side for the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pywet.report import page, plots
from pywet.report.collect import CaseResult


@dataclass(frozen=True)
class Pair:
    """The case as configured, its twin, and the twin's preset."""

    usual: CaseResult
    twin: CaseResult
    preset: str


def shown(pairs: Sequence[Pair]) -> list[dict[str, Any]]:
    """What the template shows of each pair."""
    return [_shown(pair) for pair in pairs]


def _shown(pair: Pair) -> dict[str, Any]:
    said = "; ".join(pair.twin.problems)
    both = pair.usual.summary is not None and pair.twin.summary is not None
    figure = plots.preset_curves(pair.usual, pair.twin, pair.preset) if both else ""
    return {
        "case": pair.usual.case.case,
        "preset": pair.preset,
        "said": f"The run with {pair.preset} is not done: {said}" if said else "",
        "figure": page.uri(figure.encode(), "svg") if figure else "",
        "rows": [*_numbers(pair)] if both else [],
    }


def _numbers(pair: Pair) -> list[dict[str, str]]:
    """Fraction retained, bridges and liquid at the end, and what the run took."""
    rows = []
    a, b = ({**(r.summary or {}), **((r.summary or {}).get("events") or {})} for r in (pair.usual, pair.twin))
    for name, key, form in (
        ("fraction retained", "fraction_retained_end", "{:.3f}"),
        ("bridges formed", "formations", "{:.0f}"),
        ("bridges ruptured", "ruptures", "{:.0f}"),
        ("wall time in s", "wall_s", "{:.1f}"),
    ):
        if key in a and key in b:
            rows.append({"name": name, "paper": form.format(a[key]), "other": form.format(b[key])})
    one, two = pair.usual.liquid, pair.twin.liquid
    if one is not None and two is not None:
        for column, (label, _) in plots.PLACES.items():
            if f"{column}_m3" in one:
                ends = [f"{100 * t[f'{column}_m3'].iloc[-1] / t['initial_m3'].iloc[-1]:.2f} %" for t in (one, two)]
                rows.append({"name": f"liquid {label}", "paper": ends[0], "other": ends[1]})
    return rows
