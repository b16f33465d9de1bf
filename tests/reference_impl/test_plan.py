"""The numbers that decide which effects are on: derived twice, equal over made-up scenes; faults in them are found."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pywet.planning import numbers, surroundings
from pywet.scene import ContactPair, Liquid, SphereClass
from reference_impl.scene import plan

SCREEN = {"frequency_Hz": 50.6, "amplitude_m": [5e-5, 5e-5, 9e-4]}
SCENES = 200
Made = tuple[list[SphereClass], list[ContactPair], Liquid, dict[str, Any]]


def made_up(seed: int) -> Made:
    """One to three classes, contacts and a liquid at random; the last as scene.json holds them."""
    random = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(random.uniform(math.log(low), math.log(high))))

    names = range(1, 2 + int(random.integers(3)))
    classes = [
        SphereClass(name=f"c{n}", type=n, radius_m=between(1e-4, 1e-2), density_kg_per_m3=between(500, 8000),
                    contact_angle_rad=float(random.uniform(0, 1.4)), count=int(random.integers(0, 3)) if n > 1 else 1)
        for n in names
    ]  # fmt: skip
    pairs = [
        ContactPair(a=a, b=b, normal_stiffness_N_per_m=between(100, 1e5), tangential_stiffness_N_per_m=100.0,
                    friction=between(0.01, 1), rolling_friction_m=between(1e-7, 1e-4), restitution=0.7)
        for a in names for b in [0, *range(a, len(names) + 1)]
    ]  # fmt: skip
    liquid = Liquid(
        surface_tension_N_per_m=between(0.01, 0.5), viscosity_Pa_s=between(1e-4, 10), density_kg_per_m3=between(700, 2000),
        initial_film_thickness_m=between(1e-7, 5e-4),
    )  # fmt: skip
    scene = {
        "classes": [c.model_dump() for c in classes], "pairs": [p.model_dump() for p in pairs], "hertz": None,
        "liquid": liquid.model_dump(), "vibration": SCREEN, "gravity_m_per_s2": [0.0, 0.0, -9.81],
    }  # fmt: skip
    return classes, pairs, liquid, scene


def planned(folder: Path, made: Made, screen: dict[str, Any] = SCREEN) -> list[str]:
    """Return the numbers of pywet's plan of a scene that differ from the reference's."""
    classes, pairs, liquid, scene = made
    scene = scene | {"vibration": screen}
    found = numbers.effect_numbers(classes, pairs, liquid, plan.peak_speed(screen))
    rows = [{"effect": effect, "number": number} for effect, (_, number) in found.items()]
    (folder / plan.FILE).write_text(json.dumps({"rows": rows}))
    compared = [*plan.compared(folder, scene, case=True)]
    assert {h.name for h in compared} == {f"plan.{row['effect']}.number" for row in rows}
    return [h.name for h in compared if h.wrong]


def test_numbers_are_equal_over_made_up_scenes(tmp_path: Path) -> None:
    """All effects of 200 scenes whose radii, liquids and speeds span decades."""
    assert [seed for seed in range(SCENES) if planned(tmp_path, made_up(seed))] == []


def test_a_screen_at_rest_is_compared(tmp_path: Path) -> None:
    """Without any amplitude the Stokes number is zero: all speed is lost in the film."""
    still = SCREEN | {"amplitude_m": [0.0, 0.0, 0.0]}
    assert [seed for seed in range(20) if planned(tmp_path, made_up(seed), still)] == []
    rows = json.loads((tmp_path / plan.FILE).read_text())["rows"]
    assert {row["effect"]: row["number"] for row in rows}["viscous_normal"] == 1.0


def halved(name: str) -> Callable[[pytest.MonkeyPatch], None]:
    """A field of the groups at half its value."""

    def patch(monkeypatch: pytest.MonkeyPatch) -> None:
        sound = surroundings.groups

        def wrong(*given: Any) -> surroundings.Groups:
            g = sound(*given)
            object.__setattr__(g, name, 0.5 * getattr(g, name))
            return g

        monkeypatch.setattr(numbers, "groups", wrong)

    return patch


FAULTS = {
    "capillary number halved": (halved("capillary_number"), "dynamic_rupture"),
    "weight halved in the Bond number": (halved("weight"), "capillary"),
    "reduced radius too small in the Stokes number": (halved("normal_drag_gap"), "viscous_normal"),
    "tangential drag halved": (halved("tangential_drag"), "viscous_tangential"),
    "rolling friction halved": (halved("rolling_friction"), "rolling"),
    "weight of the liquid halved": (halved("liquid_mass"), "liquid_weight"),
    "surface that holds a drop halved": (halved("surface_tension"), "shedding"),
    "speed of a user-defined scene": (halved("speed"), "viscous_normal"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_wrong_number_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str) -> None:
    """By its effect, whatever else follows from it."""
    patch, effect = FAULTS[fault]
    patch(monkeypatch)
    wrong = [name for seed in range(20) for name in planned(tmp_path, made_up(seed))]
    assert f"plan.{effect}.number" in wrong


def test_numbers_of_a_user_defined_scene_fit_each_other(tmp_path: Path) -> None:
    """The speed follows from the capillary number; one of them halved, or no slow phase, does not fit the others."""
    classes, pairs, liquid, scene = made_up(7)  # loses 0.15 of its speed in a film at 0.1 m/s
    for factor, slow, fits in ((1.0, plan.SLOW, True), (math.sqrt(0.5), plan.SLOW, False), (1.0, math.inf, False)):
        around = surroundings.Surroundings(slow_m_per_s=slow)
        found = numbers.effect_numbers(classes, pairs, liquid, 0.3, around)
        rows = [
            {"effect": effect, "number": number * (factor if effect == "dynamic_rupture" else 1.0)}
            for effect, (_, number) in found.items()
        ]
        (tmp_path / plan.FILE).write_text(json.dumps({"rows": rows}))
        assert all(not h.wrong for h in plan.compared(tmp_path, scene, case=False)) == fits
