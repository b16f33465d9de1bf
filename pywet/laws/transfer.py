"""Shares of the liquid of a rupturing bridge: the parabola model, solved once into a table over V*.

The meridian is Y(x) = a x² + b x + c between the two contact lines (Elskamp & Kruggel-Emden 2018, 35-43, with the
signs of 40 and the cap of 43 corrected). With half-filling angles α as unknowns, contact radii and slopes are Y(0) =
r_i sin α_i, Y'(0) = −cot(θ_i + α_i), Y(D) = r_j sin α_j, Y'(D) = cot(θ_j + α_j), D = d_i + d_j + S, d = r (1 − cos
α). A parabola satisfies Y(D) − Y(0) = D (Y'(0) + Y'(D))/2; this and the volume are the two remaining equations. S is
the static rupture distance; at walls `stretch` is the fraction of it at which the same system is solved. A large wall
counts as a sphere of the same size, a wire as a sphere of its radius, both without a cap on the wall's side (the
paper after 43).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pywet.errors import PywetError
from pywet.laws.contact import effective_radius
from pywet.laws.rupture import willett_unequal
from pywet.schema import LARGE_WALL, SPHERE

Floats = NDArray[np.float64]


def v_star_grid(nodes: int) -> Floats:
    """Return the nodes of a table over V*, 0 … 0.5, dense at small V*: the ratio is smooth in V*^(1/3)."""
    return np.asarray(0.5 * np.linspace(0.0, 1.0, nodes) ** 3)


V_STAR_GRID: Floats = v_star_grid(201)
"""Default nodes of a table over V*."""
SMALLEST = 1e-5
"""Value of V* that represents V* → 0 in the table's first entry."""


@dataclass(frozen=True)
class Pair:
    """The two bodies in the parabola model; `cap_j` is 1 for a sphere, 0 for a wall [m, rad]."""

    radius_i: float
    radius_j: float
    theta_i: float
    theta_j: float
    cap_j: float


@dataclass(frozen=True)
class Bridge:
    """A solved meridian: coefficients of Y, length D, half-filling angles, partial volumes V_i, V_j."""

    a: float
    b: float
    c: float
    length: float
    alpha_i: float
    alpha_j: float
    volume_i: float
    volume_j: float


def _integral(a: float, b: float, c: float, x: float) -> float:
    """Return ∫₀ˣ π Y² dx."""
    return math.pi * (a * a * x**5 / 5 + a * b * x**4 / 2 + (b * b + 2 * a * c) * x**3 / 3 + b * c * x * x + c * c * x)


def _cap(radius: float, alpha: float) -> float:
    """Return the volume of the spherical cap of half angle α."""
    d = radius * (1.0 - math.cos(alpha))
    return math.pi / 6.0 * (3.0 * (radius * math.sin(alpha)) ** 2 * d + d**3)


def shape(pair: Pair, alpha_i: float, alpha_j: float, separation: float) -> Bridge:
    """Return the parabola through both contact lines with the difference of both slopes, in closed form in the angles."""
    d = pair.radius_i * (1 - math.cos(alpha_i)) + pair.radius_j * (1 - math.cos(alpha_j)) + separation
    start, end = -1.0 / math.tan(pair.theta_i + alpha_i), 1.0 / math.tan(pair.theta_j + alpha_j)
    a, b, c = (end - start) / (2.0 * d), start, pair.radius_i * math.sin(alpha_i)
    neck = min(max(-b / (2.0 * a) if a > 0 else 0.0, 0.0), d)
    whole, left = _integral(a, b, c, d), _integral(a, b, c, neck)
    volume_i = left - _cap(pair.radius_i, alpha_i)
    volume_j = whole - left - pair.cap_j * _cap(pair.radius_j, alpha_j)
    return Bridge(a, b, c, d, alpha_i, alpha_j, volume_i, volume_j)


