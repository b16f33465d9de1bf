"""Errors and costs from the stored runs: each level of a setting compared with the finest, and the statistical uncertainty.

Screening and bed are chaotic: two runs that differ by rounding diverge as far as two seeds. The error of a level is
the mean over seeds of its difference to the finest level with the same seed; its limit is the half width of the 99 %
confidence interval (Student) of that mean. The standard deviation is pooled over all levels and settings of the
scene, which are equally good samples of the scatter. An error within its limit is not resolved. Of a hundred such
errors one exceeds its limit by chance; statements on the defaults involve all of them and use `family`, for which the
probability is one in a hundred for all together (Bonferroni). For colliding pairs the instants of touch are the
seeds, each level with its own deviation. Everything is in the unit of `QUANTITIES`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

from pywet.compare.statistics import half_width
from pywet.cost.edit import Level
from studies.accuracy import parameters
from studies.accuracy.parameters import PARAMETERS_OF
from studies.accuracy.sieve import SCREENING

CONFIDENCE = 0.99
Sample = tuple[tuple[object, ...], np.ndarray, tuple[float, int] | None]
"""Scene, setting, level, quantity and group; differences to the finest level; the pooled deviation of the scene."""


@dataclass(frozen=True)
class Quantity:
    """Quantity of interest: its group, description and scenes, and whether errors are relative to its size."""

    name: str
    group: str
    text: str
    scenes: tuple[str, ...]
    relative: bool = False


QUANTITIES = (
    Quantity("retained_mean", "fraction retained", "mean over the run, of the feed", SCREENING),
    Quantity("retained_end", "fraction retained", "at the end, of the feed", SCREENING),
    Quantity("liquid_coarse_material", "liquid shares", "on the screen, of all liquid", ("moist",)),
    Quantity("liquid_fines", "liquid shares", "on the fines, of all liquid", ("moist",)),
    Quantity("liquid_walls", "liquid shares", "on wires and walls, of all liquid", ("moist",)),
    Quantity("liquid_bridges", "liquid shares", "in bridges, of all liquid", ("moist",)),
    Quantity("law_force", "force", "largest over the gap, of that at touch, against the exact bridge", ("laws",)),
    Quantity("law_rupture", "force", "rupture distance against the exact bridge", ("laws",)),
    Quantity("sharing_ratio", "liquid shares", "of one rupture, in the table", ("laws",)),
    Quantity("pull_force", "force", "two bodies drawn apart, at a gap of r/50", ("pull",), True),
    Quantity("pull_work", "force", "work of drawing apart", ("pull",), True),
    Quantity("pull_rupture", "force", "rupture distance of two bodies drawn apart", ("pull",), True),
    Quantity("restitution", "restitution", "of two bodies, of the speed of approach", ("pair_dry", "pair_wet")),
    Quantity("bed_height", "packing", "height of a settling bed", ("bed",), True),
    Quantity("bed_bridges", "packing", "bridges per sphere of a settling bed", ("bed",), True),
    Quantity("bed_liquid", "packing", "liquid in bridges of a settling bed", ("bed",)),
)
GROUPS = tuple(dict.fromkeys(q.group for q in QUANTITIES))


def errors(runs: pd.DataFrame, size: str) -> pd.DataFrame:
    """Return every error that the runs determine, one row each, without failed levels.

    `limit` bounds the effect of scatter on it, `family` that on the largest of all errors of the study.
    """
    done = runs[runs["failed"].isna() & (runs["parameter"] != "again")]
    samples = [
        s for quantity in QUANTITIES for scene in quantity.scenes for s in _of_scene(done, scene, quantity, size)
    ]
    alone, together = 1.0 - CONFIDENCE, sum(bool(d.any()) for _, d, _ in samples) or 1
    rows = [
        (*of, float(d.mean()), *(_limit(d, spread, 1.0 - risk) for risk in (alone, alone / together)), len(d))
        for of, d, spread in samples
    ]
    columns = ["scene", "parameter", "level", "quantity", "group", "value", "limit", "family", "seeds"]
    return pd.DataFrame(rows, columns=columns)


def _of_scene(done: pd.DataFrame, scene: str, quantity: Quantity, size: str) -> Iterator[Sample]:
    if quantity.name not in done:
        return
    runs = done[(done["scene"] == scene) & done[quantity.name].notna()]
    member = "instant" if quantity.name == "restitution" else "seed"  # different instants of touch are treated as seeds
    of_parameter = {parameter: of.set_index(member) for parameter, of in runs.groupby("parameter")}
    if "default" not in of_parameter:
        return
    differences: dict[tuple[str, Level], np.ndarray] = {}
    for parameter in PARAMETERS_OF[scene]:
        if parameter not in of_parameter:
            continue
        by_level = {level: of[quantity.name] for level, of in of_parameter[parameter].groupby("level")}
        by_level[getattr(parameters.default(size), parameter)] = of_parameter["default"][quantity.name]
        finest = by_level.get(parameters.reference(parameter, size))
        if finest is not None:
            for level, values in by_level.items():
                differences[parameter, level] = _differences(values, finest, quantity)  # type: ignore[index]
    spread = _pooled(differences.values()) if scene in (*SCREENING, "bed") else None
    for (parameter, level), d in differences.items():
        yield (scene, parameter, level, quantity.name, quantity.group), d, spread


def _differences(values: pd.Series, finest: pd.Series, quantity: Quantity) -> np.ndarray:
    shared = values.index.intersection(finest.index)
    one, two = values[shared].to_numpy(float), finest[shared].to_numpy(float)
    if quantity.scenes == ("laws",):  # the number is itself an error against an exact solution
        return one
    if quantity.name == "restitution" and values is not finest:
        two = np.full(len(two), two.mean())  # instants are not paired
    return (one - two) / abs(two.mean()) if quantity.relative else one - two


def _pooled(differences: Iterable[np.ndarray]) -> tuple[float, int]:
    """Return the standard deviation of a difference and its degrees of freedom, over levels not identical to the reference."""
    moved = [d for d in differences if len(d) > 1 and np.any(d != 0.0)]
    freedom = sum(len(d) - 1 for d in moved)
    if freedom == 0:
        return 0.0, 0
    return math.sqrt(sum(float(((d - d.mean()) ** 2).sum()) for d in moved) / freedom), freedom


def _limit(d: np.ndarray, pooled: tuple[float, int] | None, confidence: float) -> float:
    if not d.any() or (pooled is None and len(d) == 1):
        return 0.0
    deviation, freedom = pooled or (float(d.std(ddof=1)), len(d) - 1)
    if freedom == 0:
        return 1.0  # one seed gives no statistical uncertainty
    return half_width(deviation, len(d), freedom, confidence)


def costs(runs: pd.DataFrame, size: str) -> pd.DataFrame:
    """Return the processor time of the time loop over that of the default in the same round (wall time for ranks).

    There is a row for every level run in a screening scene: the median over the seeds with its range, and the
    default's own range, which is the repeatability.
    """
    rows = []
    for scene in SCREENING:
        done = runs[(runs["scene"] == scene) & runs["failed"].isna()].set_index("seed")
        defaults = done[done["parameter"].isin(["default", "again"])]
        defaults = defaults[defaults.index.isin(defaults.index[defaults["parameter"] == "default"])]
        for parameter in PARAMETERS_OF[scene]:
            clock = "loop_wall_s" if parameter == "ranks" else "loop_cpu_s"
            base = defaults[clock].groupby("seed").mean()
            for level in parameters.PARAMETERS[parameter].levels(size):
                default = level == getattr(parameters.default(size), parameter)
                of_level = defaults if default else done[(done["parameter"] == parameter) & (done["level"] == level)]
                ratios = (of_level[clock] / base.reindex(of_level.index)).dropna()
                if len(ratios):
                    middle = 1.0 if default else float(ratios.median())
                    rows.append((scene, parameter, level, middle, float(ratios.min()), float(ratios.max())))
    return pd.DataFrame(rows, columns=["scene", "parameter", "level", "ratio", "low", "high"])
