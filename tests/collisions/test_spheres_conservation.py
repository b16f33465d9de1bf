"""What must be conserved, and by how much angular momentum is not; integrators against scipy's; polar against Cartesian."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pywet.collisions.spheres.command import Problem, Run, run, three_equal_spheres
from pywet.collisions.spheres.outcome import times
from pywet.collisions.spheres.simulate import METHODS
from tests.error_codes import raises_code


def angular(found: Run) -> tuple[float, float]:
    """Angular momentum about the centre of mass at the first and last recorded instant, over the first one's size."""
    m, r, record = found.problem.mass, found.problem.radius, found.record
    values = []
    for k in (0, -1):
        x, v = record["position"][k], record["velocity"][k]
        x, v = x - (m @ x) / m.sum(), v - (m @ v) / m.sum()
        values.append(float(m @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]) + 0.4 * (m * r**2) @ record["omega"][k]))
    return values[0], values[1]


@pytest.mark.parametrize(("h_a", "mu_f"), list(itertools.product([0.001, 0.01, 0.1], [0.0, 0.2])))
def test_angular_momentum_to_the_defect_of_the_model(h_a: float, mu_f: float) -> None:
    """Both spheres of a pair feel F_t at lever a_i, but are a_i + a_j + h apart: dL/dt = −h F_t, so a defect of order ĥ_a."""
    found = run(three_equal_spheres(5.0, h_a=h_a, mu_f=mu_f, t_end=5.0), record=5000)
    first, last = angular(found)
    assert abs(last / first - 1.0) < 0.1 * h_a
    lever = run(three_equal_spheres(5.0, h_a=h_a, mu_f=mu_f, t_end=5.0, rtol=1e-11), record=5000)
    assert angular(lever)[1] == pytest.approx(last, rel=1e-8)  # the defect is the model's, not the integrator's


@pytest.mark.parametrize("method", list(METHODS))
def test_integrators_agree(method: str) -> None:
    """Global error some hundred times the tolerance at most."""
    found = run(three_equal_spheres(12.0, theta12_deg=30.0, t_end=20.0, rtol=1e-10), method=method)
    assert times(found, (1, 2), "separation")[0] == pytest.approx(4.606921745, rel=1e-8)
    assert found.energy.residual == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("method", ["DOP853", "LSODA", "Radau"])
@pytest.mark.parametrize("theta", [0.0, 45.0])
def test_first_approach_is_scipys(method: str, theta: float) -> None:
    """Two spheres to their first contact, written as three equations in scipy (20)-(22), (26) without anything of the package."""
    stokes, h_a, h_min, slope = 8.0, 0.01, 0.05, np.tan(np.radians(-theta))

    def equations(_: float, y: np.ndarray) -> list[float]:
        h, u, w, spin = y  # gap, normal, tangential speed of the centres, ω_12 times the radius
        shear = 4.0 * h_a / 3.0 * (w + spin) * np.log((2.0 - h) / h) / stokes
        squeeze = u * (1.0 - h / (2.0 - h)) ** 2 / h / stokes
        r = 1.0 / h_a + h
        return [-u, -squeeze - w * w / r, -shear + u * w / r, -2.5 * shear]

    def touch(_: float, y: np.ndarray) -> float:
        return float(y[0] - h_min)

    touch.terminal = True  # type: ignore[attr-defined]
    theirs = solve_ivp(equations, (0, 3), [1.0, 1.0, slope, 0.0], method=method, events=touch, rtol=1e-10, atol=1e-12)
    ours = run(three_equal_spheres(stokes, theta12_deg=theta, h23_0=None, t_end=3.0, rtol=1e-11))
    first = next(e for e in ours.events if e.kind == "contact")
    assert (first.time, first.speed) == pytest.approx((theirs.t_events[0][0], theirs.y_events[0][0][1]), rel=1e-7)