def residual(pair: Pair, bridge: Bridge, volume: float) -> tuple[float, float]:
    """Return the relative misfit of the far contact radius and of the volume."""
    y = bridge.a * bridge.length**2 + bridge.b * bridge.length + bridge.c
    far = pair.radius_j * math.sin(bridge.alpha_j)
    return (y - far) / volume ** (1 / 3), (bridge.volume_i + bridge.volume_j) / volume - 1.0


def solve(pair: Pair, volume: float, separation: float, guess: tuple[float, float]) -> Bridge | None:
    """Solve the meridian for a volume and separation near a guess of the angles; None if there is no solution."""

    def equations(angles: Floats) -> tuple[float, float]:
        return residual(pair, shape(pair, float(angles[0]), float(angles[1]), separation), volume)

    from scipy.optimize import root  # closed-form laws do not need scipy

    angles = root(equations, guess, method="hybr", options={"xtol": 1e-13}).x
    alpha_i, alpha_j = (float(x) for x in angles)
    if not (0 < alpha_i < math.pi / 2 and 0 < alpha_j < math.pi / 2):
        return None
    bridge = shape(pair, alpha_i, alpha_j, separation)
    good = max(abs(x) for x in residual(pair, bridge, volume)) < 1e-9
    inside = bridge.a > 0 and bridge.volume_i >= 0 and bridge.volume_j >= 0
    return bridge if good and inside and bridge.c > bridge.b**2 / (4 * bridge.a) else None


def _first(pair: Pair, volume: float, separation: float) -> Bridge | None:
    """Solve without a neighbour to start from: a grid of guesses around the cylinder of that volume."""
    width = math.sqrt(volume / (math.pi * separation))
    for scale, skew in itertools.product((1.0, 1.3, 0.8, 1.7, 0.6, 2.2), (1.0, 1.3, 0.75, 1.7, 0.6)):
        guess = (min(scale * skew * width / pair.radius_i, 1.4), min(scale / skew * width / pair.radius_j, 1.4))
        bridge = solve(pair, volume, separation, guess)
        if bridge is not None:
            return bridge
    return None


def transfer_table(
    radius_i: float,
    size_j: float,
    theta_i: float,
    theta_j: float,
    kind: int,
    v_star: Floats = V_STAR_GRID,
    stretch: float = 1.0,
) -> Floats:
    """Transfer ratio T_i = V_i/(V_i + V_j) over V*, shape of `v_star`.

    `kind` 0: `size_j` is the other sphere's radius; 1: a large wall (`size_j` is not used); 2: a wire of radius `size_j`.
    V* = V/r³ with r the harmonic mean of the radii, for walls r_i. `stretch`: separation over the rupture distance at walls.

    A solution has half-filling angles below 90°, a neck of positive radius, both parts ≥ 0 and a convex meridian; a dense scan
    of α_i (radii 1:1 to 5:1, angles 0 to 85°, V* 1e-5 to 0.5) found no cell with two. Where there is none: V* = 0 takes the
    value at 1e-5; below the smallest solvable V* (small contact angles: the neck closes) the first solved value holds; above
    the largest (large angles, thin wires: the neck reaches a contact line, T near 0 or 1) the last one.
    Linear interpolation on V_STAR_GRID is within 0.0011 of the solution for V* ≥ 1e-5 and the materials of the paper
    (201 equally spaced nodes would be off by up to 0.11 below V* = 0.0025).

    >>> float(transfer_table(2e-3, 2e-3, 0.5, 0.5, SPHERE)[7])
    0.5
    """
    check_numbers(kind, radius_i, size_j, v_star, stretch)
    if not (0.0 <= theta_i < math.pi / 2 and 0.0 <= theta_j < math.pi / 2):
        raise PywetError(
            f"contact angles of {math.degrees(theta_i):g} and {math.degrees(theta_j):g} deg given to the parabola model; "
            "expected angles from 0 to below 90 deg: fix contact_angle_deg of the materials",
            code="transfer.angles", key="contact_angle_deg", given=(math.degrees(theta_i), math.degrees(theta_j)),
        )  # fmt: skip
    if kind == SPHERE:
        return _ordered(radius_i, size_j, theta_i, theta_j, v_star)
    radius_j = radius_i if kind == LARGE_WALL else size_j
    pair = Pair(radius_i, radius_j, theta_i, theta_j, 0.0)
    return _march(pair, v_star, radius_i, math.inf, stretch)


