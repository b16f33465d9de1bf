"""One case with two presets of laws, side by side for the report."""

from __future__ import annotations

from typing import Any

from pywet.report import plots
from pywet.report.collect import CaseResult
from pywet.report.report_numbers import PRESETS, Numbers, significance


def shown(usual: CaseResult, comparison: CaseResult, preset: str, numbers: Numbers) -> dict[str, Any]:
    """Return the template's data for a case as configured and for its run with another preset."""
    message = "; ".join(comparison.problems)
    both = usual.summary is not None and comparison.summary is not None
    return {
        "case": usual.case.name,
        "preset": preset,
        "problem": f"The run with {preset} is not done: {message}" if message else "",
        "figure": plots.preset_curves(usual, comparison, preset) if both else [],
        "rows": _numbers(usual, comparison, preset, numbers) if both else [],
    }


def _numbers(usual: CaseResult, comparison: CaseResult, preset: str, numbers: Numbers) -> list[str]:
    """Store fraction retained, bridges and liquid at the end, and the cost of the run; return the rows that both runs have."""
    key = f"presets.{usual.case.name}"
    numbers.put(f"{key}.case", usual.case.case)
    found = {"paper": _values(usual), preset: _values(comparison)}
    for name, values in found.items():
        numbers.label(f"{key}.{name}", name, name)
        numbers.put(f"{key}.{name}.fraction_retained.seeds", len(values["fraction_retained"]))
    significance(numbers, f"{key}.difference", usual.ends, comparison.ends)
    rows = [row for row in PRESETS if all(of.get(row) for of in found.values())]
    for row in rows:
        numbers.label(f"presets.{row}", PRESETS[row], row)
        form = {"fraction_retained": ".3f", "liquid_percent": ".2f"}.get(row.partition(".")[0], "")
        for name, values in found.items():
            numbers.spread(f"{key}.{name}.{row}", values[row], form=form)
    return rows


def _values(result: CaseResult) -> dict[str, list[float]]:
    """Return the rows of one run for every seed; liquid in per cent of the initial liquid."""
    rows = {name: result.over_seeds("events", name) for name in ("formations", "ruptures")}
    put_in = result.over_seeds("initial_liquid_m3")
    held = {name: result.over_seeds("liquid_end_m3", name, factor=100.0) for name in plots.PLACES}
    shares = {f"liquid_percent.{n}": [h / i for h, i in zip(v, put_in, strict=False) if i] for n, v in held.items()}
    return {"fraction_retained": result.ends, **rows, "wall_s": result.wall_s, **shares}
