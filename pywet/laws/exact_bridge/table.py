"""The exact force, rupture distance and split as tables over radius ratio, volume and separation, per pair of contact angles.

Axes, equally spaced: x = ln V*, V* = V/r_eff³ with r_eff the harmonic mean (2 r at a plate); u = √(1 − S/S_rup), in
which the fold is smooth; y = (q − q*(x))^(1/3) with q the smaller over the larger radius (0: plate). At q* size and
wetting balance, and the bridge may break at either body (equal bodies: q* = 1); there S_rup has a cusp |q − q*|^(2/3)
and the split an infinite slope, both smooth in y. The tables contain S_rup/(r_eff √V*), the share of the liquid that
remains on the smaller body, and G = F/F_0 with F_0 = π σ r_eff (cos θ_s + cos θ_l)/(1 + S/(2d)), the law `lambert`,
which is exact for little liquid. Contact angles are not interpolated: a scene has few of them.

Tables are computed once and stored in the user's cache; the compiled interpolation for engines is in
`pywet/laws/young_laplace.py`.
"""

from __future__ import annotations

import hashlib
import math
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pywet.errors import PywetError
from pywet.laws.capillary import lambert
from pywet.laws.exact_bridge import branch
from pywet.laws.exact_bridge.meridian import GAP, PHI_I, PHI_J, Case, Floats, jit, start
from pywet.laws.exact_bridge.split import parts
from pywet.util import caches
from pywet.util.files import atomic_write
from pywet.util.machine_code import numba

Y_NODES, X_NODES, U_NODES = 81, 55, 25
SOLVED, EXACT, FURTHEST, DEEPEST = 0.5, 0.15, 0.4, 0.6
"""Distances outside 0 … 1: up to which q* is solved, up to which it is stored unchanged, its limit, and the limit of q itself."""
BEYOND, AROUND = 4, 3
"""Nodes of y solved beyond q = 0 and q = 1, and neighbouring nodes of x with joined ranges, needed by the spline."""
X_FIRST, X_LAST = math.log(1e-9), math.log(0.5)
"""Range of ln V*; below it the scaled quantities equal those at its lower end, above it the volume is limited to 0.5 r_eff³."""
VERSION = 1
"""Version in the cache's key; to be increased with any change of the numbers beyond the round-off of a solution (1e-9)."""
NAMES = ("balance", "rupture", "share", "ratio")


@dataclass(frozen=True)
class Table:
    """Values at the nodes for one ordered pair of contact angles (smaller body, larger body) [rad]."""

    theta_small: float
    theta_large: float
    balance: Floats
    """Balanced radius ratio q*, shape (X,)."""
    rupture: Floats
    """Scaled rupture distance S_rup/(r_eff √V*), shape (Y, X)."""
    share: Floats
    """Share of the liquid that remains on the smaller body, shape (Y, X)."""
    ratio: Floats
    """Scaled force F/F_0, shape (Y, X, U)."""


def axis(balance: Floats) -> Floats:
    """Return the nodes of y: all values for 0 ≤ q ≤ 1 at any volume, and a few beyond."""
    first, last = np.cbrt(-balance).min(), np.cbrt(1.0 - balance).max()
    step = (last - first) / (Y_NODES - 1 - 2 * BEYOND)
    y: Floats = first + step * (np.arange(Y_NODES) - BEYOND)
    return y


def needed(balance: Floats) -> list[tuple[int, int]]:
    """Return half-open ranges of the nodes of y needed at each node of x.

    Beyond the plate q = q* + y³ is negative: the larger body is concave. Beyond q = 1 the "smaller" body is the
    larger.
    """
    y3 = axis(balance) ** 3
    ends = [np.flatnonzero((b + y3 > -1e-9) & (b + y3 < 1.0 + 1e-9))[[0, -1]] for b in balance]
    ranges = []
    for k, b in enumerate(balance):
        near = np.array(ends[max(k - AROUND, 0) : k + AROUND + 1])
        allowed = np.flatnonzero((b + y3 > -DEEPEST) & (b + y3 < 1.0 + DEEPEST))
        first, last = max(near[:, 0].min() - BEYOND, allowed[0]), min(near[:, 1].max() + BEYOND, allowed[-1])
        ranges.append((int(first), int(last) + 1))
    return ranges


