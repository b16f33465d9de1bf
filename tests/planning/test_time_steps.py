"""The time step advisor: closed forms, what governs, the sentence of refusal, and the true limit in the engine."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from pywet.cases.small import scenes, small
from pywet.cases.small.bodies import water
from pywet.cli.app import app
from pywet.errors import PywetError
from pywet.laws import custom_laws, registry
from pywet.laws.contact import damping, film_volume
from pywet.planning import time_steps
from pywet.runs.rundir import RunDir
from tests.engines.liggghts import stability
from tests.engines.liggghts.scenes import contacts, spheres_of
from tests.error_codes import raises_code


def test_closed_forms() -> None:
    """Spring alone 2 sqrt(m/k), drag alone 2 m/c, and with both explicit and semi-implicit the roots of the margins."""
    assert time_steps.largest_step(2.0, 8.0, 0.0, 0.0, False) == pytest.approx(1.0, rel=1e-12)
    assert time_steps.largest_step(2.0, 0.0, 0.0, 8.0, False) == pytest.approx(0.5, rel=1e-12)
    k, c, m = 3.0, 5.0, 2.0
    both = (-c + math.sqrt(c * c + 4 * k * m)) / k
    assert time_steps.largest_step(m, k, 0.0, c, False) == pytest.approx(both, rel=1e-12)
    implicit = (c + math.sqrt(c * c + 4 * k * m)) / k
    assert time_steps.largest_step(m, k, 0.0, c, True) == pytest.approx(implicit, rel=1e-12)
    assert math.isinf(time_steps.largest_step(m, 0.0, 0.0, c, True))
    assert time_steps.largest_step(m, k, 0.0, 0.0, False, 4.0) == pytest.approx(math.sqrt(m / k), rel=1e-12)


QUADRATIC = """
from pywet.laws.force_law import force_law

@force_law
def inertial(separation, volume, radius_i, radius_j, normal_velocity, viscosity):
    return -1000.0 * radius_i**2 * normal_velocity * abs(normal_velocity)

@force_law
def one_way(separation, volume, radius_i, radius_j, normal_velocity, viscosity):
    return -viscosity * radius_i * max(normal_velocity, 0.0)
