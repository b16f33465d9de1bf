"""Viscous forces on a sphere in the layer of a wall; equation numbers of Buck et al. (2018)."""

from __future__ import annotations

import math

from numba import njit

GAP_MIN = 0.5e-6
"""Smallest gap of the viscous forces [m]: the roughness (text after (28))."""


@njit(error_model="numpy")
def unbounded(speed: float, rim: float, viscosity: float, density: float) -> float:
    """Drag far from a wall (White 2006): 6π μ r |v| (1 + Re/(4(1 + √Re)) + Re/60) [N], Re = 2 r |v| ρ/μ.

    speed |v| [m/s], rim r = R sin φ [m] (radius of the wetted part), viscosity [Pa s], density of the liquid [kg/m3].
    Valid for Re < 2e5. Source: (25), (26).

    >>> f"{unbounded(1.0, 5e-4, 1e-3, 998.0):.5e}"
    '2.38341e-04'
    """
    reynolds = 2.0 * rim * speed * density / viscosity
    creeping = 6.0 * math.pi * viscosity * rim * speed
    return creeping * (1.0 + 0.25 * reynolds / (1.0 + math.sqrt(reynolds)) + reynolds / 60.0)


@njit(error_model="numpy")
def near_wall(speed: float, gap: float, radius: float, viscosity: float) -> float:
    """Lubrication at a wall: 6π μ R² |v|/gap [N]; gap already bounded below by the roughness, R the (reduced) radius [m].

    Source: (28) with the gap h = y − R (the print has δ_l − y).

    >>> f"{near_wall(1.0, 1e-5, 1e-3, 1e-3):.5e}"
    '1.88496e-03'
    """
    return 6.0 * math.pi * viscosity * radius * radius * speed / gap


@njit(error_model="numpy")
def goldman_force(
    along: float, rim_speed: float, log_gap: float, radius: float, viscosity: float, sign: float
) -> float:
    """Tangential force of Goldman et al. (1967): −6π μ R [((8/15) Λ + 0.9588) v_t + ((2/15) Λ + s 0.2526) ωR] [N].

    along v_t and rim_speed ωR [m/s], log_gap Λ = ln(R/gap) ≥ 0, radius R [m], sign s = −1 (print: +1). Valid for gap ≪ R.
    Source: (29).

    >>> f"{goldman_force(1.0, 1.0, 3.0, 1e-3, 1e-3, -1.0):.5e}"
    '-5.10107e-05'
    """
    slide, roll = 8.0 / 15.0 * log_gap + 0.9588, 2.0 / 15.0 * log_gap + sign * 0.2526
    return -6.0 * math.pi * viscosity * radius * (slide * along + roll * rim_speed)


@njit(error_model="numpy")
def goldman_moment(
    along: float, rim_speed: float, log_gap: float, radius: float, viscosity: float, sign: float
) -> float:
    """Moment over R of Goldman et al. (1967): −8π μ R [((1/10) Λ + s 0.1895) v_t + ((2/5) Λ + 0.3817) ωR] [N].

    Arguments as in `goldman_force`. Source: (30).

    >>> f"{goldman_moment(1.0, 1.0, 3.0, 1e-3, 1e-3, -1.0):.5e}"
    '-4.25296e-05'
    """
    slide, roll = 0.1 * log_gap + sign * 0.1895, 0.4 * log_gap + 0.3817
    return -8.0 * math.pi * viscosity * radius * (slide * along + roll * rim_speed)
