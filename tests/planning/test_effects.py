"""The effect plan: what is on, why, and the numbers behind it, checked by hand for two equal POM spheres of 5 mm."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from pywet.cases.small import bodies
from pywet.config import EffectSettings, LawSettings
from pywet.config.entries import RatioEntry
from pywet.planning.effect_plan import EffectPlan, plan
from pywet.planning.numbers import effect_numbers
from pywet.planning.surroundings import Surroundings, groups
from pywet.scene import ContactPair, Effects, Liquid
from tests.error_codes import raises_code

(SPHERE,) = bodies.sphere_classes(2.5e-3, counts=10, density=1358, angle_rad=math.radians(40), name="small")
PAIRS = bodies.contacts(1, 1e5, friction=0.35, rolling_m=5e-5)
SPEED = 0.3


def water(film: float = 5e-5, viscosity: float = 1e-3) -> Liquid:
    return bodies.water(film, viscosity, density=998.2)


def settings(tolerance: float = 0.01, **switches: Any) -> EffectSettings:
    entry = RatioEntry(value=tolerance, source="assumption", reason="chosen by the test")
    return EffectSettings(tolerance=entry, **switches)


def make(liquid: Liquid | None, tolerance: float = 0.01, **switches: Any) -> EffectPlan:
    return plan((SPHERE,), PAIRS, liquid, SPEED, settings(tolerance, **switches), LawSettings())


def test_dry_scene_runs_without_bridges() -> None:
    made = make(None)
    assert made.effects == Effects(bridges=False, rolling=True)
    assert [row.effect for row in made.rows if row.on] == ["rolling", "tangential_history", "gravity"]


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
    # St = m_eff v/(6 pi eta r_red^2); the gap falls from 2 h + S_min to S_min = 0.001 r and stays there over the overlap
    m_eff = weight / 9.81 / 2
    stokes, overlap = m_eff * SPEED / (6 * math.pi * 1e-3 * 1.25e-3**2), SPEED * math.sqrt(m_eff / 1e5)
    assert numbers["viscous_normal"] == pytest.approx((math.log(1 + 1e-4 / 2.5e-6) + overlap / 2.5e-6) / stokes)
    drag = 6 * math.pi * 1e-3 * 1.25e-3 * (8 / 15 * math.log(500) + 0.9588) * SPEED
    assert numbers["viscous_tangential"] == pytest.approx(drag / (0.35 * weight))
    assert numbers["dynamic_rupture"] == pytest.approx(math.sqrt(SPEED * 1e-3 / 0.07275))
    # the capillary force increases rolling friction more than the weight does: mu_r/r F/W and mu_r/(mu r)
    assert numbers["rolling"] == pytest.approx(5e-5 / 2.5e-3 * max(1 / 0.35, numbers["capillary"]))
    film = 4 / 3 * math.pi * ((2.55e-3) ** 3 - 2.5e-3**3)
    assert numbers["liquid_weight"] == pytest.approx(film * 998.2 / (weight / 9.81), rel=1e-9)
    assert numbers["tangential_history"] == 0.35 and numbers["gravity"] == 1.0
    # Lian's rupture distance (1 + theta/2) V^(1/3), with the share of a film under a cap of 30 degrees from both spheres
    volume = 2.0 * film * 0.5 * (1.0 - math.cos(math.radians(30.0)))
    pair = groups(SPHERE, PAIRS[-1], water(), SPEED, 9.81)
    assert pair.slip_time == pytest.approx(
        4.0 * 5e-5 / SPEED + math.pi * math.sqrt(m_eff / 1e5)
    )  # films in and out, contact
    assert pair.rupture == pytest.approx((1.0 + 0.5 * math.radians(40.0)) * volume ** (1.0 / 3.0), rel=1e-9)
    half = effect_numbers((SPHERE,), PAIRS, water(), SPEED, Surroundings(wall_share=0.5))["wall_films"][1]
    assert half == pytest.approx(0.5 * numbers["wall_films"])


ODD: dict[str, tuple[dict[str, float], Surroundings]] = {
    "rolling": ({"rolling_friction_m": 5e-4}, Surroundings()),
    "tangential_history": ({"friction": 0.6}, Surroundings()),
    "viscous_tangential": ({"friction": 0.1}, Surroundings()),
    "viscous_normal": ({"normal_stiffness_N_per_m": 1e3}, Surroundings(state="at_rest")),
}
"""Effect -> properties of one contact that make its number larger."""


@pytest.mark.parametrize("effect", ODD)
def test_every_contact_of_a_class_counts(effect: str) -> None:
    """With a wall, with its own class or with another one; not with walls or classes that are not there."""
    changed, around = ODD[effect]
    two = (SPHERE, SPHERE.model_copy(update={"type": 2}))
    pairs = bodies.contacts(2, 1e5, friction=0.35, rolling_m=5e-5)
    odd = [p.model_copy(update=changed) for p in pairs]

    def number(of: list[ContactPair], count: int = 10, walls: float = 1.0) -> float:
        present = (two[0], two[1].model_copy(update={"count": count}))
        return effect_numbers(present, of, water(), SPEED, replace(around, wall_share=walls))[effect][1]

    assert number(odd) > number([*pairs])
    for k, pair in enumerate(pairs):
        one_odd = [*pairs[:k], odd[k], *pairs[k + 1 :]]
        assert number(one_odd) == number(odd)
        for absent, found in ((0, number(one_odd, walls=0.0)), (2, number(one_odd, count=0))):
            assert found == number([*pairs] if absent in (pair.a, pair.b) else odd)


def test_each_class_has_the_thickness_of_its_films() -> None:
    """Two spheres with 2 % of their radii, one ten times as large: with one film for both the small one would have 20 %."""
    small = SPHERE.model_copy(update={"type": 2, "radius_m": 0.1 * SPHERE.radius_m})
    pairs = bodies.contacts(2, 1e5, friction=0.35, rolling_m=5e-5)
    films = {1: 0.02 * SPHERE.radius_m, 2: 0.02 * small.radius_m}
    each, one = (effect_numbers((SPHERE, small), pairs, water(), SPEED, Surroundings(films_m=f)) for f in (films, {}))
    for effect, ratio in (("bridges", 0.02), ("liquid_weight", (1.02**3 - 1) * 998.2 / 1358)):
        assert each[effect][1] == pytest.approx(ratio, rel=1e-9) and one[effect][1] > 9 * ratio
    dry = effect_numbers((SPHERE, small), pairs, water(), SPEED, Surroundings(films_m={**films, 1: 0.0}))
    assert dry["bridges"][1] == pytest.approx(0.02, rel=1e-9)


def test_of_two_speeds_the_one_with_the_larger_number_counts() -> None:
    """The speed lost in a film falls with the speed; drag over friction and the stretch of a bridge rise."""
    both, fast, slow = (
        effect_numbers((SPHERE,), PAIRS, water(), speed, Surroundings(slow_m_per_s=least))
        for speed, least in ((2.4, 0.1), (2.4, math.inf), (0.1, math.inf))
    )
    assert both["viscous_normal"] == slow["viscous_normal"] > fast["viscous_normal"]
    for effect in ("viscous_tangential", "dynamic_rupture"):
        assert both[effect] == fast[effect] and both[effect][1] > slow[effect][1]


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
    assert make(None, tolerance=0.1, decide="tolerance").effects.rolling is False  # 0.057


@pytest.mark.parametrize("effect", ["capillary", "viscous_normal", "viscous_tangential", "dynamic_rupture"])
def test_an_effect_can_be_switched_by_hand(effect: str) -> None:
    made = make(water(), **{effect: False})
    assert getattr(made.effects, effect) is None
    assert next(r for r in made.rows if r.effect == effect).why == f"effects.{effect} is off in config.yaml"
    stored = make(water(viscosity=1e-9), tolerance=1.0, decide="tolerance", **{effect: True})
    assert getattr(stored.effects, effect) is not None


def test_bridges_off_takes_their_effects_along() -> None:
    assert make(water(), bridges=False).effects == Effects(bridges=False)


def test_contradictions_are_one_sentence() -> None:
    with raises_code("effect.dry"):
        make(None, bridges=True)
    with raises_code("effect.lacking", key="effects.capillary"):
        make(None, capillary=True)
    with raises_code("law.not_of_kind", given="nobody"):
        plan((SPHERE,), PAIRS, water(), SPEED, settings(), LawSettings(capillary="nobody"))


def test_one_line_per_effect_with_its_number() -> None:
    made = make(water())
    assert len(made.lines) == len(made.rows) == 13
    for row in made.rows:
        assert row.line.startswith(row.effect)
        assert f"{row.number:.2g}" in row.line and "\n" not in row.line


DILUTE = Surroundings(state="dilute", duration_s=0.01, solid_fraction=0.0, wall_share=0.0, liquid_wanted=False)


def chosen(
    liquid: Liquid | None, surroundings: Surroundings, tolerance: float, speed: float = SPEED, **switches: Any
) -> EffectPlan:
    given = settings(tolerance, decide="tolerance", **switches)
    return plan((SPHERE,), PAIRS, liquid, speed, given, LawSettings(), surroundings)


def test_what_is_left_out_is_negligible_together() -> None:
    """The numbers of all that is dropped add up to less than the tolerance, though each one that stays on may be below it."""
    for tolerance in (0.02, 0.1, 0.3, 0.9):
        made = chosen(water(), DILUTE, tolerance, speed=5.0)
        dropped = [row.number for row in made.rows if row.why == "negligible by its number"]
        assert sum(dropped) < tolerance
        stored = [row for row in made.rows if row.why == "negligible alone, not together with what is left out"]
        assert all(row.on and row.number < tolerance for row in stored)
        if stored:
            assert sum(dropped) + min(row.number for row in stored) >= tolerance


def test_negligible_liquid_that_nobody_asks_for_runs_dry() -> None:
    """A sphere at 30 m/s: a capillary and viscous energy of some 1e-3 of the kinetic energy."""
    fast = chosen(water(1e-6, 1e-4), DILUTE, 0.1, speed=30.0)
    assert not fast.effects.bridges and "is not asked" in fast.row("bridges").why
    asked = Surroundings(**{**DILUTE.__dict__, "liquid_wanted": True})
    assert chosen(water(1e-6, 1e-4), asked, 0.1, speed=30.0).effects.bridges


def test_a_resting_pile_needs_no_drag_and_a_moving_one_does() -> None:
    """10 weights and one capillary force on a spring of 1e5 N/m move a sphere by 3e-5 of its radius."""
    oil = water(viscosity=2.0)
    rest = chosen(oil, Surroundings(state="at_rest"), 0.01, speed=0.0)
    assert rest.effects.viscous_normal is None and rest.effects.viscous_tangential is None
    weight = SPHERE.mass_kg * 9.81
    pull = 2 * math.pi * 2.5e-3 * 0.07275 * math.cos(math.radians(40))
    assert rest.row("viscous_normal").number == pytest.approx((10 * weight + pull) / (1e5 * 2.5e-3))
    assert chosen(oil, Surroundings(), 0.01).effects.viscous_normal == "pitois"


def test_switches_of_walls_sharing_friction_and_gravity() -> None:
    made = make(water(), wall_films=False, sharing_by_size=False, tangential_history=False, gravity=False).effects
    assert (made.wall_films, made.transfer, made.tangential_history, made.gravity) == (False, "half", False, False)
    walled = chosen(water(), Surroundings(wall_share=0.0), 0.01).effects
    assert (walled.wall_films, walled.transfer) == (False, "half")  # no walls, spheres of one size
    floating = plan((SPHERE,), PAIRS, water(), SPEED, settings(), LawSettings(), Surroundings(gravity_m_per_s2=0.0))
    assert not floating.row("gravity").on


def test_predicted_shares_add_up_and_say_how_sure_they_are() -> None:
    made = make(water())
    shares = {row.effect: row for row in made.rows if row.predicted_share is not None}
    assert set(shares) == {"gravity", "capillary", "viscous_normal", "viscous_tangential"}
    assert sum(row.predicted_share or 0.0 for row in shares.values()) == pytest.approx(1.0)
    numbers = {effect: number for effect, (_, number) in effect_numbers((SPHERE,), PAIRS, water(), SPEED).items()}
    of_weight = {
        effect: (row.predicted_share or 0.0) / (shares["gravity"].predicted_share or 0.0)
        for effect, row in shares.items()
    }
    # three bridges a sphere: three quarters of the force at touch; 0.4 of a tenth of the speed, the number being over friction
    assert of_weight["capillary"] == pytest.approx(3.0 * 0.75 * numbers["capillary"])
    assert of_weight["viscous_tangential"] == pytest.approx(3.0 * 0.4 * 0.1 * 0.35 * numbers["viscous_tangential"])
    assert shares["capillary"].predicted_within == 3.0 and shares["viscous_normal"].predicted_within == 15.0


def test_effects_in_no_preset_say_when_they_matter() -> None:
    """Drops: what of the film is beyond 2 pi r sigma under g + v/t, t = 1/omega of a free drop of its volume."""
    made = make(water(2e-4))
    for effect in ("liquid_weight", "shedding"):
        assert not made.row(effect).on and "in no preset, though not negligible" in made.row(effect).why
    film = 4 / 3 * math.pi * (2.7e-3**3 - 2.5e-3**3)
    time = math.sqrt(998.2 * (film * 3 / (4 * math.pi)) / (8 * 0.07275))
    felt = 9.81 + SPEED / time
    held = 2 * math.pi * 2.5e-3 * 0.07275 / (998.2 * film * felt)
    assert made.row("shedding").number == pytest.approx(1 - held, rel=1e-9)
    small = make(water(1e-6))
    assert "in no preset, and negligible" in small.row("shedding").why and small.row("shedding").number == 0.0


def test_effects_in_no_preset_are_switched_by_hand() -> None:
    """Their law is the one that is named, else Tate's; a dry case cannot have them."""
    on = make(water(), liquid_weight=True, shedding=True).effects
    assert on.liquid_weight and on.shedding == "tate"
    off = make(water(2e-4), tolerance=0.01, decide="tolerance").effects
    assert not off.liquid_weight and off.shedding is None
    for effect in ("liquid_weight", "shedding"):
        with raises_code("effect.lacking", key=f"effects.{effect}"):
            make(None, **{effect: True})


def test_impossible_surroundings_are_refused() -> None:
    with raises_code("scene.surroundings"):
        Surroundings(wall_share=1.5)
    with raises_code("scene.surroundings"):
        Surroundings(solid_fraction=0.75)


def test_a_share_of_what_is_wanted_is_one_at_most() -> None:
    """In ten seconds all falls faster than it moves; in a millisecond by g t/v."""
    fall = [
        effect_numbers((SPHERE,), PAIRS, None, SPEED, Surroundings(state="dilute", duration_s=t))["gravity"][1]
        for t in (10.0, 1e-3)
    ]
    assert fall == [1.0, pytest.approx(9.81e-3 / SPEED, rel=1e-12)]