def check_numbers(kind: int, radius_i: float, size_j: float, v_star: Floats, stretch: float = 1.0) -> None:
    """Refuse arguments of a table that are not finite or not positive; V* may be 0, a large wall has no size."""
    given = {"radius_i": radius_i, "stretch": stretch, **({} if kind == LARGE_WALL else {"size_j": size_j})}
    wrong = [(name, value) for name, value in given.items() if not 0.0 < value < math.inf]
    wrong += [("v_star", float(value)) for value in v_star if not 0.0 <= value < math.inf]
    for name, value in wrong:
        raise PywetError(
            f"{name} = {value:g} given to a table of transfer ratios; expected a finite positive number",
            code="transfer.number", key=name, given=value,
        )  # fmt: skip


def _ordered(radius_i: float, radius_j: float, theta_i: float, theta_j: float, v_star: Floats) -> Floats:
    """Return the ratios for two spheres, larger first, so that T_i(i, j) + T_j(j, i) = 1 exactly; equal spheres share equally."""
    if (radius_i, theta_i) == (radius_j, theta_j):
        return np.full(len(v_star), 0.5)
    if (radius_i, theta_i) < (radius_j, theta_j):
        return 1.0 - _ordered(radius_j, radius_i, theta_j, theta_i, v_star)
    pair = Pair(radius_i, radius_j, theta_i, theta_j, 1.0)
    return _march(pair, v_star, effective_radius(radius_i, radius_j), radius_j, 1.0)


def _march(pair: Pair, v_star: Floats, r: float, rupture_radius_j: float, stretch: float) -> Floats:
    """Follow the solution from small to large V*, each started from its neighbour."""
    ratios: list[float] = []
    last: Bridge | None = None
    for reduced in v_star:
        volume = max(float(reduced), SMALLEST) * r**3
        gap = stretch * willett_unequal.python(volume, pair.radius_i, rupture_radius_j, pair.theta_i, pair.theta_j)
        bridge = solve(pair, volume, gap, (last.alpha_i, last.alpha_j)) if last else None
        bridge = bridge or _first(pair, volume, gap)
        if bridge is not None:
            last = bridge
            ratios.append(bridge.volume_i / (bridge.volume_i + bridge.volume_j))
        else:
            ratios.append(ratios[-1] if ratios else math.nan)
    filled = np.array(ratios)
    known = np.flatnonzero(np.isfinite(filled))
    if len(known) == 0:
        raise PywetError(
            f"the parabola model has no solution for radii {pair.radius_i:g} and {pair.radius_j:g} m and contact angles "
            f"{math.degrees(pair.theta_i):g} and {math.degrees(pair.theta_j):g} deg; expected smaller contact angles "
            "or more equal bodies, or the transfer law young_laplace in place of parabola",
            code="transfer.no_solution",
        )
    filled[: known[0]] = filled[known[0]]
    return filled


def halves(
    radius_i: float, size_j: float, theta_i: float, theta_j: float, kind: int, v_star: Floats = V_STAR_GRID
) -> Floats:
    """Half of a ruptured bridge to either body, T_i = 1/2 for all sizes: sharing by size switched off.

    Arguments as `transfer_table` [m, rad, -]. Exact for equal spheres; no source, a simplification to compare with.

    >>> halves(2e-3, 1e-3, 0.5, 0.5, SPHERE, np.array([0.0, 0.1])).tolist()
    [0.5, 0.5]
    """
    return np.full(len(v_star), 0.5)
