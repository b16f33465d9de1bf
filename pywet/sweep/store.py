"""The store that all sweeps share: a folder for each fingerprint, with the run and `point.json`, the numbers that it gave.

A point without `point.json` is run again; one whose run failed has the reason in `failed.json` meanwhile.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from typing_extensions import TypedDict

from pywet.errors import PywetError
from pywet.util.files import read_if_there, write_json

DONE, FAILED = "point.json", "failed.json"
AGAIN = "remove the folder, and the sweep runs the point again"


class Numbers(TypedDict):
    """What a point gave: results by name, and those of functions and on request by the word of what they were read with."""

    numbers: dict[str, float | None]


class Failure(TypedDict):
    """Reason why the run of a point failed."""

    reason: str


@dataclass(frozen=True)
class Store:
    """Folder that stores the runs of all points of a sweep."""

    folder: Path

    def place(self, name: str) -> Path:
        """Folder in which the run of a point is stored."""
        return self.folder / name

    def numbers(self, name: str, engine: bool) -> dict[str, float | None] | None:
        """Results of a point; None where it is to be run: not there, damaged, or without its run's summary."""
        if engine and not (self.place(name) / "summary.json").exists():
            return None
        try:
            found = read_if_there(self.place(name) / DONE, AGAIN, Numbers)
        except PywetError:
            return None
        return None if found is None else dict(found["numbers"])

    def leave(self, name: str, numbers: dict[str, float | None]) -> None:
        """Store the results of a point: from here on it counts as done."""
        write_json(self.place(name) / DONE, {"numbers": numbers})

    def fail(self, name: str, reason: str) -> None:
        """Store why a point has no results; the next call tries it again."""
        write_json(self.place(name) / FAILED, {"reason": reason})

    def reason(self, name: str) -> str:
        """Why a point has no results."""
        try:
            found = read_if_there(self.place(name) / FAILED, AGAIN, Failure)
        except PywetError as error:
            return str(error)
        return "it was not run to the end" if found is None else str(found["reason"])