def test_cartesian_pairs_give_the_same() -> None:
    for stokes, theta in ((3.0, 45.0), (8.0, 45.0), (12.0, 30.0), (20.0, -60.0)):
        problem = three_equal_spheres(stokes, theta12_deg=theta, t_end=30.0, rtol=1e-11)
        polar, cartesian = run(problem), run(problem, polar=False)
        assert cartesian.velocity == pytest.approx(polar.velocity, abs=1e-8)
        assert [e.kind for e in cartesian.events] == [e.kind for e in polar.events]


def errors(problem: Problem, rtol: float) -> list[float]:
    """Return the errors of the final velocities, with polar and with Cartesian pairs."""
    exact = run(problem.with_(rtol=1e-11)).velocity
    return [np.abs(run(problem.with_(rtol=rtol), polar=k).velocity - exact).max() for k in (True, False)]


def test_polar_pairs_resolve_a_small_gap_where_cartesian_ones_cannot() -> None:
    """The paper's second claim, at ĥ_a 0.001 and ĥ_m 1e-8: round-off of positions (1e-16 · 1000 δ) is 1e-5 of the gap."""
    problem = three_equal_spheres(30.0, h_a=0.001, h_min=1e-8, t_end=30.0)
    for rtol in (1e-8, 1e-10):
        polar, cartesian = errors(problem, rtol)
        assert polar < rtol
        assert cartesian > 1e-8


def test_polar_pairs_are_more_accurate_at_the_same_tolerance() -> None:
    """Rapid bounce, St 12: ln h carries a relative tolerance; five times and more, measured 50 to 2000."""
    problem = three_equal_spheres(12.0, theta12_deg=30.0, t_end=10.0)
    for rtol in (1e-6, 1e-8):
        polar, cartesian = errors(problem, rtol)
        assert cartesian > 5.0 * polar


def test_turning_and_mirroring_the_plane_changes_nothing() -> None:
    a = run(three_equal_spheres(6.0, theta12_deg=40.0, mu_f=0.1, Ca=50.0, t_end=40.0))
    b = run(three_equal_spheres(6.0, theta12_deg=-40.0, mu_f=0.1, Ca=50.0, t_end=40.0))
    assert b.velocity * [1.0, -1.0] == pytest.approx(a.velocity, abs=1e-9)
    assert -b.omega == pytest.approx(a.omega, abs=1e-11)


def test_units_do_not_matter() -> None:
    """Repeat a collision in units of length 1e-5 m, speed 0.3 m/s, mass 1e-6 kg."""
    p = three_equal_spheres(8.0, Ca=100.0, t_end=20.0)
    length, speed, mass = 1e-5, 0.3, 1e-6
    q = p.with_(
        radius=p.radius * length, mass=p.mass * mass, position=p.position * length, velocity=p.velocity * speed,
        omega=p.omega * speed / length, film={k: v * length for k, v in p.film.items()},
        gap={k: v * length for k, v in p.gap.items()}, viscosity=p.viscosity * mass * speed / length**2,
        surface_tension=p.surface_tension * mass * speed**2 / length**2, h_min=p.h_min * length,
        t_end=p.t_end * length / speed, speed=None,
    )  # fmt: skip
    a, b = run(p), run(q)
    assert b.velocity / speed == pytest.approx(a.velocity, abs=1e-9)
    assert b.speed == pytest.approx(speed, rel=1e-12)


def test_free_flight_and_gravity_are_exact() -> None:
    p = three_equal_spheres(5.0, h23_0=50.0, t_end=1.0).with_(gap={}, gravity=(0.1, -0.2), t_end=40.0)
    q = p.with_(position=p.position - np.array([[100.0, 0.0], [0.0, 0.0], [-500.0, -900.0]]))
    found = run(q)
    assert found.position[2] == pytest.approx(q.position[2] + 0.5 * 40.0**2 * np.array([0.1, -0.2]), rel=1e-12)
    assert abs(found.energy.residual) < 1e-9 * found.energy.start


def test_an_unknown_integrator_is_answered_with_those_there_are() -> None:
    with raises_code("spheres.integrator", given="euler"):
        run(three_equal_spheres(5.0), method="euler")
