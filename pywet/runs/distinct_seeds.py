"""Count each seed once: leave out runs that repeat the seed of another run of the same scene, or are of another scene."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.runs import record
from pywet.runs.rundir import RunDir
from pywet.scene import SCRIPTED
from pywet.util.notices import notice

CASE = ("case", "scale", "variant")
"""Keys of run.json in which stored tables of one scene agree."""


def distinct_seeds(folders: Iterable[Path]) -> list[Path]:
    """Return the runs or stored tables of the first one's scene whose seed no earlier one has; others are left out with a notice.

    A run of a script, whose seeds are unknown, is not left out.
    """
    first: dict[tuple[int, bytes], Path] = {}
    chosen: list[Path] = []
    for folder in folders:
        if chosen and not _alike(chosen[0], folder):
            not_counted(folder, chosen[0])
            continue
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


def _alike(one: Path, other: Path) -> bool:
    """Return whether two runs may differ only in the seed by their fingerprints, stored tables by their cases."""
    cases = [[_stored(folder).get(key) for key in CASE] for folder in (one, other)]
    return record.alike(one, other) and cases[0] == cases[1]


def _stored(folder: Path) -> dict[str, Any]:
    """Return run.json of a folder of stored tables; empty for a run."""
    return RunDir(folder).json("run.json", dict[str, Any]) or {}


def _start(run: RunDir) -> tuple[int, bytes] | None:
    """Return the seed and the digest of the initial spheres; those of `pywet scene` differ with the same seed in scene.json."""
    scene = run.json("scene.json", dict[str, Any]) or _stored(run.path)
    if scene.get("seed") is None or scene.get("name") == SCRIPTED:
        return None
    table = run.table_if_there("spheres")
    return scene["seed"], b"" if table is None else pd.util.hash_pandas_object(table, index=False).to_numpy().tobytes()
