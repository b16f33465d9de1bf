"""The exact bridge: force and volume along the meridian, closed shapes, energy, limits, symmetry, stability, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import simpson

from pywet.laws.exact_bridge import Bridge, branch, rupture, solve, solve_many, table
from pywet.laws.exact_bridge.meridian import GAP
from tests.error_codes import raises_code

PLATE = math.inf
CASES = [
    # volume, radius_i, radius_j, theta_i, theta_j
    (1e-3, 1.0, 1.0, 0.3, 0.3),
    (1e-2, 1.0, 5.0, 0.0, 0.9),
    (1e-2, 1.0, PLATE, 0.2, 1.2),
    (0.3, 1.0, 1.0, 0.7, 0.9),
    (1e-3, 1.0, PLATE, 0.3, 0.0),
    (1e-6, 3.0, 1.0, 0.0, 0.0),
    (2e-12, 1e-3, 2e-3, 0.4, 0.1),
]
SHARES = (0.0, 0.3, 0.9, 0.999)
"""Separation over rupture distance."""


def bridge_at(share: float, case: tuple[float, ...]) -> Bridge:
    found = solve(share * rupture(*case).separation, *case)
    assert found is not None
    return found


def cap(radius: float, contact: float) -> tuple[float, float, float]:
    """Depth, volume and area of the cap of a body within a contact radius."""
    if math.isinf(radius):
        return 0.0, 0.0, math.pi * contact**2
    depth = contact**2 / (radius + math.sqrt(radius**2 - contact**2))
    return depth, math.pi * depth**2 * (radius - depth / 3), 2 * math.pi * radius * depth


def arc(found: Bridge, points: int) -> np.ndarray:
    return np.linspace(0.0, found.state[3] * found.bodies.unit, points)


def energy(found: Bridge) -> float:
    """Surface energy over σ: free surface less cos θ times the wetted surfaces."""
    _, r, _ = found.meridian(2001)
    total = 2 * math.pi * simpson(r, x=arc(found, 2001))
    b = found.bodies
    for radius, theta, contact in ((b.radius_i, b.theta_i, r[0]), (b.radius_j, b.theta_j, r[-1])):
        total -= math.cos(theta) * cap(radius, contact)[2]
    return float(total)


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("case", CASES)
def test_force_is_the_same_at_every_section(case: tuple[float, ...], share: float) -> None:
    found = bridge_at(share, case)
    _, r, angle = found.meridian()
    force = 2 * math.pi * (r * np.cos(angle) - found.mean_curvature * r**2)
    assert np.abs(force / found.force(1.0) - 1).max() < 1e-8
    assert found.force(0.07) == pytest.approx(0.07 * found.force(1.0), rel=1e-15)


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("case", CASES)
def test_the_meridian_is_a_curve_that_closes_separation_and_volume(case: tuple[float, ...], share: float) -> None:
    # Simpson's rule over 2001 points; its own error is below 1e-10
    volume, ri, rj, ti, tj = case
    found = bridge_at(share, case)
    z, r, angle = found.meridian(2001)
    t = arc(found, 2001)
    assert z[-1] == pytest.approx(simpson(np.cos(angle), x=t), rel=1e-8)
    assert r[-1] - r[0] == pytest.approx(simpson(np.sin(angle), x=t), abs=1e-8 * r[0])
    (depth_i, cap_i, _), (depth_j, cap_j, _) = cap(ri, r[0]), cap(rj, r[-1])
    assert z[-1] - depth_i - depth_j == pytest.approx(found.separation, abs=1e-8 * z[-1])
    assert math.pi * simpson(r**2 * np.cos(angle), x=t) - cap_i - cap_j == pytest.approx(volume, rel=1e-8)
    # contact angles: between the surface and the body's own tangent
    for radius, theta, contact, slope in ((ri, ti, r[0], -angle[0]), (rj, tj, r[-1], angle[-1])):
        filling = 0.0 if math.isinf(radius) else math.asin(contact / radius)
        assert math.pi / 2 - slope - filling == pytest.approx(theta, abs=1e-7)
    assert found.contact_radii == pytest.approx((r[0], r[-1]), rel=1e-9)
    assert found.neck_radius <= r.min() * (1 + 1e-12)
    assert sum(found.parts) == pytest.approx(volume, rel=1e-8)


@pytest.mark.parametrize("case", CASES)
def test_force_is_the_slope_of_the_surface_energy(case: tuple[float, ...]) -> None:
    # differences of 4th order over 1 % of the rupture distance: their own error is near 1e-8
    limit = rupture(*case).separation
    energies = [energy(bridge_at(0.5 + 0.01 * k, case)) for k in (-2, -1, 1, 2)]
    slope = (energies[0] - 8 * energies[1] + 8 * energies[2] - energies[3]) / (12 * 0.01 * limit)
    assert slope == pytest.approx(bridge_at(0.5, case).force(1.0), rel=1e-6)


def case_of(
    volume: float, height: float, ends: list[tuple[float, float, float]]
) -> tuple[float, tuple[float, float, float, float, float]]:
    """Separation and case of a known surface; ends: contact radius, angle between the surface and the radius, body's radius."""
    angles = []
    for contact, slope, radius in ends:
        depth, cut, _ = cap(radius, contact)
        height, volume = height - depth, volume - cut
        angles.append(slope - (0.0 if math.isinf(radius) else math.asin(contact / radius)))
    return height, (volume, ends[0][2], ends[1][2], angles[0], angles[1])


