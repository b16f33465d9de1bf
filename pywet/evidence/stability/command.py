"""The whole study from the command line; every part is kept, so that a study that was cut off goes on."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import track

from pywet.evidence.stability import hard, maps, report, sweep
from pywet.evidence.stability.campaign import PER_BATCH


def study(cases: int, seed: int, folder: Path, console: Console) -> Path:
    """Maps, hard scenes, cases, page; returns the page's path."""
    batches = [
        partial(sweep.batch_of_cases, seed, n, folder, min(PER_BATCH, cases - n * PER_BATCH))
        for n in range(sweep.batches(cases))
    ]
    jobs = [partial(maps.map_row, name, n, folder) for name, chart in maps.MAPS.items() for n in range(len(chart.y[1]))]
    jobs += [partial(hard.hard_scene, name, folder) for name in hard.SCENES]
    made = [job() for job in track([*jobs, *batches], "maps, hard scenes, cases", console=console, transient=True)]
    sweep.collect(made[len(jobs) :], folder / "cases.csv")
    return report.write_page(folder, folder.with_suffix(".html"))
