"""The meridian of a capillary bridge as a boundary-value problem: collocation at Gauss points, Newton, continuation.

Between body i (below) and body j (above) the meridian (r, z)(t), -1 <= t <= 1, of arc length L has the tangent angle psi:
  r' = (L/2) cos psi,  z' = (L/2) sin psi,  psi' = (L/2) (P - sin(psi)/r)  (constant curvature P of the surface, tension 1).
A body is a sphere of curvature kappa = 1/R, or a plate (kappa = 0); the contact line is at the arc b along the body. There
r, z are those of the body and psi = pi - phi_i - theta_i or phi_j + theta_j, phi = kappa b. The volume is prescribed.
Unknowns: r, z, psi at N + 1 Lobatto nodes, L, P, b_i, b_j; equations: 3 N collocation conditions, 6 ends, 1 volume.
The equality of the force at every cross-section is not used; it remains as a check of the result.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
NEWTON_STEPS = 12
STEP_TOLERANCE = 1e-11


@dataclass(frozen=True)
class Problem:
    """Two bodies (curvature, contact angle), the volume between them and the number of collocation points."""

    kappa_i: float
    kappa_j: float
    theta_i: float
    theta_j: float
    volume: float
    points: int = 32


@dataclass(frozen=True)
class Grid:
    """Gauss points and weights on [-1, 1]; value and derivative there from the values at the nodes."""

    nodes: Floats
    gauss: Floats
    weights: Floats
    value: Floats
    slope: Floats


@lru_cache
def grid(points: int) -> Grid:
    """Return polynomials of degree `points` by their values at Chebyshev-Lobatto nodes."""
    nodes = -np.cos(np.pi * np.arange(points + 1) / points)
    gauss, weights = np.polynomial.legendre.leggauss(points)
    value = interpolation(nodes, gauss)
    barycentric = _barycentric(points)
    difference = nodes[:, None] - nodes[None, :] + np.eye(points + 1)
    at_nodes = barycentric[None, :] / barycentric[:, None] / difference
    np.fill_diagonal(at_nodes, 0.0)
    np.fill_diagonal(at_nodes, -at_nodes.sum(axis=1))
    return Grid(nodes, gauss, weights, value, value @ at_nodes)


def _barycentric(points: int) -> Floats:
    weight = np.where(np.arange(points + 1) % 2 == 0, 1.0, -1.0)
    weight[[0, -1]] *= 0.5
    return weight


def interpolation(nodes: Floats, at: Floats) -> Floats:
    """Return the matrix that evaluates the polynomial through Lobatto `nodes` at the points `at`."""
    difference = at[:, None] - nodes[None, :]
    exact = difference == 0.0
    terms = _barycentric(len(nodes) - 1) / np.where(exact, 1.0, difference)
    matrix = terms / terms.sum(axis=1, keepdims=True)
    matrix[exact.any(axis=1)] = exact[exact.any(axis=1)]
    return np.asarray(matrix, dtype=float)


@dataclass(frozen=True)
class State:
    """A meridian: all unknowns in one vector, and its separation."""

    x: Floats
    separation: float

    @property
    def n(self) -> int:
        return (len(self.x) - 4) // 3

    @property
    def r(self) -> Floats:
        return self.x[: self.n]

    @property
    def z(self) -> Floats:
        return self.x[self.n : 2 * self.n]

    @property
    def psi(self) -> Floats:
        return self.x[2 * self.n : 3 * self.n]

    @property
    def length(self) -> float:
        return float(self.x[-4])

    @property
    def pressure(self) -> float:
        return float(self.x[-3])

    @property
    def arc_i(self) -> float:
        return float(self.x[-2])

    @property
    def arc_j(self) -> float:
        return float(self.x[-1])


def body(kappa: float, arc: float) -> tuple[float, float]:
    """Return radius, and depth below the body's tip, of the point at `arc` along its surface."""
    if kappa == 0.0:
        return arc, 0.0
    return math.sin(kappa * arc) / kappa, 2.0 * math.sin(0.5 * kappa * arc) ** 2 / kappa


def cap_volume(kappa: float, depth: float) -> float:
    """Return the volume of a body's cap of this depth."""
    return 0.0 if kappa == 0.0 else math.pi * depth**2 * (1.0 / kappa - depth / 3.0)