@pytest.mark.parametrize("radius_j", [1.0, 2.0])
def test_cylinder(radius_j: float) -> None:
    # radius a, pressure σ/a: force 2πa − πa = πa
    a, height = 0.4, 0.5
    gap, case = case_of(math.pi * a**2 * height, height, [(a, math.pi / 2, 1.0), (a, math.pi / 2, radius_j)])
    found = solve(gap, *case)
    assert found is not None
    assert found.force(1.0) == pytest.approx(math.pi * a, rel=1e-9)
    assert 2 * found.mean_curvature == pytest.approx(1 / a, rel=1e-9)
    assert found.half_filling_angles == pytest.approx((math.asin(a), math.asin(a / radius_j)), rel=1e-9)
    assert found.neck_radius == pytest.approx(a, rel=1e-9)


@pytest.mark.parametrize("radius_j", [0.8, 2.0, PLATE])
def test_catenoid(radius_j: float) -> None:
    # r = c cosh(z/c), no pressure: force 2πc
    c, zi, zj = 0.2, -0.15, 0.06
    volume = math.pi * c**2 * (0.5 * (zj - zi) + 0.25 * c * (math.sinh(2 * zj / c) - math.sinh(2 * zi / c)))
    ends = [(c * math.cosh(z / c), math.atan(1 / math.sinh(abs(z) / c)), r) for z, r in ((zi, 1.0), (zj, radius_j))]
    gap, case = case_of(volume, zj - zi, ends)
    found = solve(gap, *case)
    assert found is not None
    assert found.force(1.0) == pytest.approx(2 * math.pi * c, rel=1e-9)
    assert found.mean_curvature == pytest.approx(0.0, abs=1e-9)
    assert found.neck_radius == pytest.approx(c, rel=1e-9)
    assert found.contact_radii == pytest.approx([end[0] for end in ends], rel=1e-9)


@pytest.mark.parametrize("theta", [0.0, 0.5, 1.2])
@pytest.mark.parametrize("radius_j", [1.0, 4.0, PLATE])
def test_small_volume_limit_of_the_contact_force(theta: float, radius_j: float) -> None:
    """F → π r (cos θ_i + cos θ_j), r = 2 r_i r_j/(r_i + r_j), 2 r_i at a plate; the correction falls with V^(1/4)."""
    harmonic = 2.0 if math.isinf(radius_j) else 2 * radius_j / (1 + radius_j)
    limit = math.pi * harmonic * (math.cos(theta) + math.cos(0.2))
    short = []
    for volume in (1e-8, 1e-12):
        found = solve(0.0, volume, 1.0, radius_j, theta, 0.2)
        assert found is not None
        short.append(abs(found.force(1.0) / limit - 1))
    assert short[1] < 2e-3
    assert short[1] == pytest.approx(0.1 * short[0], rel=0.05)


def test_small_volume_limit_of_the_rupture_distance() -> None:
    # Lian, Thornton & Adams 1993: S = (1 + θ/2) V^(1/3), a fit within a few per cent for small V
    for theta in (0.0, 0.3):
        assert rupture(1e-6, 1.0, 1.0, theta, theta).separation == pytest.approx((1 + theta / 2) * 1e-2, rel=0.04)


