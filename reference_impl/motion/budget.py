"""Check the energy budget: history/energy compared with trajectory, events, snapshots and recorded motion.

Engine and reference compute work as force times speed in the middle of a kick, so that the change of kinetic energy
is the sum of the works and `half_kick` to round-off (docs/engine.md). Kinetic energy and the work of gravity follow
from the trajectory; the energy of formations, ruptures and active bridges and, to first order in the time step, the
capillary work follow from events and snapshots. The division of the rest among the effects is checked in the steps of
the windows.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.motion import summed
from reference_impl.motion.newton import Forces, rounding
from reference_impl.motion.window import Setup
from reference_impl.replay import arrays, capillary, coverage, io
from reference_impl.replay.arrays import Floats, dot
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run, where
from reference_impl.replay.lives import FORMATION, Lives, keys

WORKS = ("gravity", "contact", "capillary", "viscous_normal", "viscous_tangential", "wall_motion", "drive")
"""Columns of the energy log that add up to the change of kinetic energy."""
VELOCITY = tuple(f"{q}{axis}" for q in "vw" for axis in "xyz")
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)
LIMITS = {"kinetic": 1e-9, "spin": 1e-9, "formed": 1e-6, "ruptured": 1e-6, "capillary_stored": 1e-6, "gravity": 1e-3,
          "capillary": 1.0, "budget": 1e-9, "windows": 1e-8}  # fmt: skip
"""Limit of each comparison; that of the capillary work is the error of the summation rule."""


def judged(run: Run) -> bool:
    """Return whether the run logged works, and its spheres have constant mass."""
    logged = where(run.folder, "energy").exists() and io.scene(run.folder)["output"].get("energy", True)
    return bool(logged and not run.meta["effects"].get("liquid_weight"))


def depth(run: Run, table: pd.DataFrame, gap: Floats, distance: Floats) -> Floats:
    """Return the capillary energy of bridges, -integral of the force from the gap to the static rupture distance."""
    force = summed.pull_of(run, table)
    # with s = u^2 laws that begin as a square root are smooth
    low, high = np.sqrt(np.maximum(gap, 0.0)), np.sqrt(distance)
    total = np.maximum(-gap, 0.0) * force(0.0 * gap)
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        u = low + (high - low) * 0.5 * (1.0 + node)
        total += 0.5 * weight * (high - low) * 2.0 * u * force(u**2)
    return -total


@dataclass
class Budget:
    """Recomputed values at every output, part by part."""

    run: Run
    setup: Setup
    rows: list[pd.DataFrame] = field(default_factory=list)
    formed: float = 0.0
    ruptured: float = 0.0
    steps: float = 0.0
    """Error of the sum over steps of the works of the bridges that formed and ruptured [J]."""
    begun: Floats | None = None
    """Position at which weight began to act on each sphere; NaN if it has not yet."""
    doubt: float = 0.0
    """Scale of the work [J] on spheres that met others just before they entered, whose path until then is not known."""
    way: float = 0.0
    """Sum of the absolute works of gravity [J] from output to output so far, for all spheres."""
    fastest: Floats = field(default_factory=lambda: np.zeros(1))
    """Largest speed of each sphere at an output so far [m/s]."""
    before: tuple[Floats, Floats, Floats] | None = None
    """Step, positions and speeds of the last output of the previous part."""

    def add(self, part: Run, lives: Lives) -> None:
        """Add a part of the logs; the table of positions contains the speeds too."""
        table, events = part.table("trajectory").sort_values(["step", "id"]), part.table("events")
        outputs = np.unique(table["step"].to_numpy())
        shape = (len(outputs), len(self.setup.ids), 3)
        x, v, w = (table[list(c)].to_numpy(float).reshape(shape) for c in ("xyz", VELOCITY[:3], VELOCITY[3:]))
        of_bridges = self._bridges(part, events, lives, (outputs, v)) if self.known else {}
        if not len(outputs):
            return
        m, free = self.setup.mass, self.setup.free
        fall, way, doubt = self._fall(outputs, x, v, events)
        margin = float(np.linalg.norm(self.setup.gravity) * m.sum()) * 1e-6
        expected: dict[str, Any] = {
            "step": outputs,
            "kinetic": 0.5 * ((v**2).sum(axis=2) * m * free).sum(axis=1),
            "spin": 0.2 * ((w**2).sum(axis=2) * m * self.setup.radius**2 * free).sum(axis=1),
            "gravity": fall.sum(axis=1),
            "gravity_size": way + doubt + margin,
        }
        self.rows.append(pd.DataFrame({**expected, **of_bridges}))

    def _fall(self, outputs: Floats, x: Floats, v: Floats, events: pd.DataFrame) -> tuple[Floats, Floats, Floats]:
        """Return the work of gravity on every sphere at the outputs [J], since the start or its insertion.

        Further results are the sum of absolute works from output to output, in which a sphere that returns
        does not cancel, and `doubt`.
        """
        enters, dt, m = self.setup.enters, self.setup.step, self.setup.mass
        if self.begun is None:
            self.begun = np.where(enters[:, None] > 0, np.nan, x[0])
        now = (outputs, x, v)
        step, at, speed = (
            now if self.before is None else (np.concatenate(both) for both in zip(self.before, now, strict=True))
        )
        for n in np.flatnonzero(np.isnan(self.begun[:, 0]) & (enters <= outputs[-1])):
            k = int(np.searchsorted(step, enters[n])) - 1
            # half a step before its weight first acts, because the work is that of the mean power of two steps
            self.begun[n] = at[k, n] + speed[k, n] * (enters[n] - 0.5 - step[k]) * dt
            met = (events["i"] == self.setup.ids[n]) | (
                (events["partner_kind"] == 0) & (events["j"] == self.setup.ids[n])
            )
            if (met & events["step"].between(step[k], enters[n])).any():
                way = np.abs((at[k + 1, n] - at[k, n]) @ self.setup.gravity)
                self.doubt += float(m[n] * way) / LIMITS["gravity"]
        self.before = outputs[-1:], x[-1:], v[-1:]
        whole = np.where(step[:, None] >= enters, ((at - self.begun) * self.setup.gravity).sum(axis=2) * m, 0.0)
        ways = self.way + np.concatenate([[0.0], np.cumsum(np.abs(np.diff(whole, axis=0)).sum(axis=1))])
        self.way = float(ways[-1])
        return whole[-len(outputs) :], ways[-len(outputs) :], self.doubt + self._touching(v)

    def _touching(self, v: Floats) -> Floats:
        """Return the scale of the error of an output during an impact [J].

        Powers at whole steps omit Δt²/4 of the acceleration, in an impact at most the fastest speed so far
        times the angular frequency of the stiffest contact.
        """
        speed = np.linalg.norm(v, axis=2)
        fastest = np.maximum.accumulate(np.concatenate([np.maximum(self.fastest, speed[:1]), speed[1:]]))
        self.fastest = fastest[-1]
        stiffest = max(pair["normal_stiffness_N_per_m"] for pair in self.setup.scene["pairs"])
        missed = 0.25 * self.setup.step**2 * fastest * np.sqrt(stiffest / self.setup.mass)
        doubt = np.linalg.norm(self.setup.gravity) * (self.setup.mass * missed).sum(axis=1) / LIMITS["gravity"]
        return np.asarray(doubt, dtype=float)

    @property
    def known(self) -> bool:
        """Return whether the capillary force is a closed form (or off)."""
        name = coverage.law(self.run, "capillary")
        return name is None or name in capillary.LAWS

    def _bridges(
        self, part: Run, events: pd.DataFrame, lives: Lives, at_outputs: tuple[Floats, Floats]
    ) -> dict[str, Floats]:
        """Return sums over the events up to each output, and over the bridges active there; outputs and all speeds at them."""
        outputs, v = at_outputs
        gap, distance = (events[n].to_numpy(float) for n in ("separation", "rupture_distance"))
        energy = depth(part, events, gap, distance)
        formation = (events["kind"] == FORMATION).to_numpy()
        way = summed.of_events(part, self.setup, events)
        until, found = np.searchsorted(events["step"].to_numpy(), outputs, "right"), {}
        for name, terms in (
            ("formed", np.where(formation, energy, 0.0)),
            ("ruptured", np.where(formation, 0.0, energy)),
            ("steps", way),
        ):
            sums = np.cumsum(np.concatenate([[getattr(self, name)], terms]))
            found[name] = sums[until]
            setattr(self, name, float(sums[-1]))
        shots = part.table("bridges")
        at = lives.at(keys(shots), shots["step"].to_numpy(np.int64), strictly=False)
        distance = np.append(lives.all.rupture_distance, np.nan)[at]
        stored = depth(part, shots, shots["separation"].to_numpy(float), distance)
        found["capillary_stored"] = np.bincount(np.searchsorted(outputs, shots["step"]), stored, len(outputs))
        found["steps"] = found["steps"] + summed.active(part, self.setup, shots, outputs, v)
        return found

    def both(self) -> tuple[pd.DataFrame, Floats]:
        """history/energy with the recomputed values next to it (`_own`), and the energy converted up to each output [J]."""
        expected = pd.concat(self.rows, ignore_index=True)
        log = io.columns(where(self.run.folder, "energy"), ["step", "half_kick", *OF_STATE, *WORKS]).sort_values("step")
        both = log.merge(expected, on="step", suffixes=("", "_own"))
        turned = both[[*WORKS]].abs().sum(axis=1) + both["kinetic"] + both["spin"]
        return both, np.maximum(np.maximum.accumulate(turned.to_numpy(float)), 1e-300)

    @staticmethod
    def size(name: str, both: pd.DataFrame, turnover: Floats) -> Floats:
        """Energy to which the deviations of the budget refer."""
        if name == "gravity":
            return both["gravity_size"].to_numpy(float)
        if name in OF_BRIDGES:
            return np.maximum((both["formed_own"].abs() + both["ruptured_own"].abs()).to_numpy(float), 1e-300)
        return turnover

    def check(self) -> list[Quantity]:
        """Compare the energy budget at the outputs, sampling windows excepted."""
        if not self.rows:
            return []
        both, turnover = self.both()

        def one(name: str, mine: Any, size: Any, scale: str) -> Quantity:
            logged = both[name].to_numpy(float) if name in both else np.zeros(len(both))
            return compare(
                f"energy_{name}", scale, logged, np.asarray(mine, float), np.asarray(size, float), both, LIMITS[name]
            )

        found = [one(name, both[f"{name}_own"], turnover, "all that was turned over") for name in ("kinetic", "spin")]
        found.append(one("gravity", both["gravity_own"], both["gravity_size"], "weight times way of all spheres"))
        gain = both["kinetic_own"] + both["spin_own"]
        left = gain - gain.iloc[0] - both[[*WORKS]].sum(axis=1) - both["half_kick"]
        found.append(one("budget", left, turnover, "all that was turned over"))
        if self.known:
            size = self.size("formed", both, turnover)
            found += [one(n, both[f"{n}_own"], size, "all formations and ruptures") for n in OF_BRIDGES]
            recomputed_work = both["formed_own"] - both["ruptured_own"] - both["capillary_stored_own"]
            of_events = both["formed_own"].abs() + both["ruptured_own"].abs()
            margin = both["steps"] + 1e-9 * turnover + SUMMED * of_events
            found.append(one("capillary", recomputed_work, margin, "what a sum over steps may miss"))
        return found


OF_BRIDGES = ("formed", "ruptured", "capillary_stored")
OF_STATE = ("kinetic", "spin", *OF_BRIDGES)
SUMMED = 2e-3
"""Additional relative error of a sum over steps for the energies of formations and ruptures.

