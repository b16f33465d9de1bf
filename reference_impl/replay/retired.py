"""Retired spheres: which, when, and with how much liquid; in a scene with outlets, those that leave there (outlets.py).

The plan follows from scene.json alone: a sphere is retired at the first checkpoint outside the windows at which its
centre is two largest diameters below the plane of the bin and its speed can lift it by at most a hundredth of that
depth. Checkpoints are outputs then, so that trajectory.parquet shows which spheres qualify. All later outputs contain
a retired sphere at rest, with its last film; for one that left at an outlet only the film.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.replay import io, laws, outlets, plans, script
from reference_impl.replay.arrays import Floats
from reference_impl.replay.arrays import size as length
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import ReplayError, Run
from reference_impl.replay.lives import RETIREMENT

NEVER = np.iinfo(np.int64).max
DIAMETERS, RISE = 2.0, 0.01
NEAR = 1e-9
"""Relative distance to the limits within which rounding decides which spheres qualify."""
FAR = 100.0
"""Distance [m] of positions that nothing may touch from the apparatus and from each other."""
NAMES = ["step", "id", "type", "outlet", "film", "x_x", "x_y", "x_z", "v_x", "v_y", "v_z"]


@dataclass(frozen=True)
class Rule:
    """Height of the centre and speed below which a sphere is retired, and the steps at which this is checked."""

    below: float
    slower: float
    steps: Floats
    stay: bool = True
    """Whether later outputs contain retired spheres."""
    size: float = 1.0
    """Length that positions are compared with: the depth below the plane of the bin, as the limit itself may lie at z = 0."""

    def holds(self, step: Floats, x: Floats, v: Floats, margin: float = 0.0) -> Floats:
        """Return which spheres satisfy the rule, at any step; with `margin` which may, by rounding (negative: certainly)."""
        return (x[:, 2] < self.below + margin * (abs(self.below) + self.size)) & (
            length(v) < self.slower * (1.0 + margin)
        )

    def entered(self, ids: pd.Series) -> Floats:
        """Return the step from which each sphere may be retired."""
        return np.zeros(len(ids))

    def booked(self, step: Floats, x: Floats, v: Floats, outlet: Floats, margin: float) -> Floats:
        """Return which rows name the location of their sphere: the bin, 0."""
        return self.holds(step, x, v, margin) & (outlet == 0)


def rule(folder: Path) -> Rule | outlets.Regions | None:
    """Derive the rule of retirement, or the outlets, of a scene; None if no sphere is removed."""
    scene = io.scene(folder)
    if not plans.taken_out(io.scene(folder)):
        return None
    planned = plans.plan(folder)
    every = plans.checkpoints_every(scene, planned.steps)
    at = np.arange(every, planned.steps + 1, every)  # includes the end if it is a checkpoint
    inside = np.zeros(len(at), dtype=bool)
    for first, last in planned.windows:
        inside |= (at >= first) & (at < last)
    if scene.get("outlets"):
        return outlets.of(folder, at[~inside])
    depth = DIAMETERS * 2.0 * max(c["radius_m"] for c in scene["classes"])
    g = abs(scene["gravity_m_per_s2"][2])
    return Rule(float(scene["bin_z_m"]) - depth, math.sqrt(2.0 * g * RISE * depth), at[~inside], size=depth)


def whole(folder: Path) -> int:
    """Refuse a table of retired spheres that does not fit start and plan; its number of rows."""
    found, limits, path = table(folder), rule(folder), folder / "history" / "retired.parquet"
    kinds = io.columns(folder / "history" / "spheres.parquet", ["id", "type"]).set_index("id")["type"]
    steps = limits.steps if limits else np.zeros(0)
    for wrong, what in (
        (found["id"].duplicated(), "twice"),
        (found["id"].map(kinds) != found["type"], "with a number or class that the start does not have"),
        (
            ~found["step"].isin(steps) & (script.of(folder) is None),
            "at a step that is no checkpoint outside the windows",
        ),
    ):
        if wrong.any():
            row = found[wrong].iloc[0]
            raise ReplayError(
                f"{path} names sphere {int(row['id'])} at step {int(row['step'])} {what}; expected each sphere of the start "
                f"once, at steps that scene.json plans: {plans.AGAIN}"
            )
    return len(found)


def table(folder: Path) -> pd.DataFrame:
    """Read history/retired.parquet in order of steps; without rows if no sphere is retired."""
    if not plans.taken_out(io.scene(folder)) and script.of(folder) is None:
        return pd.DataFrame({name: np.zeros(0) for name in NAMES}).astype({n: np.int64 for n in NAMES[:4]})
    return io.columns(folder / "history" / "retired.parquet", NAMES).sort_values(["step", "id"], ignore_index=True)


def leaves(folder: Path, ids: Floats) -> Floats:
    """Return the last step at which each of these spheres takes part."""
    gone, found = table(folder), np.full(len(ids), NEVER)
    found[np.searchsorted(ids, gone["id"].to_numpy())] = gone["step"].to_numpy() - (script.of(folder) is not None)
    return found


def nowhere(count: int) -> Floats:
    """Return positions that are far from everything and from each other, shape (count, 3)."""
    return np.stack([-FAR * (np.arange(count) + 1.0), np.zeros(count), np.zeros(count)], axis=1)


SCALES = {
    "retired_who": ("spheres that do not qualify", 0.0),
    "retired_missed": ("spheres that qualify and stay", 0.0),
    "retired_place": ("height of the limit and depth below the plane", 1e-12),
    "retired_speed": ("limit of the speed", 1e-9),
    "retired_rest": ("1 m and 1 m/s, or spheres that are still there", 0.0),
    "retired_events": ("events that do not fit in", 0.0),
    "retired_bridges": ("bridges of retired spheres", 0.0),
}
"""Scale of each deviation, and its limit."""
Deviation = tuple[str, pd.DataFrame, Floats, float]
"""Name, rows, deviation of each row, limit."""
OF_PLACES = ["step", "id", "x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"]


class Count:
    """Count of retired spheres in the logs and outputs, chunk by chunk."""

    def __init__(self, run: Run) -> None:
        self.rule, self.gone = rule(run.folder), table(run.folder)
        self.seen = np.zeros(len(self.gone), dtype=bool)

    def check(self, part: Run, outputs: Floats, shots: Floats, mean: float) -> list[Quantity]:
        """Check one chunk of the logs; `shots`: liquid of all reservoirs after its outputs, `mean`: mean film of a sphere."""
        rows, after = self.gone, np.searchsorted(outputs, self.gone["step"])
        inside = (
            after < len(outputs)
        ) & ~self.seen  # a script may delete spheres at any step; their liquid is constant afterwards
        self.seen |= inside
        rows, after = rows[inside].reset_index(drop=True), after[inside]
        films, size = shots[after, rows["id"]], np.full(len(rows), mean)
        found = compare("retired_film", "mean film of a sphere", rows["film"].to_numpy(float), films, size, rows)
        judged = self.rule or len(self.gone) or (part.table("events")["kind"] == RETIREMENT).any()
        return [found, *map(_quantity, self.deviations(part))] if judged else []

    def deviations(self, part: Run) -> list[Deviation]:
        """Compare retired spheres, their positions and the bridges that ended with them."""
        places = of_places(self.rule, self.gone, part.table("trajectory")) if self.rule else []
        return [*places, *self._of_bridges(part)]

    def _of_bridges(self, part: Run) -> list[Deviation]:
        """Check that a bridge ends by retirement if one of its spheres is retired in that step, and that none outlives them."""
        events, bridges = part.table("events"), part.table("bridges")
        step_of = dict(zip(self.gone["id"], self.gone["step"], strict=True))
        first, later = (_earliest(rows, step_of) for rows in (events, bridges))
        ended, step = (events["kind"] == RETIREMENT).to_numpy(), events["step"].to_numpy(np.int64)
        wrong = np.where(ended, first != step, step > first)
        return [
            ("retired_events", events, wrong.astype(float), 0.0),
            ("retired_bridges", bridges, (bridges["step"].to_numpy() >= later).astype(float), 0.0),
        ]


def of_dry(folder: Path) -> list[Quantity]:
    """Check the retired spheres of a dry run."""
    law = rule(folder)
    trajectory = io.columns(folder / "trajectory.parquet", OF_PLACES) if law else pd.DataFrame()
    return [*map(_quantity, of_places(law, table(folder), trajectory))] if law else []


def _quantity(deviation: Deviation) -> Quantity:
    name, rows, off, limit = deviation
    return compare(name, SCALES[name][0], off, np.zeros(len(off)), np.ones(len(off)), rows, limit)


def of_places(law: Rule | outlets.Regions, gone: pd.DataFrame, trajectory: pd.DataFrame) -> list[Deviation]:
    """Compare spheres retired at outputs with those that qualified, and check positions of retired spheres."""
    now = trajectory[OF_PLACES].merge(
        gone.drop(columns=["type", "film"]).rename(columns={"step": "last"}), on="id", how="left"
    )
    last, step = now["last"].fillna(NEVER).to_numpy(), now["step"].to_numpy()
    stays = (step < last) & np.isin(step, law.steps) & (step >= law.entered(now["id"]))
    missed = stays & law.holds(step, now[[*"xyz"]].to_numpy(float), now[["vx", "vy", "vz"]].to_numpy(float), -NEAR)
    moment, rest = (now[rows].reset_index(drop=True) for rows in (step == last, step > last))
    waits = moment["step"].to_numpy() < law.entered(moment["id"])

    def at(rows: pd.DataFrame, *names: str) -> Floats:
        return rows[list(names)].to_numpy(float)

    x, v = (at(moment, *(f"{q}_{axis}" for axis in "xyz")) for q in "xv")
    off = (
        length(at(rest, *"xyz") - at(rest, "x_x", "x_y", "x_z"))
        + length(at(rest, "vx", "vy", "vz"))
        + length(at(rest, "wx", "wy", "wz"))
        + (0.0 if law.stay else 1.0)
    )
    found = {
        "retired_who": (
            moment,
            (waits | ~law.booked(moment["step"].to_numpy(), x, v, moment["outlet"].to_numpy(), NEAR)).astype(float),
        ),
        "retired_missed": (now, missed.astype(float)),
        "retired_place": (moment, length(at(moment, *"xyz") - x) / (abs(law.below) + law.size)),
        "retired_speed": (moment, length(at(moment, "vx", "vy", "vz") - v) / law.slower),
        "retired_rest": (rest, off),
    }
    return [(name, rows, values, SCALES[name][1]) for name, (rows, values) in found.items()]


def _earliest(rows: pd.DataFrame, step_of: dict[Any, Any]) -> Floats:
    """Return the first step at which an end of each row's bridge is retired."""
    j = rows["j"].where(rows["partner_kind"] == laws.SPHERE, -1)
    ends = [side.map(step_of).fillna(NEVER).to_numpy() for side in (rows["i"], j)]
    return np.minimum(*ends)
