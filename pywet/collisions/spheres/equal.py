"""The paper's case: equal spheres in the dimensionless groups of Davis 2023, table I; times in t̂ = v_n0 t/δ_12."""

from __future__ import annotations

import math

import numpy as np

from pywet.collisions.spheres.problem import NotNegative, Number, Positive, Problem, refuse


def stokes_to_rebound(h_min: float, e_dry: float = 1.0) -> float:
    """Critical Stokes number St_s of two spheres head on (Davis 2023, 42).

    St_s = ((1 + e)/e)[ln(1/h_m) − 3 ln(2 − h_m) + 2 − 2/(2 − h_m)], h_m = h_min/δ_12.

    >>> f"{stokes_to_rebound(0.05):.6f}"
    '3.933206'
    """
    rest = 2.0 - h_min
    return (1.0 + e_dry) / e_dry * (math.log(1.0 / h_min) - 3.0 * math.log(rest) + 2.0 - 2.0 / rest)


def head_on_restitution(stokes: float, h_min: float, e_dry: float = 1.0) -> float:
    """Wet coefficient of restitution of two spheres head on (Davis 2023, 41): e_dry (1 − St_s/St_n), 0 below St_s.

    >>> f"{head_on_restitution(10.0, 0.05):.6f}"
    '0.606679'
    """
    return max(0.0, e_dry * (1.0 - stokes_to_rebound(h_min, e_dry) / stokes))


def direction(angle_deg: float) -> np.ndarray:
    """Return the unit vector at an angle, exact at multiples of 90°."""
    quarter = angle_deg / 90.0
    if quarter == round(quarter):
        return np.array([(1, 0), (0, 1), (-1, 0), (0, -1)][int(quarter) % 4], dtype=float)
    return np.array([math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))])


def three_equal_spheres(
    St_n: Positive,
    Ca: Positive | None = None,
    h_a: Positive = 0.01,
    h_min: Positive = 0.05,
    theta12_deg: Number = 45.0,
    theta23_deg: Number = 0.0,
    h23_0: Positive | None = 1.0,
    d23: Positive = 1.0,
    d13: Positive = 1.0,
    e_dry: Positive = 1.0,
    mu_f: NotNegative = 0.0,
    t_end: Positive = 400.0,
    rtol: Positive = 1e-9,
    reference_speed: Positive | None = None,
) -> Problem:
    """Sphere 1 flies along x at normal speed 1 onto sphere 2, whose films it touches at t = 0; sphere 3 rests next to sphere 2.

    Units: length δ_12, speed v_n0, mass the reduced mass m. Ca = None: no capillary force; h23_0 = None: no third sphere;
    reference_speed: what e_wet refers to, None: v_n0. The JSON form has these keys, ranges and defaults.
    """
    refuse(St_n > 0.0, f"St_n is {St_n:g}; expected a positive number", "St_n")
    refuse(
        Ca is None or Ca > 0.0, f"Ca is {Ca or 0:g}; expected a positive number, or null for no capillary force", "Ca"
    )
    refuse(h_a > 0.0, f"h_a is {h_a:g}; expected a positive number", "h_a")
    refuse(
        abs(theta12_deg) < 90.0,
        f"theta12_deg is {theta12_deg:g}; expected less than 90 either way, else sphere 1 misses sphere 2",
        "theta12_deg",
    )
    radius = 0.5 / h_a  # a_i = 2a, 4a = δ_12/h_a
    reduced = 0.5 * radius
    viscosity = 1.0 / (6.0 * math.pi * reduced**2 * St_n)
    tension = 0.0 if Ca is None else 3.0 * viscosity * reduced / Ca
    one = direction(theta12_deg)
    film, gap = {(0, 1): 1.0}, {(0, 1): 1.0}
    places = [-(2.0 * radius + 1.0) * one, np.zeros(2)]
    if h23_0 is not None:
        places.append((2.0 * radius + h23_0) * direction(theta23_deg))
        film |= {(0, 2): d13, (1, 2): d23}
        gap[1, 2] = h23_0
    n = len(places)
    velocity = np.zeros((n, 2))
    velocity[0, 0] = 1.0 / float(one[0])
    return Problem(
        radius=np.full(n, radius),
        mass=np.full(n, 2.0),
        position=np.array(places),
        velocity=velocity,
        omega=np.zeros(n),
        film=film,
        gap=gap,
        viscosity=viscosity,
        surface_tension=tension,
        h_min=h_min,
        e_dry=e_dry,
        mu_f=mu_f,
        t_end=t_end,
        rtol=rtol,
        speed=1.0,
        reference_speed=reference_speed,
    )
