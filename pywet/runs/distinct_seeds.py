"""Count each seed once: leave out runs that repeat the seed of another run of the same scene, or are of another scene."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pywet.runs.rundir import RunDir
from pywet.util.notices import notice


def distinct_seeds(folders: Iterable[Path]) -> list[Path]:
    """Return the runs of one scene whose seed no earlier one has; the others are left out with a notice.

    A folder without scene.json, such as one of stored tables, is not left out.
    """
    first: dict[int, Path] = {}
    chosen = []
    for folder in folders:
        seed = (RunDir(folder).json("scene.json", dict[str, Any]) or {}).get("seed")
        if seed in first:
            notice.warning(f"{folder} has seed {seed}, as {first[seed]}; each seed is counted once: it is left out")
            continue
        if seed is not None:
            first[seed] = folder
        chosen.append(folder)
    return chosen


def not_counted(run: Path, first: Path) -> None:
    """Print the notice that a run next to another one is not a seed of it."""
    notice.warning(
        f"{run} was run with another configuration, file or version of pywet than {first}; it is not counted as a seed of it"
    )
