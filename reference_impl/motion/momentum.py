"""Change of momentum of spheres that touched nothing between outputs, which equals weight and the impulse of bridges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from reference_impl.motion import flights, nearest
from reference_impl.motion.budget import VELOCITY
from reference_impl.motion.summed import walls_motion
from reference_impl.motion.window import Setup
from reference_impl.replay import io, laws, one_place, script
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import bodies, pairs
from reference_impl.replay.io import Run
from reference_impl.replay.lives import FORMATION, RETIREMENT

IMPULSES = ["capillary_impulse", "viscous_impulse"]


@dataclass(frozen=True)
class Outputs:
    """Steps of outputs, and the spheres' ids; the interval between two outputs has the number of the first."""

    steps: Floats
    ids: Floats

    def dense(self, table: pd.DataFrame, names: Sequence[str]) -> Floats:
        """Return columns of a table as (outputs, spheres, columns); NaN for a sphere that has left."""
        found = np.full((len(self.steps), len(self.ids), len(names)), np.nan)
        step = table["step"].to_numpy(np.int64)
        at = np.minimum(np.searchsorted(self.steps, step), len(self.steps) - 1)
        known = self.steps[at] == step
        values = table[[*names]].to_numpy(float)
        found[at[known], np.searchsorted(self.ids, table["id"].to_numpy())[known]] = values[known]
        return found

    def interval(self, step: Floats) -> Floats:
        """Return the number of the interval that contains a step; -1 up to the first output, and after the last one."""
        at = np.searchsorted(self.steps, step) - 1
        return np.asarray(np.where(at < len(self.steps) - 1, at, -1))