def test_plate_is_the_limit_of_a_growing_sphere() -> None:
    for share in (0.0, 0.7):
        gap = share * rupture(1e-2, 1.0, PLATE, 0.3, 0.6).separation
        forces = [solve(gap, 1e-2, 1.0, radius, 0.3, 0.6) for radius in (PLATE, 1e3, 1e5)]
        plate, near, nearer = (f.force(1.0) for f in forces if f is not None)
        assert abs(nearer / plate - 1) < 2e-5
        assert nearer / plate - 1 == pytest.approx(0.01 * (near / plate - 1), rel=0.02)  # first order in 1/r_j


@pytest.mark.parametrize("case", CASES)
def test_swapping_the_bodies_and_the_split(case: tuple[float, ...]) -> None:
    volume, ri, rj, ti, tj = case
    if math.isinf(rj):
        ri, rj, ti, tj = ri, 50.0, ti, tj  # a plate is always body j
    ends, swapped = rupture(volume, ri, rj, ti, tj), rupture(volume, rj, ri, tj, ti)
    assert swapped.separation == pytest.approx(ends.separation, rel=1e-9)
    assert swapped.transfer_ratio + ends.transfer_ratio == pytest.approx(1.0, abs=1e-8)
    gap = 0.9 * ends.separation
    one, other = solve(gap, volume, ri, rj, ti, tj), solve(gap, volume, rj, ri, tj, ti)
    assert one is not None and other is not None
    assert other.force(1.0) == pytest.approx(one.force(1.0), rel=1e-9)
    assert other.half_filling_angles[::-1] == pytest.approx(one.half_filling_angles, rel=1e-9)
    assert other.parts[::-1] == pytest.approx(one.parts, rel=1e-7)


def test_one_shape_at_every_size() -> None:
    big, little = solve(0.05, 1e-2, 1.0, 2.0, 0.3, 0.6), solve(0.05e-4, 1e-14, 1e-4, 2e-4, 0.3, 0.6)
    assert big is not None and little is not None
    assert little.force(1.0) == pytest.approx(1e-4 * big.force(1.0), rel=1e-10)
    assert little.half_filling_angles == pytest.approx(big.half_filling_angles, rel=1e-10)
    ends = [rupture(v, r, 2 * r, 0.3, 0.6).separation for v, r in ((1e-2, 1.0), (1e-14, 1e-4))]
    assert ends[1] == pytest.approx(1e-4 * ends[0], rel=1e-10)


@pytest.mark.parametrize("case", CASES)
def test_bridge_lives_up_to_its_rupture_distance_and_no_further(case: tuple[float, ...]) -> None:
    end = rupture(*case)
    assert solve((1 - 1e-7) * end.separation, *case) is not None
    assert solve((1 + 1e-7) * end.separation, *case) is None
    assert solve(100 * end.separation, *case) is None


def test_overlap_counts_as_touching() -> None:
    touching, overlapping = (solve(s, *CASES[1]) for s in (0.0, -0.01))
    assert touching is not None and overlapping is not None
    assert overlapping.separation == 0.0
    assert overlapping.force(1.0) == touching.force(1.0)


def test_force_ends_in_a_fold_or_where_equal_bodies_lose_symmetry() -> None:
    """At a fold dF/dS is infinite like 1/√(S_rup − S); the loss of symmetry comes where the force is still smooth."""
    for theta, kind in ((0.2, "fold"), (0.7, "asymmetry")):
        case = (0.3, 1.0, 1.0, theta, theta)
        end = rupture(*case)
        assert (end.kind, end.transfer_ratio) == (kind, pytest.approx(0.5, abs=1e-9))
        forces = [end.bridge.force(1.0), *(bridge_at(1 - d, case).force(1.0) for d in (1e-6, 1e-4))]
        growth = (forces[2] - forces[0]) / (forces[1] - forces[0])
        assert growth == pytest.approx(10.0 if kind == "fold" else 100.0, rel=0.05)  # 100^(1/2) or 100
    assert rupture(0.3, 1.0, 1.0, 0.7, 0.9).kind == "fold"


