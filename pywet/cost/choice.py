"""Choose settings from the stored table: the cheapest combination whose summed errors stay below the required accuracy.

In each group of quantities a level has the largest of its errors there. The burden of proof is on the cheaper level:
for a level that is not more expensive than the default in every round, the upper bound of the error is used; for the
default and more expensive levels, the resolved error. Errors of the settings are added, costs multiplied. A lower
accuracy permits all combinations of a higher one, and so never costs more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from pywet.cost.edit import CONFIGURABLE, Level
from pywet.errors import PywetError
from pywet.util.files import read_json

STORED = Path(__file__).with_name("table.json")
GROUPS = ("fraction retained", "liquid shares", "force", "restitution", "packing")
"""Groups of quantities for which errors are given; a test compares them with those of the accuracy study."""
WANTED = ("fraction retained", "liquid shares", "force", "restitution")
"""Groups that are used unless others are named."""
SCENES = {"moist": ("moist", "bed", "pair_wet", "pull", "laws"), "dry": ("dry", "pair_dry")}
"""Kind of case -> scenes of the study that represent it."""
NEAREST = ("reduced", "smoke")
"""Scales whose table is used for a scale without one."""


@dataclass(frozen=True)
class Option:
    """One level of a setting, with its cost and errors.

    `charge`: errors that are counted, by group; `bound`: upper bounds of the errors, by group.
    """

    setting: str
    level: Level
    cost: float
    charge: dict[str, float]
    bound: dict[str, float]


@dataclass(frozen=True)
class Chosen:
    """Chosen settings: levels by setting, cost relative to the default; by group the error counted and its upper bound."""

    levels: dict[str, Level]
    cost: float
    error: dict[str, float]
    bound: dict[str, float]

    @classmethod
    def of(cls, picked: Collection[Option], wanted: Sequence[str]) -> Chosen:
        """Return the levels together: errors and bounds added, costs multiplied."""
        return cls(
            {o.setting: o.level for o in picked},
            math.prod(o.cost for o in picked),
            {group: sum(o.charge[group] for o in picked) for group in wanted},
            {group: sum(o.bound[group] for o in picked) for group in wanted},
        )


def parse(text: str) -> float:
    """An accuracy such as `2%` or `0.02` as a share.

    >>> parse("2%"), parse("0.5 %"), parse("0.02")
    (0.02, 0.005, 0.02)
    """
    stripped = text.strip()
    percent = stripped.endswith("%")
    try:
        value = float(stripped.rstrip("%")) * (0.01 if percent else 1.0)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1.0:
        raise PywetError(
            f"accuracy {text!r} given, expected more than 0 and below 100 per cent, such as 2% or 0.02",
            code="cost.accuracy", key="--accuracy", given=text,
        )  # fmt: skip
    return value


@cache
def stored(path: Path = STORED) -> dict[str, Any]:
    """Read the stored table of the study; a setting that it does not contain keeps its default."""
    table: dict[str, Any] = read_json(
        path, "make the table of the accuracy study with `pywet study accuracy --store`", dict[str, Any]
    )
    return table


def for_scale(scale: str) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return the table of a scale and the settings that may vary; without a table, the nearest one without springs and wires."""
    tables = stored()["scales"]
    if scale in tables:
        return tables[scale], tuple(CONFIGURABLE)
    nearest = next(tables[name] for name in NEAREST if name in tables)
    return nearest, tuple(k for k in CONFIGURABLE if k not in ("stiffness", "wire_sides"))


