"""Runs of one user-defined scene with several seeds, in neighbouring folders, and their results as mean and interval."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pywet.cases.screening import verdict
from pywet.products.feed import LEFT_OUT
from pywet.runs import record
from pywet.runs.distinct_seeds import distinct_seeds
from pywet.runs.loaded import Run
from pywet.runs.rundir import RunDir
from pywet.runs.spread import with_interval

Runs = Sequence[Run]


def of_scene(folder: Path) -> list[Run]:
    """List the run and the finished runs in folders FOLDER-SEED that differ only in the seed, each seed once.

    Their descriptions differ in nothing else; those for which a file or pywet has changed are left out with a notice.
    """
    folder = folder.resolve() if folder.name in ("", "..") else folder
    return [Run(p) for p in distinct_seeds([folder, *(p for p in _others(folder) if _finished(p))])]


def _others(folder: Path) -> list[Path]:
    """List the folders FOLDER-SEED with the description of a run but for the seed, by seed."""
    description = but_seed(folder)
    found = (p for p in folder.parent.glob(f"{folder.name}-*") if p.name.removeprefix(f"{folder.name}-").isdigit())
    others = [p for p in found if description and but_seed(p) == description]
    return sorted(others, key=lambda p: int(p.name.rpartition("-")[2]))


def _finished(folder: Path) -> bool:
    return (folder / "summary.json").exists()


def but_seed(folder: Path) -> dict[str, Any]:
    """Return the description of a run without its seed, its location and what follows from it; empty without a description."""
    less = ("seed", "file", "folder", LEFT_OUT)
    return {key: value for key, value in RunDir(folder).description.items() if key not in less}


def over(values: Sequence[float], digits: int = 4) -> str:
    """Format a number of all runs as mean ± half width of its 95 % interval, or as it is if all runs agree.

    >>> over([3.0, 3.0]), over([2.0, 3.0, 4.0])
    ('3', '3.0 ± 2.5')
    """
    return with_interval(values[:1] if len(set(values)) == 1 else values, digits)


def worst(runs: Runs) -> verdict.CheckResult:
    """Return the worst status of the runs with the name of that run, and a note on how the numbers are combined.

    A further seed without results counts as one that fails: runs that end early are no random sample.
    """
    found = [(verdict.check_result(RunDir(run.path)), run.path.name) for run in runs]
    first = runs[0].path
    if missing := [p.name for p in _others(first) if not _finished(p) and record.alike(first, p)]:
        ended = verdict.CheckResult("no", "bad", "not run to the end, there is no summary.json.")
        found.insert(0, (ended, ", ".join(missing)))
    lowest, name = min(found, key=lambda entry: verdict.ORDER.index(entry[0].word))
    if len(found) == 1:
        return lowest
    names = ", ".join(run.path.name for run in runs)
    several = (
        f"{len(runs)} seeds ({names}): numbers are their mean ± 95 % confidence interval of the mean, curves their mean with "
        "that interval as a band; the picture is of the first. "
    )
    return verdict.CheckResult(
        lowest.word, lowest.grade, f"{several if len(runs) > 1 else ''}{name}: {lowest.sentence}"
    )


def agreement(runs: Runs) -> list[verdict.Agreement]:
    """Combine the replays: all values of every quantity, and the row of the run with the largest deviation."""
    rows: dict[str, list[verdict.Agreement]] = {}
    for run in runs:
        for row in verdict.agreement(run.replay) if run.replay else []:
            rows.setdefault(row.quantity, []).append(row)
    largest = (max(of, key=lambda row: row.largest / row.limit if row.limit else row.largest) for of in rows.values())
    return [replace(row, count=sum(r.count for r in rows[row.quantity])) for row in largest]


def lines_of(runs: Runs, sentences: Callable[[Run], Sequence[str]]) -> list[str]:
    """Collect the sentences of all runs, each once, with the names of its runs if they differ."""
    found: dict[str, list[str]] = {}
    for run in runs:
        for sentence in sentences(run):
            found.setdefault(sentence, []).append(run.path.name)
    return [s if len(of) == len(runs) else f"{', '.join(of)}: {s}" for s, of in found.items()]
