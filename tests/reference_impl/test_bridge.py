"""The reference solver of the exact bridge against surfaces known in closed form, limits, energy and symmetry."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from reference_impl.bridge.branch import lowest_eigenvalue, touching
from reference_impl.bridge.bridge import branch, rupture, solve
from reference_impl.bridge.solver import Problem, State, grid, newton

PLATE = math.inf
CASES = [
    # volume, radius_i, radius_j, theta_i, theta_j
    (1e-3, 1.0, 1.0, 0.3, 0.3),
    (1e-2, 1.0, 5.0, 0.0, 0.9),
    (1e-2, 1.0, PLATE, 0.2, 1.2),
    (0.3, 1.0, 1.0, 0.7, 0.9),
    (0.1, 1.0, 0.5, 1.5, 1.4),
    (1e-6, 1.0, 3.0, 0.0, 0.0),
]


def cap(radius: float, contact: float) -> tuple[float, float]:
    """Depth and volume of the cap of a sphere within a contact radius."""
    depth = radius - math.sqrt(radius**2 - contact**2)
    return depth, math.pi * depth**2 * (radius - depth / 3)


def case_of(
    meridian_volume: float, height: float, ends: list[tuple[float, float, float]]
) -> tuple[float, tuple[float, float, float, float, float]]:
    """Separation and case from a known surface; ends: contact radius, angle of the surface with the radius, body's radius."""
    gap, volume, angles = height, meridian_volume, []
    for contact, slope, radius in ends:
        if math.isinf(radius):
            angles.append(slope)
            continue
        depth, cut = cap(radius, contact)
        gap, volume = gap - depth, volume - cut
        angles.append(slope - math.asin(contact / radius))
    assert gap >= 0 and all(0 <= angle < math.pi / 2 for angle in angles)
    return gap, (volume, ends[0][2], ends[1][2], angles[0], angles[1])


def test_cylinder() -> None:
    # radius a, pressure 1/a: force 2 pi a - pi a = pi a
    a, height = 0.4, 0.5
    gap, case = case_of(math.pi * a**2 * height, height, [(a, math.pi / 2, 1.0), (a, math.pi / 2, 2.0)])
    found = solve(gap, *case)
    assert found.force == pytest.approx(math.pi * a, rel=1e-10)
    assert 2 * found.curvature == pytest.approx(1 / a, rel=1e-10)
    assert [found.half_filling_i, found.half_filling_j] == pytest.approx([math.asin(a), math.asin(a / 2)], rel=1e-9)


@pytest.mark.parametrize("radius_j", [0.8, 2.0, PLATE])
def test_catenoid(radius_j: float) -> None:
    # r = c cosh(z/c), no pressure: force 2 pi c
    c, zi, zj = 0.2, -0.15, 0.06
    volume = math.pi * c**2 * (0.5 * (zj - zi) + 0.25 * c * (math.sinh(2 * zj / c) - math.sinh(2 * zi / c)))
    ends = [
        (c * math.cosh(z / c), math.atan(1 / math.sinh(abs(z) / c)), radius)
        for z, radius in ((zi, 1.0), (zj, radius_j))
    ]
    gap, case = case_of(volume, zj - zi, ends)
    found = solve(gap, *case)
    assert found.force == pytest.approx(2 * math.pi * c, rel=1e-10)
    assert found.neck_radius == pytest.approx(c, rel=1e-10)
    assert abs(found.curvature) * c < 1e-10
    # the part below the neck, without the cap of i
    below = math.pi * c**2 * (-0.5 * zi - 0.25 * c * math.sinh(2 * zi / c)) - cap(1.0, ends[0][0])[1]
    assert found.share_i == pytest.approx(below / case[0], rel=1e-9)


def test_sphere() -> None:
    # a sphere of liquid has pressure 2/radius and pulls with no force
    ball = 0.5
    turns, fillings = np.radians([20.0, 10.0]), np.radians([25.0, 14.0])
    ends = [
        (ball * math.cos(turn), math.pi / 2 + turn, ball * math.cos(turn) / math.sin(filling))
        for turn, filling in zip(turns, fillings, strict=True)
    ]
    zi, zj = -ball * math.sin(turns[0]), ball * math.sin(turns[1])
    gap, case = case_of(math.pi * (ball**2 * (zj - zi) - (zj**3 - zi**3) / 3), zj - zi, ends)
    found = solve(gap, *case)
    assert abs(found.force) < 1e-10 * ball
    assert found.curvature == pytest.approx(1 / ball, rel=1e-10)
    assert [found.half_filling_i, found.half_filling_j] == pytest.approx(fillings, rel=1e-9)


