"""The papers' equations in numpy, implemented independently of `pywet`.

`wall` marks walls (arrays of booleans). The module contains viscous forces, rupture and formation; the capillary
forces are in capillary.py. Numbers (E n) are those of Elskamp & Kruggel-Emden 2018.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[Any]
Flags = NDArray[np.bool_]
SPHERE, LARGE_WALL, SMALL_WALL = 0, 1, 2


def harmonic_radius(ri: Floats, rj: Floats, wall: Flags) -> Floats:
    """Return r_eff of two spheres; at a wall the sphere's radius."""
    return np.where(wall, ri, 2.0 * ri * rj / (ri + rj))


def reduced_radius(ri: Floats, rj: Floats, wall: Flags) -> Floats:
    """Return r_red of two spheres; at a wall the sphere's radius."""
    return np.where(wall, ri, ri * rj / (ri + rj))


def least_gap(s: Floats, ri: Floats, rj: Floats, wall: Flags) -> Floats:
    """Return S + S_min with S_min = 0.001 r_eff, S not below zero (E after 29)."""
    return np.maximum(s, 0.0) + harmonic_radius(ri, rj, wall) / 1000.0


def pitois(s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, vn: Floats, eta: float) -> Floats:
    """Return the normal viscous force along n (E 26)."""
    a = reduced_radius(ri, rj, wall)
    h = least_gap(s, ri, rj, wall)
    x = 1.0 - 1.0 / np.sqrt(1.0 + v / (np.pi * a * h**2))
    return -6.0 * np.pi * eta * a**2 * vn / h * x**2


def adams_perchard(s: Floats, v: Floats, ri: Floats, rj: Floats, wall: Flags, vn: Floats, eta: float) -> Floats:
    """Return the normal viscous force along n (E 25): lubrication, independent of the volume."""
    return -6.0 * np.pi * eta * reduced_radius(ri, rj, wall) ** 2 * vn / least_gap(s, ri, rj, wall)


def goldman(s: Floats, ri: Floats, rj: Floats, wall: Flags, eta: float) -> tuple[Floats, Floats]:
    """Return the coefficients of the sliding and of the spin part of the tangential viscous force (E 28, 29), none below zero."""
    a = reduced_radius(ri, rj, wall)
    h = least_gap(s, ri, rj, wall)
    stokes, log = 6.0 * np.pi * eta * a, np.log(a / h)
    slide = np.maximum(stokes * (8.0 / 15.0 * log + 0.9588), 0.0)
    near = 2.0 / 15.0 * log - 0.2526
    q = a / (h + a)
    far = (1.0 / 8.0) * (q**2) ** 2 * (1.0 - 3.0 / 8.0 * q)
    return slide, stokes * np.where(h < a / 10.0, near, far)


def lian_drag(s: Floats, ri: Floats, rj: Floats, wall: Flags, eta: float) -> tuple[Floats, Floats]:
    """Return the tangential drag with one coefficient for translation and spin (E 27)."""
    slide, _ = goldman(s, ri, rj, wall, eta)
    return slide, slide


def willett_rupture(v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats) -> Floats:
    """Return the static rupture distance of unequal spheres (E 32); at a wall the limit r_j -> infinity, r_eff = 2 r_i."""
    r = np.where(wall, 2.0 * ri, 2.0 * ri * rj / (ri + rj))
    return _unequal(v, r, ri, rj, wall, ti, tj)


def willett_rupture_as_printed(v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats) -> Floats:
    """Return the rupture distance of unequal spheres as printed: r_eff = r_i at a wall (E 32)."""
    return _unequal(v, harmonic_radius(ri, rj, wall), ri, rj, wall, ti, tj)


def _unequal(v: Floats, r: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats) -> Floats:
    q = np.where(wall, 0.0, np.minimum(ri, rj) / np.maximum(ri, rj))
    w = np.cbrt(v) / r
    return r * (1.0 + (ti + tj) / 8.0 * (1.0 + q)) * (w + (q / 2.0 - 0.4) * w**2)


def willett_equal_rupture(v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats) -> Floats:
    """Return the static rupture distance of equal spheres (E 31); at a wall r_eff = 2 r_i."""
    r = np.where(wall, 2.0 * ri, 2.0 * ri * rj / (ri + rj))
    return (1.0 + (ti + tj) / 4.0) * np.cbrt(v) * (1.0 + 0.1 * np.cbrt(v) / r)


def lian_rupture(v: Floats, ri: Floats, rj: Floats, wall: Flags, ti: Floats, tj: Floats) -> Floats:
    """Return the static rupture distance (1 + theta/2) V^(1/3) (E 30)."""
    return (1.0 + (ti + tj) / 4.0) * np.cbrt(v)


def pitois_factor(speed: Floats, eta: float, sigma: float) -> Floats:
    """Return the factor of dynamic rupture (E 33); without surface tension, where it is undefined, 1."""
    if sigma == 0.0:
        return np.ones_like(speed)
    return 1.0 + np.sqrt(speed * eta / sigma)


def drawn_from_sphere(kind: Any, film: Any, ri: Any, rj: Any, half_width: Any) -> Floats:
    """Return the liquid that sphere i gives to a new bridge (E 8, 9, 12)."""
    sine = np.where(kind == LARGE_WALL, 0.5, rj / (ri + rj))
    cap = film / 2.0 * (1.0 - np.sqrt(1.0 - sine**2))
    return np.where(kind == SMALL_WALL, film * half_width / (6.0 * ri), cap)


def drawn_from_wall(kind: Any, thickness: Floats, ri: Floats, half_width: Any) -> Floats:
    """Return the liquid that a wall gives to a new bridge (E 10, 13)."""
    return thickness * np.where(kind == SMALL_WALL, 2.0 * ri * half_width, np.pi / 4.0 * ri**2)


VISCOUS_NORMAL = {"pitois": pitois, "adams_perchard": adams_perchard}
VISCOUS_TANGENTIAL = {"goldman": goldman, "lian": lian_drag}
RUPTURE = {
    "willett_unequal": willett_rupture,
    "willett_unequal_as_printed": willett_rupture_as_printed,
    "willett": willett_equal_rupture,
    "lian": lian_rupture,
}
"""Laws by their names in a run."""
