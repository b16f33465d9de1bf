"""The commands in groups, each with an example: what `pywet --help` and `pywet COMMAND --help` show."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import typer

GROUPS = {
    "Start": {
        "init": "init mydrum --example drum",
        "doctor": "doctor",
        "docs": "docs own-scene",
    },
    "Process: screening cases": {
        "plan": "plan 2 --why",
        "run": "run 2 --seeds 3",
        "timestep": "timestep results/smoke/case02",
    },
    "Process: scenes and calibration": {
        "run-scene": "run-scene examples/scenes/hopper.yaml --out hopper",
        "scene": "scene drum --moisture 1 --spheres 400 --seconds 1.5",
        "liggghts": "liggghts -in in.drum --check",
        "lammps": "lammps -in in.packing",
        "calibrate": "calibrate examples/calibrations/drum.yaml",
        "sweep": "sweep examples/sweeps/small_drum.yaml --cores 2",
    },
    "Results": {
        "report": "report results/smoke/case02",
        "screen": "screen results/smoke/case02",
        "kinetics": "kinetics docs/full_scale/data/case02-10007",
        "view": "view results/smoke/case02 --movie",
        "app": "app results/smoke/case01 results/smoke/case02",
        "plot": "plot results/smoke/case02* --out fig.pdf",
        "compare": "compare results/smoke/case01 results/smoke/case02 --force",
        "digest": "digest results/smoke/case02 --out case02.json",
    },
    "Laws and single bodies": {
        "laws": "laws --check willett",
        "bridge": "bridge examples/bridge.json --table",
        "collide": "collide wall examples/wall_wet.json",
    },
    "Cross-checks": {
        "replay": "replay results/smoke/case02",
        "score": "score viscous_pull my_answers.csv",
        "study": "study stability --cases 20",
    },
}
"""Example command line of each command, by group."""


def arrange(*apps: typer.Typer) -> None:
    """Assign each command of the apps to its group, with an example below its help."""
    for info in _commands(apps):
        name = info.name or info.callback.__name__.replace("_", "-")
        group = next(g for g, members in GROUPS.items() if name in members)
        info.rich_help_panel = group
        if "Example:" not in (getattr(info.callback, "__doc__", None) or ""):
            info.epilog = f"Example: pywet {GROUPS[group][name]}"


def _commands(apps: tuple[typer.Typer, ...]) -> Iterator[Any]:
    for app in apps:
        yield from app.registered_commands
        yield from (group for group in app.registered_groups if group.name)
