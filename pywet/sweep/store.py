"""The store shared by all sweeps: a folder for each fingerprint, with the run and its results in `point.json`.

A point without `point.json` is run again; after a failure `failed.json` contains the reason.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from typing_extensions import TypedDict

from pywet.errors import PywetError
from pywet.sweep.costs import Cost
from pywet.util.files import read_if_there, write_json

DONE, FAILED, COST = "point.json", "failed.json", "cost.json"
AGAIN = "remove the folder, and the sweep runs the point again"


class Numbers(TypedDict):
    """Results of a point by name, and those of functions and on request by the digest of their code."""

    numbers: dict[str, float | None]


class Failure(TypedDict):
    """Reason why the run of a point failed."""

    reason: str


class Took(TypedDict):
    """Total processor time [s] and file size [B] of a run of the engine."""

    seconds: float
    disk_B: float


@dataclass(frozen=True)
class Store:
    """Folder that stores the runs of all points of a sweep."""

    folder: Path

    def place(self, name: str) -> Path:
        """Return the folder in which the run of a point is stored."""
        return self.folder / name

    def numbers(self, name: str, engine: bool) -> dict[str, float | None] | None:
        """Return the results of a point; None if they are missing, damaged, or without the summary of the run."""
        if engine and not (self.place(name) / "summary.json").exists():
            return None
        try:
            found = read_if_there(self.place(name) / DONE, AGAIN, Numbers)
        except PywetError:
            return None
        return None if found is None else dict(found["numbers"])

    def leave(self, name: str, numbers: dict[str, float | None]) -> None:
        """Store the results of a point, which then counts as done."""
        write_json(self.place(name) / DONE, {"numbers": numbers})

    def note(self, name: str, seconds: float) -> None:
        """Store the cost of the run of a point."""
        files = self.place(name).rglob("*")
        write_json(
            self.place(name) / COST, {"seconds": seconds, "disk_B": sum(p.stat().st_size for p in files if p.is_file())}
        )

    def took(self, name: str) -> Cost | None:
        """Return the cost of the run of a point; None if not known."""
        try:
            found = read_if_there(self.place(name) / COST, AGAIN, Took)
        except PywetError:
            return None
        return None if found is None else Cost(found["seconds"], found["disk_B"])

    def typical(self, name: str) -> Cost | None:
        """Return the mean cost of runs whose names have the same beginning; None if there are none."""
        folders = self.folder.glob(f"{name.rpartition('-')[0]}-*")
        found = [cost for cost in (self.took(folder.name) for folder in folders) if cost is not None]
        return Cost(*(sum(part) / len(found) for part in zip(*(c[:2] for c in found), strict=True))) if found else None

    def fail(self, name: str, reason: str) -> None:
        """Store why a point has no results; the next call tries it again."""
        write_json(self.place(name) / FAILED, {"reason": reason})

    def reason(self, name: str) -> str:
        """Return the reason why a point has no results."""
        try:
            found = read_if_there(self.place(name) / FAILED, AGAIN, Failure)
        except PywetError as error:
            return str(error)
        return "it was not run to the end" if found is None else str(found["reason"])