def volumes() -> Floats:
    """Return V* at the nodes of x."""
    return np.exp(np.linspace(X_FIRST, X_LAST, X_NODES))


neck_force = numba.njit(error_model="numpy")(lambert.python)
"""Force scale F_0 of the law `lambert`."""


@jit
def case_of(q: float, v_star: float, ti: float, tj: float, symmetric: bool) -> Case:
    """Return the case of a bridge between radii 1 and 1/q."""
    return Case(v_star * (2.0 / (1.0 + q)) ** 3, 1.0, math.inf if q == 0.0 else 1.0 / q, ti, tj, symmetric)


@jit
def leans(q: float, v_star: float, ti: float, tj: float) -> float:
    """Return a positive number if the smaller body's contact line outgrows the other's at rupture; 0 if not known."""
    kind, points = branch.follow(case_of(q, v_star, ti, tj, q == 1.0 and ti == tj), math.inf)
    if kind == branch.LOST:
        return 0.0
    c, end = case_of(q, v_star, ti, tj, False), points[-1]
    before = (end - points[-2]) / np.abs(end)
    tangent, _ = branch.tangent_of(end, c, before)
    return tangent[PHI_I] - math.copysign(1.0, c.rj) * tangent[PHI_J]


@jit
def balance_at(v_star: float, ti: float, tj: float) -> float:
    """Return q* of a volume, by bisection; nan if the bridge always breaks at the same body."""
    low, high = -SOLVED, 1.0 + SOLVED
    at_low, at_high = leans(low, v_star, ti, tj), leans(high, v_star, ti, tj)
    while at_low == 0.0 and low < -0.01:  # no bridge exists in so deep a cavity
        low *= 0.5
        at_low = leans(low, v_star, ti, tj)
    while at_high == 0.0 and high > 1.01:
        high = 1.0 + 0.5 * (high - 1.0)
        at_high = leans(high, v_star, ti, tj)
    if at_low * at_high >= 0.0:
        return math.nan
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        if leans(middle, v_star, ti, tj) * at_low > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def balances(theta_small: float, theta_large: float) -> Floats:
    """Return q* at the nodes of x: solved within the solvable range, extended smoothly from there to its ends."""
    v_star = volumes()
    if theta_small == theta_large:
        return np.ones(X_NODES)
    balance = np.array([balance_at(v, theta_small, theta_large) for v in v_star])
    known = np.flatnonzero(np.isfinite(balance))
    if len(known) < 2:
        return np.full(X_NODES, -FURTHEST if theta_small < theta_large else 1.0 + FURTHEST)
    first, last = known[0], known[-1]
    k = np.arange(X_NODES)
    balance[:first] = balance[first] + (k[:first] - first) * (balance[first + 1] - balance[first])
    balance[last + 1 :] = balance[last] + (k[last + 1 :] - last) * (balance[last] - balance[last - 1])
    return _saturate(balance - 1.0) + 1.0 if balance[first] > 0.5 and balance[last] > 0.5 else -_saturate(-balance)


def _saturate(excess: Floats) -> Floats:
    """Return the argument up to EXACT, and from there a smooth (twice differentiable) approach to FURTHEST."""
    margin = FURTHEST - EXACT
    return np.where(excess <= EXACT, excess, EXACT + margin * np.tanh((excess - EXACT) / margin))


@jit
def fill(q: float, v_star: float, ti: float, tj: float, u: Floats, ratio: Floats) -> tuple[float, float]:
    """Return force ratios over u for one radius ratio and volume, scaled rupture distance and share; nan after a failure."""
    c, r = case_of(q, v_star, ti, tj, q == 1.0 and ti == tj), 2.0 / (1.0 + q)
    kind, points = branch.follow(c, math.inf)
    if kind == branch.LOST:
        return math.nan, math.nan
    end = points[-1]
    last = end[GAP]
    of_i, other = parts(end, c)
    m = 1
    for n in range(u.size - 1, -1, -1):  # from contact to rupture
        gap = last * (1.0 - u[n] * u[n])
        while m < points.shape[0] - 1 and points[m, GAP] < gap:
            m += 1
        ok, state = True, points[0] if n == u.size - 1 else end
        if 0 < n < u.size - 1:
            ok, state = branch.between(points[m - 1], points[m], gap, last, c)
        ratio[n] = 2.0 * math.pi * start(state, c)[3] / neck_force(gap, c.volume, c.ri, c.rj, ti, tj, 1.0)
        if not ok:
            return math.nan, math.nan
    return last / (r * math.sqrt(v_star)), of_i / (of_i + other)


