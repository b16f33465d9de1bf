"""One step of an embedded Runge-Kutta method, compiled: DOP853 and Dormand-Prince 5(4) (explicit), Radau IIA 5 (implicit).

The implicit one is that of Hairer, Nørsett & Wanner II, with the coefficients of `scipy.integrate`. A step gives the
new state, its derivative and the error relative to the tolerance; `marching` chooses the next step.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate._ivp.radau import MU_COMPLEX, MU_REAL, TI, E, T

from pywet.collisions.runge_kutta import combine, error_of
from pywet.collisions.spheres.dynamics import derivative, place
from pywet.collisions.spheres.state import WORKS, compiled

EXPLICIT, IMPLICIT = 0, 1
NEWTON = 8
"""Largest number of Newton iterations of an implicit step."""
SHARPER = 1e-3
"""Tolerance of the implicit method over the requested one: its error estimate omits stiff components."""


@compiled
def set_scale(s: Any, w: Any, y: Any, other: Any) -> None:
    """Set the error scale of each variable: gaps relative (ln h), angles absolute, lengths by 1, speeds by 1 or their size."""
    spheres, tol = s.radius.size, w.now.tolerance
    for i in range(spheres):
        b = 5 * i
        for k in range(2):
            w.scale[b + k] = tol + 1e-15 * abs(y[b + k])
            w.scale[b + 2 + k] = tol * max(1.0, abs(y[b + 2 + k]), abs(other[b + 2 + k]))
        w.scale[b + 4] = tol * max(1.0 / s.radius[i], abs(y[b + 4]), abs(other[b + 4]))
    for k in range(WORKS):
        w.scale[5 * spheres + k] = tol * max(w.now.energy, 0.01 * abs(y[5 * spheres + k]))
    for b in range(place(s, 0), w.count.size, 4):
        w.scale[b] = w.scale[b + 1] = tol
        for k in (2, 3):
            w.scale[b + k] = tol * max(1.0, abs(y[b + k]), abs(other[b + k]))


@compiled
def explicit_step(dt: float, s: Any, w: Any) -> float:
    """Make a step of size dt from w.y to w.y_new, w.f_new; returns the error over the tolerance and records the stiffness."""
    n, tab = w.count.size, w.tableau
    last = len(tab.a) - 1
    w.stages[0, :n] = w.f[:n]
    for k in range(1, last + 1):
        if k == last:
            w.y_trial[:n] = w.y_new[:n]
        combine(w.y, w.stages, tab.a[k], k, dt, w.y_new[:n])
        derivative(w.y_new, w.stages[k], s, w, w.lam_new)
    set_scale(s, w, w.y, w.y_new)
    w.f_new[:n] = w.stages[last, :n]
    stiff = norm(w.stages[last] - w.stages[last - 1], w.scale, n)
    move = norm(w.y_new - w.y_trial, w.scale, n)
    w.now.stiffness = dt * stiff / move if move > 0.0 else 0.0
    return error_of(w.stages, tab.error, tab.error_low, w.scale[:n], dt)


@compiled
def jacobian(s: Any, w: Any) -> Any:
    """Compute the Jacobian at w.y by one-sided differences."""
    n = w.count.size
    matrix, up = np.empty((n, n)), np.empty(n)
    for q in range(n):
        stored = w.y[q]
        d = 1.5e-8 * max(abs(stored), w.scale[q] / (SHARPER * w.now.tolerance))
        w.y[q] = stored + d
        d = w.y[q] - stored
        derivative(w.y, up, s, w, w.lam_new)
        w.y[q] = stored
        matrix[:, q] = (up - w.f[:n]) / d
    return matrix


@compiled
def norm(x: Any, scale: Any, n: int) -> float:
    """Return the root mean square of x over its scale."""
    total = 0.0
    for q in range(n):
        total += (x[q] / scale[q]) ** 2
    return math.sqrt(total / n)


@compiled
def implicit_step(dt: float, s: Any, w: Any) -> float:
    """Make a Radau IIA step of size dt from w.y to w.y_new, w.f_new; the error is infinite if Newton's iteration fails."""
    n = w.count.size
    set_scale(s, w, w.y, w.y)
    w.scale[:n] *= SHARPER
    j = jacobian(s, w)
    if not math.isfinite(j.sum()):
        return math.inf
    real = np.linalg.inv(MU_REAL / dt * np.eye(n) - j)
    cplx = np.linalg.inv(MU_COMPLEX / dt * np.eye(n) - j)
    z, v, f = np.zeros((3, n)), np.zeros((3, n)), np.empty((3, n))
    before, done = -1.0, False
    for _ in range(NEWTON):
        for k in range(3):
            w.y_trial[:n] = w.y[:n] + z[k]
            derivative(w.y_trial, f[k], s, w, w.lam_new)
        g = np.dot(TI, f)
        d_real = np.dot(real, g[0] - MU_REAL / dt * v[0])
        d_cplx = np.dot(cplx, (g[1] + 1j * g[2]) - MU_COMPLEX / dt * (v[1] + 1j * v[2]))
        v[0] += d_real
        v[1] += d_cplx.real
        v[2] += d_cplx.imag
        z = np.dot(T, v)
        size = norm(d_real, w.scale, n) + norm(d_cplx.real, w.scale, n) + norm(d_cplx.imag, w.scale, n)
        if not math.isfinite(size) or (before > 0.0 and size > 2.0 * before):
            return math.inf
        if size < 1e-3 or (before > 0.0 and size * size / max(before - size, 1e-300) < 1e-3 and size < before):
            done = True
            break
        before = size
    if not done:
        return math.inf
    w.y_new[:n] = w.y[:n] + z[2]
    derivative(w.y_new, w.f_new, s, w, w.lam_new)
    ze = (E[0] * z[0] + E[1] * z[1] + E[2] * z[2]) / dt
    error = np.dot(real, w.f[:n] + ze)
    w.y_trial[:n] = w.y[:n] + error
    derivative(w.y_trial, f[0], s, w, w.lam_new)
    return norm(np.dot(real, f[0] + ze), w.scale, n)


@compiled
def step(dt: float, s: Any, w: Any) -> float:
    """Make one step with the current integration method."""
    return implicit_step(dt, s, w) if w.count.mode == IMPLICIT else explicit_step(dt, s, w)
