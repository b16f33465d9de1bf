"""The time up to which runs with `until` are compared: such runs of one scene end after different numbers of blocks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from pywet.products.until import Until, fewest
from pywet.runs.rundir import RunDir


@dataclass(frozen=True)
class Beginning(RunDir):
    """The beginning of a run: its tables end at a time [s], and it has no summary."""

    end_s: float

    def table_if_there(self, name: str) -> pd.DataFrame | None:
        """Return the rows of `table` up to the end; None without such a file."""
        table = super().table_if_there(name)
        if table is None:
            return None
        return table[table["time_s" if "time_s" in table else "time"] < self.end_s + 0.5 * self.scene.time_step_s]

    @property
    def summary(self) -> None:
        """Return None, since a summary is of the whole run."""
        return None


def of_runs(folders: Iterable[Path]) -> float | None:
    """Return the end [s] of the shortest run if any has `until`; None if all durations are given."""
    scenes = [RunDir(Path(folder)).scene for folder in folders]
    return min(scene.duration_s for scene in scenes) if any(scene.blocks for scene in scenes) else None


def of_scene(folder: Path) -> float | None:
    """Return the time [s] that every run of a scene with `until` reaches; None if the duration is given."""
    run = RunDir(Path(folder))
    if not run.scene.blocks:
        return None
    until = run.description.get("until")
    return run.scene.block_s * (fewest(Until.model_validate(until), run.scene.block_s) if until else 1)


def beginning(run: RunDir, end_s: float | None) -> RunDir:
    """Return the run, or its beginning if it goes on after a time [s]."""
    if end_s is None or end_s > run.scene.duration_s - 0.5 * run.scene.time_step_s:
        return run
    return Beginning(run.path, end_s)
