"""Follows the stable branch of a bridge: Newton's method, continuation in volume and separation, the limit of stability.

The branch starts at touching bodies and ends at the first zero of the Jacobian's determinant: a fold, or for equal bodies of
large contact angle the loss of symmetry shortly before it. A negative r_j is a hollow (its φ_j is negative too): tables need
points a little beyond the plate. All compiled; the user's functions are in `bridge.py`.
"""

from __future__ import annotations

import math

import numpy as np

from pywet.laws.exact_bridge.linear import determinant, solve_linear
from pywet.laws.exact_bridge.meridian import CURVATURE, GAP, LENGTH, PHI_I, PHI_J, Floats, antisymmetric, jit, residual

FOLD, ASYMMETRY, LOST = 0, 1, 2
"""How a branch ended; LOST: the continuation failed."""
MOST_POINTS = 400
FIRST_VOLUME = 1e-9
"""Volume in units of the smaller radius cubed from which the march in volume starts."""


@jit
def scales(y: Floats, out: Floats) -> None:
    """Natural size of each unknown near y, so that steps are relative."""
    out[PHI_I], out[PHI_J] = abs(y[PHI_I]), abs(y[PHI_J])
    out[LENGTH] = abs(y[LENGTH])
    out[CURVATURE] = max(abs(y[CURVATURE]), 1.0 / abs(y[LENGTH]))
    out[GAP] = abs(y[LENGTH])


@jit
def jacobian(
    y: Floats, volume: float, ri: float, rj: float, ti: float, tj: float, symmetric: bool, d: Floats, out: Floats
) -> None:
    """4 × 5 matrix of the residual's derivatives by the scaled unknowns, central differences."""
    plus, minus, trial = np.empty(4), np.empty(4), y.copy()
    for k in range(4):
        step = 3e-6 * d[k]
        trial[k] = y[k] + step
        residual(trial, volume, ri, rj, ti, tj, symmetric, plus)
        trial[k] = y[k] - step
        residual(trial, volume, ri, rj, ti, tj, symmetric, minus)
        trial[k] = y[k]
        for m in range(4):
            out[m, k] = (plus[m] - minus[m]) / 6e-6
    for m in range(4):
        out[m, GAP] = 0.0
    out[2, GAP] = -d[GAP] / y[LENGTH]


@jit
def correct(
    y: Floats,
    volume: float,
    ri: float,
    rj: float,
    ti: float,
    tj: float,
    symmetric: bool,
    tangent: Floats,
    most: int,
) -> int:
    """Newton's method on the bridge at fixed separation (tangent of size 0) or across the plane normal to `tangent`.

    Changes y in place; returns the iterations used, −1 when it did not converge.
    """
    along = tangent.size == 5
    n = 5 if along else 4
    d, jac, out = np.empty(5), np.empty((4, 5)), np.empty(4)
    scales(y, d)
    last = math.inf
    for iteration in range(most):
        residual(y, volume, ri, rj, ti, tj, symmetric, out)
        size = np.abs(out).max()
        if not math.isfinite(size) or size > 1e3:
            return -1
        if size < 1e-13 or (size < 2e-12 and size >= 0.5 * last):
            return iteration
        last = size
        jacobian(y, volume, ri, rj, ti, tj, symmetric, d, jac)
        matrix, right = np.zeros((n, n)), np.zeros(n)
        matrix[:4, :n] = jac[:, :n]
        right[:4] = -out
        if along:
            matrix[4, :] = tangent
        if not solve_linear(matrix, right):
            return -1
        step = min(1.0, 0.3 / max(np.abs(right).max(), 1e-300))
        for k in range(n):
            y[k] += step * right[k] * d[k]
        if y[LENGTH] <= 0.0 or y[PHI_I] <= 0.0 or y[PHI_J] * rj <= 0.0:
            return -1
    return most if last < 1e-10 else -1


