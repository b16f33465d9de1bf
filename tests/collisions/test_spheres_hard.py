"""Hard cases end, with finite numbers and a closed energy budget, or are refused with a sentence."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from pywet.collisions.spheres import contacts, simulate
from pywet.collisions.spheres.command import Problem, Run, run, three_equal_spheres
from tests.collisions import spheres_hard as hard
from tests.error_codes import raises_code

CLOSED = 1e-8
"""The budget's defect over the largest energy in it, at rtol = 1e-9."""


def holds(problem: Problem) -> Run:
    """Run it; finite, within its work bound, closed."""
    found = run(problem)
    e = found.energy
    largest = max(e.start, abs(e.viscous), abs(e.capillary))
    assert np.isfinite(found.position).all() and np.isfinite(found.velocity).all() and np.isfinite(found.omega).all()
    assert abs(e.residual) < CLOSED * largest
    assert found.steps + 9 * found.implicit_steps <= simulate.MOST_STEPS
    assert min(found.gaps.values()) >= problem.h_min * (1.0 - 1e-6) - 1e-9
    momentum = (problem.mass[:, None] * (found.velocity - problem.velocity)).sum(axis=0)
    assert np.abs(momentum).max() < 1e-11 * np.abs(problem.mass[:, None] * problem.velocity).max()
    # round-off of some 1e5 impulses, from forces up to 80 times the momentum per unit of time
    return found


@pytest.mark.parametrize(
    ("h_min", "stokes", "ca"), list(itertools.product([1e-2, 1e-4, 1e-6], [0.05, 1.0, 10.0, 1000.0], [0.1, 10.0, None]))
)
def test_small_gaps_any_stokes_any_capillary_number(h_min: float, stokes: float, ca: float | None) -> None:
    holds(three_equal_spheres(stokes, Ca=ca, h_min=h_min, t_end=60.0))


@pytest.mark.parametrize(("angle", "ca"), [(89.9, None), (-89.9, 0.1), (89.9, 10.0)])
@pytest.mark.parametrize("stokes", [0.05, 5.0, 1000.0])
def test_glancing(angle: float, ca: float | None, stokes: float) -> None:
    holds(three_equal_spheres(stokes, Ca=ca, theta12_deg=angle, t_end=400.0))


@pytest.mark.parametrize(
    ("stokes", "e_dry", "gap"), list(itertools.product([1.0, 20.0, 1000.0], [1.0, 0.5], [0.05, 0.5, 1.0]))
)
def test_chain_of_five(stokes: float, e_dry: float, gap: float) -> None:
    holds(hard.chain(stokes, None, e_dry, gap))
    holds(hard.chain(stokes, 10.0, e_dry, gap, t_end=50.0))


def test_dry_chain_is_newtons_cradle() -> None:
    """St → ∞, e = 1, gap closed: the last sphere leaves with all the speed, to the little that the film takes (1/St)."""
    found = holds(hard.chain(1e6, None, 1.0, 0.05))
    assert found.velocity[:, 0] == pytest.approx([0.0, 0.0, 0.0, 0.0, 1.0], abs=2e-5)


@pytest.mark.parametrize(("stokes", "ca", "mu_f"), list(itertools.product([0.5, 50.0], [0.1, None], [0.0, 0.3])))
def test_equilateral_cluster(stokes: float, ca: float | None, mu_f: float) -> None:
    holds(hard.triangle(stokes, ca, mu_f))


def test_cluster_with_redundant_contacts() -> None:
    found = holds(hard.hexagon(10.0, 10.0, t_end=20.0))
    assert len(found.resting) >= 6
    holds(hard.hexagon(10.0, 1.0, t_end=20.0).with_(mu_f=0.2))


@pytest.mark.parametrize(("stokes", "ca"), list(itertools.product([0.05, 500.0], [0.1, None])))
def test_size_ratio_of_twenty(stokes: float, ca: float | None) -> None:
    holds(hard.twenty(stokes, ca))


@pytest.mark.parametrize("e_dry", [1.0, 0.9, 0.5, 0.1])
def test_chatter_comes_to_rest(e_dry: float) -> None:
    """Capillarity presses, the contact bounces on and on; a pair may not make more than BURST impacts per doubling."""
    found = holds(three_equal_spheres(2.0, Ca=20.0, e_dry=e_dry, mu_f=0.2, t_end=60.0))
    assert found.resting
    assert found.impacts <= 3 * contacts.BURST * 17  # log2(1/1e-5) = 17 doublings
    assert found.rest_speed < 1e-3


def test_rest_speed_does_not_decide_what_follows() -> None:
    """A tenth of the rest speed: the same separation to 1e-6 of the time, although ten times as many impacts are made."""
    base = three_equal_spheres(2.0, t_end=200.0)
    coarse, fine = run(base), run(base.with_(rest_speed=1e-6))
    assert fine.impacts > 300 + coarse.impacts
    last = [next(e.time for e in f.events if e.kind == "separation") for f in (coarse, fine)]
    assert last[0] == pytest.approx(last[1], rel=1e-6)


def test_a_symmetric_double_impact_stays_symmetric() -> None:
    """One sphere flies between two: both contacts at one instant, taken one after the other, the faster first."""
    base = three_equal_spheres(30.0, theta12_deg=0.0, t_end=5.0)
    size = 2.0 * base.radius[0] + 1.0
    c, s = np.cos(0.6), np.sin(0.6)
    places = np.array([[0.0, 0.0], [size * c, size * s], [size * c, -size * s]])
    found = holds(hard.arrange(base, places, 0, {(0, 1): 1.0, (0, 2): 1.0}))
    touched = [e.time for e in found.events if e.kind == "contact"]
    assert touched[0] == pytest.approx(touched[1], abs=1e-10)


@pytest.mark.parametrize(
    ("change", "code", "key"),
    [
        ({"theta12_deg": 90.0}, "spheres.value", "theta12_deg"),
        ({"h_min": 1.0}, "spheres.thin_films", "spheres 1 and 2"),
        ({"h23_0": 0.01}, "spheres.close", "spheres 2 and 3"),
        ({"theta23_deg": 170.0}, "spheres.close", "spheres 1 and 3"),
        ({"e_dry": 0.0}, "spheres.value", "e_dry"),
        ({"h_a": 2.0}, "spheres.thick_films", "spheres 1 and 2"),
        ({"rtol": 1.0}, "spheres.value", "rtol"),
    ],
)
def test_what_the_model_cannot_describe_is_refused(change: dict[str, float], code: str, key: str) -> None:
    with raises_code(code, key=key):
        three_equal_spheres(**{"St_n": 5.0, **change})


def test_a_run_beyond_its_work_bound_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulate, "MOST_STEPS", 50)
    with raises_code("spheres.not_finished"):
        run(three_equal_spheres(5.0))