It is of second order at the kink where bodies touch: at most 9.4e-4 in the stress tests (ten g, step 4e-6 s), 3e-4 in
sixty others.
"""


def powers(setup: Setup, f: Forces) -> Floats:
    """Return the power of each effect in each step of a window, shape (steps, effects) as in WORKS [W]."""
    w, count, n = f.window, len(f.window.steps), {name: k for k, name in enumerate(WORKS)}
    found = np.zeros((count, len(WORKS)))
    weight = (w.v * setup.pull(w.steps)).sum(axis=2) * w.mass
    found[:, n["gravity"]] = weight.sum(axis=1)
    t, c = f.touches, f.contacts
    terms: list[tuple[Any, ...]] = [
        ("contact", t, t.vb, c.force(t.n), c.torque_a(t.n), c.torque_b(t.n), np.ones(len(t)))
    ]
    if f.bridges is not None:
        b = f.bridges
        zero = np.zeros((len(b.k), 3))
        on = b.acting
        terms += [
            ("capillary", b, b.vb, -(b.capillary * on["capillary"])[:, None] * b.n, zero, zero, b.weight),
            ("viscous_normal", b, b.vb, (b.normal * on["viscous_normal"])[:, None] * b.n, zero, zero, b.weight),
            ("viscous_tangential", b, b.vb, b.tangential * on["viscous_tangential"], *b.torques(setup), b.weight),
        ]
    driven, all_power = ~setup.free, weight
    for name, rows, vb, force, ta, tb, times in terms:
        k, a, other = rows.k, rows.a, np.where(rows.wall, 0, rows.b)
        on_a = dot(force, w.v[k, a]) + dot(ta, w.w[k, a])
        on_b = np.where(rows.wall, 0.0, -dot(force, w.v[k, other]) + dot(tb, w.w[k, other]))
        wall = np.where(rows.wall, dot(force, vb), 0.0)
        np.add.at(found[:, n[name]], k, times * (on_a + on_b - wall))
        np.add.at(found[:, n["wall_motion"]], k, times * wall)
        if driven.any():
            np.add.at(all_power, (k, a), times * on_a)
            np.add.at(all_power, (k, other), times * on_b)
    found[:, n["drive"]] = -all_power[:, driven].sum(axis=1)
    return found


def works_in_window(setup: Setup, f: Forces) -> tuple[Floats, Floats, Floats, pd.DataFrame] | None:
    """Return the work of each effect from one step of a window to the next, logged and recomputed, its scale, and rows.

    Steps between which the engine was set up again are omitted. The error of contact work by rounding of a wall's
    position and by rolling resistance of undefined direction (`_of_rounding`) is part of the scale.
    """
    path, steps = where(setup.folder, "window_energy"), f.window.steps
    log = io.columns(path, ["step", *WORKS]).sort_values("step")
    inside = log[(log["step"] >= steps[0]) & (log["step"] <= steps[-1])]
    if setup.scene["output"].get("energy", True) and inside["step"].tolist() != steps.tolist():
        raise io.ReplayError(
            f"{path} is not whole: {len(inside)} rows from step {steps[0]} to {steps[-1]}; expected one for each step of the "
            "window: run the case again"
        )
    power, parts = powers(setup, f) if len(inside) > 1 else np.zeros((0, len(WORKS))), []
    doubt = _of_rounding(setup, f)
    for one, two in zip(inside.itertuples(index=False), inside.iloc[1:].itertuples(index=False), strict=False):
        if any(one.step <= s <= two.step for s in setup.broken):
            continue
        at = power[np.searchsorted(steps, one.step) : np.searchsorted(steps, two.step) + 1]
        expected = setup.step * 0.5 * (at[1:] + at[:-1]).sum(axis=0)
        turned = float(setup.step * 0.5 * np.abs(at[1:] + at[:-1]).sum())
        lost = setup.step * float(doubt[np.searchsorted(steps, one.step) : np.searchsorted(steps, two.step) + 1].sum())
        parts.append((two.step, [getattr(two, n) - getattr(one, n) for n in WORKS], expected, turned, lost))
    if not parts:
        return None
    rows = pd.DataFrame({"step": [p[0] for p in parts]})
    logged, expected, size, margin = (np.array([p[k] for p in parts]) for k in (1, 2, 3, 4))
    # the plugin has no forces on walls: `contact` contains both terms
    if not setup.scene["effects"].get("wall_films", True):
        contact, wall = WORKS.index("contact"), WORKS.index("wall_motion")
        for works in (logged, expected):
            works[:, contact] += works[:, wall]
            works[:, wall] = 0.0
    # the logged energy terms are differences of sums over the whole run
    least = 1e-6 * float(log[list(WORKS)].abs().to_numpy().max())
    return logged, expected, np.maximum(size, least) + margin / LIMITS["windows"], rows


def _of_rounding(setup: Setup, f: Forces) -> Floats:
    """Return the uncertainty of the contacts' power in each step [W] due to rounding.

    At walls it is due to the wall's position: the change of the normal force with the position, and of friction
    at its limit, times the speeds of both sides and of the spin. If a spin is lost in the rounding of a kick, it
    is the uncertainty of the rolling torque (dry.py) times the relative spin after the kick.
    """
    w, t, c = f.window, f.touches, f.contacts
    kinds = setup.kind[t.a], np.zeros(len(t), dtype=int)
    slope = (1.0 + setup.dry.power) * setup.dry.at(kinds, c.overlap, w.mass[t.k, t.a])[0]
    speed = arrays.size(w.v[t.k, t.a]) + arrays.size(t.vb) + setup.radius[t.a] * arrays.size(w.w[t.k, t.a])
    power = t.wall * (1.0 + setup.dry.friction[kinds]) * slope * rounding(setup) * speed
    other = np.where(t.wall, 0, t.b)
    power += c.doubt * arrays.size(w.w[t.k, t.a] - np.where(t.wall[:, None], 0.0, w.w[t.k, other]))
    return np.bincount(t.k, power, len(w.steps))


def in_window(setup: Setup, f: Forces, run: Run) -> list[Quantity]:
    """Compare the logged energy terms of a sampling window with the recomputed ones."""
    works = works_in_window(setup, f)
    if works is None:
        return []
    run.known.setdefault("works_in_windows", []).append(works)
    logged, expected, size, rows = works
    return [compare("energy_windows", "work of all effects", logged, expected, size, rows, LIMITS["windows"])]
