"""The frame of the three studies: what a run is, how it is stored and found again, how all of them become one table.

A study is a list of jobs; a job is some runs that are done one after the other, so that what is compared is timed side by side.
Each run leaves one file: its rows, and a hash of all that they follow from. A run whose file is there with the same hash is not
done again, so that a study that was cut off goes on, and one whose configuration was edited does what the edit touches.
`carry_out` does the jobs in turn; Snakemake does several at a time and calls it last (workflow/rules/studies.smk).
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
from typing_extensions import TypedDict

from pywet.config import Config
from pywet.errors import PywetError
from pywet.util.files import atomic_write, read_json, write_json

Row = dict[str, Any]
Report = Callable[[str, float], None]
"""Called with what is being done and the share of the study that is done."""


@dataclass(frozen=True)
class Run:
    """One run: the name of its file, all that its rows follow from (plain data), and the function that gives them.

    `labels` are put next to the rows in the table. Runs of one name and the same `given` are done once.
    """

    name: str
    given: Any
    make: Callable[[], Iterable[Row]]
    labels: Mapping[str, Any] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Hash of the data that define a run."""
        return hashlib.sha256(json.dumps(self.given, sort_keys=True).encode()).hexdigest()[:16]


class StoredRun(TypedDict):
    """Stored rows of a run, in a JSON file."""

    key: str
    rows: list[dict[str, Any]]


class Study(ABC):
    """A study in a folder; the page is next to the folder, under its name."""

    folder: Path

    @abstractmethod
    def jobs(self) -> list[str]:
        """Names of the jobs, in the order they are done."""

    @abstractmethod
    def runs(self, job: str) -> list[Run]:
        """The runs of a job, in the order they are done."""

    @abstractmethod
    def show(self) -> Path:
        """Write tables and page from the runs that are stored; the page."""

    @property
    def page(self) -> Path:
        return self.folder.with_suffix(".html")

    def file(self, run: Run) -> Path:
        """Path of the file in which a run is stored."""
        return self.folder / "runs" / f"{run.name}.json"

    def stored(self, run: Run) -> list[Row] | None:
        """The rows of a run; None where its file is not there, is damaged, or of something else."""
        try:
            stored = read_json(self.file(run), shape=StoredRun)
        except PywetError:
            return None
        return list(stored["rows"]) if stored["key"] == run.key else None

    def missing(self) -> list[Run]:
        return [run for job in self.jobs() for run in self.runs(job) if self.stored(run) is None]

    def forget(self) -> None:
        for job in self.jobs():
            for run in self.runs(job):
                self.file(run).unlink(missing_ok=True)

    def do(self, job: str, report: Report = lambda name, share: None) -> None:
        """Do what is missing of a job; the share that is reported is that of the job."""
        runs = self.runs(job)
        for k, run in enumerate(runs):
            if self.stored(run) is None:
                report(run.name, k / len(runs))
                rows = [plain(row) for row in run.make()]
                write_json(self.file(run), {"key": run.key, "rows": rows})

    def gather(self, jobs: Iterable[str] | None = None) -> pd.DataFrame:
        """The rows of all stored runs (of these jobs) in one table, with the runs' names and labels."""
        runs = [run for job in (self.jobs() if jobs is None else jobs) for run in self.runs(job)]
        return pd.DataFrame([{"run": r.name, **r.labels, **row} for r in runs for row in self.stored(r) or ()])

    def carry_out(self, report: Report = lambda name, share: None) -> Path:
        """Do what is missing, then show all; the page."""
        jobs = self.jobs()
        for k, job in enumerate(jobs):
            self.do(job, lambda name, share, k=k: report(name, (k + share) / len(jobs)))  # type: ignore[misc]
        return self.show()


def plain(row: Row) -> Row:
    """A row as JSON can store it: a number that is not finite is missing."""
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in row.items()}


def write_rows(path: Path, value: Any) -> None:
    """JSON to be stored under version control: what holds no list or object of its own stands on one line."""
    text = re.sub(r"[{\[][^{}\[\]]*[}\]]", lambda row: " ".join(row[0].split()), json.dumps(value, indent=1))
    with atomic_write(path) as temporary:
        temporary.write_text(text + "\n")


def configured(config: Config, number: int, scale: str) -> dict[str, Any]:
    """Return the part of the configuration on which a run of a case depends, without ranks and presets, which a study sets."""
    resolved = config.resolved(number, scale)
    del resolved["settings"]["ranks"], resolved["settings"]["both_presets"]
    return resolved