@jit
def guess(volume: float, ri: float, rj: float, ti: float, tj: float) -> Floats:
    """Toroidal ring between touching bodies, good for small volumes."""
    reduced = ri if math.isinf(rj) else ri * rj / (ri + rj)
    rho = (4.0 * reduced * volume / math.pi) ** 0.25
    height = rho * rho / (2.0 * reduced)
    phi_i = rho / ri
    phi_j = rho if math.isinf(rj) else rho / rj
    opening = math.cos(ti + phi_i) + math.cos(tj if math.isinf(rj) else tj + phi_j)
    angle = math.pi - ti - tj - phi_i - (0.0 if math.isinf(rj) else phi_j)
    length = height * (0.5 * angle / math.sin(0.5 * angle) if abs(angle) > 1e-6 else 1.0)
    return np.array([phi_i, phi_j, 0.5 * (1.0 / rho - opening / height), length, 0.0])


@jit
def touching(volume: float, ri: float, rj: float, ti: float, tj: float, symmetric: bool) -> tuple[bool, Floats]:
    """The bridge between touching bodies, by a march in volume from a thin ring."""
    none = np.empty(0)
    smaller = min(ri, abs(rj))
    v = min(volume, FIRST_VOLUME * smaller**3)
    y = guess(v, ri, rj, ti, tj)
    if correct(y, v, ri, rj, ti, tj, symmetric, none, 60) < 0:
        return False, y
    factor = 4.0
    while v < volume:
        grown = min(v * factor, volume)
        trial = grow(y, grown / v)
        if correct(trial, grown, ri, rj, ti, tj, symmetric, none, 12) < 0:
            factor = math.sqrt(factor)
            if factor < 1.001:
                return False, y
            continue
        y, v = trial, grown
    return True, y


@jit
def grow(y: Floats, factor: float) -> Floats:
    """Prediction of a touching bridge of another volume: φ ~ V^¼, length ~ V^½, H ~ V^−½."""
    root = math.sqrt(math.sqrt(factor))
    out = y.copy()
    out[PHI_I] *= root
    out[PHI_J] *= root
    out[LENGTH] *= root * root
    out[CURVATURE] /= root * root
    return out


@jit
def tangent_of(
    y: Floats, volume: float, ri: float, rj: float, ti: float, tj: float, symmetric: bool, before: Floats
) -> tuple[Floats, float]:
    """Unit tangent of the branch in scaled unknowns, pointing like `before`, and the determinant there."""
    d, jac = np.empty(5), np.empty((4, 5))
    scales(y, d)
    jacobian(y, volume, ri, rj, ti, tj, symmetric, d, jac)
    matrix, right = np.zeros((5, 5)), np.zeros(5)
    matrix[:4, :] = jac
    matrix[4, :] = before
    right[4] = 1.0
    if not solve_linear(matrix, right):
        return before, 0.0
    return right / math.sqrt((right * right).sum()), determinant(jac)


@jit
def step_along(
    y: Floats,
    size: float,
    tangent: Floats,
    volume: float,
    ri: float,
    rj: float,
    ti: float,
    tj: float,
    symmetric: bool,
) -> tuple[int, Floats]:
    """One predicted and corrected step of the continuation."""
    d = np.empty(5)
    scales(y, d)
    trial = y + size * tangent * d
    if trial[LENGTH] <= 0.0 or trial[PHI_I] <= 0.0 or trial[PHI_J] * rj <= 0.0:
        return -1, trial
    return correct(trial, volume, ri, rj, ti, tj, symmetric, tangent, 8), trial


@jit
def indicators(det: float, tangent: Floats, y: Floats, ri: float, ti: float, symmetric: bool) -> tuple[float, float]:
    """Fold and second indicator; the bridge becomes unstable where either changes sign.

    The fold: the separation stops growing along the branch. The second: the determinant, which sees a jump over a fold; for
    equal bodies the loss of symmetry.
    """
    return tangent[GAP], antisymmetric(y, ri, ti) if symmetric else det


