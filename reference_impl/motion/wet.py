"""Forces of the bridges in the windows from the trajectories: the contact log only determines which bridges act.

Positions, speeds and spins are those of the trajectory; closest points on walls and their motion are computed by the
reference. A law that cannot be recomputed (the exact bridge is solved for a sample only) is taken as logged, as in
forces.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from reference_impl.motion import impulses, nearest
from reference_impl.motion.window import Setup, Window
from reference_impl.replay import capillary, coverage, images, laws
from reference_impl.replay.arrays import Floats, cross, dot, size, vectors
from reference_impl.replay.bodies import bodies, pairs
from reference_impl.replay.implicit import relative_kick
from reference_impl.replay.io import Run
from reference_impl.replay.lives import RETIREMENT

DEFAULT = {"capillary": "rabinovich", "viscous_normal": "pitois", "viscous_tangential": "goldman"}
"""Laws by which an effect that is off is estimated."""


@dataclass(frozen=True)
class Bridges:
    """Bridges of a window, one row each, forces on a; `triangle` is the recomputed closest one, `point` the closest point."""

    table: pd.DataFrame
    k: Floats
    a: Floats
    b: Floats
    wall: Floats
    n: Floats
    gap: Floats
    point: Floats
    vb: Floats
    relative: Floats
    slip: Floats
    capillary: Floats
    normal: Floats
    tangential: Floats
    weight: Floats
    acting: dict[str, bool]

    def force(self) -> Floats:
        """Total force of a bridge on body a."""
        zero = np.zeros(len(self.k))
        pull = self.capillary if self.acting["capillary"] else zero
        drag = self.normal if self.acting["viscous_normal"] else zero
        side = self.tangential if self.acting["viscous_tangential"] else np.zeros((len(self.k), 3))
        return np.asarray((drag - pull)[:, None] * self.n + side)

    def torques(self, setup: Setup) -> tuple[Floats, Floats]:
        """Return torques on a and on b (zero at a wall)."""
        turn = cross(self.n, self.tangential) * self.acting["viscous_tangential"]
        rb = np.where(self.wall, 0.0, setup.radius[np.where(self.wall, 0, self.b)])
        return -setup.radius[self.a][:, None] * turn, -rb[:, None] * turn


def _ends(run: Run, setup: Setup, window: Window, table: pd.DataFrame) -> tuple[Floats, ...]:
    """Return for rows of a log whether they are at walls, their step and bodies, and place and velocity of the end at j."""
    wall = (table["partner_kind"] != laws.SPHERE).to_numpy()
    k = np.searchsorted(window.steps, table["step"].to_numpy())
    a = np.searchsorted(setup.ids, table["i"].to_numpy())
    b = np.where(wall, table["j"].to_numpy(), np.searchsorted(setup.ids, table["j"].to_numpy()))
    other = np.where(wall, 0, b)
    point, vb = window.x[k, other], window.v_half[k, other]
    if wall.any():
        at, parts = np.flatnonzero(wall), nearest.parts(run)
        step = window.steps[k[at]]
        point[at] = parts.closest(step, window.x[k[at], a[at]], b[at]).point
        vb[at] = parts.velocity(step, point[at], b[at])
    return wall, k, a, b, point, vb


def event_speeds(run: Run, setup: Setup, window: Window) -> tuple[Floats, Floats, Floats, pd.DataFrame]:
    """Return the speeds of the formations and ruptures in a window, logged and recomputed, their scale [m/s], and the rows.

    A retired sphere has the speed at the end of its last step.
    """
    table = run.rows("events", int(window.steps[0]), int(window.steps[-1]))
    table = table[table["kind"] != RETIREMENT].reset_index(drop=True)
    _, k, a, _, _, vb = _ends(run, setup, window, table)
    va = window.v_half[k, a]
    scale = np.maximum(np.maximum(size(va), size(vb)), 1e-3)
    return table["speed"].to_numpy(float), size(va - vb), scale, table


def of_window(run: Run, setup: Setup, window: Window) -> Bridges:
    """Recompute the forces of all bridges in one sampling window."""
    table = run.rows("contacts", int(window.steps[0]), int(window.steps[-1]))
    wall, k, a, b, point, vb = _ends(run, setup, window, table)
    other = np.where(wall, 0, b)
    d = images.of(run.folder).nearest(window.x[k, a] - point)
    apart = size(d)
    n = d / apart[:, None]
    rb = np.where(wall, 0.0, setup.radius[other])
    gap = apart - setup.radius[a] - rb
    relative = window.v_half[k, a] - vb
    spin = setup.radius[a][:, None] * window.w_half[k, a] + rb[:, None] * window.w_half[k, other]
    pull, normal, side, acting = _terms(run, table, gap, n, relative, spin)
    slip = relative - dot(relative, n)[:, None] * n - cross(spin, n)
    weight = impulses.weights(run, table)
    return Bridges(table, k, a, b, wall, n, gap, point, vb, relative, slip, pull, normal, side, weight, acting)


def _terms(
    run: Run, table: pd.DataFrame, gap: Floats, n: Floats, relative: Floats, spin: Floats
) -> tuple[Floats, Floats, Floats, dict[str, bool]]:
    """Return capillary force, normal and tangential drag along n; for an effect that is off, by its usual law."""
    p = pairs(table, bodies(run))
    volume, eta, sigma = table["volume"].to_numpy(float), run.meta["viscosity"], run.meta["surface_tension"]
    name = {effect: coverage.law(run, effect) for effect in DEFAULT}
    acting = {effect: law is not None for effect, law in name.items()}
    use = {effect: law or DEFAULT[effect] for effect, law in name.items()}
    push, spin_push = vectors(table, "push"), vectors(table, "spin_push")
    pull = table["capillary"].to_numpy(float)
    if use["capillary"] in capillary.LAWS:
        pull = capillary.LAWS[use["capillary"]](gap, volume, p.ri, p.rj, p.wall, p.ti, p.tj, sigma)
    normal, side = table["viscous_normal"].to_numpy(float), vectors(table, "viscous_tangential")
    kick = relative_kick(run, table)
    if use["viscous_normal"] in laws.VISCOUS_NORMAL:
        law = laws.VISCOUS_NORMAL[use["viscous_normal"]]
        drag = -law(gap, volume, p.ri, p.rj, p.wall, np.ones(len(gap)), eta)
        normal = -drag * (dot(relative, n) + dot(push, n)) / (1.0 + drag * kick)
    if use["viscous_tangential"] in laws.VISCOUS_TANGENTIAL:
        slide, roll = laws.VISCOUS_TANGENTIAL[use["viscous_tangential"]](gap, p.ri, p.rj, p.wall, eta)
        moved = relative + push
        sideways, turn = moved - dot(moved, n)[:, None] * n, cross(spin + spin_push, n)
        side = (roll[:, None] * turn - slide[:, None] * sideways) / (1.0 + (slide + 2.5 * roll) * kick)[:, None]
    return pull, normal, side, acting
