"""The exact axisymmetric capillary bridge without gravity between two spheres, or a sphere and a plate (radius math.inf).

Method: the meridian is solved as a boundary-value problem by collocation with polynomials at Gauss points
(bridge_solver), followed in arc length of the branch from S = 0, where stability is the sign of the second variation
(bridge_branch). Conservation of the force is not used, so that its spread along the meridian measures the error;
points are added until it is below 1e-11. Contact angles are in [0, 90°), the surface tension is 1: a force is in
metres, to be multiplied by the tension in N/m.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy  # its parts are loaded where they are used

from reference_impl.bridge.branch import Point, apart, finer, lowest_eigenvalue, moved, norm_weight, step_from, walk
from reference_impl.bridge.measures import energy, force_spread, narrowest, share_i
from reference_impl.bridge.solver import Floats, Problem, State, grid, interpolation, newton
from reference_impl.bridge.solver import unit as unit_direction

SPREAD = 1e-11
MOST_POINTS = 256


@dataclass(frozen=True)
class Bridge:
    """One bridge, in metres; the surface tension is 1. `i` is the lower body, z = 0 is the middle of the gap."""

    separation: float
    force: float
    """Attraction at the narrowest cross-section: 2 pi r sin(psi) - pi r² P."""
    force_i: float
    force_j: float
    """Attraction at the contact line of j."""
    force_spread: float
    """Largest difference of the force along the meridian, relative to the larger of it and 2 pi neck_radius."""
    half_filling_i: float
    half_filling_j: float
    """Angle from the axis to the contact line, seen from the sphere's centre [rad]; nan for a plate."""
    wetted_radius_i: float
    wetted_radius_j: float
    neck_radius: float
    """Smallest radius of the meridian; that of a contact line if there is no neck between the two."""
    curvature: float
    """Mean curvature, half the pressure inside; negative for suction."""
    energy: float
    """Surface energy [m²]: free surface - sum of cos(theta) wetted area; force = d(energy)/d(separation)."""
    share_i: float
    """Share of the volume on i's side of the narrowest cross-section."""
    eigenvalue: float
    """Lowest eigenvalue of the constrained second variation times (arc length)²."""
    stable: bool
    r: Floats
    z: Floats


@dataclass(frozen=True)
class Rupture:
    """End of the stable branch: a fold of the separation, or an earlier onset of an asymmetric mode."""

    separation: float
    transfer_ratio_i: float
    kind: Literal["fold", "instability"]
    bridge: Bridge


def solve(separation: float, volume: float, radius_i: float, radius_j: float, theta_i: float, theta_j: float) -> Bridge:
    """The stable bridge at a separation >= 0 [m]; ValueError where there is none.

    Just below 2, the limit of no liquid:

    >>> f"{solve(0.0, 1e-6, 1.0, 1.0, 0.0, 0.0).force / math.pi:.4f}"
    '1.9777'
    """
    unit, problem = _scaled(volume, radius_i, radius_j, theta_i, theta_j)
    if not 0.0 <= separation < math.inf:
        raise ValueError(f"separation {separation} m was given; expected a number >= 0")
    problem, state = _reach(problem, separation / unit)
    return _bridge(problem, state, unit)


def rupture(volume: float, radius_i: float, radius_j: float, theta_i: float, theta_j: float) -> Rupture:
    """Return the end of the stable branch of bridges of this volume [m³], and the split at the narrowest section there."""
    unit, problem = _scaled(volume, radius_i, radius_j, theta_i, theta_j)
    problem, point, ahead = _bracket(problem)
    last = _end(problem, point, _distance(point, ahead))
    bridge = _bridge(problem, last.state, unit)
    weight = norm_weight(last.state)
    climb = abs(float(unit_direction(last.direction, weight)[-1])) * math.sqrt(float(weight[-1]))
    kind: Literal["fold", "instability"] = "fold" if climb < 1e-3 else "instability"
    return Rupture(bridge.separation, bridge.share_i, kind, bridge)


def branch(volume: float, radius_i: float, radius_j: float, theta_i: float, theta_j: float) -> Iterator[Bridge]:
    """Yield bridges along the branch from S = 0, through the loss of stability and back, as far as resolved (1e-6)."""
    unit, problem = _scaled(volume, radius_i, radius_j, theta_i, theta_j)
    for point in walk(problem):
        if point.state.separation < 0.0 or force_spread(point.state) > 1e-6:
            return
        yield _bridge(problem, point.state, unit)


def _scaled(volume: float, radius_i: float, radius_j: float, theta_i: float, theta_j: float) -> tuple[float, Problem]:
    """Scale a bridge by the radius of the smaller body."""
    if not (radius_i > 0.0 and radius_j > 0.0 and min(radius_i, radius_j) < math.inf):
        raise ValueError(f"radii {radius_i} and {radius_j} m were given; expected both > 0, at most one infinite")
    if not (0.0 <= theta_i < math.pi / 2 and 0.0 <= theta_j < math.pi / 2):
        raise ValueError(f"contact angles {theta_i} and {theta_j} rad were given; expected 0 <= angle < pi/2")
    if not 0.0 < volume < math.inf:
        raise ValueError(f"volume {volume} m³ was given; expected a number > 0")
    unit = min(radius_i, radius_j)
    return unit, Problem(unit / radius_i, unit / radius_j, theta_i, theta_j, volume / unit**3)


