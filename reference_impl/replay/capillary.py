"""Closed-form capillary forces in numpy, implemented independently from the papers; magnitudes, attraction positive.

All have the arguments (S, V, r_i, r_j, wall, theta_i, theta_j, sigma) and treat S < 0 as S = 0; at a wall r_j is not
used. Numbers (E n) are those of Elskamp & Kruggel-Emden 2018, corrected unless the name ends in `_as_printed`. The
exact force is in exact.py.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from reference_impl.replay.laws import Flags, Floats, harmonic_radius

Law = Callable[[Floats, Floats, Floats, Floats, Flags, Floats, Floats, float], Floats]


def limit_radius(ri: Floats, rj: Floats, wall: Flags) -> Floats:
    """Return r_eff of two spheres; at a wall its limit for r_j -> infinity, 2 r_i."""
    return np.where(wall, 2.0, 1.0) * harmonic_radius(ri, rj, wall)


def limit_at_touch(ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float) -> Floats:
    """Return the exact force for S = 0 and V -> 0: pi r_eff sigma (cos theta_i + cos theta_j), r_eff = 2 r_i at a wall."""
    return np.pi * sigma * limit_radius(ri, rj, wall) * (np.cos(ti) + np.cos(tj))


def _immersion(gap: Floats, v: Floats, r: Floats, wall: Flags) -> Floats:
    """Return d of (E 16, 18): 2 d² + 2 S d = V/(pi r) between spheres, d² + 2 S d = V/(pi r) at a wall."""
    square = np.where(wall, 1.0, 2.0)
    return (v / (np.pi * r)) / (gap + np.sqrt(gap**2 + square * v / (np.pi * r)))


def _line(r: Floats, lever: Floats, phi: Floats, ti: Floats, tj: Floats, sigma: float) -> Floats:
    """Return the surface tension force on a contact line: 2 pi sigma r sin(lever) sin(phi + theta_m)."""
    return 2.0 * np.pi * sigma * r * np.sin(lever) * np.sin(phi + (ti + tj) / 2.0)


def rabinovich(
    s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float
) -> Floats:
    """Return the neck term plus the surface-tension term (E 14, 15)."""
    r, gap = harmonic_radius(ri, rj, wall), np.maximum(s, 0.0)
    d = _immersion(gap, v, r, wall)
    phi = np.sqrt(2.0 * d / r)
    neck = limit_at_touch(ri, rj, wall, ti, tj, sigma) / (1.0 + np.where(wall, gap, gap / 2.0) / d)
    return neck + _line(r, phi, phi, ti, tj, sigma)


def rabinovich_small_gap(
    s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float
) -> Floats:
    """Return the force with the first term for S -> 0: d = sqrt(V/(pi r)) at a wall, sqrt(V/(2 pi r)) between spheres."""
    r, gap = harmonic_radius(ri, rj, wall), np.maximum(s, 0.0)
    phi = np.sqrt(2.0 * _immersion(gap, v, r, wall) / r)
    near = np.sqrt(v / (np.pi * r) / np.where(wall, 1.0, 2.0))
    neck = limit_at_touch(ri, rj, wall, ti, tj, sigma) / (1.0 + np.where(wall, gap, gap / 2.0) / near)
    return neck + _line(r, phi, phi, ti, tj, sigma)


def rabinovich_as_printed(
    s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float
) -> Floats:
    """Return the force with lever sin(theta_m) for sin(phi); at a wall 1 + S sqrt(pi r/V), and phi of (E 18) without its -1."""
    r, gap = harmonic_radius(ri, rj, wall), np.maximum(s, 0.0)
    d = _immersion(gap, v, r, wall)
    flat = v / (np.pi * r)
    # S sqrt(1 + V/(pi r S²)) = sqrt(S² + V/(pi r)) holds at S = 0 too
    phi = np.sqrt(np.where(wall, 2.0 * np.sqrt(gap**2 + flat), 2.0 * d) / r)
    weaker = 1.0 + np.where(wall, gap / np.sqrt(flat), gap / (2.0 * d))
    neck = limit_at_touch(ri, rj, wall, ti, tj, sigma) / weaker
    return neck + _line(r, (ti + tj) / 2.0, phi, ti, tj, sigma)


def rabinovich_spheres_as_printed(
    s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float
) -> Floats:
    """Return the force with (E 14) as printed, (E 15) corrected."""
    given = (s, v, ri, rj, wall, ti, tj, sigma)
    return np.where(wall, rabinovich(*given), rabinovich_as_printed(*given))


def rabinovich_walls_as_printed(
    s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float
) -> Floats:
    """Return the force with (E 14) corrected, (E 15, 18) as printed."""
    given = (s, v, ri, rj, wall, ti, tj, sigma)
    return np.where(wall, rabinovich_as_printed(*given), rabinovich(*given))


def lambert(s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float) -> Floats:
    """Return the first term of (E 14) alone."""
    r, gap = limit_radius(ri, rj, wall), np.maximum(s, 0.0)
    d = _immersion(gap, v, r, np.zeros_like(wall))
    return limit_at_touch(ri, rj, wall, ti, tj, sigma) / (1.0 + gap / (2.0 * d))


# fmt: off
WILLETT = np.array([
    [[-0.44507, 0.050832, -1.1466], [-0.1119, -0.000411, -0.1490], [-0.012101, -0.0036456, -0.01255],
     [-0.0005, -0.0003505, -0.00029076]],
    [[1.9222, -0.57473, -1.2918], [-0.0668, -0.1201, -0.22574], [-0.0013375, -0.0068988, -0.01137],
     [0.0, 0.0, 0.0]],
    [[1.268, -0.01396, -0.23566], [0.198, 0.092, -0.06418], [0.02232, 0.02238, -0.009853],
     [0.0008585, 0.001318, -0.00053]],
    [[-0.010703, 0.073776, -0.34742], [0.03345, 0.04543, -0.09056], [0.0018574, 0.004456, -0.006257],
     [0.0, 0.0, 0.0]],
])
# fmt: on
"""Coefficients of f1 to f4 by power of ln V* (four) and of theta (three) (E 20)."""


def willett(s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float) -> Floats:
    """Return the full fit (E 19, 20), with V* limited to 1e-3 … 0.1 in its polynomials."""
    r, theta = limit_radius(ri, rj, wall), (ti + tj) / 2.0
    x = np.log(np.clip(v / r**3, 1e-3, 0.1))
    powers = np.stack([x**0, x, x**2, x**3])
    angles = np.stack([theta**0, theta, theta**2])
    f1, f2, f3, f4 = np.einsum("fpa,pn,an->fn", WILLETT, powers, angles)
    apart = s > 0.0
    reach = np.log(np.where(apart, s, 1.0) / 2.0 * np.sqrt(r / v))
    fall = np.where(apart, f2 * np.exp(f3 * reach + f4 * reach**2), 0.0)
    return 2.0 * np.pi * r * sigma * np.exp(f1 - fall)


def willett_simple(
    s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float
) -> Floats:
    """Return the short fit (E 21) with pi."""
    reach = np.maximum(s, 0.0) / 2.0 * np.sqrt(limit_radius(ri, rj, wall) / v)
    return limit_at_touch(ri, rj, wall, ti, tj, sigma) / (1.0 + 2.1 * reach + 10.0 * reach**2)


def willett_simple_as_printed(
    s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float
) -> Floats:
    """Return the short fit (E 21) with 2 pi."""
    return 2.0 * willett_simple(s, v, ri, rj, wall, ti, tj, sigma)


def _boundary(gap: Floats, v: Floats, r: Floats, theta: Floats, part: float) -> tuple[Floats, Floats]:
    """Return phi (E 23) and the pressure over sigma (E 24); `part`: share of S in the height of the meridian."""
    quartic = v / (0.12 * (2.0 * r) ** 3 * (1.0 + 6.0 * gap / (2.0 * r)) * (1.0 + 1.1 * np.sin(theta)))
    phi = np.arcsin(np.minimum(quartic, 1.0) ** 0.25)
    height = r * (1.0 - np.cos(phi)) + part * gap
    # R1 = height/cos(a) is infinite at a = 90°; R1 (1 - sin a) = height tan(45° - a/2) is not
    a = phi + theta
    return phi, np.cos(a) / height - 1.0 / (r * np.sin(phi) - height * np.tan(np.pi / 4.0 - a / 2.0))


def weigert(s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float) -> Floats:
    """Return the force by the boundary method (E 22-24)."""
    r = limit_radius(ri, rj, wall)
    phi, pressure = _boundary(np.maximum(s, 0.0), v, r, (ti + tj) / 2.0, 0.5)
    return np.pi * (r * np.sin(phi)) ** 2 * sigma * pressure + _line(r, phi, phi, ti, tj, sigma)


def weigert_as_printed(
    s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float
) -> Floats:
    """Return the boundary method with S in place of S/2 in (E 24) and the lever sin(theta_m) in (E 22)."""
    r = limit_radius(ri, rj, wall)
    phi, pressure = _boundary(np.maximum(s, 0.0), v, r, (ti + tj) / 2.0, 1.0)
    return np.pi * (r * np.sin(phi)) ** 2 * sigma * pressure + _line(r, (ti + tj) / 2.0, phi, ti, tj, sigma)


def soulie(s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float) -> Floats:
    """Return the force of Soulié et al. 2006 (4)-(7), not below 0; at a wall both its lengths are 2 r_i."""
    larger = np.where(wall, 2.0 * ri, np.maximum(ri, rj))
    mean = np.where(wall, 2.0 * ri, np.sqrt(ri * rj))
    log, theta = np.log(v / larger**3), (ti + tj) / 2.0
    a = -1.1 * np.exp(-0.53 * log)
    b = -(0.148 * log + 0.96) * theta**2 - 0.0082 * log + 0.48
    c = 0.0018 * log + 0.078
    return np.maximum(np.pi * sigma * mean * (c + np.exp(a * np.maximum(s, 0.0) / larger + b)), 0.0)


def bagheri(s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats, sigma: float) -> Floats:
    """Return the force of Bagheri, Roy & Pöschel 2024 (24)-(30)."""
    r, theta = limit_radius(ri, rj, wall), (ti + tj) / 2.0
    x = v / r**3
    root = np.cbrt(x)
    reach = np.maximum(s, 0.0) / (r * (1.0 + theta / 2.0) * (root + root**2 / 10.0))
    wetted = (0.6474 + 0.4158 * x**0.2835) * np.sin(theta) ** (2.267 - 0.2087 * x**0.3113)
    touch = 2.0 * np.pi * r * sigma * (1.0 - 0.3823 * x**0.2586) * (1.0 - wetted)
    a = 0.6717 * x**0.1995 - 0.3319 * x**0.4974
    b = 13.84 / x**0.3909 - 12.11 / x**0.3945
    cubic = np.polyval([-0.007815, -0.2105, -1.426], np.log(x))
    turn = 1.0 + theta * (0.6669 / x**0.01391 - 1.78 * x**0.8351) + theta**3 * cubic
    return touch * (1.0 + a * reach) / (1.0 + turn * b * reach * (a + reach))


LAWS: dict[str, Law] = {
    law.__name__: law
    for law in (
        rabinovich,
        rabinovich_small_gap,
        rabinovich_as_printed,
        rabinovich_spheres_as_printed,
        rabinovich_walls_as_printed,
        lambert,
        willett,
        willett_simple,
        willett_simple_as_printed,
        weigert,
        weigert_as_printed,
        soulie,
        bagheri,
    )
}
"""Capillary law by its name in a run."""
