"""The collision inside the engine next to the model: the same laws, and each difference accounted for."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from pywet.collisions.wall import drag, wall
from pywet.collisions.wall.problem import Readings
from pywet.laws import registry, toroid
from studies.buck2018 import buck_impact, engine
from tests.collisions.cases import problem

GLASS, ALUMINA = "glass_1.74mm", "alumina_1.74mm"
TOUCH = 8.7e-4, math.radians(15.0)


def test_plugin_capillary_law_is_the_models_at_the_volume_it_has_at_touch() -> None:
    """φ is found from V with 50 halvings: 1e-12."""
    radius, theta = TOUCH
    law = registry.get("capillary", "buck").functions[0]
    for phi in np.radians([5.0, 35.0, 55.0, 80.0]):
        cap, angle, rim = radius * (1 - math.cos(phi)), phi + theta, radius * math.sin(phi)
        volume = toroid.volume(cap, radius, phi, angle, False, False)
        for gap in (0.0, 1e-5, 0.3 * cap):
            want = max(toroid.attraction(gap + cap, rim, angle, 0.0728, False, False), 0.0)
            assert law(gap, volume, radius, math.inf, theta, 0.0, 0.0728) == pytest.approx(want, rel=1e-11)


def test_plugin_viscous_laws_are_the_models() -> None:
    radius, theta = TOUCH
    phi = math.radians(35.0)
    volume = toroid.volume(radius * (1 - math.cos(phi)), radius, phi, phi + theta, False, False)
    normal = registry.get("viscous_normal", "buck_water").functions[0]
    for gap, speed in ((0.0, 0.5), (1e-4, 1.0), (8e-4, 2.0)):
        floor = max(gap, drag.GAP_MIN)
        want = max(
            drag.unbounded(speed, radius * math.sin(phi), 1e-3, 998.0), drag.near_wall(speed, floor, radius, 1e-3)
        )
        assert normal(gap, volume, radius, math.inf, -speed, 1e-3) == pytest.approx(want, rel=1e-11)
        assert normal(-1e-7, volume, radius, math.inf, -speed, 1e-3) == 0.0
        slide, roll = (f(gap, radius, math.inf, 1e-3) for f in registry.get("viscous_tangential", "buck").functions)
        log = math.log(radius / floor)
        assert -slide == pytest.approx(drag.goldman_force(1.0, 0.0, log, radius, 1e-3, -1.0), rel=1e-12)
        assert -roll == pytest.approx(drag.goldman_force(0.0, 1.0, log, radius, 1e-3, -1.0), rel=1e-12)


def test_plugin_rupture_is_the_models() -> None:
    static = registry.get("rupture", "buck").functions[0](1e-10, 1e-3, math.inf, 0.2618, 0.0)
    factor = registry.get("dynamic_rupture", "pitois").functions[0](0.7, 1e-3, 0.07)
    assert static * factor == pytest.approx(toroid.rupture_length(1e-10, 0.7, 0.2618, 1e-3, 0.07), rel=1e-14)


@pytest.mark.engine
def test_each_step_from_the_model_to_the_engine(tmp_path: Path) -> None:
    """The engine agrees with its own equations solved in Python to 1e-3 (50 steps per contact); the frozen volume is most of
    the difference to the model, the rest is below 0.01.
    """
    case, changed = problem(GLASS, ("water", 100)), {}
    steps = [wall.collide(case)["e_n"]]
    for name, reading in (("bridge_volume", "frozen"), ("rupture_from", "wall"), ("capillary", "film_and_bridge")):
        changed[name] = reading
        steps.append(wall.collide(case.model_copy(update={"readings": Readings.model_validate(changed)}))["e_n"])
    steps += [buck_impact.normal_coefficient(case), engine.impact(case, tmp_path).e_n]
    assert steps[-1] == pytest.approx(steps[-2], abs=1e-3)
    assert steps[1] - steps[0] == pytest.approx(0.044, abs=1e-3)
    assert np.abs(np.diff(steps[1:])).max() < 0.01


@pytest.mark.engine
def test_dry_and_oblique_inside_the_engine(tmp_path: Path) -> None:
    """Friction and spin have the signs of the model. Sliding all through: Coulomb's impulse in both. e_n within 1 % (50 steps per
    contact); the tangential impulse within 3 %, since a Hertzian contact pulls at its end and a linear one is cut off there.
    """
    case = problem(ALUMINA, angle_deg=60.0, omega_rad_per_s=-300.0, gravity_m_per_s2=0.0)
    inside, model = engine.impact(case, tmp_path), wall.collide(case)
    assert inside.e_n == pytest.approx(model["e_n"], rel=0.01)
    before = case.tangential_velocity
    assert inside.v_t - before == pytest.approx(model["v_t_out"] - before, rel=0.03)
    assert inside.omega + 300.0 == pytest.approx(model["omega_out"] + 300.0, rel=0.03)
