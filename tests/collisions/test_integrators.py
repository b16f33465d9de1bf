"""Every integrator gives the same collision; the events come in order; sticking is recognised, not timed out."""

from __future__ import annotations

import numpy as np
import pytest

from pywet.collisions.wall import compiled, wall
from pywet.collisions.wall.problem import Problem
from tests.collisions.cases import problem, run, sticking_velocity

GLASS, ALUMINA = "glass_1.74mm", "alumina_1.74mm"
OBLIQUE = problem(ALUMINA, ("tween20", 100), friction=0.16, angle_deg=35.0, omega_rad_per_s=-960.0)
METHODS = {"DOP853": 1e-7, "RK45": 1e-7, "RK23": 2e-5, "LSODA": 2e-6, "Radau": 1e-7, "BDF": 2e-6}
"""Method -> how far it may stray at rtol 1e-9: a hundred times the tolerance, low orders of multistep methods more."""


def with_method(case: Problem, method: str, rtol: float = 1e-9) -> np.ndarray:
    """(e_n, e_t, e_ω) of a method."""
    p = case.parameters()
    raw = wall.integrate(p, wall.start(case, p), rtol, method)
    assert raw.code == 0
    got = wall.outcome(case, p, wall.start(case, p), raw, rtol)
    return np.array([got["e_n"], got["e_t"], got["e_omega"]])


@pytest.mark.parametrize("method", METHODS)
def test_result_does_not_depend_on_the_integrator(method: str) -> None:
    rtol = 1e-7 if method == "RK23" else 1e-9
    assert np.abs(with_method(OBLIQUE, method, rtol) - with_method(OBLIQUE, "compiled", 1e-12)).max() < METHODS[method]


def test_compiled_takes_the_steps_of_scipys_dop853() -> None:
    """Compare with SciPy's DOP853: step counts within a few (events are located in another manner), results to the tolerance."""
    p = OBLIQUE.parameters()
    steps = [wall.integrate(p, wall.start(OBLIQUE, p), 1e-8, m).steps for m in ("compiled", "DOP853")]
    assert abs(steps[0] - steps[1]) <= 4


def test_tighter_tolerances_converge() -> None:
    """B Fig. 6 for our reading: the error falls with the tolerance down to 1e-9 (and not only at 1e-13)."""
    case = problem(GLASS, ("water", 400))
    reference = with_method(case, "compiled", 1e-13)[0]
    for rtol in (1e-5, 1e-7, 1e-9, 1e-11):
        stray = abs(with_method(case, "compiled", rtol)[0] - reference)
        assert stray < 20.0 * rtol  # a hundred steps, each within rtol


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_toroid_in_a_thick_film_has_a_pole(rtol: float) -> None:
    """B Fig. 6: with the capillary force in phase I too, 400 µm of water have r_m = 0 at h = δ_l − R(1 − cos φ) = 29 µm. Pulling
    (mended) the integrator stops there; pushing (printed sign) the sphere is held: no tolerance gives a converged rebound.
    """
    case = problem(GLASS, ("water", 400))
    p = case.parameters()._replace(other=case.parameters().other._replace(capillary=True))
    pole = p.layer - p.radius * (1.0 - np.cos(p.half_filling))
    assert pole == pytest.approx(29e-6, abs=0.5e-6)
    assert wall.integrate(p, wall.start(case, p), rtol, "RK45").code == compiled.TOO_SMALL
    pushed = wall.integrate(p._replace(other=p.other._replace(suction_sign=True)), wall.start(case, p), 1e-6, "RK45")
    assert pushed.log[-1][2] != 1  # not a rupture


@pytest.mark.parametrize("method", ["compiled", "DOP853", "LSODA"])
def test_events_in_order(method: str) -> None:
    got = run(GLASS, ("water", 400), integrator=method)
    assert [e["kind"] for e in got["events"]] == ["entry", "contact", "lift_off", "film_exit", "rupture"]
    times = [e["t"] for e in got["events"]]
    assert times == sorted(times) and got["duration_s"] == times[-1]
    assert [e["kind"] for e in run(GLASS)["events"]] == ["contact", "lift_off"]


@pytest.mark.parametrize("method", ["compiled", "DOP853"])
@pytest.mark.parametrize(
    ("velocity", "viscosity", "last"),
    [(0.3, 1e-3, "film_exit"), (0.05, 1e-3, "lift_off"), (0.5, 0.02, "lift_off"), (0.3, 50.0, "entry")],
)
def test_sticking_in_each_phase(method: str, velocity: float, viscosity: float, last: str) -> None:
    """In the bridge, in the film on the way out, and creeping in a very viscous one: always as an event."""
    case = problem(GLASS, ("water", 400), normal_velocity_m_per_s=velocity, integrator=method)
    assert case.liquid is not None
    liquid = case.liquid.model_copy(update={"viscosity_Pa_s": viscosity})
    got = wall.collide(case.model_copy(update={"liquid": liquid}))
    assert (got["e_n"], got["stuck"]) == (0.0, True)
    assert [e["kind"] for e in got["events"]][-2:] == [last, "stick"]


def test_sticking_in_contact() -> None:
    """Dry under gravity at 1 µm/s: the rebound is less than the depth at which the sphere lies."""
    got = run(GLASS, normal_velocity_m_per_s=1e-6)
    assert got["stuck"] and [e["kind"] for e in got["events"]] == ["contact", "stick"]


def test_rupture_just_above_the_sticking_velocity() -> None:
    """√Ca collapses as the sphere slows down: next to sticking the bridge ruptures in the very last step, at e_n near zero.

    At rest the bridge is shorter than at any speed, so the rupture is found by testing again where the sphere stops.
    """
    stick = sticking_velocity(GLASS, ("water", 400))
    above, below = (run(GLASS, ("water", 400), normal_velocity_m_per_s=stick + d) for d in (1e-4, -2e-4))
    assert not above["stuck"] and 0.0 < above["e_n"] < 0.05
    assert below["stuck"]


@pytest.mark.parametrize("method", ["compiled", "DOP853"])
def test_a_bridge_that_ruptures_within_the_step_that_stops(method: str) -> None:
    """Velocities that approach sticking from above in tiny steps: never a gap where a rupturing bridge is called stuck."""
    stick = sticking_velocity(GLASS, ("water", 400))
    outcomes = [
        run(GLASS, ("water", 400), normal_velocity_m_per_s=stick + d, integrator=method)["stuck"]
        for d in np.linspace(-1e-3, 1e-3, 41)
    ]
    assert outcomes == sorted(outcomes, reverse=True)


def test_step_control_gives_up_with_a_code() -> None:
    """A force that is not finite ends as a code, which `collide` turns into a sentence."""
    p = OBLIQUE.parameters()._replace(surface_tension=float("nan"))
    state, log = wall.start(OBLIQUE, p), np.zeros((8, 3))
    assert compiled.collide(p, state, 1e-8, log)[0] == compiled.TOO_SMALL
