"""Dry contact: Hertz (1882) with the damping of Tsuji et al. (1992), Mindlin's tangential spring, Coulomb's limit.

Equation numbers are those of Buck et al. (2018). R* is the reduced radius of the pair (sphere-wall: the sphere's radius).
"""

from __future__ import annotations

import math

from numba import njit


def damping_constant(restitution: float) -> float:
    """α = −√5 ln e/√(ln² e + π²) [-], so that the contact returns e at every velocity. e = 0: the limit √5. Source: (16).

    The print's √(5/2) is read as √5/√(…): with it, and with the contact ended at zero overlap, e comes out as put in.

    >>> f"{damping_constant(0.76):.6f}"
    '0.194593'
    """
    if restitution <= 0.0:
        return math.sqrt(5.0)
    log = math.log(restitution)  # as in stored digests: the steps of an adaptive integrator depend on the last bit
    return -math.sqrt(5.0) * log / math.hypot(log, math.pi)


def effective_modulus(modulus_i: float, poisson_i: float, modulus_j: float, poisson_j: float) -> float:
    """1/E* = (1 − ν_i²)/E_i + (1 − ν_j²)/E_j; moduli and result [Pa]. Source: (15).

    >>> f"{effective_modulus(63e9, 0.23, 63e9, 0.23):.5e}"
    '3.32594e+10'
    """
    return 1.0 / ((1.0 - poisson_i**2) / modulus_i + (1.0 - poisson_j**2) / modulus_j)


def effective_shear(modulus_i: float, poisson_i: float, modulus_j: float, poisson_j: float, printed: bool) -> float:
    """1/G* = Σ (2 − ν)/G with G = E/(2(1 + ν)) [Pa]; `printed`: 2 − ν², as the paper has it. Source: (21), (22), mended.

    >>> f"{effective_shear(14.5e9, 0.25, 63e9, 0.23, False):.5e}"
    '2.69659e+09'
    """
    power = 2 if printed else 1
    shear_i, shear_j = (e / (2.0 * (1.0 + nu)) for e, nu in ((modulus_i, poisson_i), (modulus_j, poisson_j)))
    return 1.0 / ((2.0 - poisson_i**power) / shear_i + (2.0 - poisson_j**power) / shear_j)


@njit(error_model="numpy")
def normal_force(overlap: float, rate: float, stiffness: float, damping: float) -> float:
    """F = k δ^{3/2} + d δ^{1/4} δ̇ [N], repulsion positive; overlap δ [m], rate δ̇ [m/s], k = (4/3) E* √R* [N/m^1.5],
    d = α √(m* k) [kg/(s m^0.25)]. Zero at δ ≤ 0. Source: (9), (11), (12).

    >>> f"{normal_force(1e-5, 0.1, 1e9, 0.02):.6f}"
    '31.622889'
    """
    if overlap <= 0.0:
        return 0.0
    root = math.sqrt(overlap)
    return stiffness * overlap * root + damping * math.sqrt(root) * rate


@njit(error_model="numpy")
def tangential_force(
    overlap: float, slip: float, slip_rate: float, shear: float, damping: float, limit: float
) -> float:
    """F = −(k_t δ_t + d δ^{1/4} v_c) [N], clipped to ± limit; k_t = shear √δ with shear = 8 G* √R* [N/m^1.5].

    slip δ_t [m] is the way of the contact point over the whole contact, also while it slides; slip_rate v_c = v_t + ω R [m/s];
    limit = μ max(F_n, 0) [N]. Source: (18)-(20), (23), (24).

    >>> f"{tangential_force(1e-6, 1e-8, 0.01, 1e9, 0.0, 1.0):.6f}"
    '-0.010000'
    """
    if overlap <= 0.0:
        return 0.0
    root = math.sqrt(overlap)
    force = -(shear * root * slip + damping * math.sqrt(root) * slip_rate)
    return min(max(force, -limit), limit)
