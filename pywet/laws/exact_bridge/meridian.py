"""The meridian of an axisymmetric liquid bridge without gravity: the closed form in arc length, and the equations of a bridge.

On a surface of constant mean curvature H, f = r cos α − H r² is constant along the meridian (α: angle between tangent
and axis; 2πσf is the force). With w = r² and arc length t from the contact line on body i that integrates to w(t) =
w_i + w_i' t sinc(2Ht) + (w_i''/2) t² sinc²(Ht), w_i' = −2 ρ_i cos(θ_i + φ_i), w_i'' = 2 − 4H ρ_i sin(θ_i + φ_i),
smooth through H = 0 (catenoid), cylinders and inflections. Only length and volume need quadrature: z = ∫ (f + H w)/√w
dt, ∫ π r² dz = π ∫ √w (f + H w) dt.

Everything here is compiled; lengths are in any one unit, σ = 1. `branch.py` follows branches and finds rupture.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pywet.util.machine_code import numba

Floats = NDArray[np.float64]
jit = numba.njit(cache=True, error_model="numpy")

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)
NODES: Floats = 0.5 * (_NODES + 1.0)
WEIGHTS: Floats = 0.5 * _WEIGHTS
"""Weights of Gauss-Legendre quadrature on [0, 1]; 48 nodes integrate a meridian whose neck is a tenth of its length to 1e-13."""

PHI_I, PHI_J, CURVATURE, LENGTH, GAP = 0, 1, 2, 3, 4
"""Indices of the unknowns: half-filling angles (wetted radius on a plate), mean curvature, arc length, separation."""


class Case(NamedTuple):
    """Volume, radii and contact angles of a bridge to be solved; between equal bodies half a bridge is solved."""

    volume: float
    ri: float
    rj: float
    ti: float
    tj: float
    symmetric: bool


@jit
def sinc(x: float) -> float:
    """Return sin(x)/x, 1 at 0."""
    return 1.0 - x * x / 6.0 * (1.0 - x * x / 20.0) if abs(x) < 1e-3 else math.sin(x) / x


@jit
def contact(angle: float, radius: float, theta: float) -> tuple[float, float, float, float, float]:
    """Return contact radius, sin α and cos α there (positive if opening outwards), cap height and cap volume of a body.

    `angle` is the half-filling angle on a sphere; on a plate (radius infinite) the wetted radius itself.
    """
    if math.isinf(radius):
        return angle, math.cos(theta), math.sin(theta), 0.0, 0.0
    half = math.sin(0.5 * angle)
    height = 2.0 * radius * half * half
    cap = math.pi / 3.0 * height * height * (3.0 * radius - height)
    return radius * math.sin(angle), math.cos(theta + angle), math.sin(theta + angle), height, cap


@jit
def start(y: Floats, c: Case) -> tuple[float, float, float, float]:
    """Return w, w', w'' at the contact line of body i, and f."""
    rho, sine, cosine, _, _ = contact(y[PHI_I], c.ri, c.ti)
    h = y[CURVATURE]
    return rho * rho, -2.0 * rho * sine, 2.0 - 4.0 * h * rho * cosine, rho * cosine - h * rho * rho


@jit
def square(t: float, h: float, w0: float, w1: float, w2: float) -> float:
    """Return w = r² at arc length t."""
    a = sinc(h * t) * t
    return w0 + w1 * t * sinc(2.0 * h * t) + 0.5 * w2 * a * a


@jit
def slope(t: float, h: float, w1: float, w2: float) -> float:
    """Return dw/dt = 2 r sin α at arc length t."""
    return w1 * math.cos(2.0 * h * t) + w2 * t * sinc(2.0 * h * t)


@jit
def integrals(t: float, h: float, w0: float, w1: float, w2: float, f: float) -> tuple[float, float]:
    """Return the axial length and ∫ π r² dz from the contact line of body i to arc length t."""
    z = volume = 0.0
    for k in range(NODES.size):
        w = max(square(t * NODES[k], h, w0, w1, w2), 1e-300)
        r = math.sqrt(w)
        rate = (f + h * w) * WEIGHTS[k]
        z += rate / r
        volume += rate * r
    return z * t, math.pi * volume * t


@jit
def residual(y: Floats, c: Case) -> Floats:
    """Return the misfit of a trial bridge: far contact radius, far angle, separation, volume.

    The unknowns are y = (φ_i, φ_j, H, length, separation). For equal bodies half a bridge is used, so that the
    branch remains symmetric.
    """
    h, t = y[CURVATURE], y[LENGTH]
    w0, w1, w2, f = start(y, c)
    rho_j, sine, cosine, height_j, cap_j = contact(y[PHI_J], c.rj, c.tj)
    _, _, _, height_i, cap_i = contact(y[PHI_I], c.ri, c.ti)
    z, whole = integrals(t, h, w0, w1, w2, f)
    out = np.empty(4)
    if c.symmetric:
        out[0] = y[PHI_J] / y[PHI_I] - 1.0
        out[1] = slope(0.5 * t, h, w1, w2) / math.sqrt(w0)
    else:
        w = square(t, h, w0, w1, w2)
        out[0] = w / (rho_j * rho_j) - 1.0
        out[1] = (0.5 * slope(t, h, w1, w2) * cosine - (f + h * w) * sine) / rho_j
    out[2] = (z - height_i - height_j - y[GAP]) / t
    out[3] = (whole - cap_i - cap_j) / c.volume - 1.0
    return out


@jit
def antisymmetric(y: Floats, c: Case) -> float:
    """Return a number whose sign changes where an asymmetric branch of solutions begins between equal bodies.

    Moving the meridian along the axis while both contact lines slide requires no energy if H R sin 2φ = sin(2φ +
    θ). A cylinder moved along its axis does not change; dividing by 1 − 2H r at half length removes that zero.
    """
    phi, h = y[PHI_I], y[CURVATURE]
    w0, w1, w2, _ = start(y, c)
    middle = math.sqrt(square(0.5 * y[LENGTH], h, w0, w1, w2))
    return (math.sin(2.0 * phi + c.ti) - h * c.ri * math.sin(2.0 * phi)) / (1.0 - 2.0 * h * middle)
