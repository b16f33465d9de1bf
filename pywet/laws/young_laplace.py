"""The exact bridge as laws for the engine: force and rupture distance interpolated in tables, at the cost of a closed form.

`pywet.laws.exact_bridge.table` computes and stores the tables, one for each pair of contact angles. Here they become
uniform cubic B-splines (twice continuously differentiable) in one block of memory that compiled code finds through a
directory at a fixed address; a pair of angles that was not prepared gives NaN, which stops a run. Calls from Python
prepare the tables they need.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from pywet.errors import PywetError
from pywet.laws.exact_bridge import table as tables
from pywet.laws.exact_bridge.table import U_NODES, X_FIRST, X_LAST, X_NODES, Y_NODES, axis
from pywet.laws.force_law import ForceLaw, Prepared, register
from pywet.laws.kinds import BRIDGE
from pywet.laws.memory import FAST, cube_root, floats_at, inline, ints_at, singles_at

Floats = NDArray[np.float64]
carray: Any = numba.carray  # type: ignore[attr-defined]
MOST_PAIRS = 256
"""Largest number of pairs of contact angles in one process."""
_Y, _X, _U = Y_NODES + 2, X_NODES + 2, U_NODES + 2
_X_STEP = (X_LAST - X_FIRST) / (X_NODES - 1)
_HEAD = 3
"""Number of values at the start of a block: first node of y, nodes per unit of y, and π (cos θ_s + cos θ_l)."""
_V_FIRST = math.exp(X_FIRST)
_ANGLES = np.full((MOST_PAIRS, 2), np.nan)
_BLOCKS = np.zeros(MOST_PAIRS + 1, dtype=np.int64)
"""Address of each pair's block; the last entry is the number of blocks."""
_KEEP: list[Floats] = []
_HELD = 16
"""Number of prepared numbers of a bridge, two cache lines: 1/S_rup, F_0/σ at touch and, in single precision (1e-7 of the
force), its spline over u. The sums over volume and radius ratio are evaluated once per bridge."""


def prepare(angles: Iterable[tuple[float, float]], progress: Callable[[int, int], None] | None = None) -> None:
    """Load or build the tables of these pairs (contact angle of the smaller body, of the larger) [rad]."""
    for small, large in angles:
        count = int(_BLOCKS[MOST_PAIRS])
        if (_ANGLES[:count] == (small, large)).all(axis=1).any():
            continue
        if count == MOST_PAIRS:
            raise PywetError(
                f"more than {MOST_PAIRS} pairs of contact angles given to the law young_laplace; expected fewer materials, "
                "or another capillary law",
                code="law.many_angles", expected=MOST_PAIRS,
            )  # fmt: skip
        held = tables.load(float(small), float(large), progress)
        y = axis(held.balance)
        values = [_spline(v).ravel() for v in (held.balance, held.rupture, held.ratio)]
        head = [y[0], (Y_NODES - 1) / (y[-1] - y[0]), math.pi * (math.cos(small) + math.cos(large))]
        block = np.concatenate([head, *values])
        _KEEP.append(block)
        _ANGLES[count] = small, large
        _BLOCKS[count] = block.ctypes.data
        _BLOCKS[MOST_PAIRS] = count + 1


def _spline(values: Floats) -> Floats:
    """Return the coefficients of the uniform cubic B-spline along every axis (not-a-knot ends); each axis grows by 2.

    If a spline is a cubic p, its coefficients are p − p''/6 at the nodes; the first and last are one node outside.
    """
    from scipy.interpolate import CubicSpline

    for k in range(values.ndim):
        nodes = np.arange(-1.0, values.shape[k] + 1)
        through = CubicSpline(nodes[1:-1], values, axis=k)
        values = through(nodes) - through(nodes, 2) / 6.0
    return np.ascontiguousarray(values)


_ANGLES_AT, _BLOCKS_AT = (a.ctypes.data for a in (_ANGLES, _BLOCKS))


@inline
def _block(small, large):  # type: ignore[no-untyped-def]
    """Return the address of the block of a pair of angles, 0 if it was not prepared."""
    angles = floats_at(_ANGLES_AT)
    blocks = ints_at(_BLOCKS_AT)
    for k in range(blocks[MOST_PAIRS]):
        if angles[2 * k] == small and angles[2 * k + 1] == large:
            return blocks[k]
    return 0


@inline
def _cell(t, last):  # type: ignore[no-untyped-def]
    """Return cell and weights of the uniform cubic B-spline at t, nodes 0 … last."""
    k = min(max(int(t), 0), last - 1)
    w = t - k
    v = 1.0 - w
    w3 = w * w * w
    v3 = v * v * v
    return k, v3 / 6.0, (4.0 - 6.0 * w * w + 3.0 * w3) / 6.0, (4.0 - 6.0 * v * v + 3.0 * v3) / 6.0, w3 / 6.0


