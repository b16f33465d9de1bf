"""Hard cases: chains, clusters, very unequal spheres."""

from __future__ import annotations

import math

import numpy as np

from pywet.collisions.spheres.command import Problem, three_equal_spheres


def arrange(base: Problem, places: np.ndarray, striker: int, gaps: dict[tuple[int, int], float]) -> Problem:
    """The spheres of `base` at other places; the striker flies along x at speed 1, all films touch at a gap of 1."""
    n = len(places)
    velocity = np.zeros((n, 2))
    velocity[striker, 0] = 1.0
    return base.with_(
        radius=np.full(n, base.radius[0]), mass=np.full(n, 2.0), position=places, velocity=velocity, omega=np.zeros(n),
        film={(i, j): 1.0 for i in range(n) for j in range(i + 1, n)}, gap=gaps,
    )  # fmt: skip


def chain(stokes: float, ca: float | None, e_dry: float, gap: float, t_end: float = 200.0) -> Problem:
    """Five equal spheres in a row, the first flying in."""
    base = three_equal_spheres(stokes, Ca=ca, theta12_deg=0.0, e_dry=e_dry, t_end=t_end)
    size = 2.0 * base.radius[0]
    x = [-size - 1.0, *((size + gap) * k for k in range(4))]
    gaps = {(0, 1): 1.0, **{(k, k + 1): gap for k in range(1, 4)}}
    return arrange(base, np.array([[a, 0.0] for a in x]), 0, gaps)


def triangle(stokes: float, ca: float | None, mu_f: float, gap: float = 0.5) -> Problem:
    """An equilateral triangle, a fourth sphere flying at one corner."""
    base = three_equal_spheres(stokes, Ca=ca, e_dry=0.9, mu_f=mu_f, t_end=200.0)
    size = 2.0 * base.radius[0]
    s = size + gap
    places = np.array([[0.0, 0.0], [s, 0.0], [0.5 * s, 0.5 * math.sqrt(3.0) * s], [-size - 1.0, 0.0]])
    return arrange(base, places, 3, {(0, 1): gap, (0, 2): gap, (1, 2): gap, (0, 3): 1.0})


def hexagon(stokes: float, ca: float, t_end: float = 100.0) -> Problem:
    """Seven touching spheres, more contacts than a plane cluster can tell apart, an eighth flying in."""
    base = three_equal_spheres(stokes, Ca=ca, e_dry=0.9, t_end=t_end)
    size = 2.0 * base.radius[0]
    s = size + 0.05
    ring = [[s * math.cos(k * math.pi / 3), s * math.sin(k * math.pi / 3)] for k in range(6)]
    gaps = {(0, k): 0.05 for k in range(1, 7)} | {(min(k, k % 6 + 1), max(k, k % 6 + 1)): 0.05 for k in range(1, 7)}
    return arrange(base, np.array([[0.0, 0.0], *ring, [-s - size - 1.0, 0.3 * base.radius[0]]]), 7, gaps)


def twenty(stokes: float, ca: float | None) -> Problem:
    """A small sphere against one twenty times its size that touches a third, small one."""
    radius = np.array([50.0, 1000.0, 50.0])
    mass = 2.0 * (radius / 50.0) ** 3
    a = 50.0 * 1000.0 / 1050.0
    viscosity = mass[0] * mass[1] / (mass[0] + mass[1]) / (6.0 * math.pi * a * a * stokes)
    return Problem(
        radius=radius, mass=mass, velocity=np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]]), omega=np.zeros(3),
        position=np.array([[-math.sqrt(1051.0**2 - 300.0**2), 300.0], [0.0, 0.0], [1051.0, 0.0]]),
        film={(0, 1): 1.0, (0, 2): 1.0, (1, 2): 1.0}, gap={(0, 1): 1.0, (1, 2): 1.0}, viscosity=viscosity,
        surface_tension=0.0 if ca is None else 3.0 * viscosity * a / ca, h_min=0.01, e_dry=0.9, mu_f=0.2, t_end=400.0,
    )  # fmt: skip
