"""Dry contact, implemented independently: normal spring and dashpot, tangential spring with friction, rolling resistance (E 3-5).

Conventions are those of the engine: the dashpot also acts in attraction; friction is limited by the whole normal force,
rolling by its elastic part; lever arms extend to the middle of the overlap; the tangential spring is rotated into the present
tangent plane. Friction without history is a drag c v up to the same limit. Springs and dashpots are constant, or those of Hertz
and Mindlin at the present overlap (`window.Dry`); a Hertz contact that does not slide also has a tangential dashpot, which the
limit omits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference_impl.motion.touching import Touches
from reference_impl.motion.window import Setup, Window
from reference_impl.replay.arrays import Floats, cross, dot, size

AT_LIMIT = 1e-11
"""Share of the spring's limit within which a logged spring counts as limited by friction."""


@dataclass(frozen=True)
class Contacts:
    """Forces on a (b has the opposite), torques on both; `slid`: reduction of the spring by friction [m]."""

    elastic: Floats
    damping: Floats
    tangential: Floats
    spring: Floats
    slid: Floats
    overlap: Floats
    vn: Floats
    slip: Floats
    arm_a: Floats
    arm_b: Floats
    rolling: Floats
    """Torque on a [N m]; b has the opposite."""
    lost: Floats
    """Power dissipated by friction and the tangential dashpot [W]."""
    doubt: Floats
    """Uncertainty of the rolling torque [N m], since a spin that is lost in the rounding of the step's kick has no direction."""

    def force(self, n: Floats) -> Floats:
        """Total force of a dry contact on body a."""
        return np.asarray((self.elastic + self.damping)[:, None] * n + self.tangential)

    def torque_a(self, n: Floats) -> Floats:
        """Total torque of a dry contact on body a."""
        return np.asarray(-self.arm_a[:, None] * cross(n, self.tangential) + self.rolling)

    def torque_b(self, n: Floats) -> Floats:
        """Total torque of a dry contact on body b."""
        return np.asarray(-self.arm_b[:, None] * cross(n, self.tangential) - self.rolling)


def contacts(setup: Setup, window: Window, t: Touches, before: Floats, given: Floats | None = None) -> Contacts:
    """Compute all contacts of a window; `before`: springs of the previous step, `given`: rows that have the present one."""
    kinds = setup.kind[t.a], np.where(t.wall, 0, setup.kind[np.where(t.wall, 0, t.b)])
    mu, length, drag = (getattr(setup.dry, name)[kinds] for name in ("friction", "rolling", "drag"))
    partner = np.where(t.wall, 0, t.b)
    ra, rb = setup.radius[t.a], np.where(t.wall, 0.0, setup.radius[partner])
    wa, wb = window.w_half[t.k, t.a], np.where(t.wall[:, None], 0.0, window.w_half[t.k, partner])
    overlap = ra + rb - t.apart
    ma, mb = window.mass[t.k, t.a], np.where(t.wall, np.inf, window.mass[t.k, partner])
    kn, kt, gamma, gamma_side = setup.dry.at(kinds, overlap, ma / (1.0 + ma / mb))
    relative = window.v_half[t.k, t.a] - t.vb
    vn = dot(relative, t.n)
    arm_a, arm_b = ra - 0.5 * overlap, np.where(t.wall, 0.0, rb - 0.5 * overlap)
    slip = relative - vn[:, None] * t.n - cross(arm_a[:, None] * wa + arm_b[:, None] * wb, t.n)
    elastic, damping = kn * overlap, -gamma * vn
    moved = before + slip * setup.step
    moved = moved - dot(moved, t.n)[:, None] * t.n
    if given is not None:
        moved = np.where(given[:, None], before, moved)
    stretch, grip = size(moved), mu * np.abs(elastic + damping) / np.maximum(kt, 1e-300)
    slides = stretch > grip
    share = np.where(slides, grip / np.maximum(stretch, 1e-300), 1.0)
    spring = share[:, None] * moved
    # a logged spring that slides is at the friction limit to round-off
    at_limit = slides if given is None else slides | (given & (stretch >= (1.0 - AT_LIMIT) * grip))
    dashpot = np.where(at_limit, 0.0, gamma_side)
    slid, side = (1.0 - share) * stretch, -kt[:, None] * spring - dashpot[:, None] * slip
    if not setup.memory:
        rate = size(slip)
        grip = np.minimum(drag, mu * np.abs(elastic + damping) / np.maximum(rate, 1e-300))
        slid, side, spring = rate * setup.step, -grip[:, None] * slip, np.zeros_like(slip)
    lost = size(side) * slid / setup.step + dashpot * dot(slip, slip)
    turn = np.where(t.wall[:, None], wa, wa - wb)
    rate = size(turn)
    direction = turn / np.where(rate > 0.0, rate, 1.0)[:, None]
    direction = direction - dot(direction, t.n)[:, None] * t.n
    rolling = -(length * elastic)[:, None] * direction
    margin = window.w_margin[t.k, t.a] + np.where(t.wall, 0.0, window.w_margin[t.k, partner])
    doubt = np.abs(length * elastic) * np.minimum(2.0, margin / np.maximum(rate, 1e-300))
    return Contacts(
        elastic, damping, side, spring, slid, overlap, vn, slip, arm_a, arm_b, rolling, lost, doubt
    )  # fmt: skip
