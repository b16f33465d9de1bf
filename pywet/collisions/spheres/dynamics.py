"""Forces and equations of motion of N wet spheres in a plane, compiled (Davis 2023, eqs. 1-18, misprints mended).

The state holds, for each sphere, x, y, vx, vy, ω; then four works (viscous, capillary, gravity, friction of resting contacts);
then, for each pair whose films overlap, four polar variables: q = ln h, θ, u = −dh/dt and w = (v_i − v_j)·t = −r dθ/dt.
Forces come from the polar variables, energies from the Cartesian ones: the energy budget therefore tests one against the other.
With `polar` off the pairs' variables are differences of the Cartesian ones (for comparison). Units: those of `System`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

WORKS = 4
"""Accumulators behind the spheres: viscous, capillary, gravity, friction of resting contacts."""
compiled = njit(error_model="numpy")
"""Not cached one by one: numba would not notice a change in another file; see `marching.march`."""
H, COS, SIN, U, W, R = range(6)
"""Columns of the geometry of an overlapping pair."""


class System(NamedTuple):
    """Constants of a problem; arrays over spheres (n) or over pairs (first < second)."""

    radius: np.ndarray
    mass: np.ndarray
    first: np.ndarray
    second: np.ndarray
    film: np.ndarray
    """Gap at which the films touch, δ_i + δ_j."""
    h_min: np.ndarray
    """Gap of solid contact."""
    normal: np.ndarray
    """6π μ a², a the reduced radius a_i a_j/(a_i + a_j)."""
    tangential: np.ndarray
    """2π μ a."""
    capillary: np.ndarray
    """8π a σ."""
    e_dry: float
    mu_f: float
    slip_scale: float
    """Slip speed over which the friction of a resting contact builds up."""
    gx: float
    gy: float


@compiled
def pair_geometry(y: Any, s: Any, p: int, slot: int, polar: bool, out: Any) -> None:
    """Gap, direction from i to j, u = −dh/dt, w = (v_i − v_j)·t and centre distance of pair p into `out`."""
    i, j = s.first[p], s.second[p]
    touch = s.radius[i] + s.radius[j]
    if polar and slot >= 0:
        b = 5 * s.radius.size + WORKS + 4 * slot
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
    """[1 − h/(2δ − h)]²/h and ln[(2δ − h)/h] (Davis 2023, 3, 4), continued a little beyond 0.1 h_min < h < δ for trial stages."""
    g = min(max(h, 0.1 * h_min), 1.3 * film)
    rest = 2.0 * film - g
    squeeze = 1.0 - g / rest
    return squeeze * squeeze / g, math.log(rest / g)


@compiled
def push(dy: Any, s: Any, i: int, j: int, fx: float, fy: float, ft: float) -> None:
    """Accelerations of a pair under the force −(fx, fy) on i, + on j, with tangential part ft."""
    dy[5 * i + 2] -= fx / s.mass[i]
    dy[5 * i + 3] -= fy / s.mass[i]
    dy[5 * j + 2] += fx / s.mass[j]
    dy[5 * j + 3] += fy / s.mass[j]
    dy[5 * i + 4] -= 2.5 * ft / (s.mass[i] * s.radius[i])
    dy[5 * j + 4] -= 2.5 * ft / (s.mass[j] * s.radius[j])


@compiled
def slip(y: Any, s: Any, p: int, w: float) -> float:
    """Relative speed of the two surfaces along t, v^s = −rΩ + a_i ω_i + a_j ω_j."""
    i, j = s.first[p], s.second[p]
    return w + s.radius[i] * y[5 * i + 4] + s.radius[j] * y[5 * j + 4]


@compiled
def along(dy: Any, s: Any, p: int, x: float, y: float) -> float:
    """(a_i − a_j)·(x, y) of the accelerations in dy."""
    i, j = s.first[p], s.second[p]
    return (dy[5 * i + 2] - dy[5 * j + 2]) * x + (dy[5 * i + 3] - dy[5 * j + 3]) * y


@compiled
def resting_forces(y: Any, dy: Any, s: Any, act: Any, m: int, rest: Any, lam: Any, geo: Any) -> float:
    """Normal forces `lam` that keep resting pairs at du/dt = 0; they and their friction are added to dy. Returns
    friction's power.

    Friction of a resting contact: μ_f λ v_s/√(v_s² + slip_scale²), against the slip v_s.
    """
    slots = [k for k in range(m) if rest[act[k]]]
    count = len(slots)
    matrix, wanted, share = np.zeros((count, count)), np.empty(count), np.empty(count)
    for a in range(count):
        p, g = act[slots[a]], geo[slots[a]]
        v = slip(y, s, p, g[W])
        share[a] = s.mu_f * v / math.sqrt(v * v + s.slip_scale * s.slip_scale) if s.mu_f > 0.0 else 0.0
        wanted[a] = g[W] * g[W] / g[R] - along(dy, s, p, g[COS], g[SIN])
    for b in range(count):
        p, g = act[slots[b]], geo[slots[b]]
        x, z = g[COS] - share[b] * g[SIN], g[SIN] + share[b] * g[COS]
        for a in range(count):
            o, k = act[slots[a]], geo[slots[a]]
            for at, sign in ((s.first[p], -1.0), (s.second[p], 1.0)):
                if at == s.first[o]:
                    matrix[a, b] += sign * (x * k[COS] + z * k[SIN]) / s.mass[at]
                elif at == s.second[o]:
                    matrix[a, b] -= sign * (x * k[COS] + z * k[SIN]) / s.mass[at]
    for a in range(count):
        matrix[a, a] *= 1.0 + 1e-12  # redundant contacts of a dense cluster share the load
    if not math.isfinite(matrix.sum() + wanted.sum()):  # a trial stage far off: its step is refused
        dy[:] = math.nan
        return math.nan
    force = np.linalg.solve(matrix, wanted)
    power = 0.0
    for a in range(count):
        p, g = act[slots[a]], geo[slots[a]]
        lam[p] = force[a]
        ft = share[a] * force[a]
        push(dy, s, s.first[p], s.second[p], force[a] * g[COS] - ft * g[SIN], force[a] * g[SIN] + ft * g[COS], ft)
        power += ft * slip(y, s, p, g[W])
    return power


@compiled
def rhs(y: Any, dy: Any, s: Any, act: Any, m: int, rest: Any, lam: Any, geo: Any, polar: bool) -> None:
    """Time derivative of the state into dy; `act[:m]` are the overlapping pairs, `rest` marks resting contacts."""
    spheres = s.radius.size
    works = 5 * spheres
    for i in range(spheres):
        dy[5 * i], dy[5 * i + 1] = y[5 * i + 2], y[5 * i + 3]
        dy[5 * i + 2], dy[5 * i + 3], dy[5 * i + 4] = s.gx, s.gy, 0.0
    viscous, capillary, gravity, resting = 0.0, 0.0, 0.0, False
    for k in range(m):
        p, g = act[k], geo[k]
        pair_geometry(y, s, p, k, polar, g)
        squeeze, shear = film_factors(g[H], s.film[p], s.h_min[p])
        v = slip(y, s, p, g[W])
        fn, ft = s.normal[p] * squeeze * g[U], s.tangential[p] * shear * v
        viscous += fn * g[U] + ft * v
        capillary -= s.capillary[p] * g[U]
        fn -= s.capillary[p]
        push(dy, s, s.first[p], s.second[p], fn * g[COS] - ft * g[SIN], fn * g[SIN] + ft * g[COS], ft)
        resting = resting or rest[p]
    for i in range(spheres):
        gravity += s.mass[i] * (s.gx * y[5 * i + 2] + s.gy * y[5 * i + 3])
    friction = resting_forces(y, dy, s, act, m, rest, lam, geo) if resting else 0.0
    dy[works], dy[works + 1], dy[works + 2], dy[works + 3] = viscous, capillary, gravity, friction
    if polar:
        for k in range(m):
            p, g, b = act[k], geo[k], works + WORKS + 4 * k
            dy[b], dy[b + 1] = -g[U] / g[H], -g[W] / g[R]
            dy[b + 2] = along(dy, s, p, g[COS], g[SIN]) - g[W] * g[W] / g[R]
            dy[b + 3] = along(dy, s, p, -g[SIN], g[COS]) + g[U] * g[W] / g[R]
            if rest[p]:
                dy[b] = dy[b + 2] = 0.0
