"""The effect plan: what is on, why, and the numbers behind it, checked by hand for two equal POM spheres of 5 mm."""

from __future__ import annotations

import math
from typing import Any

import pytest

from pywet.config import EffectSettings, LawSettings
from pywet.config.entries import RatioEntry
from pywet.effects import EffectPlan, effect_numbers, plan
from pywet.errors import PywetError
from pywet.scene import ContactPair, Effects, Liquid, SphereClass

SPHERE = SphereClass(
    name="small", type=1, radius_m=2.5e-3, density_kg_per_m3=1358, contact_angle_rad=math.radians(40), count=10
)
PAIRS = tuple(
    ContactPair(
        a=1,
        b=b,
        normal_stiffness_N_per_m=1e5,
        tangential_stiffness_N_per_m=1e5,
        friction=0.35,
        rolling_friction_m=5e-5,
        restitution=0.8,
    )
    for b in (0, 1)
)
SPEED = 0.3


def water(film: float = 5e-5, viscosity: float = 1e-3) -> Liquid:
    return Liquid(
        surface_tension_N_per_m=0.07275,
        viscosity_Pa_s=viscosity,
        density_kg_per_m3=998.2,
        initial_film_thickness_m=film,
    )


def settings(tolerance: float = 0.01, **switches: Any) -> EffectSettings:
    entry = RatioEntry(value=tolerance, source="assumption", reason="chosen by the test")
    return EffectSettings(tolerance=entry, **switches)


def make(liquid: Liquid | None, tolerance: float = 0.01, **switches: Any) -> EffectPlan:
    return plan((SPHERE,), PAIRS, liquid, SPEED, settings(tolerance, **switches), LawSettings())


def test_dry_scene_runs_without_bridges() -> None:
    made = make(None)
    assert made.effects == Effects(bridges=False, rolling=True)
    assert [row.effect for row in made.rows if row.on] == ["rolling"]


def test_moist_scene_has_the_papers_laws() -> None:
    assert make(water()).effects == Effects(
        bridges=True,
        capillary="rabinovich",
        viscous_normal="pitois",
        viscous_tangential="goldman",
        rupture="willett_unequal",
        dynamic_rupture="pitois",
        formation="shi_mccarthy",
        transfer="parabola",
        rolling=True,
    )


def test_numbers_by_hand() -> None:
    numbers = {effect: number for effect, (_, number) in effect_numbers((SPHERE,), PAIRS, water(), SPEED).items()}
    weight = 1358 * 4 / 3 * math.pi * 2.5e-3**3 * 9.81
    assert numbers["bridges"] == pytest.approx(0.02, rel=1e-12)
    # 2 pi r sigma cos(theta) of two equal spheres at touch
    assert numbers["capillary"] == pytest.approx(2 * math.pi * 2.5e-3 * 0.07275 * math.cos(math.radians(40)) / weight)
    # St = m_eff v/(6 pi eta r_red^2); the gap falls from 2 h + S_min to S_min = 0.001 r
    stokes = weight / 9.81 / 2 * SPEED / (6 * math.pi * 1e-3 * 1.25e-3**2)
    assert numbers["viscous_normal"] == pytest.approx(math.log(1 + 1e-4 / 2.5e-6) / stokes)
    drag = 6 * math.pi * 1e-3 * 1.25e-3 * (8 / 15 * math.log(500) + 0.9588) * SPEED
    assert numbers["viscous_tangential"] == pytest.approx(drag / (0.35 * weight))
    assert numbers["dynamic_rupture"] == pytest.approx(math.sqrt(SPEED * 1e-3 / 0.07275))
    assert numbers["rolling"] == pytest.approx(5e-5 / (0.35 * 2.5e-3))


def test_preset_keeps_what_is_negligible_and_says_so() -> None:
    made = make(water(viscosity=1e-6))
    row = next(r for r in made.rows if r.effect == "viscous_normal")
    assert row.on and row.number < row.threshold
    assert row.why == "negligible by its number but on: preset paper asks for it"


def test_tolerance_drops_what_is_negligible() -> None:
    made = make(water(viscosity=1e-6), decide="tolerance")
    assert made.effects.viscous_normal is None and made.effects.viscous_tangential is None
    assert made.effects.dynamic_rupture is None  # sqrt(Ca) = 2e-3
    assert made.effects.capillary == "rabinovich"
    assert make(water(), tolerance=0.1, decide="tolerance").effects.rolling is False  # 0.057


@pytest.mark.parametrize("effect", ["capillary", "viscous_normal", "viscous_tangential", "dynamic_rupture"])
def test_an_effect_can_be_switched_by_hand(effect: str) -> None:
    made = make(water(), **{effect: False})
    assert getattr(made.effects, effect) is None
    assert next(r for r in made.rows if r.effect == effect).why == f"effects.{effect} is off in config.yaml"
    kept = make(water(viscosity=1e-9), tolerance=1.0, decide="tolerance", **{effect: True})
    assert getattr(kept.effects, effect) is not None


def test_bridges_off_takes_their_effects_along() -> None:
    assert make(water(), bridges=False).effects == Effects(bridges=False)


def test_contradictions_are_one_sentence() -> None:
    with pytest.raises(PywetError, match=r"effects\.bridges is on but the case has no liquid"):
        make(None, bridges=True)
    with pytest.raises(PywetError, match=r"effects\.capillary is on but there are no bridges"):
        make(None, capillary=True)
    with pytest.raises(PywetError, match="no capillary law named nobody"):
        plan((SPHERE,), PAIRS, water(), SPEED, settings(), LawSettings(capillary="nobody"))


def test_one_line_per_effect_with_its_number() -> None:
    made = make(water())
    assert len(made.lines) == len(made.rows) == 8
    for row in made.rows:
        assert row.line.startswith(row.effect)
        assert f"{row.number:.2g}" in row.line and "\n" not in row.line
