"""Steps between the sampling windows: the impulses that the plugin accumulates from output to output.

For each bridge the capillary impulse is between time times force at the largest and at the smallest separation since
the previous output; a normal drag -c(S) dS/dt leaves -(C(S2) - C(S1)), where C is the integral of c. For each sphere
the change of momentum is weight and the impulse of its bridges if it touched nothing, which follows from the
separations. The uncertainty of the bounds is reported as a share of the capillary impulse.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.motion import impulses, momentum, splitting
from reference_impl.motion.budget import VELOCITY
from reference_impl.motion.splitting import Shift
from reference_impl.motion.summed import pull_of, walls_motion
from reference_impl.motion.window import Setup
from reference_impl.replay import capillary, coverage, laws
from reference_impl.replay.arrays import Floats, dot, size
from reference_impl.replay.bodies import Pairs, bodies, pairs
from reference_impl.replay.compare import TOLERANCE, Quantity, compare
from reference_impl.replay.exact_sum import Exact
from reference_impl.replay.io import Run
from reference_impl.replay.lives import FORMATION, Lives, keys

SAMPLES = (0.0, 0.5, 1.0)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)
APART = 0.01
"""Smallest separation, over the radius of i, above which a step changes the separation little."""
SMALL = 0.05
"""Share of a separation, or of its change, that the error of a step may have."""
GROUP, FEWEST = 25, 10
"""Number of consecutive bridges of one kind whose median is judged, and its minimum for the last ones."""
OF_DRAG = 0.25
"""Limit on the deviation of that median, because steps are finite. In smoke case 2 it is at most 0.022."""
UNKNOWN = 0.5 * OF_DRAG
"""For semi-implicit drag, share of an expected impulse that may be unknown (splitting.py).

