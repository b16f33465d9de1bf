"""summary.json of a screening case: what every summary says, and the fraction retained, the liquid, what holds."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from pywet.files import write_json
from pywet.runs.rundir import RunDir
from pywet.runs.summary import general
from pywet.screening.results import Results, at_end, coarse_share


def summarise(run: RunDir, results: Results) -> dict[str, Any]:
    """The content of summary.json; times in seconds, volumes in m3, masses in kg."""
    return {
        **general(run),
        "fraction_retained_end": float(results.retained["fraction_retained"].iloc[-1]),
        "coarse_share": coarse_share(run.scene),
        "spheres_that_came_back_from_the_bin": run.timeline.came_back,
        "liquid_end_m3": at_end(results.liquid),
        "checks": [asdict(c) for c in results.checks],
    }


def write_summary(run: RunDir, results: Results) -> dict[str, Any]:
    """Write summary.json into the run directory and return its content."""
    content = summarise(run, results)
    write_json(run.path / "summary.json", content)
    return content