def liquid_volume(problem: Problem, state: State) -> float:
    """Return the volume between the surface of revolution and the two bodies."""
    g = grid(state.n - 1)
    solid = math.pi * float(g.weights @ ((g.value @ state.r) ** 2 * (g.slope @ state.z)))
    depth_i, depth_j = body(problem.kappa_i, state.arc_i)[1], body(problem.kappa_j, state.arc_j)[1]
    return solid - cap_volume(problem.kappa_i, depth_i) - cap_volume(problem.kappa_j, depth_j)


def residual(problem: Problem, state: State) -> Floats:
    """Return the residual of all equations; zero for a bridge."""
    g, half = grid(state.n - 1), 0.5 * state.length
    rg, psig = g.value @ state.r, g.value @ state.psi
    (ri, hi), (rj, hj) = body(problem.kappa_i, state.arc_i), body(problem.kappa_j, state.arc_j)
    ends = [
        state.r[0] - ri,
        state.z[0] + 0.5 * state.separation + hi,
        state.psi[0] - (math.pi - problem.kappa_i * state.arc_i - problem.theta_i),
        state.r[-1] - rj,
        state.z[-1] - 0.5 * state.separation - hj,
        state.psi[-1] - (problem.kappa_j * state.arc_j + problem.theta_j),
        liquid_volume(problem, state) - problem.volume,
    ]
    return np.concatenate(
        [
            g.slope @ state.r - half * np.cos(psig),
            g.slope @ state.z - half * np.sin(psig),
            g.slope @ state.psi - half * (state.pressure - np.sin(psig) / rg),
            ends,
        ]
    )


def jacobian(problem: Problem, state: State) -> Floats:
    """Return the derivatives of `residual`, one row per equation; the last column is that by the separation."""
    g, half, n = grid(state.n - 1), 0.5 * state.length, state.n
    m = n - 1
    rg, psig = g.value @ state.r, g.value @ state.psi
    sine, cosine = np.sin(psig), np.cos(psig)
    jac = np.zeros((3 * n + 4, 3 * n + 5))
    r, z, p = slice(0, n), slice(n, 2 * n), slice(2 * n, 3 * n)
    length, pressure, arc_i, arc_j, gap = range(3 * n, 3 * n + 5)
    jac[:m, r] = g.slope
    jac[:m, p] = (half * sine)[:, None] * g.value
    jac[:m, length] = -0.5 * cosine
    jac[m : 2 * m, z] = g.slope
    jac[m : 2 * m, p] = -(half * cosine)[:, None] * g.value
    jac[m : 2 * m, length] = -0.5 * sine
    jac[2 * m : 3 * m, r] = -(half * sine / rg**2)[:, None] * g.value
    jac[2 * m : 3 * m, p] = g.slope + (half * cosine / rg)[:, None] * g.value
    jac[2 * m : 3 * m, length] = -0.5 * (state.pressure - sine / rg)
    jac[2 * m : 3 * m, pressure] = -half
    angle_i, angle_j = problem.kappa_i * state.arc_i, problem.kappa_j * state.arc_j
    e = 3 * m
    for row, column in ((e, 0), (e + 1, n), (e + 2, 2 * n), (e + 3, n - 1), (e + 4, 2 * n - 1), (e + 5, 3 * n - 1)):
        jac[row, column] = 1.0
    jac[e, arc_i], jac[e + 1, arc_i], jac[e + 2, arc_i] = -math.cos(angle_i), math.sin(angle_i), problem.kappa_i
    jac[e + 3, arc_j], jac[e + 4, arc_j], jac[e + 5, arc_j] = -math.cos(angle_j), -math.sin(angle_j), -problem.kappa_j
    jac[e + 1, gap], jac[e + 4, gap] = 0.5, -0.5
    jac[e + 6, r] = 2.0 * math.pi * (g.weights * rg * (g.slope @ state.z)) @ g.value
    jac[e + 6, z] = math.pi * (g.weights * rg**2) @ g.slope
    # dV/d(depth) of a cap is pi times the square of its radius
    for kappa, arc, column in ((problem.kappa_i, state.arc_i, arc_i), (problem.kappa_j, state.arc_j, arc_j)):
        jac[e + 6, column] = -math.pi * body(kappa, arc)[0] ** 2 * math.sin(kappa * arc)
    return jac


