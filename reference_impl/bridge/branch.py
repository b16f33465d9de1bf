"""Branch of bridges of one volume, from touching bodies to the loss of stability.

Stability is the sign of the lowest eigenvalue of the second variation of the surface energy under the volume
constraint, for axisymmetric normal displacements N(s) (Myshkis et al. 1987, Low-Gravity Fluid Mechanics, ch. 3):
integral (N'² - (k² + (sin(psi)/r)²) N²) r ds + sum over both ends of chi r N², integral N r ds = 0, chi = (kappa - k
cos(theta))/sin(theta), k = psi' at the end. At theta = 0 the ends cannot move: N = 0 there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy  # its parts are loaded where they are used

from reference_impl.bridge.solver import (
    Floats,
    Problem,
    State,
    grid,
    liquid_volume,
    newton,
    refined,
    scales,
    tangent,
    unit,
)

EASY_ANGLE = math.radians(60.0)
EASY_VOLUME = 1e-3
"""Volume in units of r_eff³ up to which a toroid is a sufficient first guess for Newton's method."""
FIXED_END = 1e-7
"""Sine of the contact angle below which an end counts as fixed."""


def lowest_eigenvalue(problem: Problem, state: State) -> float:
    """Return the lowest eigenvalue of the constrained second variation, times the square of the arc length (dimensionless)."""
    g, half = grid(state.n - 1), 0.5 * state.length
    # Legendre polynomials, few enough for the quadrature to be exact
    degree = 2 * (state.n - 1) // 3
    shape = np.polynomial.legendre.legvander(g.gauss, degree)
    derivative = np.polynomial.legendre.legder(np.eye(degree + 1))
    bent = np.polynomial.legendre.legvander(g.gauss, degree - 1) @ derivative / half
    rg, psig = g.value @ state.r, g.value @ state.psi
    density = g.weights * rg * half
    curvature = (g.slope @ state.psi / half) ** 2 + (np.sin(psig) / rg) ** 2
    stiff = (bent.T * density) @ bent - (shape.T * (density * curvature)) @ shape
    mass = (shape.T * density) @ shape
    constraints: list[Floats] = [np.asarray(density @ shape, dtype=float)]
    for node, side, kappa, theta in (
        (0, -1.0, problem.kappa_i, problem.theta_i),
        (-1, 1.0, problem.kappa_j, problem.theta_j),
    ):
        end: Floats = np.power(side, np.arange(degree + 1))
        if math.sin(theta) < FIXED_END:
            constraints.append(end)
            continue
        bend = state.pressure - math.sin(state.psi[node]) / state.r[node]
        chi = (kappa - bend * math.cos(theta)) / math.sin(theta)
        stiff += state.r[node] * chi * np.outer(end, end)
    free = scipy.linalg.null_space(np.array(constraints) / np.linalg.norm(constraints, axis=1)[:, None])
    lowest = scipy.linalg.eigh(free.T @ stiff @ free, free.T @ mass @ free, subset_by_index=[0, 0], eigvals_only=True)
    return float(lowest[0]) * state.length**2


def toroid(problem: Problem) -> State:
    """Return a first guess at S = 0: the circular arc that meets both bodies at their angles and encloses the volume."""
    g = grid(problem.points)
    ci, cj = math.cos(problem.theta_i), math.cos(problem.theta_j)
    ki, kj = problem.kappa_i, problem.kappa_j

    def arc(radius: float) -> State:
        power = 2.0 * radius * (ci + cj) / (ki + kj)  # |centre|² - radius², from the tangency with both bodies
        zc = radius * ci - 0.5 * ki * power
        rc = math.sqrt(power + radius**2 - zc**2)

        def end(kappa: float, theta: float, height: float) -> tuple[float, float]:
            if kappa == 0.0:
                return rc - radius * math.sin(theta), theta
            inner = math.atan2(radius * math.sin(theta), 1.0 / kappa + radius * math.cos(theta))
            phi = math.atan2(rc, 1.0 / kappa + height) - inner
            return phi / kappa, phi + theta

        (arc_i, turn_i), (arc_j, turn_j) = end(ki, problem.theta_i, zc), end(kj, problem.theta_j, -zc)
        psi = 0.5 * (math.pi - turn_i + turn_j) + 0.5 * g.nodes * (turn_j - math.pi + turn_i)
        r, z = rc - radius * np.sin(psi), zc + radius * np.cos(psi)
        pressure = 1.0 / float(np.min(r)) - 1.0 / radius
        length = radius * (math.pi - turn_i - turn_j)
        return State(np.concatenate([r, z, psi, [length, pressure, arc_i, arc_j]]), 0.0)

    size = 1.0 / (ki + kj)
    low, high = 1e-9 * size, 1e-9 * size
    while liquid_volume(problem, arc(high)) < problem.volume:
        low, high = high, 1.5 * high
    return arc(
        float(
            scipy.optimize.brentq(
                lambda radius: liquid_volume(problem, arc(radius)) - problem.volume, low, high, xtol=1e-6 * low
            )
        )
    )


