"""Predicted against measured time of cases that were run, a ratio for each: what `pywet plan CASE --accuracy` says of the time.

python benchmarks/predicted_times.py [SCALE [RESULTS]]
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from pywet import config as settings
from pywet.study.accuracy import choice, command, cost

ALLOWED = 1.5
"""A prediction is to be within this factor."""


def main(scale: str = "smoke", results: str = "results") -> None:
    """Print a line for each case whose run is in RESULTS/SCALE, measured on this machine."""
    config = settings.load(Path("config"))
    machine, habit = command.calibrated(config.folder), command.habit(choice.for_scale(scale)[0])
    ratios = []
    print("case  predicted [s]  processor time [s]  wall time [s]  predicted/processor  predicted/wall")
    for number in sorted(config.cases):
        path = Path(results) / scale / f"case{number:02d}" / "engine" / "run.json"
        if not path.exists():
            continue
        run = json.loads(path.read_text())
        seconds, _ = cost.predict(config, number, scale, machine, habit)
        ratios.append(seconds / run["cpu_s"])
        print(
            f"{number:4d}  {seconds:13.1f}  {run['cpu_s']:18.1f}  {run['wall_s']:13.1f}  {ratios[-1]:19.2f}"
            f"  {seconds / run['wall_s']:14.2f}"
        )
    inside = sum(1.0 / ALLOWED <= r <= ALLOWED for r in ratios)
    print(f"{inside} of {len(ratios)} within a factor of {ALLOWED} of the processor time")


if __name__ == "__main__":
    main(*sys.argv[1:])