def test_nearly_equal_bodies_rupture_like_an_imperfect_pitchfork() -> None:
    """An imperfection ε shortens the rupture distance by ε^(2/3) and moves the split by ε^(1/3)."""
    end = rupture(0.3, 1.0, 1.0, 0.7, 0.7)
    for bodies in (lambda e: (1.0, 1.0 + e, 0.7, 0.7), lambda e: (1.0, 1.0, 0.7, 0.7 + e)):
        near = [rupture(0.3, *bodies(e)) for e in (1e-7, 1e-4)]
        short = [end.separation - n.separation for n in near]
        away = [abs(0.5 - n.transfer_ratio) for n in near]
        assert short[1] / short[0] == pytest.approx(1000 ** (2 / 3), rel=0.05)
        assert away[1] / away[0] == pytest.approx(10.0, rel=0.05)


def test_rupture_distance_grows_with_volume() -> None:
    for ri, rj, ti, tj in ((1.0, 1.0, 0.0, 0.0), (1.0, PLATE, 0.2, 0.5), (1.0, 3.0, 1.0, 0.3)):
        distances = [rupture(v, ri, rj, ti, tj).separation for v in np.geomspace(1e-8, 0.5, 12)]
        assert (np.diff(distances) > 0).all()


@pytest.mark.parametrize(
    ("arguments", "code", "key"),
    [
        ((0.0, 1e-3, -1.0, 1.0, 0.0, 0.0), "bridge.radius", "radius_i"),
        ((0.0, 1e-3, 1.0, 0.0, 0.0, 0.0), "bridge.radius", "radius_j"),
        ((0.0, 1e-3, PLATE, 1.0, 0.0, 0.0), "bridge.plate_first", "radius_i"),
        ((0.0, 1e-3, 1.0, 1.0, math.pi / 2, 0.0), "bridge.contact_angle", "contact_angle_i"),
        ((0.0, 1e-3, 1.0, 1.0, 0.0, -0.1), "bridge.contact_angle", "contact_angle_j"),
        ((0.0, 0.0, 1.0, 1.0, 0.0, 0.0), "bridge.volume", "volume"),
        ((0.0, 1e6, 1.0, 1.0, 0.0, 0.0), "bridge.lost", ""),
    ],
)
def test_refuses_what_is_no_bridge(arguments: tuple[float, ...], code: str, key: str) -> None:
    with raises_code(code, key=key):
        solve(*arguments)  # type: ignore[arg-type]


GIVEN = {"separation": 0.0, "volume": 1e-3, "radius_i": 1.0, "radius_j": 1.0, "theta_i": 0.0, "theta_j": 0.0}
CODES = {
    "separation": "bridge.separation", "volume": "bridge.volume", "radius_i": "bridge.radius", "radius_j": "bridge.radius",
    "theta_i": "bridge.contact_angle", "theta_j": "bridge.contact_angle",
}  # fmt: skip
NO_NUMBERS = (math.nan, math.inf, -math.inf)


@pytest.mark.parametrize("value", NO_NUMBERS)
@pytest.mark.parametrize("name", GIVEN)
def test_refuses_what_is_not_finite(name: str, value: float) -> None:
    """In each argument of each public function; only a plate's radius is infinite. A separation was None, or no number."""
    if (name, value) == ("radius_j", PLATE):
        return
    given = {**GIVEN, name: value}
    key, code = name.replace("theta", "contact_angle"), CODES[name]
    code = "bridge.plate_first" if (name, value) == ("radius_i", PLATE) else code
    with raises_code(code, key=key):
        solve(**given)
    gap = given.pop("separation")
    with raises_code(code, key=key):
        solve_many([0.0, gap, 1e-3], **given)
    if name != "separation":
        with raises_code(code, key=key):
            rupture(**given)


@pytest.mark.parametrize("value", (*NO_NUMBERS, -0.07))
def test_a_force_needs_a_surface_tension(value: float) -> None:
    bridge = solve(**GIVEN)
    assert bridge is not None and bridge.force(0.0) == 0.0
    with raises_code("bridge.surface_tension", key="surface_tension"):
        bridge.force(value)


def test_a_branch_that_nearly_meets_another_at_its_limit_is_followed() -> None:
    """A concave body of 40 and 45 degrees, a node of a table: the corrector hardly converges where both come close."""
    case = table.case_of(-0.04881318798871452, 0.0001428713629385982, math.radians(40), math.radians(45), False)
    kind, points = branch.follow(case, math.inf)
    assert kind == branch.FOLD and points[-1, GAP] == points[:, GAP].max()