def build(theta_small: float, theta_large: float, progress: Callable[[int, int], None] | None = None) -> Table:
    """Solve all nodes for a pair of contact angles [rad]; `progress(done, all)` is called after each volume."""
    for angle in (theta_small, theta_large):
        if not 0.0 <= angle < math.pi / 2:
            raise PywetError(
                f"contact angle of {math.degrees(angle):g} deg given to the exact bridge; expected 0 to below 90 deg",
                code="bridge.table_angle", given=angle,
            )  # fmt: skip
    v_star, u = volumes(), np.linspace(0.0, 1.0, U_NODES)
    balance = balances(theta_small, theta_large)
    rupture, share = np.empty((Y_NODES, X_NODES)), np.empty((Y_NODES, X_NODES))
    ratio = np.empty((Y_NODES, X_NODES, U_NODES))
    y3 = axis(balance) ** 3
    for k, (first, end) in enumerate(needed(balance)):
        for m in range(first, end):
            q = balance[k] + y3[m]
            q = 1.0 if abs(q - 1.0) < 1e-12 else q
            rupture[m, k], share[m, k] = fill(q, v_star[k], theta_small, theta_large, u, ratio[m, k])
        for values in (rupture[:, k], share[:, k], ratio[:, k]):
            _continue(values, first, end)
        if progress:
            progress(k + 1, X_NODES)
    if not np.isfinite(rupture).all():
        raise PywetError(
            f"{np.isnan(rupture).sum()} nodes of the exact bridge's table could not be solved for contact angles "
            f"{math.degrees(theta_small):g} and {math.degrees(theta_large):g} deg; expected none",
            code="bridge.table_nodes",
        )
    return Table(theta_small, theta_large, balance, rupture, share, ratio)


def _continue(values: Floats, first: int, end: int) -> None:
    """Extrapolate a parabola into the nodes that are not needed, so that they do not disturb the spline inside."""
    for m in range(first - 1, -1, -1):
        values[m] = 3.0 * values[m + 1] - 3.0 * values[m + 2] + values[m + 3] if m > first - 4 else values[m + 1]
    for m in range(end, len(values)):
        values[m] = 3.0 * values[m - 1] - 3.0 * values[m - 2] + values[m - 3] if m < end + 3 else values[m - 1]


def _read(path: Path) -> list[Floats] | None:
    """Read the arrays of a file of the cache; None if it is missing or damaged, so that the table is computed again."""
    shapes = ((X_NODES,), (Y_NODES, X_NODES), (Y_NODES, X_NODES), (Y_NODES, X_NODES, U_NODES))
    try:
        with np.load(path) as file:
            held = [file[name] for name in NAMES]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
        return None
    whole = all(v.shape == shape and np.isfinite(v).all() for v, shape in zip(held, shapes, strict=True))
    return held if whole else None


def load(theta_small: float, theta_large: float, progress: Callable[[int, int], None] | None = None) -> Table:
    """Return the table from the cache, or compute and store it; a damaged file is replaced.

    Angles that differ by less than 5e-13 rad, such as by conversion from degrees, share one table: its error is
    1e-9.
    """
    angles = f"{theta_small:.12f} {theta_large:.12f}"
    key = f"{VERSION} {Y_NODES} {X_NODES} {U_NODES} {BEYOND} {AROUND} {X_FIRST!r} {X_LAST!r} {angles}"
    path = caches.folder() / f"young_laplace-{hashlib.sha256(key.encode()).hexdigest()[:16]}.npz"
    if held := _read(path):
        return Table(theta_small, theta_large, *held)
    with caches.alone(path):
        if held := _read(path):
            return Table(theta_small, theta_large, *held)
        table = build(theta_small, theta_large, progress)
        with atomic_write(path) as temporary, temporary.open("wb") as stream:
            np.savez(stream, **{name: getattr(table, name) for name in NAMES})
    return table