@inline
def _order(radius_i, radius_j, contact_angle_i, contact_angle_j):  # type: ignore[no-untyped-def]
    """Return radius ratio q, harmonic mean (2 r at a plate) and the contact angles of the smaller and the larger body."""
    if math.isinf(radius_j):
        return 0.0, 2.0 * radius_i, contact_angle_i, contact_angle_j
    r = 2.0 * radius_i * radius_j / (radius_i + radius_j)
    if radius_i <= radius_j:
        return radius_i / radius_j, r, contact_angle_i, contact_angle_j
    return radius_j / radius_i, r, contact_angle_j, contact_angle_i


@inline
def _along(data, at, x0, x1, x2, x3):  # type: ignore[no-untyped-def]
    """Sum of four successive coefficients of a spline with their weights."""
    return x0 * data[at] + x1 * data[at + 1] + x2 * data[at + 2] + x3 * data[at + 3]


@inline
def _place(data, q, kx, x0, x1, x2, x3):  # type: ignore[no-untyped-def]
    """Return the position of the radius ratio on the axis y, in nodes."""
    return (cube_root(q - _along(data, _HEAD + kx, x0, x1, x2, x3)) - data[0]) * data[1]


@inline
def _rupture(data, ky, y0, y1, y2, y3, kx, x0, x1, x2, x3):  # type: ignore[no-untyped-def]
    """Evaluate S_rup/(r_eff √V*) by the spline."""
    at = _HEAD + (1 + ky) * _X + kx
    a0 = a1 = a2 = a3 = 0.0  # four independent sums, which the processor adds in one instruction
    for weight in (y0, y1, y2, y3):
        a0 += weight * data[at]
        a1 += weight * data[at + 1]
        a2 += weight * data[at + 2]
        a3 += weight * data[at + 3]
        at += _X
    return x0 * a0 + x1 * a1 + x2 * a2 + x3 * a3


@numba.njit(error_model="numpy", fastmath=FAST)
def _hold(volume, radius_i, radius_j, contact_angle_i, contact_angle_j, held):  # type: ignore[no-untyped-def]
    """Fill in the prepared numbers of a bridge; NaN if its angles were not prepared."""
    q, r, small, large = _order(radius_i, radius_j, contact_angle_i, contact_angle_j)
    address = _block(small, large)
    if address == 0 or volume <= 0.0:
        held[:] = math.nan
        return
    data = floats_at(address)
    _, kx, x0, x1, x2, x3, scale = _volume(volume, r)
    ky, y0, y1, y2, y3 = _cell(_place(data, q, kx, x0, x1, x2, x3), Y_NODES - 1)
    rupture = scale * _rupture(data, ky, y0, y1, y2, y3, kx, x0, x1, x2, x3)
    sums = np.zeros(_U)
    row = _HEAD + (1 + _Y) * _X + (ky * _X + kx) * _U
    for wy in (y0, y1, y2, y3):
        at = row
        for wx in (x0, x1, x2, x3):
            weight = wy * wx
            for n in range(_U):
                sums[n] += weight * data[at + n]
            at += _U
        row += _X * _U
    held[0], held[1] = 1.0 / rupture, r * data[2]
    spline = held.view(np.float32)
    for n in range(_U):
        spline[4 + n] = sums[n]


def _hold_at(volume, radius_i, radius_j, contact_angle_i, contact_angle_j, address):  # type: ignore[no-untyped-def]
    _hold(volume, radius_i, radius_j, contact_angle_i, contact_angle_j, carray(address, _HELD))


@inline
def _held_force(separation, volume, radius_i, radius_j, surface_tension, held, spline):  # type: ignore[no-untyped-def]
    """Return the capillary force from the numbers prepared for a bridge, without branches in the compiled code."""
    r = 2.0 * radius_i if math.isinf(radius_j) else 2.0 * radius_i * radius_j / (radius_i + radius_j)
    ring = 2.0 * min(volume / (r * r * r), 0.5) * r * r / math.pi
    s = max(separation, 0.0)
    share = s * held[0]
    s = s if share < 1.0 else s / share
    k, u0, u1, u2, u3 = _cell(math.sqrt(max(1.0 - share, 0.0)) * (U_NODES - 1), U_NODES - 1)
    ratio = u0 * spline[k + 4] + u1 * spline[k + 5] + u2 * spline[k + 6] + u3 * spline[k + 7]
    return surface_tension * held[1] * ratio * ring / (ring + s * (s + math.sqrt(s * s + ring)))


def _evaluate(separation, volume, radius_i, radius_j, ti, tj, surface_tension, address):  # type: ignore[no-untyped-def]
    return _held_force(separation, volume, radius_i, radius_j, surface_tension, floats_at(address), singles_at(address))


@inline
def _volume(volume, r):  # type: ignore[no-untyped-def]
    """Return V* limited to the table, its cell and weights on the axis x, and r √V* (below the table by its known limit)."""
    v = min(volume / (r * r * r), 0.5)
    x = (math.log(v) - X_FIRST) / _X_STEP
    scale = r * math.sqrt(v)
    if x < 0.0:
        scale *= (_V_FIRST / v) ** (1.0 / 6.0)
        x = 0.0
    k, x0, x1, x2, x3 = _cell(x, X_NODES - 1)
    return v, k, x0, x1, x2, x3, scale


