"""Follow the stable branch of a bridge: Newton's method, continuation in volume and separation, the limit of stability.

The branch starts at touching bodies and ends at the first zero of the Jacobian's determinant: a fold, or for equal
bodies of large contact angle the loss of symmetry shortly before it. A negative r_j is a concave body (its φ_j is
negative too), because tables need points slightly beyond the plate. All functions are compiled; the public ones are
in `bridge.py`.
"""

from __future__ import annotations

import math

import numpy as np

from pywet.laws.exact_bridge.meridian import (
    CURVATURE,
    GAP,
    LENGTH,
    PHI_I,
    PHI_J,
    Case,
    Floats,
    antisymmetric,
    jit,
    residual,
)

FOLD, ASYMMETRY, LOST = 0, 1, 2
"""Ends of a branch; LOST: the continuation failed."""
MOST_POINTS = 400
FIRST_VOLUME = 1e-9
"""Volume over the cube of the smaller radius from which the continuation in volume starts."""


@jit
def scales(y: Floats) -> Floats:
    """Return the natural size of each unknown near y, so that steps are relative."""
    d = np.abs(y)
    d[CURVATURE] = max(d[CURVATURE], 1.0 / d[LENGTH])
    d[GAP] = d[LENGTH]
    return d


@jit
def jacobian(y: Floats, c: Case, d: Floats) -> Floats:
    """Return the 4 × 5 matrix of the residual's derivatives by the unknowns in units of d, central differences."""
    matrix, trial = np.zeros((4, 5)), y.copy()
    for k in range(4):
        step = 3e-6 * d[k]
        trial[k] = y[k] + step
        plus = residual(trial, c)
        trial[k] = y[k] - step
        matrix[:, k] = (plus - residual(trial, c)) / 6e-6
        trial[k] = y[k]
    matrix[2, GAP] = -d[GAP] / y[LENGTH]
    return matrix


@jit
def solved(matrix: Floats, right: Floats) -> Floats:
    """Solve a linear system; nan if it is singular."""
    answer = np.full(right.size, math.nan)
    if math.isfinite(matrix.sum()):
        try:
            answer = np.linalg.solve(matrix, right)
        except Exception:  # singular
            answer[:] = math.nan
    return answer


@jit
def outside(y: Floats, c: Case) -> bool:
    """Return whether the unknowns are outside the range in which a bridge exists."""
    return y[LENGTH] <= 0.0 or y[PHI_I] <= 0.0 or y[PHI_J] * c.rj <= 0.0


@jit
def correct(y: Floats, c: Case, tangent: Floats, most: int) -> int:
    """Solve the bridge by Newton's method at fixed separation (tangent of size 0) or in the plane normal to `tangent`.

    Changes y in place; returns the iterations used, −1 without convergence.
    """
    n = 4 if tangent.size == 0 else 5
    d, last = scales(y), math.inf
    for iteration in range(most):
        misfit = residual(y, c)
        size = np.abs(misfit).max()
        if not math.isfinite(size) or size > 1e3:
            return -1
        if size < 1e-13 or (size < 2e-12 and size >= 0.5 * last):
            return iteration
        last = size
        matrix, right = np.empty((n, n)), np.zeros(n)
        matrix[:4] = jacobian(y, c, d)[:, :n]
        right[:4] = -misfit
        if n == 5:
            matrix[4] = tangent
        change = solved(matrix, right)
        step = min(1.0, 0.3 / max(np.abs(change).max(), 1e-300))
        y[:n] += step * change * d[:n]
        if outside(y, c):
            return -1
    return most if last < 1e-10 else -1


@jit
def guess(c: Case) -> Floats:
    """Return the toroidal ring between touching bodies as a first guess, good for small volumes."""
    plate = math.isinf(c.rj)
    reduced = c.ri if plate else c.ri * c.rj / (c.ri + c.rj)
    rho = (4.0 * reduced * c.volume / math.pi) ** 0.25
    height = rho * rho / (2.0 * reduced)
    phi_i = rho / c.ri
    phi_j = rho if plate else rho / c.rj
    opening = math.cos(c.ti + phi_i) + math.cos(c.tj if plate else c.tj + phi_j)
    angle = math.pi - c.ti - c.tj - phi_i - (0.0 if plate else phi_j)
    length = height * (0.5 * angle / math.sin(0.5 * angle) if abs(angle) > 1e-6 else 1.0)
    return np.array([phi_i, phi_j, 0.5 * (1.0 / rho - opening / height), length, 0.0])


@jit
def touching(c: Case) -> tuple[bool, Floats]:
    """Compute the bridge between touching bodies by continuation in volume from a thin ring."""
    none, factor = np.empty(0), 4.0
    v = min(c.volume, FIRST_VOLUME * min(c.ri, abs(c.rj)) ** 3)
    first = of_volume(c, v)
    y = guess(first)
    if correct(y, first, none, 60) < 0:
        return False, y
    while v < c.volume:
        grown = min(v * factor, c.volume)
        root = math.sqrt(math.sqrt(grown / v))  # φ ~ V^¼, H ~ V^−½, length ~ V^½
        trial = y * np.array([root, root, 1.0 / (root * root), root * root, 1.0])
        if correct(trial, of_volume(c, grown), none, 12) < 0:
            factor = math.sqrt(factor)
            if factor < 1.001:
                return False, y
            continue
        y, v = trial, grown
    return True, y