def half_delaunay(neck: float, pressure: float, contact: float) -> tuple[float, float, float]:
    """Height, volume and slope from the neck to a contact radius, by quadrature of the conserved force."""
    force = 2 * neck - neck**2 * pressure

    def rise(u: float, power: int) -> float:
        # r = neck + u² removes the singularity at the neck
        r = neck + u * u
        sine = (force + r * r * pressure) / (2 * r)
        return 2 * sine / math.sqrt((2 - pressure * (r + neck)) / (2 * r) * (1 + sine)) * r**power

    height, square = (
        quad(rise, 0, math.sqrt(contact - neck), args=(power,), epsabs=0, epsrel=1e-12)[0] for power in (0, 2)
    )
    return height, math.pi * square, math.asin((force + contact**2 * pressure) / (2 * contact))


@pytest.mark.parametrize("radius_j", [1.0, 3.0, PLATE])
@pytest.mark.parametrize("pressure", [-8.0, -2.0, 1.5])
def test_nodoid_and_unduloid(pressure: float, radius_j: float) -> None:
    neck, contacts = 0.2, (0.26, 0.24)
    halves = [half_delaunay(neck, pressure, contact) for contact in contacts]
    ends = [(contact, half[2], radius) for contact, half, radius in zip(contacts, halves, (1.0, radius_j), strict=True)]
    gap, case = case_of(sum(half[1] for half in halves), sum(half[0] for half in halves), ends)
    found = solve(gap, *case)
    assert found.force == pytest.approx(math.pi * (2 * neck - neck**2 * pressure), rel=1e-10)
    assert 2 * found.curvature == pytest.approx(pressure, rel=1e-9)
    assert [found.wetted_radius_i, found.wetted_radius_j] == pytest.approx(contacts, rel=1e-9)
    assert found.neck_radius == pytest.approx(neck, rel=1e-9)


@pytest.mark.parametrize("case", CASES)
def test_force_is_the_same_at_every_section_and_the_slope_of_the_energy(case: tuple[float, ...]) -> None:
    volume, ri, rj, ti, tj = case
    limit = rupture(volume, ri, rj, ti, tj).separation
    found = solve(0.5 * limit, *case)
    assert found.stable
    assert found.force_spread < 1e-11
    assert [found.force_i, found.force_j] == pytest.approx([found.force] * 2, rel=1e-10)
    # 4th-order differences over 1 % of rupture: their own error is near 1e-8
    step = 0.01 * limit
    energy = [solve(0.5 * limit + k * step, *case).energy for k in (-2, -1, 1, 2)]
    slope = (energy[0] - 8 * energy[1] + 8 * energy[2] - energy[3]) / (12 * step)
    assert slope == pytest.approx(found.force, rel=1e-6)


@pytest.mark.parametrize("case", CASES)
def test_swapping_the_bodies(case: tuple[float, ...]) -> None:
    volume, ri, rj, ti, tj = case
    ends, swapped = rupture(volume, ri, rj, ti, tj), rupture(volume, rj, ri, tj, ti)
    assert swapped.separation == pytest.approx(ends.separation, rel=1e-9)
    assert swapped.transfer_ratio_i == pytest.approx(1 - ends.transfer_ratio_i, abs=1e-8)
    one, other = (
        solve(0.9 * ends.separation, *case),
        solve(0.9 * ends.separation, volume, rj, ri, tj, ti),
    )
    assert other.force == pytest.approx(one.force, rel=1e-10)
    assert other.half_filling_i == pytest.approx(one.half_filling_j, rel=1e-9, nan_ok=True)


@pytest.mark.parametrize("theta", [0.0, 0.5, 1.2])
@pytest.mark.parametrize("radius_j", [1.0, 4.0, PLATE])
def test_small_volume_limit_of_the_contact_force(theta: float, radius_j: float) -> None:
    harmonic = 2.0 if math.isinf(radius_j) else 2 * radius_j / (1 + radius_j)
    limit = math.pi * harmonic * (math.cos(theta) + math.cos(0.2))
    short = [abs(solve(0.0, volume, 1.0, radius_j, theta, 0.2).force / limit - 1) for volume in (1e-8, 1e-12)]
    # the correction is proportional to the half-filling angle, V^(1/4): a tenth for 1e-4 of the volume
    assert short[1] < 2e-3
    assert short[1] == pytest.approx(0.1 * short[0], rel=0.05)