def free_spheres(run: Run, setup: Setup, tables: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Return spheres that touched nothing between outputs: gain of momentum minus weight, and the logged impulse."""
    outputs = Outputs(np.unique(tables["trajectory"]["step"].to_numpy(np.int64)), setup.ids)
    one, two = outputs.steps[:-1], outputs.steps[1:]
    if not judged(run):
        one = two = outputs.steps[:0]
    if not len(two):
        return pd.DataFrame({name: np.zeros(0) for name in ("step", "i", *_named("gain"), *_named("impulse"), "scale")})
    bad = _touching(run, setup, tables, outputs)
    v, m = outputs.dense(tables["trajectory"], VELOCITY[:3]), setup.mass[:, None]
    bad |= _beside(run, setup, tables, outputs, size(v))
    push = outputs.dense(tables["impulses"], _named("impulse"))[1:]
    weight = ((two - one) * setup.step)[:, None, None] * m * setup.pull(two)
    gain, momentum = m * (v[1:] - v[:-1]) - weight, setup.mass * (size(v[1:]) + size(v[:-1]))
    interval, sphere = np.nonzero(~bad)
    columns = {"step": two[interval], "i": setup.ids[sphere]}
    for name, values in (("gain", gain), ("impulse", push)):
        columns |= dict(zip(_named(name), values[interval, sphere].T, strict=True))
    return pd.DataFrame({**columns, "scale": (momentum + size(weight) + size(push))[interval, sphere]})


def size(a: Floats) -> Floats:
    """Return the length of each vector."""
    return np.asarray(np.linalg.norm(a, axis=-1))


def _named(name: str) -> list[str]:
    return [f"{name}_{axis}" for axis in "xyz"]


def _touching(run: Run, setup: Setup, tables: dict[str, pd.DataFrame], outputs: Outputs) -> Floats:
    """Return whether a sphere is driven, enters, leaves, touched, lost a bridge or had no film; shape (intervals, spheres)."""
    fixed, one, two = bodies(run), outputs.steps[:-1, None], outputs.steps[1:, None]
    bad = ~setup.free | ((setup.enters > one) & (setup.enters <= two)) | (setup.leaves <= two)
    for step in setup.broken:
        bad[(one <= step)[:, 0] & (step <= two)[:, 0]] = True
    events, shots = tables["events"], tables["bridges"]
    events = events[events["kind"] != FORMATION]
    at = outputs.interval(events["step"].to_numpy(np.int64))
    touched = shots[shots["least_separation"] <= 0.0]
    # a bridge that ends by retirement at the first output acts half a step longer, which no logged impulse contains
    retired = events[events["kind"] == RETIREMENT]
    after = outputs.interval(retired["step"].to_numpy(np.int64) + 1)
    for table, interval in (
        (events, at), (retired, after), (touched, outputs.interval(touched["step"].to_numpy(np.int64)))
    ):  # fmt: skip
        p, real = pairs(table, fixed), interval >= 0
        bad[interval[real], np.searchsorted(setup.ids, p.i[real].astype(int))] = True
        real &= ~p.wall
        bad[interval[real], np.searchsorted(setup.ids, p.sphere_j[real].astype(int))] = True
    films = outputs.dense(tables["films"], ["film"])[..., 0]
    dry = films < flights.DRY * fixed.radius[setup.ids] ** 3
    return np.asarray(bad | dry[:-1] | dry[1:])


def _beside(run: Run, setup: Setup, tables: dict[str, pd.DataFrame], outputs: Outputs, speed: Floats) -> Floats:
    """Return the spheres that may touch a part of a wall without a bridge.

    At a convex edge a sphere has one bridge with all parts that meet there. Before any contact the speed of a
    sphere is at most that of the fastest body at either output, to which drag could accelerate it, plus the
    effect of weight and of the capillary force and normal drag of its bridges in between. If a part next to that
    of its bridge is farther than this speed and that of the walls allow, the sphere does not touch it.
    """
    found, ids = np.zeros((len(outputs.steps) - 1, len(outputs.ids)), dtype=bool), outputs.ids
    interval = outputs.interval(tables["bridges"]["step"].to_numpy(np.int64))
    shots = tables["bridges"][interval >= 0].reset_index(drop=True)
    interval = interval[interval >= 0]
    p, pull = pairs(shots, bodies(run)), np.zeros(found.shape)
    pushes = shots[IMPULSES].abs().sum(axis=1).to_numpy(float)
    np.add.at(pull, (interval, np.searchsorted(ids, p.i.astype(int))), pushes)
    between = ~p.wall
    np.add.at(pull, (interval[between], np.searchsorted(ids, p.sphere_j[between].astype(int))), pushes[between])
    at_wall = (shots["partner_kind"] != laws.SPHERE).to_numpy()
    rows, interval = shots.loc[at_wall, ["i", "j"]].reset_index(drop=True), interval[at_wall]
    row, part = one_place.beside(run, rows)
    ends, parts = rows["i"].to_numpy(np.int64), int(max(part.max(initial=0), rows["j"].max() if len(rows) else 0)) + 1

    def code(of: Floats, j: Floats) -> Floats:
        return np.asarray((interval[of] * (int(ids.max()) + 1) + ends[of]) * parts + j)

    alone = ~np.isin(code(row, part), code(np.arange(len(rows)), rows["j"].to_numpy(np.int64)))
    row, part = row[alone], part[alone]
    if not len(row):
        return found
    k, sphere = interval[row], np.searchsorted(ids, ends[row])
    x = outputs.dense(tables["trajectory"], ("x", "y", "z"))[k, sphere]
    time, walls = np.diff(outputs.steps) * setup.step, walls_motion(setup)[0]
    largest = np.nanmax(np.fmax(speed[1:], speed[:-1]), axis=1, initial=walls)
    fastest = (largest + time * float(np.linalg.norm(setup.gravity)))[k] + (pull / setup.mass)[k, sphere]
    apart = nearest.parts(run).closest(outputs.steps[k], x, part).distance - setup.radius[sphere]
    near = apart <= time[k] * (fastest + walls)
    found[k[near], sphere[near]] = True
    return found


def judged(run: Run) -> bool:
    """Return whether the momentum of a sphere without contacts must be that of weight and bridges.

    Its mass must be constant, and it must reach walls through a bridge only; in a script's run gravity must be
    the only other force.
    """
    effects = run.meta["effects"]
    return bool(
        io.scene(run.folder)["effects"].get("wall_films", True)
        and not (script.of(run.folder) and script.in_the_way_of_gravity(run.folder))
        and not effects.get("liquid_weight") and not effects.get("shedding")
    )  # fmt: skip