def _bracket(problem: Problem, target: float = math.inf) -> tuple[Problem, Point, Point]:
    """Return two neighbours on the branch: the last stable one at or below `target` and the next, beyond it or unstable.

    The problem is returned with the number of points that the second one needs.
    """
    before: Point | None = None
    for point in walk(problem):
        if before is None and point.eigenvalue <= 0.0:
            raise ValueError("the bridge of this volume is not stable at S = 0")
        if before is not None and (point.eigenvalue <= 0.0 or point.state.separation > target):
            break
        before = point
    else:
        raise ArithmeticError(f"the branch of {problem} could not be followed to its end")
    assert before is not None
    ahead = point
    step = _distance(before, ahead)
    while force_spread(ahead.state) > SPREAD and 2 * problem.points <= MOST_POINTS:
        problem, before = finer(problem, before)
        while before.eigenvalue <= 0.0:
            found = step_from(problem, before, -0.25 * step, norm_weight(before.state))
            if found is None:
                raise ArithmeticError(f"{problem} could not be refined")
            before = found
        # at a sharp bend of the branch only a shorter step converges
        steps = (step_from(problem, before, step / 2**k, norm_weight(before.state)) for k in range(20))
        ahead = next(point for point in steps if point is not None)
    return problem, before, ahead


def _distance(a: Point, b: Point) -> float:
    return apart(a.state, b.state, norm_weight(a.state))


def _end(problem: Problem, point: Point, step: float) -> Point:
    """Find the point beyond the stable `point`, within about `step`, at which the lowest eigenvalue is zero."""
    # a sharp bend close to the end (nearly equal bodies) may require a start closer to it
    for near in (2e-3, 2e-5, 2e-7):
        point, step = _approached(problem, point, step, near)
        found = _zero(problem, point, step)
        if found is not None:
            return found
    raise ArithmeticError(f"the end of the branch of {problem} could not be resolved")


def _approached(problem: Problem, point: Point, step: float, near: float) -> tuple[Point, float]:
    """Return a stable point within about `near` of the end, by steps that are halved if they pass the end or cut a bend."""
    while step > near:
        weight = norm_weight(point.state)
        found = step_from(problem, point, step, weight)
        if found is not None and found.eigenvalue > 0.0 and _agree(point, found, weight):
            point = found
        else:
            step *= 0.5
    return point, step


def _zero(problem: Problem, point: Point, step: float) -> Point | None:
    """Return the point of eigenvalue zero on the branch beyond `point`, or None if a step to it fails."""
    weight = norm_weight(point.state)
    seen: dict[float, Point] = {0.0: point}

    def eigenvalue(length: float) -> float:
        if length not in seen:
            found = step_from(problem, point, length, weight)
            if found is None or not _agree(point, found, weight):
                raise ArithmeticError
            seen[length] = found
        return seen[length].eigenvalue

    try:
        high = 2.0 * step
        while eigenvalue(high) > 0.0:
            high *= 1.5
        root = float(scipy.optimize.brentq(eigenvalue, 0.0, high, xtol=1e-14, rtol=1e-12))
        eigenvalue(root)
    except ArithmeticError:
        return None
    return seen[root]


def _agree(a: Point, b: Point, weight: Floats) -> bool:
    """Return whether the branch turned by less than about 25° between two points."""
    return float((weight * unit_direction(a.direction, weight)) @ unit_direction(b.direction, weight)) > 0.9


def _reach(problem: Problem, target: float) -> tuple[Problem, State]:
    """Return the stable bridge at this separation (in units)."""
    problem, point, ahead = _bracket(problem, target)
    step = _distance(point, ahead)
    while step > 1e-9:
        heading = unit_direction(point.direction, norm_weight(point.state))
        climb = float(heading[-1])
        to_go = (target - point.state.separation) / climb if climb > 0.0 else math.inf
        if to_go < 2.0 * step:
            guess = replace(moved(point.state, heading, to_go), separation=target)
            found = newton(problem, guess)
            if found is not None and lowest_eigenvalue(problem, found) > 0.0:
                return problem, found
        nearer = step_from(problem, point, step, norm_weight(point.state))
        if nearer is not None and nearer.eigenvalue > 0.0 and nearer.state.separation <= target:
            point = nearer
        else:
            step *= 0.5
    raise ValueError(
        f"no stable bridge at {target:.9g} of the smaller radius; expected less than {point.state.separation:.9g}, its rupture"
    )


def _bridge(problem: Problem, state: State, unit: float) -> Bridge:
    """Convert the scaled solution of a bridge to metres."""
    neck = narrowest(state)
    row = interpolation(grid(state.n - 1).nodes, np.array([neck]))[0]
    force = 2.0 * math.pi * state.r * np.sin(state.psi) - math.pi * state.r**2 * state.pressure
    rn, psin = float(row @ state.r), float(row @ state.psi)
    at_neck = 2.0 * math.pi * rn * math.sin(psin) - math.pi * rn**2 * state.pressure
    eigenvalue = lowest_eigenvalue(problem, state)
    return Bridge(
        separation=unit * state.separation,
        force=unit * at_neck,
        force_i=unit * float(force[0]),
        force_j=unit * float(force[-1]),
        force_spread=force_spread(state),
        half_filling_i=problem.kappa_i * state.arc_i if problem.kappa_i > 0.0 else math.nan,
        half_filling_j=problem.kappa_j * state.arc_j if problem.kappa_j > 0.0 else math.nan,
        wetted_radius_i=unit * float(state.r[0]),
        wetted_radius_j=unit * float(state.r[-1]),
        neck_radius=unit * rn,
        curvature=0.5 * state.pressure / unit,
        energy=unit**2 * energy(problem, state),
        share_i=share_i(problem, state, neck),
        eigenvalue=eigenvalue,
        stable=eigenvalue > 0.0,
        r=unit * state.r,
        z=unit * state.z,
    )
