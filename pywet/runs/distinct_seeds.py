"""Count each seed once: leave out runs that repeat the seed of another run of the same scene, or are of another scene."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.runs.rundir import RunDir
from pywet.scene import SCRIPTED
from pywet.util.notices import notice


def distinct_seeds(folders: Iterable[Path]) -> list[Path]:
    """Return the runs of one scene whose seed no earlier one has; the others are left out with a notice.

    A folder without scene.json, such as one of stored tables, is not left out, nor is a run of a script, whose seeds are unknown.
    """
    first: dict[tuple[int, bytes], Path] = {}
    chosen = []
    for folder in folders:
        start = _start(RunDir(folder))
        if start and start in first:
            notice.warning(
                f"{folder} has seed {start[0]}, as {first[start]}; each seed is counted once: it is left out"
            )
            continue
        if start:
            first[start] = folder
        chosen.append(folder)
    return chosen


def not_counted(run: Path, first: Path) -> None:
    """Print the notice that a run next to another one is not a seed of it."""
    notice.warning(
        f"{run} was run with another configuration, file or version of pywet than {first}; it is not counted as a seed of it"
    )


def _start(run: RunDir) -> tuple[int, bytes] | None:
    """Return the seed and the digest of the initial spheres; those of `pywet scene` differ with the same seed in scene.json."""
    scene = run.json("scene.json", dict[str, Any]) or {}
    if scene.get("seed") is None or scene.get("name") == SCRIPTED:
        return None
    table = run.table_if_there("spheres")
    return scene["seed"], b"" if table is None else pd.util.hash_pandas_object(table, index=False).to_numpy().tobytes()