def touching(problem: Problem) -> State:
    """Return the bridge at S = 0, by continuation from a small volume and moderate angles to the requested ones."""
    cube = (2.0 / (problem.kappa_i + problem.kappa_j)) ** 3
    angles = np.array([problem.theta_i, problem.theta_j])
    easy_angles = np.minimum(angles, EASY_ANGLE)
    easy_volume = min(problem.volume, EASY_VOLUME * cube)

    def at(share: float) -> Problem:
        # the first half of the path changes the contact angles, the second half the volume
        ti, tj = easy_angles + (angles - easy_angles) * min(1.0, 2.0 * share)
        volume = easy_volume * (problem.volume / easy_volume) ** max(0.0, 2.0 * share - 1.0)
        return replace(problem, theta_i=float(ti), theta_j=float(tj), volume=volume)

    state = newton(at(0.0), toroid(at(0.0)))
    share, step = 0.0, 0.5
    if np.array_equal(angles, easy_angles):
        share = 0.5
    while state is not None and share < 1.0:
        if easy_volume == problem.volume and share >= 0.5:
            break
        target = min(1.0, share + step, 0.5 if share < 0.5 else 1.0)
        found = newton(at(target), _stretched(state, at(share), at(target)))
        if found is None:
            step *= 0.5
            if step < 1e-4:
                state = None
        else:
            state, share, step = found, target, 1.5 * step
    if state is None:
        raise ArithmeticError(f"no bridge at S = 0 was found for {problem}")
    return state


def _stretched(state: State, old: Problem, new: Problem) -> State:
    """Return a guess for a changed volume: radii as V^(1/4), heights as V^(1/2)."""
    ratio = (new.volume / old.volume) ** 0.25
    tail = [state.length * ratio**2, state.pressure / ratio**2, state.arc_i * ratio, state.arc_j * ratio]
    return State(np.concatenate([state.r * ratio, state.z * ratio**2, state.psi, tail]), 0.0)


@dataclass(frozen=True)
class Point:
    """One bridge of the branch: its state, the direction there and the lowest eigenvalue."""

    state: State
    direction: Floats
    eigenvalue: float


def norm_weight(state: State) -> Floats:
    """Return the weights of the norm for steps along the branch, made of the meridian and the separation."""
    size, n = scales(state), state.n
    weight = 1.0 / size**2
    weight[: 3 * n] /= n
    weight[3 * n : 3 * n + 4] = 0.0
    return np.asarray(weight, dtype=float)


def apart(a: State, b: State, weight: Floats) -> float:
    """Return the length of the path between two bridges."""
    return math.sqrt(float(weight @ np.append(a.x - b.x, a.separation - b.separation) ** 2))


def moved(state: State, direction: Floats, step: float) -> State:
    """Extrapolate a solution along the branch as a guess."""
    return State(state.x + step * direction[:-1], state.separation + step * float(direction[-1]))


def walk(problem: Problem) -> Iterator[Point]:
    """Yield bridges from S = 0 along the branch, by steps in arc length of the branch (which passes folds)."""
    point = at(problem, touching(problem))
    weight = norm_weight(point.state)
    yield point
    step = 0.1
    while step > 1e-7:
        found = step_from(problem, point, step, weight)
        if found is None or float((weight * found.direction) @ point.direction) < 0.9:
            step *= 0.5
            continue
        point = found
        yield point
        step = min(1.4 * step, 0.5)


def at(problem: Problem, state: State) -> Point:
    """Return a bridge as a point of its branch, in the direction of growing separation."""
    weight = norm_weight(state)
    opening = np.zeros(len(state.x) + 1)
    opening[-1] = 1.0 / math.sqrt(weight[-1])
    return Point(state, tangent(problem, state, weight, opening), lowest_eigenvalue(problem, state))


def finer(problem: Problem, point: Point) -> tuple[Problem, Point]:
    """Refine a solution on the branch to twice the number of points."""
    dense = replace(problem, points=2 * problem.points)
    guess, along = refined(point.state, point.direction, dense.points)
    state = newton(dense, guess, along * norm_weight(guess), guess)
    if state is None:
        raise ArithmeticError(f"{problem} could not be refined")
    weight = norm_weight(state)
    return dense, Point(state, tangent(dense, state, weight, along), lowest_eigenvalue(dense, state))


def step_from(problem: Problem, point: Point, step: float, weight: Floats) -> Point | None:
    """Return the bridge one step further along the branch, or None."""
    heading = unit(point.direction, weight)
    guess = moved(point.state, heading, step)
    if guess.length <= 0.0 or np.min(guess.r) <= 0.0:
        return None
    state = newton(problem, guess, heading * weight, guess)
    # a solution far from the guess may be on another branch
    if state is None or apart(state, guess, weight) > 0.5 * abs(step):
        return None
    try:
        direction = tangent(problem, state, weight, heading)
    except np.linalg.LinAlgError:
        return None
    return Point(state, direction, lowest_eigenvalue(problem, state))
