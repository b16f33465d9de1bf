"""Predicted against measured time of runs that were made, a ratio for each: what `pywet plan CASE --accuracy` says of the time.

python benchmarks/predicted_times.py [SCALE [FOLDER [CONFIG]]]

FOLDER (results/SCALE) holds run directories caseNN or caseNN-SEED, CONFIG (config) is the configuration they were made with.
"""

from __future__ import annotations

import sys
from pathlib import Path

from pywet import config as settings
from pywet.cost import choice, command, cost
from pywet.util.files import read_json

ALLOWED = 1.3
"""A prediction is to be within this factor."""


def main(scale: str = "smoke", folder: str = "", folder_of_config: str = "config") -> None:
    """Print a line for each run, measured on this machine."""
    config = settings.load(Path(folder_of_config))
    machine, habit = command.calibrated(), command.habit(choice.for_scale(scale)[0])
    ratios = []
    print("run  predicted [s]  processor time [s]  wall time [s]  predicted/processor  predicted/wall")
    for path in sorted(Path(folder or f"results/{scale}").glob("case[0-9][0-9]*/engine/run.json")):
        run, name = read_json(path), path.parents[1].name
        seconds, _ = cost.predict(config, int(name[4:6]), scale, machine, habit)
        ratios.append(seconds / run["cpu_s"])
        print(
            f"{name}  {seconds:13.1f}  {run['cpu_s']:18.1f}  {run['wall_s']:13.1f}  {ratios[-1]:19.2f}"
            f"  {seconds / run['wall_s']:14.2f}"
        )
    inside = sum(1.0 / ALLOWED <= r <= ALLOWED for r in ratios)
    print(f"{inside} of {len(ratios)} within a factor of {ALLOWED} of the processor time")


if __name__ == "__main__":
    main(*sys.argv[1:])
