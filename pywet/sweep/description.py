"""The file of a sweep: base, axes, design, seeds, constraints, gathered results; each mistake is reported in one sentence."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from pywet.cases.custom.walls import chosen
from pywet.config.loading import begun, parse, read_yaml
from pywet.errors import ConfigError
from pywet.scene import Positive, Title, Word
from pywet.strict import Strict
from pywet.sweep import constraints
from pywet.sweep.constraints import Constraint

Value = float | int | str | bool
MOST_RUNS = 10_000
"""Largest number of runs of one sweep, each of which is a folder in the store."""
KINDS = ("case", "scene", "script", "wall", "bridge")


class Base(Strict):
    """Run that a sweep repeats: a screening case, a scene, a LIGGGHTS script with liquid, a collision with a wall, or a bridge.

    Paths are relative to the file.
    """

    case: Annotated[int, Field(ge=1)] | None = None
    """Number of a case in the folder `config`."""
    config: Path = Path("config")
    scale: Word | None = None
    """Scale of a case; by default that of its config.yaml."""
    scene: Path | None = None
    wall: Path | None = None
    bridge: Path | None = None
    script: Path | None = None
    """A LIGGGHTS script with the line of fix pywet."""
    seed: Word | None = None
    """Variable of a script that is its seed; the seeds of a point are this prime number and those after it."""

    @model_validator(mode="after")
    def _one(self) -> Self:
        if chosen(self, *KINDS, needed=False) is None:
            raise ValueError(f"one of {', '.join(KINDS)}")
        if self.case is None and {"config", "scale"} & self.model_fields_set:
            raise ValueError("config and scale with a case only")
        if self.script is None and self.seed is not None:
            raise ValueError("seed with a script only")
        return self

    @property
    def kind(self) -> str:
        return str(chosen(self, *KINDS))


Ends = Annotated[tuple[float, float, int], Field(min_length=3, max_length=3)]


class Axis(Strict):
    """Values of one key: listed, spaced (`linspace`, `logspace`: first, last, count), or a range for a design."""

    values: tuple[Value, ...] | None = None
    linspace: Ends | None = None
    logspace: Ends | None = None
    low: float | None = None
    high: float | None = None
    log: bool = False
    """Whether a range is sampled, and an axis drawn, on a logarithmic scale."""
    whole: bool = False
    """Whether values are rounded to integers."""

    @model_validator(mode="before")
    @classmethod
    def _no_switch_for_a_number(cls, given: Any) -> Any:
        """Allow true and false for switches such as effects.gravity."""
        return given

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        ways = [w for w in ("values", "linspace", "logspace") if getattr(self, w) is not None]
        ways += ["low and high"] * self.is_range
        if len(ways) != 1:
            raise ValueError(f"one of a list, linspace, logspace, low with high, not {' and '.join(ways) or 'none'}")
        if self.is_range and (self.low is None or self.high is None or not self.low < self.high):
            raise ValueError("low less than high, both given")
        for name in ("linspace", "logspace"):
            ends = getattr(self, name)
            if ends is not None and (ends[2] < 2 or ends[0] == ends[1]):
                raise ValueError(f"{name}: [first, last, count] with two different ends and a count of at least 2")
        if self.values is not None:
            self._check_values(self.values)
        given = self.values or (self.logspace or self.linspace or (self.low,))[:2]
        if self.logarithmic and not all(not isinstance(v, str) and v is not None and v > 0 for v in given):
            raise ValueError("numbers above 0 on a logarithmic scale")
        return self

    @staticmethod
    def _check_values(values: tuple[Value, ...]) -> None:
        if not values:
            raise ValueError("at least one value")
        if twice := [v for k, v in enumerate(values) if v in values[:k]]:
            raise ValueError(f"each value once ({twice[0]} is there {values.count(twice[0])} times)")
        if len({isinstance(v, str) for v in values}) > 1:
            raise ValueError("only numbers or only text")

    @property
    def is_range(self) -> bool:
        return self.low is not None or self.high is not None

    @property
    def logarithmic(self) -> bool:
        return self.log or self.logspace is not None

    @property
    def listed(self) -> tuple[Value, ...]:
        """Return all values of an axis that is no range."""
        if self.values is not None:
            found = self.values
        elif self.linspace is not None:
            found = tuple(float(f"{v:.12g}") for v in np.linspace(*self.linspace))
        else:
            assert self.logspace is not None
            found = tuple(float(f"{v:.12g}") for v in np.geomspace(*self.logspace))
        return tuple(dict.fromkeys(self.rounded(v) for v in found))

    def at(self, share: float) -> Value:
        """Convert a position in a range (0 to 1) to a value."""
        assert self.low is not None and self.high is not None
        between = self.low * (self.high / self.low) ** share if self.log else self.low + share * (self.high - self.low)
        return self.rounded(float(f"{between:.12g}"))

    def rounded(self, value: Value) -> Value:
        return round(value) if self.whole and isinstance(value, float | int) else value


def _axis(given: Any) -> Any:
    return {"values": given} if isinstance(given, list | tuple) else given


class Design(Strict):
    """Design by which points are drawn from axes that are ranges; axes with listed values are crossed with them."""

    latin_hypercube: Annotated[int, Field(ge=2, le=MOST_RUNS)] | None = None
    sobol: Annotated[int, Field(ge=2, le=MOST_RUNS)] | None = None
    """Number of points; a longer Sobol design begins with the points of a shorter one."""
    seed: Annotated[int, Field(ge=0)] = 1

    @model_validator(mode="after")
    def _one(self) -> Self:
        if chosen(self, "latin_hypercube", "sobol", needed=False) is None:
            raise ValueError("latin_hypercube or sobol, with the number of points")
        return self


class Function(Strict):
    """A result computed from a run by a function in a user's file, `path/to/file.py:name`.

    It is permitted to run if it is below the sweep's folder, or with --trust.
    """

    function: Annotated[str, Field(pattern=r"^.+\.py:[A-Za-z_]\w*$")]
    unit: str = ""

    @property
    def name(self) -> str:
        return self.function.rpartition(":")[2]


def _gathered(given: Any) -> Any:
    return {"function": given} if isinstance(given, str) and ".py:" in given else given


class Goal(Strict):
    """The result whose optimum the page reports."""

    maximise: str | None = None
    minimise: str | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if chosen(self, "maximise", "minimise", needed=False) is None:
            raise ValueError("maximise or minimise, with a gathered result")
        return self

    @property
    def result(self) -> str:
        return self.maximise or self.minimise or ""


class Sweep(Strict):
    """Describe a sweep as in its YAML file."""

    name: Title
    base: Base
    axes: Annotated[dict[str, Annotated[Axis, BeforeValidator(_axis)]], Field(min_length=1, max_length=20)]
    zips: tuple[Annotated[tuple[str, ...], Field(min_length=2)], ...] = ()
    """Axes that change together, value by value; all others are combined in a grid."""
    design: Design | None = None
    seeds: Annotated[int, Field(ge=1, le=1000)] = 1
    constraints: tuple[str, ...] = ()
    gather: tuple[Annotated[str | Function, BeforeValidator(_gathered)], ...] = ()
    goal: Goal | None = None
    most_core_hours: Positive = 24.0
    most_disk_GB: Positive = 20.0

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.ranges and self.design is None:
            raise ValueError(f"a design with the range of {self.ranges[0]}, such as design: {{sobol: 32}}")
        if self.design is not None and not self.ranges:
            raise ValueError("an axis with low and high for the design to draw from")
        for group in self.zips:
            if wrong := [key for key in group if key not in self.axes or self.axes[key].is_range]:
                raise ValueError(f"zips of axes with listed values, not {wrong[0]}")
            lengths = {key: len(self.axes[key].listed) for key in group}
            if len({*lengths.values()}) > 1:
                counts = ", ".join(f"{key} has {n}" for key, n in lengths.items())
                raise ValueError(f"axes of a zip with equally many values ({counts})")
        zipped = [key for group in self.zips for key in group]
        if twice := [key for k, key in enumerate(zipped) if key in zipped[:k]]:
            raise ValueError(f"each axis in one zip ({twice[0]} is in two)")
        names = [g if isinstance(g, str) else g.name for g in self.gather]
        if twice := [n for k, n in enumerate(names) if n in names[:k]]:
            raise ValueError(f"each gathered result once ({twice[0]} is there twice)")
        if wrong := [key for key in self.axes if key in names or key in RESERVED]:
            raise ValueError(f"another key than {wrong[0]}, which is a column of the table")
        if (key := f"script.{self.base.seed}") in self.axes:
            raise ValueError(f"the key seeds in place of the axis {key}, which is the seed in base")
        if self.goal is not None and names and self.goal.result not in names:
            raise ValueError(f"goal to name a gathered result ({', '.join(names)}), not {self.goal.result}")
        return self

    @property
    def factors(self) -> list[tuple[str, ...]]:
        """Return the axes, those of a zip together, in the order of the file: all that changes independently."""
        return list(dict.fromkeys(map(self.factor, self.axes)))

    def factor(self, key: str) -> tuple[str, ...]:
        """Return the axes of the zip of an axis; the axis alone without one."""
        return next((group for group in self.zips if key in group), (key,))

    @property
    def groups(self) -> list[tuple[str, ...]]:
        """Return the factors with listed values."""
        return [group for group in self.factors if not self.axes[group[0]].is_range]

    @property
    def ranges(self) -> list[str]:
        return [key for key, axis in self.axes.items() if axis.is_range]

    @property
    def count(self) -> int:
        """Return the number of requested runs, before constraints."""
        grid = math.prod(len(self.axes[group[0]].listed) for group in self.groups)
        drawn = (self.design.latin_hypercube or self.design.sobol or 1) if self.design else 1
        return grid * drawn * self.seeds


def joined(group: Iterable[str]) -> str:
    """Return the name of axes that change together.

    >>> joined(["width_mm", "length_mm"])
    'width_mm + length_mm'
    """
    return " + ".join(group)


RESERVED = ("point", "seed", "status", "reason", "run")
"""Columns of the table that are neither axes nor results."""


def read(file: Path) -> Sweep:
    """Read and check the file; its constraints are parsed, but not evaluated."""
    sweep = parse(Sweep, read_yaml(file, Sweep, begun("sweep")), str(file))
    if sweep.count > MOST_RUNS:
        raise ConfigError(
            f"{file} asks for {sweep.count} runs, expected at most {MOST_RUNS}: shorten axes or seeds, or split it",
            file=file, code="sweep.many_runs", given=sweep.count, expected=MOST_RUNS,
        )  # fmt: skip
    parsed(sweep, file)
    return sweep


def parsed(sweep: Sweep, file: Path) -> list[Constraint]:
    """Parse the constraints of a sweep on its axes."""
    try:
        return [constraints.read(text, list(sweep.axes)) for text in sweep.constraints]
    except ConfigError as error:
        raise ConfigError(f"{file}: {error}", **{**error.data, "where": file}) from error


Point = Mapping[str, Value]
"""Values of a point by axis."""