def test_plate_is_the_limit_of_a_growing_sphere() -> None:
    case = (0.05, 1e-2, 1.0)
    plate = solve(*case, PLATE, 0.3, 0.6).force
    away = [solve(*case, radius, 0.3, 0.6).force / plate - 1 for radius in (1e3, 1e5)]
    assert abs(away[1]) < 2e-5
    assert away[1] == pytest.approx(0.01 * away[0], rel=0.02)  # first order in 1/R_j


def test_one_shape_at_every_size() -> None:
    big, small = solve(0.05, 1e-2, 1.0, 2.0, 0.3, 0.6), solve(0.05e-4, 1e-14, 1e-4, 2e-4, 0.3, 0.6)
    assert small.force == pytest.approx(1e-4 * big.force, rel=1e-10)


def test_converges_exponentially_with_points() -> None:
    forces = []
    for points in (4, 8, 32):
        problem = Problem(1.0, 0.5, 0.4, 0.8, 1e-2, points)
        state = touching(problem)
        found = newton(problem, State(state.x, 0.02))
        assert found is not None
        forces.append(math.pi * float(found.r[0] * (2 * math.sin(found.psi[0]) - found.r[0] * found.pressure)))
    errors = np.abs(np.array(forces[:2]) / forces[2] - 1)
    assert errors[0] < 1e-4
    assert errors[1] < 1e-4 * errors[0]


@pytest.mark.parametrize("length", [0.8, 1.2])
def test_second_variation_of_a_cylinder(length: float) -> None:
    # between plates at 90° the mode cos(pi s/L) gives pi² - (L/a)²: Plateau's limit L = pi a
    a, g = 1.0 / math.pi, grid(32)
    n = len(g.nodes)
    x = np.concatenate([np.full(n, a), 0.5 * length * g.nodes, np.full(n, math.pi / 2), [length, 1 / a, a, a]])
    problem = Problem(0.0, 0.0, math.pi / 2, math.pi / 2, math.pi * a**2 * length)
    assert lowest_eigenvalue(problem, State(x, length)) == pytest.approx(math.pi**2 * (1 - length**2), rel=1e-10)


@pytest.mark.parametrize("case", CASES)
def test_stability_ends_where_the_separation_folds(case: tuple[float, ...]) -> None:
    # between unequal bodies both criteria give the same point, by different equations
    end = rupture(*case)  # type: ignore[arg-type]
    assert end.kind == "fold"
    separations = []
    for bridge in branch(*case):  # type: ignore[arg-type]
        separations.append((bridge.separation, bridge.stable))
        if not bridge.stable and len(separations) > 1 and separations[-2][1] is False:
            break
    assert max(s for s, _ in separations) <= end.separation * (1 + 1e-6)
    assert [stable for _, stable in separations] == sorted((stable for _, stable in separations), reverse=True)
    assert solve(end.separation * (1 - 1e-7), *case).stable
    with pytest.raises(ValueError, match="rupture"):
        solve(end.separation * (1 + 1e-5), *case)


def test_equal_bodies_at_a_large_angle_lose_symmetry_before_the_fold() -> None:
    end = rupture(0.3, 1.0, 1.0, 0.7, 0.7)
    assert (end.kind, end.transfer_ratio_i) == ("instability", pytest.approx(0.5, abs=1e-9))
    # a difference e of the angles gives a fold earlier by e^(2/3), as for any imperfect pitchfork
    short = [end.separation - rupture(0.3, 1.0, 1.0, 0.7, 0.7 + e).separation for e in (1e-6, 1e-4)]
    assert short[1] / short[0] == pytest.approx(100 ** (2 / 3), rel=0.01)
    assert rupture(0.3, 1.0, 1.0, 0.2, 0.2).kind == "fold"


def test_rupture_of_a_small_volume_is_near_its_cube_root() -> None:
    # Lian, Thornton & Adams 1993: S = (1 + theta/2) V^(1/3), a fit to the fold within a few per cent for small V
    for theta in (0.0, 0.3):
        assert rupture(1e-6, 1.0, 1.0, theta, theta).separation == pytest.approx((1 + theta / 2) * 1e-2, rel=0.04)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-1e-9, 1e-3, 1.0, 1.0, 0.0, 0.0), "separation"),
        ((0.0, 0.0, 1.0, 1.0, 0.0, 0.0), "volume"),
        ((0.0, 1e-3, PLATE, PLATE, 0.0, 0.0), "radii"),
        ((0.0, 1e-3, 1.0, 1.0, 0.0, 1.6), "contact angles"),
    ],
)
def test_refuses_what_is_no_bridge(arguments: tuple[float, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        solve(*arguments)  # type: ignore[arg-type]