def options(
    table: dict[str, Any], moist: bool, turned: Collection[str] = CONFIGURABLE, longer_by: float = 1.0
) -> dict[str, list[Option]]:
    """List the levels of every setting of a moist or a dry case with their cost and errors.

    Settings that are not varied have their default; a level for which a run of the study failed is omitted.
    `longer_by`: time step of semi-implicit over explicit drag for this case. The study's liquid is water, for
    which both steps are equal; for a more viscous one the cost is divided by this ratio.
    """
    kind = "moist" if moist else "dry"
    scenes = SCENES[kind]
    by_parameter: dict[str, list[Option]] = {}
    for setting, rows in table["parameters"].items():
        for row in rows:
            cost = row["cost"].get(kind)
            if cost is None or setting not in CONFIGURABLE:
                continue
            if setting not in turned and row["level"] != table["default"][setting]:
                continue
            if any(reason.partition(":")[0] in scenes for reason in row["failed"]):
                continue
            longer = longer_by if (setting, row["level"]) == ("integration", "semi_implicit") else 1.0
            cheaper = cost["low"] < longer and row["level"] != table["default"][setting]
            charge, bound = dict.fromkeys(GROUPS, 0.0), dict.fromkeys(GROUPS, 0.0)
            for error in row["errors"]:
                if error["scene"] in scenes:
                    group, size, limit = error["group"], abs(error["value"]), error["limit"]
                    counted = size + limit if cheaper else size if size > limit else 0.0
                    charge[group] = max(charge[group], counted)
                    bound[group] = max(bound[group], size + limit)
            made = Option(setting, row["level"], cost["ratio"] / longer, charge, bound)
            by_parameter.setdefault(setting, []).append(made)
    return by_parameter


def choose(
    table: dict[str, Any],
    accuracy: float,
    moist: bool,
    wanted: Sequence[str] = WANTED,
    turned: Collection[str] = CONFIGURABLE,
    longer_by: float = 1.0,
    runs: Callable[[dict[str, Level]], bool] = lambda levels: True,
) -> Chosen:
    """Return the cheapest combination within the accuracy in all wanted groups; raises `PywetError` if there is none.

    `runs`: whether a combination is stable.
    """
    best: Chosen | None = None
    nearest = math.inf
    for combination in combinations(options(table, moist, turned, longer_by), wanted):
        worst = max(combination.error.values(), default=0.0)
        nearest = min(nearest, worst)
        better = best is None or (combination.cost, worst) < (best.cost, max(best.error.values()))
        if worst <= accuracy and better and runs(combination.levels):
            best = combination
    if best is None:
        raise PywetError(
            f"accuracy {100 * accuracy:g} % given, but the finest settings of the study have errors of {100 * nearest:.2g} % "
            f"in {', '.join(wanted)}; expected at least that",
            code="cost.finest", key="--accuracy", given=accuracy, expected=nearest,
        )  # fmt: skip
    return best


def combinations(by_parameter: dict[str, list[Option]], wanted: Sequence[str]) -> Iterable[Chosen]:
    """Yield the combinations of levels for which no other level of the setting is better in both cost and all relevant errors."""
    for picked in product(*(_worth(levels, wanted) for levels in by_parameter.values())):
        yield Chosen.of(picked, wanted)


def _worth(levels: list[Option], wanted: Sequence[str]) -> list[Option]:
    """Return the levels for which no other level of the setting is better in every respect; of equal ones the first listed."""
    rows = np.array([[o.cost, *(o.charge[g] for g in wanted)] for o in levels])
    beaten = [bool(((rows <= row).all(axis=1) & (rows < row).any(axis=1)).any()) for row in rows]
    _, first = np.unique(rows, axis=0, return_index=True)
    return [o for k, o in enumerate(levels) if k in first and not beaten[k]]


def of_default(table: dict[str, Any], moist: bool, wanted: Sequence[str] = WANTED) -> Chosen:
    """Return the default with its errors."""
    base = table["default"]
    return Chosen.of(
        [o for levels in options(table, moist).values() for o in levels if o.level == base[o.setting]], wanted
    )


def largest_setting(table: dict[str, Any], moist: bool, group: str) -> str:
    """Return the setting whose default has the largest error in a group of quantities."""
    base = table["default"]
    picked = [o for levels in options(table, moist).values() for o in levels if o.level == base[o.setting]]
    return str(max(picked, key=lambda o: o.charge[group]).setting)
