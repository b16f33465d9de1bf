"""The whole study from the command line; every part is kept, so that a study that was cut off goes on."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from pywet.study.stability import hard, report, sweep
from pywet.study.stability.maps import MAPS, one


def study(cases: int, seed: int, folder: Path, console: Console) -> Path:
    """Maps, hard scenes, cases, page; returns the page's path."""
    jobs = [(name, n) for name, chart in MAPS.items() for n in range(len(chart.y[1]))]
    total = len(jobs) + len(hard.SCENES) + sweep.batches(cases)
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task("maps", total=total)
        for name, n in jobs:
            one(name, n, folder)
            bar.advance(task)
        for name in hard.SCENES:
            bar.update(task, description="hard scenes")
            hard.one(name, folder)
            bar.advance(task)
        start = len(jobs) + len(hard.SCENES)
        sweep.run(
            cases,
            seed,
            folder,
            lambda done, of: bar.update(task, description=f"cases {done}/{of}", completed=start + done),
        )
    return report.write(folder, folder.with_suffix(".html"))
