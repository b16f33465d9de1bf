"""Forces and equations of motion of N wet spheres in a plane, compiled (Davis 2023, eqs. 1-18, misprints corrected).

Forces come from the pairs' polar variables, energies from the spheres' Cartesian ones: the energy budget tests one against
the other. The variables are those of `state`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pywet.collisions.spheres.state import COS, SIN, WORKS, H, R, U, W, compiled


@compiled
def place(s: Any, slot: int) -> int:
    """Return the index of the first variable of the pair in a slot."""
    return 5 * s.radius.size + WORKS + 4 * slot


@compiled
def pair_geometry(y: Any, s: Any, p: int, slot: int, out: Any) -> None:
    """Write gap, direction from i to j, u = −dh/dt, w = (v_i − v_j)·t and centre distance of pair p to `out`.

    With slot −1 they are computed from the spheres' variables.
    """
    i, j = s.first[p], s.second[p]
    touch = s.radius[i] + s.radius[j]
    if s.polar and slot >= 0:
        b = place(s, slot)
        out[H] = math.exp(min(y[b], math.log(4.0 * s.film[p])))
        out[COS], out[SIN] = math.cos(y[b + 1]), math.sin(y[b + 1])
        out[U], out[W] = y[b + 2], y[b + 3]
        out[R] = touch + out[H]
        return
    dx, dy = y[5 * j] - y[5 * i], y[5 * j + 1] - y[5 * i + 1]
    r = math.hypot(dx, dy)
    c, n = dx / r, dy / r
    vx, vy = y[5 * i + 2] - y[5 * j + 2], y[5 * i + 3] - y[5 * j + 3]
    out[H], out[COS], out[SIN], out[R] = r - touch, c, n, r
    out[U], out[W] = vx * c + vy * n, vy * c - vx * n


@compiled
def film_factors(h: float, film: float, h_min: float) -> tuple[float, float]:
    """Return [1 − h/(2δ − h)]²/h and ln[(2δ − h)/h] (Davis 2023, 3, 4), extended beyond 0.1 h_min < h < δ for trial stages."""
    g = min(max(h, 0.1 * h_min), 1.3 * film)
    rest = 2.0 * film - g
    squeeze = 1.0 - g / rest
    return squeeze * squeeze / g, math.log(rest / g)


@compiled
def push(motion: Any, s: Any, p: int, fx: float, fy: float, ft: float) -> None:
    """Add a force (or impulse) −(fx, fy) on i, + on j, with tangential part ft, to accelerations (or velocities)."""
    i, j = s.first[p], s.second[p]
    motion[5 * i + 2] -= fx / s.mass[i]
    motion[5 * i + 3] -= fy / s.mass[i]
    motion[5 * j + 2] += fx / s.mass[j]
    motion[5 * j + 3] += fy / s.mass[j]
    motion[5 * i + 4] -= 2.5 * ft / (s.mass[i] * s.radius[i])
    motion[5 * j + 4] -= 2.5 * ft / (s.mass[j] * s.radius[j])


@compiled
def shared(s: Any, p: int, o: int) -> float:
    """Return the relative acceleration of pair o along a unit force on pair p: ± 1/m of the spheres in both."""
    total = 0.0
    for at, sign in ((s.first[p], -1.0), (s.second[p], 1.0)):
        if at == s.first[o]:
            total += sign / s.mass[at]
        elif at == s.second[o]:
            total -= sign / s.mass[at]
    return total


@compiled
def slip(y: Any, s: Any, p: int, w: float) -> float:
    """Return the relative speed of the two surfaces along t, v^s = −rΩ + a_i ω_i + a_j ω_j."""
    i, j = s.first[p], s.second[p]
    return w + s.radius[i] * y[5 * i + 4] + s.radius[j] * y[5 * j + 4]


@compiled
def along(dy: Any, s: Any, p: int, x: float, y: float) -> float:
    """Return (a_i − a_j)·(x, y) of the accelerations in dy."""
    i, j = s.first[p], s.second[p]
    return (dy[5 * i + 2] - dy[5 * j + 2]) * x + (dy[5 * i + 3] - dy[5 * j + 3]) * y


@compiled
def resting_forces(y: Any, dy: Any, s: Any, w: Any, lam: Any) -> float:
    """Normal forces `lam` that keep resting pairs at du/dt = 0, added to dy with their friction, whose power is returned.

    Friction of a resting contact: μ_f λ v_s/√(v_s² + slip_scale²), against the slip v_s.
    """
    slots = [k for k in range(w.count.pairs) if w.rest[w.act[k]]]
    count = len(slots)
    matrix, wanted, share = np.empty((count, count)), np.empty(count), np.empty(count)
    for a in range(count):
        p, g = w.act[slots[a]], w.geometry[slots[a]]
        v = slip(y, s, p, g[W])
        share[a] = s.mu_f * v / math.sqrt(v * v + s.slip_scale * s.slip_scale) if s.mu_f > 0.0 else 0.0
        wanted[a] = g[W] * g[W] / g[R] - along(dy, s, p, g[COS], g[SIN])
    for b in range(count):
        p, g = w.act[slots[b]], w.geometry[slots[b]]
        x, z = g[COS] - share[b] * g[SIN], g[SIN] + share[b] * g[COS]
        for a in range(count):
            k = w.geometry[slots[a]]
            matrix[a, b] = shared(s, p, w.act[slots[a]]) * (x * k[COS] + z * k[SIN])
        matrix[b, b] *= 1.0 + 1e-12  # redundant contacts of a dense cluster share the load
    if not math.isfinite(matrix.sum() + wanted.sum()):  # a trial stage far from the solution: its step is rejected
        dy[:] = math.nan
        return math.nan
    force = np.linalg.solve(matrix, wanted)
    power = 0.0
    for a in range(count):
        p, g = w.act[slots[a]], w.geometry[slots[a]]
        lam[p] = force[a]
        ft = share[a] * force[a]
        push(dy, s, p, force[a] * g[COS] - ft * g[SIN], force[a] * g[SIN] + ft * g[COS], ft)
        power += ft * slip(y, s, p, g[W])
    return power


@compiled
def derivative(y: Any, dy: Any, s: Any, w: Any, lam: Any) -> None:
    """Write the time derivative of the state to dy, and update the geometry of the overlapping pairs."""
    w.count.evaluations += 1
    works = 5 * s.radius.size
    for i in range(s.radius.size):
        dy[5 * i], dy[5 * i + 1] = y[5 * i + 2], y[5 * i + 3]
        dy[5 * i + 2], dy[5 * i + 3], dy[5 * i + 4] = s.gx, s.gy, 0.0
    viscous, capillary, gravity, resting = 0.0, 0.0, 0.0, False
    for k in range(w.count.pairs):
        p, g = w.act[k], w.geometry[k]
        pair_geometry(y, s, p, k, g)
        squeeze, shear = film_factors(g[H], s.film[p], s.h_min)
        v = slip(y, s, p, g[W])
        fn, ft = s.normal[p] * squeeze * g[U], s.tangential[p] * shear * v
        viscous += fn * g[U] + ft * v
        capillary -= s.capillary[p] * g[U]
        fn -= s.capillary[p]
        push(dy, s, p, fn * g[COS] - ft * g[SIN], fn * g[SIN] + ft * g[COS], ft)
        resting = resting or w.rest[p]
    for i in range(s.radius.size):
        gravity += s.mass[i] * (s.gx * y[5 * i + 2] + s.gy * y[5 * i + 3])
    friction = resting_forces(y, dy, s, w, lam) if resting else 0.0
    dy[works], dy[works + 1], dy[works + 2], dy[works + 3] = viscous, capillary, gravity, friction
    if s.polar:
        for k in range(w.count.pairs):
            p, g, b = w.act[k], w.geometry[k], place(s, k)
            dy[b], dy[b + 1] = -g[U] / g[H], -g[W] / g[R]
            dy[b + 2] = along(dy, s, p, g[COS], g[SIN]) - g[W] * g[W] / g[R]
            dy[b + 3] = along(dy, s, p, -g[SIN], g[COS]) + g[U] * g[W] / g[R]
            if w.rest[p]:
                dy[b] = dy[b + 2] = 0.0
