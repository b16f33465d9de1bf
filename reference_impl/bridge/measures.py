"""Measures of a solved meridian: the spread of its force, its narrowest section, the split there, its energy."""

from __future__ import annotations

import itertools
import math

import numpy as np
import scipy  # its parts are loaded where they are used

from reference_impl.bridge.solver import Problem, State, body, cap_volume, grid, interpolation


def force_spread(state: State) -> float:
    """Return the largest difference of the axial force along the meridian, relative to it or to 2 pi r at the narrowest node."""
    force = 2.0 * math.pi * state.r * np.sin(state.psi) - math.pi * state.r**2 * state.pressure
    return float(np.ptp(force) / max(abs(force).min(), 2.0 * math.pi * state.r.min()))


def narrowest(state: State) -> float:
    """Return the position t of the smallest radius: the interior neck, or else a contact line."""
    nodes = grid(state.n - 1).nodes

    def slope(t: float) -> float:
        return float(interpolation(nodes, np.array([t]))[0] @ state.psi) - 0.5 * math.pi

    inner = [
        float(scipy.optimize.brentq(slope, a, b, xtol=1e-15))
        for a, b in itertools.pairwise(nodes)
        if slope(float(a)) > 0.0 >= slope(float(b))
    ]
    places = [-1.0, 1.0, *inner]
    return min(places, key=lambda t: float(interpolation(nodes, np.array([t]))[0] @ state.r))


def share_i(problem: Problem, state: State, neck: float) -> float:
    """Return the share of the liquid below the plane through the narrowest section.

    If that is a contact line, all liquid is on the other side; half if both contact lines are equally narrow.
    """
    if abs(neck) == 1.0:
        equal = abs(state.r[0] - state.r[-1]) < 1e-9 * state.r[0]
        return 0.5 if equal else 0.5 + 0.5 * neck
    g = grid(state.n - 1)
    at = -1.0 + 0.5 * (g.gauss + 1.0) * (neck + 1.0)
    value = interpolation(g.nodes, at)
    rise = 0.5 * state.length * np.sin(value @ state.psi) * 0.5 * (neck + 1.0)
    below = math.pi * float(g.weights @ ((value @ state.r) ** 2 * rise))
    plane = float(interpolation(g.nodes, np.array([neck]))[0] @ state.z)
    half = 0.5 * state.separation
    cap_i = cap_volume(problem.kappa_i, body(problem.kappa_i, state.arc_i)[1])
    above_i = cap_volume(problem.kappa_i, max(0.0, -half - plane))
    below_j = cap_volume(problem.kappa_j, max(0.0, plane - half))
    return (below - (cap_i - above_i) - below_j) / problem.volume


def energy(problem: Problem, state: State) -> float:
    """Return the surface energy with tension 1."""
    g = grid(state.n - 1)
    free = math.pi * state.length * float(g.weights @ (g.value @ state.r))
    wetted = 0.0
    for kappa, theta, arc in (
        (problem.kappa_i, problem.theta_i, state.arc_i),
        (problem.kappa_j, problem.theta_j, state.arc_j),
    ):
        # area of a spherical cap: pi times the square of the chord
        chord = arc if kappa == 0.0 else 2.0 * math.sin(0.5 * kappa * arc) / kappa
        wetted += math.cos(theta) * math.pi * chord**2
    return free - wetted
