"""Interface of every kind of base of a sweep: checked points with fingerprints, runs, predicted costs, names of results."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from pywet.runs.loaded import Run
from pywet.sweep.costs import Cost
from pywet.sweep.description import Base, Point
from pywet.util import sources

Numbers = dict[str, float | None]
"""Result -> value; None if a run has none, such as ruptures of a dry one."""


def number(value: Any) -> float | None:
    """Return a result as a float; None for one that is missing or not finite."""
    return None if value is None or not math.isfinite(value) else float(value)


class Built(NamedTuple):
    """A point ready to run: the name of its folder in the store, made from its fingerprint, and the object to run."""

    name: str
    given: Any


def stored_name(kind: str, word: str, module: str) -> str:
    """Return the name in the store of the run with this fingerprint, from which the module of this file gathers numbers."""
    return f"{kind}-{sources.digest([Path(module)], word, sources.digest_of_evaluation())[:16]}"


class Kind(ABC):
    """A kind of base; `engine`: whether it writes a run directory, `seeded`: whether results depend on a seed."""

    engine = True
    seeded = True
    results: tuple[str, ...] = ()
    """Results that are gathered if the file names none."""

    def __init__(self, base: Base, folder: Path, trust: bool = False) -> None:
        self.base, self.folder, self.trust = base, folder, trust

    @cached_property
    def file(self) -> Path:
        """Return the file of the base; a case has none."""
        return self.folder / str(getattr(self.base, self.base.kind))

    @abstractmethod
    def built(self, values: Point, seed: int) -> Built:
        """Check a point and name it; raises `PywetError` if it cannot be run. `seed` is relative to the base's."""

    @abstractmethod
    def run(self, built: Built, folder: Path, ranks: int) -> Numbers:
        """Run a point in its folder of the store; its results by name."""

    @property
    def ranks(self) -> int:
        """Return the number of MPI ranks of a run if the command names none."""
        return 1

    @abstractmethod
    def cost(self, built: Built) -> Cost:
        """Predict time, memory and disk of a run."""

    def subject(self, folder: Path) -> Any:
        """Return the argument of a user's function: the tables of a run."""
        return Run(folder)

    @abstractmethod
    def known(self, built: Built) -> list[str]:
        """Return the names of the results that a point may have."""