"""


def test_semi_implicit_drag_is_for_forces_proportional_to_the_velocity(tmp_path: Path) -> None:
    """Its coefficient is that at 1 m/s: a law for which another holds at another velocity is integrated explicitly."""
    (tmp_path / "laws.py").write_text(QUADRATIC)
    custom = [f"{tmp_path / 'laws.py'}:{name}" for name in ("inertial", "one_way")]
    custom_laws.trust(custom)
    key = "time_step.viscous_integration"
    for law in (None, "pitois", "adams_perchard", "davis", "buck_water", *custom):
        effects = small.PAPER.model_copy(update={"viscous_normal": law})
        time_steps.refuse_nonlinear_drag(effects, "explicit", key, "config.yaml")
        if law in ("buck_water", *custom):
            with raises_code("step.not_proportional", key=key, given="semi_implicit", expected="explicit"):
                time_steps.refuse_nonlinear_drag(effects, "semi_implicit", key, "config.yaml")
        else:
            time_steps.refuse_nonlinear_drag(effects, "semi_implicit", key, "config.yaml")


def test_a_wet_and_viscous_scene_is_governed_by_the_drag(tmp_path: Path) -> None:
    """And a thin liquid by the contact; the lines say so."""
    thick, _ = stability.pressed_pair(tmp_path / "thick", 1.0, 2e-6, "explicit")
    thin, _ = stability.pressed_pair(tmp_path / "thin", 1e-4, 2e-5, "explicit")
    assert time_steps.advise(thick).governs.effect == "viscous normal"
    assert time_steps.advise(thin).governs.effect in ("contact", "viscous normal")
    assert "which is: viscous normal" in time_steps.advise(thick).lines[-1]


def test_a_bridge_has_its_limits_whatever_the_viscosity(tmp_path: Path) -> None:
    """It is passed in a tenth of the time in which 0.1 m/s crosses its rupture distance, with the angles of both spheres."""
    small_one, large_one = stability.R, 2 * stability.R
    angles = (math.radians(15.0), math.radians(60.0))
    classes = [
        c.model_copy(update={"contact_angle_rad": a})
        for c, a in zip(spheres_of(small_one, large_one), angles, strict=True)
    ]
    drawn, rupture = (
        registry.get(*law).functions[0] for law in (("formation", "shi_mccarthy"), ("rupture", "willett_unequal"))
    )
    pairs = ((small_one, large_one), (large_one, small_one))
    volume = sum(drawn(film_volume(stability.FILM, r), r, other) for r, other in pairs)
    dragged = stability.NORMAL.model_copy(update={"capillary": None})
    for viscosity, effects in ((1.0, stability.NORMAL), (1e-6, stability.NORMAL), (1e-6, small.PAPER), (1.0, dragged)):
        scene = small.prepare(
            tmp_path / f"{viscosity}{effects.viscous_tangential}{effects.capillary}", classes,
            [small.Sphere(k + 1, (0.0, 0.0, 0.1 * k)) for k in (0, 1)], contacts(2),
            liquid=water(stability.FILM, viscosity), effects=effects, time_step_s=1e-7, steps=1,
        )  # fmt: skip
        limits = {limit.effect: limit.time_step_s for limit in time_steps.advise(scene).limits}
        sideways = {"viscous tangential"} if effects.viscous_tangential else set()
        pulled = {"capillary"} if effects.capillary else set()
        assert set(limits) == {"contact", "viscous normal", "passing a bridge"} | sideways | pulled
        distance = rupture(volume, small_one, large_one, *angles)
        assert limits["passing a bridge"] == pytest.approx(0.1 * distance / 0.1, rel=1e-9)
        pair, mass = next(p for p in scene.pairs if (p.a, p.b) == (1, 2)), 1.0 / sum(1.0 / c.mass_kg for c in classes)
        drag = registry.get("viscous_normal", "pitois").functions[0]
        c = -drag(0.0, volume, small_one, large_one, 1.0, viscosity)  # at 1 m/s
        stiffness = pair.normal_stiffness_N_per_m
        alone = time_steps.largest_step(mass, stiffness, damping(pair.restitution, mass, stiffness), c, False)
        assert limits["viscous normal"] == pytest.approx(alone, rel=1e-9)
        if viscosity < 1e-3 and sideways:  # of a spring at the rim of two spheres, I = 2/5 m r^2
            turned = 2.0 * math.sqrt(mass / (3.5 * pair.tangential_stiffness_N_per_m))
            assert limits["viscous tangential"] == pytest.approx(turned, rel=1e-5)


def test_a_turning_wall_is_as_fast_as_its_rim(tmp_path: Path) -> None:
    """A drum that turns twice as fast passes a bridge in half the time; the speed is that of its corners about the axis z."""
    choice, limits = scenes.Choice(spheres=60), {}
    sphere, outside = choice.glass(60), 0.0
    for rpm in (0.1, 200.0, 400.0):
        poured, where = scenes.in_a_drum(dataclasses.replace(choice, turns_per_minute=rpm))
        folder = tmp_path / f"{rpm:g}"
        scene = small.prepare(
            folder, [sphere], poured, scenes.springs(2e3), liquid=choice.liquid(sphere), effects=small.PAPER, time_step_s=1e-7,
            steps=1, **where,
        )  # fmt: skip
        run = RunDir(folder)
        outside = float(np.hypot(run.corners_at_rest[..., 0], run.corners_at_rest[..., 1]).max())
        corners = {wall.name: run.corners_at_rest[run.meshes == wall.name] for wall in scene.walls}
        limits[rpm] = [passing(time_steps.advise(scene, *given)) for given in ((corners,), ())]
        shown = CliRunner().invoke(app, ["timestep", str(folder)]).output
        assert f"passing a bridge    {limits[rpm][0]:9.2e} s" in shown
    still, fast = limits[0.1][0], limits[200.0][0]
    assert limits[400.0][0] == pytest.approx(0.5 * fast, rel=1e-9)
    assert fast == pytest.approx(still * 0.1 / (2.0 * math.pi * 200.0 / 60.0 * outside), rel=1e-9)
    assert limits[200.0][1] < fast  # the box is larger


def passing(advice: time_steps.Advice) -> float:
    return next(limit.time_step_s for limit in advice.limits if limit.effect == "passing a bridge")


def test_a_step_at_the_limit_is_not_refused(tmp_path: Path) -> None:
    scene, _ = stability.pressed_pair(tmp_path, 1.0, 4e-5, "explicit")
    largest = min(limit.time_step_s for limit in time_steps.advise(scene).limits if limit.stability)
    time_steps.refuse_unstable(scene.model_copy(update={"time_step_s": largest}))
    with raises_code("step.unstable"):
        time_steps.refuse_unstable(scene.model_copy(update={"time_step_s": largest * (1.0 + 1e-12)}))


def test_unstable_step_is_refused_in_one_sentence(tmp_path: Path) -> None:
    """It names the scene, the step, the effect, the bodies, the limit and the remedy."""
    scene, _ = stability.pressed_pair(tmp_path, 1.0, 4e-5, "explicit")
    with raises_code("step.unstable"):
        time_steps.refuse_unstable(scene)
    scene, _ = stability.pressed_pair(tmp_path, 1.0, 4e-5, "semi_implicit")
    time_steps.refuse_unstable(scene)


def test_refusal_names_bridges_every_where_it_is_more_than_one(tmp_path: Path) -> None:
    scene, _ = stability.pressed_pair(tmp_path, 1.0, 4e-5, "explicit")
    for every, named in ((1, False), (2, True)):
        with pytest.raises(PywetError) as refused:
            time_steps.refuse_unstable(scene.model_copy(update={"bridges_every": every}))
        assert (f"or bridges_every, which is {every}" in str(refused.value)) == named


@pytest.mark.engine
@pytest.mark.parametrize(
    ("viscosity", "how"),
    [
        (1.0, "explicit"),
        pytest.param(1e-4, "explicit", marks=pytest.mark.slow),
        pytest.param(0.01, "semi_implicit", marks=pytest.mark.slow),
    ],
)
def test_limit_in_the_engine(tmp_path: Path, viscosity: float, how: str) -> None:
    """At 0.97 of the advised limit a pair comes to rest, at 1.03 it does not."""
    limit, _ = stability.advised(tmp_path / "advised", viscosity, how)
    assert stability.is_stable(tmp_path / "below", viscosity, 0.97 * limit, how)
    assert not stability.is_stable(tmp_path / "above", viscosity, 1.03 * limit, how)


@pytest.mark.engine
@pytest.mark.slow
@pytest.mark.parametrize(
    ("viscosity", "how"),
    [(eta, "explicit") for eta in (1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0)]
    + [(eta, "semi_implicit") for eta in (1e-3, 1e-2, 0.1)],
)
def test_limit_by_bisection(tmp_path: Path, viscosity: float, how: str) -> None:
    """The advised limit is within 5 % of the true one: six halvings of an interval of 1.5/0.7 leave 1.2 %, and at 1e-4 Pa s a
    swing close to the limit decays too slowly to be distinguished from one that does not."""
    limit, _ = stability.advised(tmp_path, viscosity, how)
    assert stability.true_limit(tmp_path, viscosity, how, limit) == pytest.approx(limit, rel=0.05)


@pytest.mark.engine
@pytest.mark.slow
@pytest.mark.parametrize("viscosity", [1.0, 10.0, 1000.0])
def test_semi_implicit_is_stable_at_the_contact_limit(tmp_path: Path, viscosity: float) -> None:
    """Whatever the viscosity, a step just below the dry contact's limit is stable."""
    scene, _ = stability.pressed_pair(tmp_path / "advised", viscosity, 1e-6, "semi_implicit")
    contact = next(limit for limit in time_steps.advise(scene).limits if limit.effect == "contact")
    assert time_steps.advise(scene).governs == contact
    assert stability.is_stable(tmp_path / "run", viscosity, 0.97 * contact.time_step_s, "semi_implicit")
