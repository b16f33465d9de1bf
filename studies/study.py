"""Common part of the three studies: definition of a run, its storage and retrieval, the table of all runs.

A study is a list of jobs; a job is a few runs executed one after the other, so that compared runs are timed side by
side. Each run has one file: its rows, and a digest of all data and code that determine them. A run whose file exists
with the same digest is not repeated, so that an interrupted study resumes, and one whose configuration was edited does
what the edit touches. `carry_out` does the jobs in turn; Snakemake does several at a time and calls it last
(workflow/rules/studies.smk).
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
from pywet.util import sources
from pywet.util.files import atomic_write, read_json, write_json

Row = dict[str, Any]
Report = Callable[[str, float], None]
"""Progress callback with the current work and the finished share of the study."""


@dataclass(frozen=True)
class Run:
    """One run: the name of its file, the data that determine its rows, and the function that computes them.

    `labels` are added to the rows in the table. Runs of one name with the same `given` are executed once.
    """

    name: str
    given: Any
    make: Callable[[], Iterable[Row]]
    labels: Mapping[str, Any] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Hash of the data that define a run, and of the code that runs and evaluates it."""
        parts = json.dumps(self.given, sort_keys=True), sources.digest_of_a_run(), sources.digest_of_evaluation()
        return hashlib.sha256(" ".join(parts).encode()).hexdigest()[:16]


class StoredRun(TypedDict):
    """Stored rows of a run, in a JSON file."""

    key: str
    rows: list[dict[str, Any]]


class Study(ABC):
    """A study in a folder; the page is next to the folder, under its name."""

    folder: Path

    @abstractmethod
    def jobs(self) -> list[str]:
        """Return the names of the jobs, in order of execution."""

    @abstractmethod
    def runs(self, job: str) -> list[Run]:
        """Return the runs of a job, in order of execution."""

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
        """Return the rows of a run; None if its file is missing, damaged, or of other data."""
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
        """Execute the missing runs of a job; the reported share is that of these runs."""
        missing = [run for run in self.runs(job) if self.stored(run) is None]
        for k, run in enumerate(missing):
            if self.stored(run) is None:  # not yet executed under other labels
                report(run.name, k / len(missing))
                rows = [plain(row) for row in run.make()]
                write_json(self.file(run), {"key": run.key, "rows": rows})

    def gather(self, jobs: Iterable[str] | None = None) -> pd.DataFrame:
        """Return the rows of all stored runs (of these jobs) in one table, with the runs' names and labels."""
        runs = [run for job in (self.jobs() if jobs is None else jobs) for run in self.runs(job)]
        return pd.DataFrame([{"run": r.name, **r.labels, **row} for r in runs for row in self.stored(r) or ()])

    def carry_out(self, report: Report = lambda name, share: None) -> Path:
        """Execute missing runs, show all results, and return the page; shares are of the jobs with missing runs."""
        jobs = [job for job in self.jobs() if any(self.stored(run) is None for run in self.runs(job))]
        for k, job in enumerate(jobs):
            self.do(job, lambda name, share, k=k: report(name, (k + share) / len(jobs)))  # type: ignore[misc]
        return self.show()


def plain(row: Row) -> Row:
    """Return a row as JSON can store it: a number that is not finite is missing."""
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in row.items()}


def write_rows(path: Path, value: Any) -> None:
    """Write JSON for version control: lists and objects without nested ones are on one line."""
    text = re.sub(r"[{\[][^{}\[\]]*[}\]]", lambda row: " ".join(row[0].split()), json.dumps(value, indent=1))
    with atomic_write(path) as temporary:
        temporary.write_text(text + "\n")


def configured(config: Config, number: int, scale: str) -> dict[str, Any]:
    """Return the part of the configuration on which a run of a case depends, without ranks and presets, which a study sets."""
    resolved = config.resolved(number, scale)
    del resolved["settings"]["ranks"], resolved["settings"]["both_presets"]
    return resolved