@jit
def of_volume(c: Case, volume: float) -> Case:
    """Return a copy of the problem with another volume between the bodies."""
    return Case(volume, c.ri, c.rj, c.ti, c.tj, c.symmetric)


@jit
def tangent_of(y: Floats, c: Case, before: Floats) -> tuple[Floats, float]:
    """Return the unit tangent of the branch in scaled unknowns, oriented like `before`, and a second indicator of stability.

    The bridge becomes unstable where either changes sign: the tangent's component of separation, which is zero at
    a fold, or the second, the determinant, which detects a step across a fold; for equal bodies it is the loss of
    symmetry.
    """
    matrix, right = np.empty((5, 5)), np.zeros(5)
    matrix[:4] = jacobian(y, c, scales(y))
    matrix[4] = before
    right[4] = 1.0
    along = solved(matrix, right)
    regular = math.isfinite(along.sum())
    second = antisymmetric(y, c) if c.symmetric else np.linalg.det(matrix[:4, :4].copy()) if regular else 0.0
    return along / math.sqrt((along * along).sum()) if regular else before, second


@jit
def step_along(y: Floats, size: float, tangent: Floats, c: Case) -> tuple[int, Floats, Floats, float]:
    """Make one predicted and corrected step of the continuation: iterations (−1: failed), its end, `tangent_of` there."""
    trial = y + size * tangent * scales(y)
    used = -1 if outside(trial, c) else correct(trial, c, tangent, 8)
    turned, second = tangent_of(trial, c, tangent) if used >= 0 else (tangent, 0.0)
    return used, trial, turned, second


@jit
def trace(y0: Floats, c: Case, stop: float) -> tuple[int, Floats]:
    """Return points of the branch from y0 (touching) to its limit of stability, or to the first point beyond separation `stop`.

    The first result is how it ended; the last point is the limit itself unless it stopped earlier.
    """
    points = np.empty((MOST_POINTS, 5))
    points[0] = y0
    count, size = 1, 0.1
    before = np.zeros(5)
    before[GAP] = 1.0
    y = y0.copy()
    tangent, sign = tangent_of(y, c, before)
    while count < MOST_POINTS:
        used, trial, turned, second = step_along(y, size, tangent, c)
        if used < 0 or (turned * tangent).sum() < 0.95:
            size *= 0.5
            if size < 1e-9:
                return LOST, points[:count]
            continue
        if turned[GAP] <= 0.0 or second * sign <= 0.0:
            last, along = _limit(y, size, tangent, c, sign, True)
            if along[GAP] >= 1e-3 and not c.symmetric:
                last, along = _limit(y, size, tangent, c, sign, False)
            y, tangent = last, along
            points[count] = y
            count += 1
            if tangent[GAP] < 1e-3:
                return FOLD, points[:count]
            if c.symmetric:
                return ASYMMETRY, points[:count]
            # The step has jumped to another branch: continue from the last stable point with smaller steps.
            if size < 1e-7:
                return LOST, points[:count]
            size = 0.02 * size
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
def follow(c: Case, stop: float) -> tuple[int, Floats]:
    """Return the branch of a bridge from touching bodies, in the form of `trace`."""
    ok, y = touching(c)
    return trace(y, c, stop) if ok else (LOST, y.reshape(1, 5))


@jit
def _limit(y: Floats, size: float, tangent: Floats, c: Case, sign: float, smooth: bool) -> tuple[Floats, Floats]:
    """Return the last stable point between y and the next step, and the tangent there.

    By bisection on the step, or, where `second` passes smoothly through zero, by the Illinois method on it.
    """
    low, high, at_low, at_high, side = 0.0, size, 0.0, 0.0, 0  # 0: not known
    best, best_tangent = y.copy(), tangent.copy()
    least = 1e-12 + 1e-11 * size
    while high - low > least:
        middle = 0.5 * (low + high)
        if smooth and at_low > 0.0 and at_high < 0.0:
            zero = low + (high - low) * at_low / (at_low - at_high)
            middle = min(max(zero, low + 0.9 * least), high - 0.9 * least)
        _, trial, turned, second = step_along(y, middle, tangent, c)
        if turned[GAP] > 0.0 and second * sign > 0.0:
            at_high *= 0.5 if side > 0 else 1.0
            low, best, best_tangent, at_low, side = middle, trial, turned, second * sign, 1
        else:
            at_low *= 0.5 if side < 0 else 1.0
            high, at_high, side = middle, second * sign, -1
    return best, best_tangent


@jit
def between(left: Floats, right: Floats, gap: float, last: float, c: Case) -> tuple[bool, Floats]:
    """Solve the bridge at a separation between two neighbouring points of a branch that ends at separation `last`.

    The start is interpolated in √(last − S), the shape of a fold.
    """
    if right[GAP] == gap:
        return True, right.copy()
    a, b = math.sqrt(max(last - left[GAP], 0.0)), math.sqrt(max(last - right[GAP], 0.0))
    share = (a - math.sqrt(max(last - gap, 0.0))) / (a - b) if a > b else 0.0
    y = left + share * (right - left)
    y[GAP] = gap
    return correct(y, c, np.empty(0), 30) >= 0, y