The other half of the limit is for finite steps.
"""
MOST = 200_000
"""Largest number of records for which parts that disagree are stored."""
NUMBERS = ("capillary_impulse", "viscous_impulse", "least_separation", "largest_separation")


@dataclass
class Between:
    """Accumulated results of the chunks of a run."""

    run: Run
    setup: Setup
    outputs: Floats
    last: dict[str, pd.DataFrame] = field(default_factory=dict)
    """Rows of the last output of the previous part."""
    total: Exact = field(default_factory=Exact)
    """Capillary impulse of all bridges at outputs [N s]."""
    bounded: Exact = field(default_factory=Exact)
    """Lower bound of that impulse."""
    rows: dict[str, list[pd.DataFrame]] = field(default_factory=lambda: {"capillary": [], "drag": [], "momentum": []})
    """Records of the parts that disagree, for the diagnosis."""

    ratios: pd.DataFrame = field(default_factory=lambda: pd.DataFrame({"step": [], "wall": [], "ratio": []}))
    """Ratios of the normal drag's impulses that belong to no group yet."""
    recomputed: Exact = field(default_factory=Exact)
    """Capillary impulse recomputed step by step in the windows [N s]."""
    formed: int = 0
    met: set[int] = field(default_factory=set)
    """Bridges that formed, and the rows of those for which a force was recomputed."""

    def windows(self, table: pd.DataFrame, lives: Lives) -> None:
        """Add the rows of the contact log of a part."""
        at = lives.at(keys(table), np.asarray(table["step"], dtype=np.int64), strictly=False)
        self.met.update(np.unique(lives.all.row[at[at >= 0]]).tolist())
        force = np.abs(np.asarray(table["capillary"], dtype=float))
        self.recomputed.add(force * impulses.weights(self.run, table) * self.setup.step)

    def seen(self) -> dict[str, float]:
        """Return the shares of the bridges and of the capillary impulse that the replay has recomputed."""
        bridges, total = max(self.formed, 1), max(self.total.value, 1e-300)
        return {
            "bridges": len(self.met) / bridges,
            "impulse_in_windows": min(self.recomputed.value / total, 1.0),
            "impulse_by_bounds": self.bounded.value / total,
        }

    def add(self, part: Run, lives: Lives) -> list[Quantity]:
        """Compare the impulses between the outputs of one chunk of the logs."""
        now = {name: part.table(name) for name in ("trajectory", "bridges", "films", "impulses", "events")}
        both = {n: pd.concat([self.last[n], now[n]], ignore_index=True) if n in self.last else now[n] for n in now}
        shots, self.formed = now["bridges"], self.formed + int((now["events"]["kind"] == FORMATION).sum())
        found = self._bridges(part, both, self._before(both["bridges"], shots), self._formed(shots, lives))
        found.append(self._momentum(part, both))
        step = int(both["trajectory"]["step"].max()) if len(both["trajectory"]) else -1
        self.last = {n: rows[rows["step"] >= step] for n, rows in both.items()}
        return found

    @staticmethod
    def _formed(shots: pd.DataFrame, lives: Lives) -> Floats:
        """Return the step at which each bridge formed."""
        at = lives.at(keys(shots), shots["step"].to_numpy(np.int64), strictly=False)
        return np.asarray(np.append(lives.all.step, -1)[at], dtype=np.int64)

    def _previous(self, step: Floats) -> Floats:
        return np.asarray(self.outputs[np.maximum(np.searchsorted(self.outputs, step) - 1, 0)])

    def _before(self, both: pd.DataFrame, shots: pd.DataFrame) -> Floats:
        """Return the separation of each bridge at the previous output; NaN if it did not exist."""
        ends, step = keys(both), np.searchsorted(self.outputs, both["step"].to_numpy(np.int64))
        known, code = np.unique(ends, return_inverse=True)
        code = code * (len(self.outputs) + 1) + step
        order = np.argsort(code, kind="stable")
        asked = np.searchsorted(known, keys(shots)) * (len(self.outputs) + 1)
        asked += np.searchsorted(self.outputs, self._previous(shots["step"].to_numpy(np.int64)))
        at = np.minimum(np.searchsorted(code[order], asked), max(len(order) - 1, 0))
        if not len(order):
            return np.zeros(0)
        found = both["separation"].to_numpy(float)[order[at]]
        return np.asarray(np.where(code[order[at]] == asked, found, np.nan))

    def _bridges(self, part: Run, both: dict[str, pd.DataFrame], before: Floats, formed: Floats) -> list[Quantity]:
        shots = part.table("bridges")
        step = shots["step"].to_numpy(np.int64)
        previous, k = self._previous(step), impulses.every(self.run)
        acted = (step - np.maximum(previous, formed) + 0.5 * (k - 1) * (formed > previous)) * self.setup.step
        old = step > previous
        rows = shots[old].reset_index(drop=True)
        new = before[old]
        new[formed[old] > previous[old]] = np.nan
        p = pairs(rows, bodies(self.run))
        return [
            self._ranges(rows, new, p.ri),
            *([self._capillary(part, rows, acted[old])] if self._closed("capillary", capillary.LAWS) else []),
            *([self._drag(both, rows, new, p)] if self._closed("viscous_normal", laws.VISCOUS_NORMAL) else []),
        ]

    def _closed(self, effect: str, known: Any) -> bool:
        return coverage.law(self.run, effect) in known

    def _ranges(self, rows: pd.DataFrame, before: Floats, radius: Floats) -> Quantity:
        """Check that the separations at both outputs are within the logged range."""
        gap, least, most = (rows[n].to_numpy(float) for n in ("separation", *NUMBERS[2:]))
        low, high = np.fmin(gap, before), np.fmax(gap, before)
        off = np.maximum(np.maximum(least - low, high - most), 0.0)
        return compare("between_range", "radius", off, 0.0 * off, radius, rows, TOLERANCE)

    def _capillary(self, part: Run, rows: pd.DataFrame, acted: Floats) -> Quantity:
        """Compare the capillary impulse with its bounds."""
        logged, least, most = (rows[NUMBERS[k]].to_numpy(float) for k in (0, 2, 3))
        force, total = pull_of(part, rows), np.zeros((len(SAMPLES), len(rows)))
        for n, at in enumerate(SAMPLES):
            total[n] = force(least + at * (most - least)) * acted
        low, high = total.min(axis=0, initial=np.inf), total.max(axis=0, initial=-np.inf)
        falls = (np.diff(total, axis=0) <= 0.0).all(axis=0)
        slack = np.where(falls, 0.0, np.abs(np.diff(total, axis=0)).max(axis=0, initial=0.0))
        low, high = low - slack, high + slack
        self.total.add(np.abs(logged))
        self.bounded.add(np.minimum(np.abs(low), np.abs(logged)))
        expected = np.clip(logged, low, high)
        found = compare(
            "between_capillary", "largest by the bounds", logged, expected, np.maximum(high, 1e-300), rows, TOLERANCE
        )
        wall = rows["partner_kind"].to_numpy() != laws.SPHERE
        self._keep(found, rows[["step", "i", "j", "partner_kind"]].assign(wall=wall, logged=logged, low=low, high=high))
        return found

    def _keep(self, found: Quantity, rows: pd.DataFrame) -> None:
        stored = self.rows[found.name.removeprefix("between_")]
        if not found.ok and sum(map(len, stored)) < MOST:
            stored.append(rows)

    def _drag(self, both: dict[str, pd.DataFrame], rows: pd.DataFrame, before: Floats, p: Pairs) -> Quantity:
        """Check the median of the normal drag's impulse over that from the separations, for some bridges of one kind.

        Bridges are omitted if their displacement in a step is no small part of the separation, if they slide so fast
        that the rotation of normals matters: in a time T by v^2 T dt/r, or if they hardly move, so that in T/dt steps
        the round-off of positions matters. With semi-implicit drag bridges with a too uncertain expected impulse are
        omitted, too (see splitting.py).
        """
        gap, least, most = (rows[n].to_numpy(float) for n in ("separation", *NUMBERS[2:]))
        step, dt = rows["step"].to_numpy(np.int64), self.setup.step
        speed = self._speeds(both, rows, step, p)
        time = (step - self._previous(step)) * dt
        turned, rounded = speed**2 * time * dt / p.ri, (step - self._previous(step)) * _last_digit(rows)
        calm = (most <= 0.0) | ((least > APART * p.ri) & (speed * dt < SMALL * least))
        calm &= (np.abs(gap - before) > (turned + rounded) / SMALL) & (impulses.every(self.run) == 1)
        expected, shift = integral(self.run, rows, p, before, gap), splitting.none(len(rows))
        if coverage.semi_implicit(self.run):
            before_it = self._previous(step)
            faster = np.maximum(speed, self._speeds(both, rows, before_it, p))
            c = (
                coefficient(self.run, rows, p, np.maximum(least, 0.0)),
                coefficient(self.run, rows, p, np.maximum(most, 0.0)),
            )
            shift = splitting.shift(self.run, self.setup, rows, both, c, faster * time)
            # the velocity is that of the next step, so the separation changes one step later
            later = sum(self._opening(both, rows, at, p) for at in (step, before_it)) * dt
            doubt = shift.doubt + c[0] * (faster**2 * time * dt / p.ri + later)
            calm &= doubt < UNKNOWN * np.abs(expected - shift.pushed)
        ratio = ratios(rows[calm], expected[calm], Shift(shift.pushed[calm], shift.shared[calm], shift.doubt[calm]))
        table = rows.loc[calm, ["step"]].assign(wall=p.wall[calm], ratio=ratio)
        table = table[np.isfinite(table["ratio"])].sort_values("step", kind="stable")
        return self._groups(pd.concat([self.ratios, table], ignore_index=True) if len(self.ratios) else table)

    def last_groups(self) -> list[Quantity]:
        """Judge the impulses of normal drag that are left over from full groups after the last chunk."""
        return [self._groups(self.ratios, last=True)] if self._closed("viscous_normal", laws.VISCOUS_NORMAL) else []

    def _groups(self, table: pd.DataFrame, last: bool = False) -> Quantity:
        """Return the medians of the full groups; the rest waits for the next part, independently of how the log is divided."""
        nth, many = table.groupby("wall").cumcount(), table.groupby("wall")["step"].transform("size")
        table = table.assign(group=nth // GROUP)
        waits = (nth >= many // GROUP * GROUP) & (not last)
        self.ratios, table = table.loc[waits, ["step", "wall", "ratio"]], table[~waits]
        of_groups = table.groupby(["wall", "group"]).agg(
            step=("step", "first"), median=("ratio", "median"), size=("ratio", "size")
        )
        table = of_groups[of_groups["size"] >= FEWEST].reset_index().drop(columns="group")
        table = table.sort_values(["step", "wall"], ignore_index=True)
        logged, one = table["median"].to_numpy(float), np.ones(len(table))
        found = compare("between_drag", "itself, median of a group", logged, one, one, table, OF_DRAG)
        self._keep(found, table)
        return found

    def _speeds(self, both: dict[str, pd.DataFrame], rows: pd.DataFrame, step: Floats, p: Pairs) -> Floats:
        """Return the sum of the speeds of both ends at outputs; for a wall that of the fastest wall."""
        of_i, of_j = (size(self._velocity(both, rows, step, n)) for n in "ij")
        return np.asarray(of_i + np.where(p.wall, walls_motion(self.setup)[0], of_j))

    def _opening(self, both: dict[str, pd.DataFrame], rows: pd.DataFrame, step: Floats, p: Pairs) -> Floats:
        """Return the relative speed along the normal at outputs, with the speed of the fastest wall added for walls."""
        n = splitting.normals(self.run, rows)
        of_i, of_j = (dot(self._velocity(both, rows, step, end), n) for end in "ij")
        return np.asarray(np.where(p.wall, np.abs(of_i) + walls_motion(self.setup)[0], np.abs(of_i - of_j)))

    @staticmethod
    def _velocity(both: dict[str, pd.DataFrame], rows: pd.DataFrame, step: Floats, end: str) -> Floats:
        table = both["trajectory"]
        at = pd.MultiIndex.from_frame(table[["step", "id"]]).get_indexer(pd.MultiIndex.from_arrays([step, rows[end]]))
        found = table[[*VELOCITY[:3]]].to_numpy(float)[at]
        return np.asarray(np.where(at[:, None] < 0, 0.0, found))

    def _momentum(self, part: Run, both: dict[str, pd.DataFrame]) -> Quantity:
        """Check the change of momentum of spheres that touched nothing from one output to the next."""
        rows = momentum.free_spheres(self.run, self.setup, both)
        columns = [[f"{n}_{axis}" for axis in "xyz"] for n in ("gain", "impulse")]
        logged, expected, scale = (rows[n].to_numpy(float) for n in (*columns, "scale"))
        quantity = compare("between_momentum", "momentum, weight and impulse", logged, expected, scale, rows, TOLERANCE)
        self._keep(quantity, rows)
        return quantity


def _last_digit(rows: pd.DataFrame) -> Floats:
    """Return the last digit of the largest coordinate of both ends [m]; a step may round a separation by about as much."""
    return np.spacing(np.abs(rows[[f"x{end}_{axis}" for end in "ij" for axis in "xyz"]].to_numpy(float)).max(axis=1))


def coefficient(run: Run, rows: pd.DataFrame, p: Pairs, gap: Floats) -> Floats:
    """Return the normal drag per speed [kg/s] of bridges at given separations."""
    law = laws.VISCOUS_NORMAL[str(coverage.law(run, "viscous_normal"))]
    volume, eta = rows["volume"].to_numpy(float), run.meta["viscosity"]
    return np.asarray(-law(gap, volume, p.ri, p.rj, p.wall, 1.0 + 0.0 * gap, eta))


def integral(run: Run, rows: pd.DataFrame, p: Pairs, before: Floats, gap: Floats) -> Floats:
    """Return C(S2) - C(S1) of the normal drag's coefficient [N s]."""

    def drag(s: Floats) -> Floats:
        return coefficient(run, rows, p, s)

    low, high = (np.sqrt(np.maximum(s, 0.0)) for s in (before, gap))
    expected = drag(0.0 * gap) * (np.minimum(gap, 0.0) - np.minimum(before, 0.0))
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        u = low + (high - low) * 0.5 * (1.0 + node)
        expected += 0.5 * weight * (high - low) * 2.0 * u * drag(u**2)
    return expected


def ratios(rows: pd.DataFrame, expected: Floats, shift: Shift) -> Floats:
    """Return the logged impulse of the normal drag over the expected one."""
    with np.errstate(all="ignore"):
        expected = (expected - shift.pushed) / (1.0 + shift.shared)
        return np.asarray(-rows["viscous_impulse"].to_numpy(float) / expected)