@jit
def trace(
    y0: Floats, volume: float, ri: float, rj: float, ti: float, tj: float, symmetric: bool, stop: float
) -> tuple[int, Floats]:
    """Points of the branch from y0 (touching) to its limit of stability, or to the first point beyond separation `stop`.

    Returns how it ended and an array of points; the last point is the limit itself unless it stopped earlier.
    """
    points = np.empty((MOST_POINTS, 5))
    points[0] = y0
    count, size = 1, 0.1
    before = np.zeros(5)
    before[GAP] = 1.0
    y = y0.copy()
    tangent, det = tangent_of(y, volume, ri, rj, ti, tj, symmetric, before)
    sign = indicators(det, tangent, y, ri, ti, symmetric)[1]
    while count < MOST_POINTS:
        used, trial = step_along(y, size, tangent, volume, ri, rj, ti, tj, symmetric)
        turned, det = tangent, 0.0
        if used >= 0:
            turned, det = tangent_of(trial, volume, ri, rj, ti, tj, symmetric, tangent)
        if used < 0 or (turned * tangent).sum() < 0.95:
            size *= 0.5
            if size < 1e-9:
                return LOST, points[:count]
            continue
        fold, other = indicators(det, turned, trial, ri, ti, symmetric)
        if fold <= 0.0 or other * sign <= 0.0:
            reached, turned, fold = _limit(y, size, tangent, volume, ri, rj, ti, tj, symmetric, sign)
            points[count] = reached
            count += 1
            if fold < 1e-3:
                return FOLD, points[:count]
            if symmetric:
                return ASYMMETRY, points[:count]
            # The step had jumped to another branch: go on from the last stable point in finer steps.
            if size < 1e-7:
                return LOST, points[:count]
            y, tangent, size = reached, turned, 0.02 * size
            continue
        points[count] = trial
        count += 1
        y, tangent = trial, turned
        if y[GAP] > stop:
            return FOLD, points[:count]
        if used <= 3:
            size = min(size * 1.5, 0.25)
    return LOST, points[:count]


@jit
def _limit(
    y: Floats,
    size: float,
    tangent: Floats,
    volume: float,
    ri: float,
    rj: float,
    ti: float,
    tj: float,
    symmetric: bool,
    sign: float,
) -> tuple[Floats, Floats, float]:
    """The last stable point between y and one step further, by bisection on the step; tangent and fold indicator there."""
    low, high = 0.0, size
    best, best_tangent, best_fold = y.copy(), tangent.copy(), tangent[GAP]
    while high - low > 1e-12 + 1e-11 * size:
        middle = 0.5 * (low + high)
        used, trial = step_along(y, middle, tangent, volume, ri, rj, ti, tj, symmetric)
        if used < 0:
            high = middle
            continue
        turned, det = tangent_of(trial, volume, ri, rj, ti, tj, symmetric, tangent)
        fold, other = indicators(det, turned, trial, ri, ti, symmetric)
        if fold > 0.0 and other * sign > 0.0:
            low = middle
            best, best_tangent, best_fold = trial, turned, fold
        else:
            high = middle
    return best, best_tangent, best_fold


@jit
def between(
    left: Floats,
    right: Floats,
    gap: float,
    last: float,
    volume: float,
    ri: float,
    rj: float,
    ti: float,
    tj: float,
    symmetric: bool,
) -> tuple[bool, Floats]:
    """The bridge at a separation between two neighbouring points of a branch that ends at separation `last`.

    Starts from interpolation in √(last − S), the shape of a fold.
    """
    a, b, x = (
        math.sqrt(max(last - left[GAP], 0.0)),
        math.sqrt(max(last - right[GAP], 0.0)),
        math.sqrt(max(last - gap, 0.0)),
    )
    share = (a - x) / (a - b) if a > b else 0.0
    y = left + share * (right - left)
    y[GAP] = gap
    if right[GAP] == gap:
        return True, right.copy()
    used = correct(y, volume, ri, rj, ti, tj, symmetric, np.empty(0), 30)
    return used >= 0, y
