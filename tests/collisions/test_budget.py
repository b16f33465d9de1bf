"""The energy budget: closed everywhere, and a check that can fail; its works again by an independent quadrature of the path."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import fixed_quad

from pywet.collisions.wall import adaptive, forces, wall
from pywet.collisions.wall.problem import Problem
from tests.collisions.cases import problem, run
from tests.error_codes import raises_code

GLASS, ALUMINA = "glass_1.74mm", "alumina_1.74mm"
CASES = {
    "dry": problem(GLASS),
    "wet": problem(GLASS, ("water", 400)),
    "stuck": problem(GLASS, ("water", 400), normal_velocity_m_per_s=0.3),
    "oblique": problem(ALUMINA, ("tween20", 100), friction=0.16, angle_deg=40.0, omega_rad_per_s=-960.0),
    "grazing": problem(ALUMINA, ("glycerol35", 100), friction=0.14, angle_deg=89.9),
    "no gravity": problem(GLASS, ("glycerol50", 400), gravity_m_per_s2=0.0),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
@pytest.mark.parametrize("integrator", ["compiled", "DOP853", "RK45", "LSODA", "Radau"])
def test_budget_closes(case: Problem, integrator: str) -> None:
    """1e-8 of the initial energy, the contract's number, at the default tolerance."""
    got = wall.collide(case.model_copy(update={"integrator": integrator}))
    e = got["energy_J"]
    lost = e["contact"] + e["viscous"] + e["capillary"] + e["gravity"]
    assert abs(e["in"] - e["out"] - lost) <= 1e-8 * e["in"]
    assert e["residual"] == pytest.approx(e["in"] - e["out"] - lost, abs=1e-15 * e["in"])


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_works_are_those_of_the_forces_along_the_path(case: Problem) -> None:
    """Power from forces written here, along the dense output, by Gauss rule in every step: 1e-7 of the initial energy, which is
    what the interpolation between the steps of DOP853 leaves at rtol 1e-12.
    """
    p = case.parameters()
    first = wall.start(case, p)
    course = adaptive.collide(p, first, 1e-12, "DOP853", keep_path=True)
    works = np.zeros(4)
    for phase, _, solved in course.pieces:
        for a, b in itertools.pairwise(solved.t):
            works += fixed_quad(lambda t, f=phase, s=solved: powers(case, f, s.sol(t)), a, b, n=5)[0]
    assert works * p.mass == pytest.approx(
        [x * p.mass for x in course.state[forces.WORK :]], rel=0, abs=1e-7 * wall.energy(first) * p.mass
    )


def powers(case: Problem, phase: int, y: np.ndarray) -> np.ndarray:
    """Power taken out by contact, viscous, capillary force and gravity, per mass, at states y: models.md written once more."""
    particle, liquid, m = case.particle, case.liquid, case.mass
    r, h, u, slip, v, w = particle.radius_m, *y[:5]
    zero = np.zeros_like(h)
    if phase == forces.CONTACT:
        modulus = 1 / sum((1 - b.poisson_ratio**2) / b.youngs_modulus_Pa for b in (particle, case.wall) if b)
        shear = 1 / sum(
            (2 - b.poisson_ratio) * 2 * (1 + b.poisson_ratio) / b.youngs_modulus_Pa for b in (particle, case.wall) if b
        )
        k = 4 / 3 * modulus * math.sqrt(r)
        log = math.log(particle.restitution)
        d = np.maximum(-h, 0.0)
        damper = -math.sqrt(5) * log / math.hypot(log, math.pi) * math.sqrt(m * k) * d**0.25
        f_n = k * d**1.5 - damper * u
        limit = case.friction * np.maximum(f_n, 0.0)
        f_t = np.clip(-8 * shear * np.sqrt(r * d) * slip - damper * (v + w), -limit, limit)
        return np.array([-(f_n * u + f_t * (v + w)) / m, zero, zero, case.gravity_m_per_s2 * u])
    assert liquid is not None
    mu, phi = liquid.viscosity_Pa_s, math.radians(liquid.half_filling_angle_deg)
    rim, gap = r * math.sin(phi), np.maximum(h, 0.5e-6)
    re = 2 * rim * np.abs(u) * liquid.density_kg_per_m3 / mu
    drag = 6 * math.pi * mu * rim * np.abs(u) * (1 + re / (4 * (1 + np.sqrt(re))) + re / 60)
    viscous = np.maximum(drag, 6 * math.pi * mu * r**2 * np.abs(u) / gap) * np.abs(u)
    if phase != forces.BRIDGE:
        log = np.log(r / gap)
        force = 6 * math.pi * mu * r * ((8 / 15 * log + 0.9588) * v + (2 / 15 * log - 0.2526) * w)
        moment = 8 * math.pi * mu * r * ((log / 10 - 0.1895) * v + (2 / 5 * log + 0.3817) * w)
        return np.array([zero, (viscous + force * v + moment * w) / m, zero, case.gravity_m_per_s2 * u])
    a = phi + math.radians(liquid.contact_angle_deg)
    height = h + r * (1 - math.cos(phi)) - liquid.layer_thickness_m
    r_m = height / (1 + math.cos(a))
    r_a = rim + r_m * (math.sin(a) - 1)
    sigma = liquid.surface_tension_N_per_m
    pull = 2 * math.pi * sigma * rim * math.sin(a) + math.pi * rim**2 * sigma * (1 / r_m - 1 / r_a)
    axis, psi = rim + r_m * math.sin(a), math.pi - a
    volume = math.pi * axis**2 * height - math.pi * r_m**2 * psi * (axis - 4 * r_m / (3 * psi) * math.sin(psi / 2) ** 2)
    volume -= math.pi * r_m**2 * math.sin(a) * math.cos(a) * (rim + 2 / 3 * r_m * math.sin(a))
    cap = r * (1 - math.cos(phi))
    volume -= math.pi / 3 * cap**2 * (3 * r - cap)
    heavy = case.gravity_m_per_s2 * (m + volume * liquid.density_kg_per_m3)
    return np.array([zero, viscous / m, pull * u / m, heavy * u / m])


def test_a_wrong_work_opens_the_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    """One part in a million taken from the viscous work is seen, and the collision refused."""
    whole = wall.integrate

    def wrong(*arguments: object) -> wall.Raw:
        raw = whole(*arguments)  # type: ignore[arg-type]
        raw.state[forces.WORK + 1] *= 1.0 - 1e-6
        return raw

    monkeypatch.setattr(wall, "integrate", wrong)
    with raises_code("wall.not_finished"):
        wall.collide(CASES["wet"])


def test_a_loose_tolerance_is_tightened_until_the_budget_closes() -> None:
    got = run(GLASS, ("water", 400), rtol=1e-3)
    assert abs(got["energy_J"]["residual"]) <= 1e-8 * got["energy_J"]["in"]
    assert got["rtol_used"] < 1e-3


def test_a_sphere_held_in_the_film_was_given_energy_by_gravity() -> None:
    """Held in the film: what gravity gave is m g times the fall from the surface to where it stops, less than the layer."""
    got = run(GLASS, ("water", 400), normal_velocity_m_per_s=0.05)
    assert [e["kind"] for e in got["events"]] == ["entry", "contact", "lift_off", "stick"]
    assert -9.81 * 400e-6 < got["energy_J"]["gravity"] / problem(GLASS).mass < 0.0