def _force(
    separation: float,
    volume: float,
    radius_i: float,
    radius_j: float,
    contact_angle_i: float,
    contact_angle_j: float,
    surface_tension: float,
) -> float:
    """The exact capillary force (axisymmetric Young-Laplace without gravity, stable branch), interpolated.

    Parameters
    ----------
    separation : float or array
        Gap S between the surfaces [m]; negative in overlap.
    volume : float or array
        Volume V of the bridge [m³].
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    contact_angle_i : float or array
        Contact angle on body i [rad].
    contact_angle_j : float or array
        Contact angle on body j [rad].
    surface_tension : float or array
        Surface tension σ [N/m].

    Returns
    -------
    float or array
        Attraction F [N].

    Notes
    -----
    Radius convention: V* = V/r_eff³ with the harmonic mean r_eff (2 r_i at a plate). Valid for 1e-9 ≤ V* ≤ 0.5 and
    contact angles below 90°; a larger volume counts as V* = 0.5, for a smaller one the known limit is approached. S ≤
    0: the force at touch. Beyond the rupture distance (dynamic rupture comes later): the force there.

    References
    ----------
    the exact solution, `pywet.laws.exact_bridge`; errors of the interpolation are in docs/young_laplace.md.

    Examples
    --------
    >>> f"{young_laplace(0.0, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07):.4e}"
    '3.8898e-04'
    """
    if volume <= 0.0:
        r = _order(radius_i, radius_j, contact_angle_i, contact_angle_j)[1]
        cosines = math.cos(contact_angle_i) + math.cos(contact_angle_j)
        return math.pi * surface_tension * r * cosines if separation <= 0.0 else 0.0
    held = np.empty(_HELD)
    _hold(volume, radius_i, radius_j, contact_angle_i, contact_angle_j, held)
    return _held_force(separation, volume, radius_i, radius_j, surface_tension, held, held.view(np.float32))


def _distance(volume: float, radius_i: float, radius_j: float, contact_angle_i: float, contact_angle_j: float) -> float:
    """The exact static rupture distance: the limit of stability of the Young-Laplace bridge, interpolated.

    Parameters
    ----------
    volume : float or array
        Volume V of the bridge [m³].
    radius_i : float or array
        Radius of sphere i [m].
    radius_j : float or array
        Radius of body j [m]; infinite at a wall.
    contact_angle_i : float or array
        Contact angle on body i [rad].
    contact_angle_j : float or array
        Contact angle on body j [rad].

    Returns
    -------
    float or array
        Static rupture distance S_rup [m].

    Notes
    -----
    A fold, or for equal bodies with contact angles above about 30° the loss of symmetry shortly before it.

    Radius convention and range as the force `young_laplace`.

    References
    ----------
    the exact solution, `pywet.laws.exact_bridge`.

    Examples
    --------
    >>> f"{young_laplace_rupture(1e-11, 1e-3, 1e-3, 0.0, 0.0):.4e}"
    '2.1905e-04'
    """
    q, r, small, large = _order(radius_i, radius_j, contact_angle_i, contact_angle_j)
    if volume <= 0.0:
        return 0.0
    address = _block(small, large)
    if address == 0:
        return math.nan
    data = floats_at(address)
    _, kx, x0, x1, x2, x3, scale = _volume(volume, r)
    ky, y0, y1, y2, y3 = _cell(_place(data, q, kx, x0, x1, x2, x3), Y_NODES - 1)
    return scale * _rupture(data, ky, y0, y1, y2, y3, kx, x0, x1, x2, x3)


class TableLaw(ForceLaw):
    """A law that reads prepared tables; calls from Python prepare the tables they need."""

    cached = False
    fastmath = FAST

    def __init__(self, function: Callable[..., float], name: str) -> None:
        super().__init__(function)
        self.name = self.__name__ = name

    tabulated = True

    def tables(self, arguments: Mapping[str, Any]) -> None:
        """Prepare the tables of the contact angles of these bodies; a caller without them gets no tables."""
        if not set(BRIDGE[1:]) <= set(arguments):
            return
        ri, rj, ti, tj = np.broadcast_arrays(*(np.asarray(arguments[n], float) for n in BRIDGE[1:]))
        swap = ri > rj
        small, large = np.where(swap, tj, ti), np.where(swap, ti, tj)
        prepare(set(zip(small.ravel(), large.ravel(), strict=True)))


young_laplace = TableLaw(_force, "young_laplace")
young_laplace.prepared = Prepared(_HELD // 8, _hold_at, _evaluate)
young_laplace_rupture = TableLaw(_distance, "young_laplace_rupture")
register("capillary", "young_laplace", young_laplace)
register("rupture", "young_laplace", young_laplace_rupture)