def scales(state: State) -> Floats:
    """Return the typical size of each unknown, and of the separation."""
    n, radius = state.n, float(np.max(np.abs(state.r)))
    tail = [state.length, abs(state.pressure) + 1.0 / radius, radius, radius, state.length]
    return np.concatenate([np.full(n, radius), np.full(n, state.length), np.ones(n), tail])


def _solve_scaled(matrix: Floats, right: Floats, column_scale: Floats) -> Floats:
    """Solve a linear system whose rows and columns are scaled to one size first."""
    scaled = matrix * column_scale
    rows = np.max(np.abs(scaled), axis=1)
    return np.asarray(np.linalg.solve(scaled / rows[:, None], right / rows) * column_scale, dtype=float)


def even(problem: Problem, change: Floats) -> Floats:
    """Return the symmetric part of a change for equal bodies; otherwise the change itself.

    Without this, rounding would leave the symmetric branch where an asymmetric one bifurcates.
    """
    if problem.kappa_i != problem.kappa_j or problem.theta_i != problem.theta_j:
        return change
    n = (len(change) - 5) // 3
    parts = change[:n], change[n : 2 * n], change[2 * n : 3 * n]
    r, z, psi = (0.5 * (part + sign * part[::-1]) for part, sign in zip(parts, (1.0, -1.0, -1.0), strict=True))
    tail = change[3 * n :].copy()
    tail[2:4] = 0.5 * (tail[2] + tail[3])
    return np.concatenate([r, z, psi, tail])


def _admissible(state: State) -> bool:
    return bool(np.all(np.isfinite(state.x)) and state.length > 0.0 and np.min(state.r) > 0.0)


def newton(problem: Problem, start: State, row: Floats | None = None, predicted: State | None = None) -> State | None:
    """Solve for the bridge near `start`; None without convergence.

    With `row` the separation is free and the correction to `predicted` is orthogonal to `row`.
    """
    state = start
    last = math.inf
    for _ in range(NEWTON_STEPS):
        size = scales(state)
        jac, right = jacobian(problem, state), -residual(problem, state)
        try:
            if row is None or predicted is None:
                step = np.append(_solve_scaled(jac[:, :-1], right, size[:-1]), 0.0)
            else:
                here = np.append(state.x - predicted.x, state.separation - predicted.separation)
                step = _solve_scaled(np.vstack([jac, row]), np.append(right, -row @ here), size)
        except np.linalg.LinAlgError:
            return None
        step = even(problem, step)
        worst = float(np.max(np.abs(step) / size))
        if not math.isfinite(worst) or worst > 2.0:
            return None
        factor = min(1.0, 0.5 / worst) if worst > 0.0 else 1.0
        state = State(state.x + factor * step[:-1], state.separation + factor * float(step[-1]))
        if not _admissible(state):
            return None
        # stop at the tolerance, or when rounding keeps the steps from getting smaller
        if worst < STEP_TOLERANCE or (worst < 1e-8 and worst > 0.5 * last):
            return state
        last = worst
    return None


def unit(direction: Floats, weight: Floats) -> Floats:
    """Scale a direction to length one in the norm given by `weight`."""
    return np.asarray(direction / math.sqrt(float(weight @ direction**2)), dtype=float)


def tangent(problem: Problem, state: State, weight: Floats, before: Floats) -> Floats:
    """Return the unit direction of the branch in the norm given by `weight`, on the side of `before`."""
    right = np.zeros(len(state.x) + 1)
    right[-1] = 1.0
    direction = _solve_scaled(np.vstack([jacobian(problem, state), before * weight]), right, scales(state))
    return unit(even(problem, direction), weight)


def refined(state: State, direction: Floats, points: int) -> tuple[State, Floats]:
    """Interpolate meridian and direction to another number of points, as a start for Newton's method."""
    matrix = interpolation(grid(state.n - 1).nodes, grid(points).nodes)
    whole = State(direction[:-1], float(direction[-1]))
    x, along = (np.concatenate([matrix @ s.r, matrix @ s.z, matrix @ s.psi, s.x[-4:]]) for s in (state, whole))
    return State(x, state.separation), np.append(along, whole.separation)
