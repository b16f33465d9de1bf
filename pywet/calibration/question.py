"""Input file of `pywet calibrate`: measured targets, parameters with bounds, confidence level, seeds and runs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from pywet.calibration.experiments import KINDS, Experiment
from pywet.calibration.inference import Floats
from pywet.cases.custom.walls import chosen
from pywet.config.dotted_keys import holds
from pywet.config.entries import Limited
from pywet.config.loading import begun, parse, read_yaml
from pywet.errors import ConfigError
from pywet.scene import Positive, Title
from pywet.strict import Strict

LEVELS = {1: 5, 2: 3, 3: 3}
"""Number of values of each parameter in a round of runs, by the number of parameters."""


class Target(Limited):
    """A measured number, and the file of `pywet bridge`, `pywet collide wall` or `pywet run-scene` whose experiment gives it."""

    bridge: Path | None = None
    wall: Path | None = None
    scene: Path | None = None
    changes: dict[str, Any] = Field(default_factory=dict)
    """Values that replace keys of that file (dotted), so that one file serves several targets."""
    quantity: str
    value: float
    scatter: Positive
    """Standard deviation of a single measurement."""
    repeats: Annotated[int, Field(ge=1, le=10_000)] = 1
    """Number of measurements of which `value` is the mean; with 1, `scatter` is taken as exactly known."""

    @model_validator(mode="after")
    def _known(self) -> Self:
        known = KINDS[self.kind].quantities
        if self.quantity not in known:
            raise ValueError(f"quantity to be one of {', '.join(known)}, not {self.quantity}")
        return self

    @property
    def kind(self) -> str:
        return chosen(self, *KINDS) or ""

    @property
    def error(self) -> float:
        """Standard error of the mean of the repeated measurements."""
        return self.scatter / math.sqrt(self.repeats)

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the scatter."""
        return self.repeats - 1.0 if self.repeats > 1 else math.inf


class Parameter(Strict):
    """Parameter to be determined: a number between bounds, written to `keys` (dotted) of every experiment that has them."""

    keys: Annotated[tuple[str, ...], Field(min_length=1)]
    low: float
    high: float
    log: bool = False
    """Search on a logarithmic scale: equal ratios have equal weight."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low < self.high or (self.log and self.low <= 0.0):
            raise ValueError("low less than high" + (" and more than 0, as log is true" if self.log else ""))
        return self

    def at(self, share: float) -> float:
        """Convert a position between the bounds (0 to 1) to a value."""
        if self.log:
            return float(self.low * (self.high / self.low) ** share)
        return self.low + share * (self.high - self.low)


class Question(Strict):
    """Describe a calibration as in its YAML file: targets, parameters, numbers of runs."""

    name: Title
    targets: Annotated[tuple[Target, ...], Field(min_length=1, max_length=20)]
    parameters: Annotated[dict[Title, Parameter], Field(min_length=1, max_length=3)]
    confidence: Annotated[float, Field(ge=0.5, le=0.999)] = 0.95
    seeds: Annotated[int, Field(ge=2, le=20)] = 2
    """Number of runs, each with its own seed, at each point of a round."""
    most_runs: Annotated[int, Field(le=10_000)] = 60
    check_runs: Annotated[int, Field(ge=2, le=100)] = 3
    """Number of runs at the answer, which are not used to determine it."""

    @model_validator(mode="after")
    def _enough(self) -> Self:
        first = self.seeds * LEVELS[len(self.parameters)] ** len(self.parameters)
        if self.most_runs < first:
            raise ValueError(f"most_runs of at least {first}, the first round of {len(self.parameters)} parameters")
        return self

    def values(self, place: Floats) -> dict[str, float]:
        """Return the values of the parameters at a point of the unit cube."""
        return {name: p.at(float(u)) for (name, p), u in zip(self.parameters.items(), place, strict=True)}

    def settings(self, place: Floats) -> dict[str, float]:
        """Convert values of the parameters to entries by key of the experiments' files."""
        values = self.values(place)
        return {key: values[name] for name, p in self.parameters.items() for key in p.keys}


def read(file: Path) -> tuple[Question, list[Experiment]]:
    """Read a question and the experiment of each target, and try both ends of all bounds; each mistake is one sentence."""
    content = read_yaml(file, Question, begun("calibration"))
    if "turned" in content:
        raise ConfigError(
            f"{file} names statements of the paper; expected targets: `pywet study search {file}` answers it in a checkout",
            file=file, key="turned", code="calibration.study_question",
        )  # fmt: skip
    question = parse(Question, content, str(file))
    experiments = [Experiment.read(t.kind, file.parent / getattr(t, t.kind), t.changes) for t in question.targets]
    for name, parameter in question.parameters.items():
        for key in parameter.keys:
            if not any(holds(e.content, key) for e in experiments):
                raise ConfigError(
                    f"{file}: parameters.{name}.keys names {key}, which is in none of the targets' files; expected a "
                    "dotted key that is written there, such as materials.glass.friction or spheres.0.film_um",
                    file=file, key=f"parameters.{name}.keys", code="calibration.parameter_key", given=key,
                )  # fmt: skip
    for end in (0.0, 1.0):
        settings = question.settings(np.full(len(question.parameters), end))
        for experiment in experiments:
            experiment.built(settings)
    return question, experiments
