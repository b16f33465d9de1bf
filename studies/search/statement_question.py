"""Input of a search for readings: statements, varied entries of the configuration, budget."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from pywet.config.entries import Limited
from pywet.scene import Word
from pywet.strict import Strict
from studies.full_scale.judging import Statement
from studies.full_scale.statements import STATEMENTS

Place = Mapping[str, str | float]


class Turned(Strict):
    """An entry of the configuration, `file.yaml: path to it`, and its trial values."""

    entry: Annotated[str, Field(pattern=r"^(config|materials|scales)\.yaml: [A-Za-z0-9_ ]+$")]
    values: Annotated[tuple[str | float, ...], Field(min_length=1, max_length=20)]


class Search(Limited):
    """Describe a search of readings as in its YAML file."""

    name: str
    configuration: Path
    scale: Word = "full"
    statements: tuple[int, ...] = tuple(s.number for s in STATEMENTS)
    turned: Annotated[dict[Word, Turned], Field(min_length=1, max_length=10)]
    seeds: Annotated[int, Field(ge=1, le=20)] = 2
    most_runs: Annotated[int, Field(ge=1, le=10_000)] = 60
    cores: Annotated[int, Field(ge=1, le=1024)] = 1

    @model_validator(mode="after")
    def _known(self) -> Search:
        unknown = sorted(set(self.statements) - {s.number for s in STATEMENTS})
        if unknown:
            raise ValueError(f"statements to be of 1 to {max(s.number for s in STATEMENTS)}, not {unknown[0]}")
        return self

    @property
    def places(self) -> list[Place]:
        """List all combinations of the varied settings."""
        return [dict(zip(self.turned, v, strict=True)) for v in product(*(t.values for t in self.turned.values()))]

    @property
    def asked(self) -> list[Statement]:
        """List the statements that the runs of the search decide."""
        return [s for s in STATEMENTS if s.number in self.statements and s.cases]

    def entries(self, place: Place) -> dict[str, str | float]:
        """Return entry of the configuration -> value of a combination."""
        return {t.entry: place[name] for name, t in self.turned.items()}


def name_of(place: Place) -> str:
    """Return a combination as the name of a folder."""
    return ",".join(
        f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}" for name, value in place.items()
    )
