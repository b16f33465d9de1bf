"""The stability study: rows of the maps, stress tests, batches of random cases; each is one job of one run."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from pywet import run_folder
from pywet.util.files import write_csv
from studies import study
from studies.stability import hard_scenes, random_cases, running
from studies.stability.maps import MAPS, row_of
from studies.stability.random_cases import PER_BATCH

FINE = ("stable", "law")
"""States of a case without objection."""


@dataclass(frozen=True)
class StabilityStudy(study.Study):
    """Study of all maps and stress tests, and of a number of random cases of a seed."""

    folder: Path
    cases: int = 2000
    seed: int = 1

    @property
    def map_rows(self) -> dict[str, list[str]]:
        return {name: [f"maps/{name}-{n:02d}" for n in range(len(chart.y[1]))] for name, chart in MAPS.items()}

    @property
    def scenes(self) -> list[str]:
        return [f"hard/{name}" for name in hard_scenes.SCENES]

    @property
    def batches(self) -> list[str]:
        return [f"batches/{self.seed}-{n:03d}" for n in range(-(-self.cases // PER_BATCH))]

    def jobs(self) -> list[str]:
        return [*(job for jobs in self.map_rows.values() for job in jobs), *self.scenes, *self.batches]

    def runs(self, job: str) -> list[study.Run]:
        part, _, name = job.partition("/")
        chart, _, number = name.rpartition("-")
        make: Callable[[Path], pd.DataFrame]
        given: dict[str, Any] = {part: name}
        if part == "maps":
            given |= {"x": MAPS[chart].x[1].tolist(), "y": float(MAPS[chart].y[1][int(number)])}
            make = lambda work: row_of(MAPS[chart], int(number), work)  # noqa: E731
        elif part == "hard":
            make = lambda work: hard_scenes.judged(name, work)  # noqa: E731
        else:
            count = given["count"] = min(PER_BATCH, self.cases - int(number) * PER_BATCH)
            make = lambda work: running.judged(random_cases.draw_batch(self.seed, int(number), count), work)  # noqa: E731
        return [study.Run(job, given, lambda: self._rows(make, self.folder / "work" / job))]

    def _rows(self, make: Callable[[Path], pd.DataFrame], work: Path) -> list[study.Row]:
        """Return the rows of a job; its runs remain in the folder `work` if they need inspection."""
        started = time.monotonic()
        table = make(work)
        run_folder.discard(work.with_name(f"{work.name}-passive"))
        if "case" not in table or table["state"].isin(FINE).all():
            run_folder.discard(work)
        table["wall_s"] = (time.monotonic() - started) / len(table)
        return table.to_dict("records")  # type: ignore[return-value]

    def show(self) -> Path:
        """Write a table of each map, of the stress tests and of the cases, and the page."""
        from studies.stability import page

        maps = {name: self.gather(jobs) for name, jobs in self.map_rows.items()}
        scenes, cases = self.gather(self.scenes), self.gather(self.batches)
        for name, table in {**{f"map_{n}": m for n, m in maps.items()}, "hard_scenes": scenes, "cases": cases}.items():
            write_csv(table.drop(columns="run"), self.folder / f"{name}.csv")
        return page.write_page(self.page, maps, scenes, cases)
