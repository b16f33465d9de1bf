"""One case with two presets of laws, side by side for the report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pywet.report import plots
from pywet.report.collect import CaseResult
from pywet.runs.spread import difference, with_interval


def shown(usual: CaseResult, twin: CaseResult, preset: str) -> dict[str, Any]:
    """Return the template's data for a case as configured and for its run with another preset."""
    message = "; ".join(twin.problems)
    both = usual.summary is not None and twin.summary is not None
    return {
        "case": usual.case.case,
        "preset": preset,
        "said": f"The run with {preset} is not done: {message}" if message else "",
        "figure": plots.preset_curves(usual, twin, preset) if both else [],
        "rows": _numbers(usual, twin) if both else [],
        "apart": apart(usual.ends, twin.ends, preset) if both else "",
    }


ENOUGH = 4
"""Seeds of each preset below which no difference is told: the spread of three is hardly known."""


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
    low, high = difference(other, usual)
    message = f"{preset} − paper lies between {low:+.3f} and {high:+.3f} (95 %, {a} and {b} seeds)"
    if not (low > 0.0 or high < 0.0):
        return f"Whether the fraction retained differs cannot be told: {message}."
    return f"The fraction retained differs by more than seeds do: {message}."


def _spread(values: Sequence[float]) -> str:
    """Write the value of one seed, or the mean over seeds with its 95 % interval."""
    if len(values) < 2:
        return f"{values[0]:.3f}, one seed" if values else "–"
    return f"{with_interval(values)}, {len(values)} seeds"


def _numbers(usual: CaseResult, twin: CaseResult) -> list[dict[str, str]]:
    """Fraction retained, bridges and liquid at the end, and what the run took."""
    rows = [{"name": "fraction retained", "paper": _spread(usual.ends), "other": _spread(twin.ends)}]
    for name, keys in (
        ("bridges formed", ("events", "formations")),
        ("bridges ruptured", ("events", "ruptures")),
        ("wall time in s", ("wall_s",)),
    ):
        both = [r.over_seeds(*keys) for r in (usual, twin)]
        if "–" not in both:
            rows.append({"name": name, "paper": both[0], "other": both[1]})
    for column, (label, _) in plots.PLACES.items():
        held = [_held(r, column) for r in (usual, twin)]
        if all(held):
            rows.append({"name": f"liquid {label}", "paper": f"{held[0]} %", "other": f"{held[1]} %"})
    return rows


def _held(result: CaseResult, column: str) -> str:
    """Per cent of the liquid put in that a reservoir holds at the end, over seeds; empty where a run does not have it."""
    every = [s for s in (result.summary, *result.others) if s and s["initial_liquid_m3"]]
    if not every or column not in every[0]["liquid_end_m3"]:
        return ""
    shares = [100.0 * s["liquid_end_m3"].get(column, 0.0) / s["initial_liquid_m3"] for s in every]
    return with_interval(shares) if len(shares) > 1 else f"{shares[0]:.2f}"
