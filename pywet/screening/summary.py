"""summary.json of a run: what was run, with which versions, how fast, and what holds."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from pywet.files import write_json
from pywet.runs.rundir import RunDir
from pywet.runs.summary import general
from pywet.screening import results


def summarise(run: RunDir) -> dict[str, Any]:
    """The content of summary.json."""
    retained, liquid = results.fraction_retained(run), results.liquid_by_holder(run)
    return {
        **general(run),
        "fraction_retained_end": float(retained["fraction_retained"].iloc[-1]),
        "coarse_share": results.coarse_share(run.scene),
        "spheres_that_came_back_from_the_bin": run.timeline.came_back,
        "liquid_end_m3": results.at_end(liquid),
        "checks": [asdict(c) for c in results.checks(run, retained, liquid)],
    }


def write(run_dir: Path) -> dict[str, Any]:
    """Write summary.json into the run directory and return its content."""
    run = RunDir(Path(run_dir))
    content = summarise(run)
    write_json(run.path / "summary.json", content)
    return content
