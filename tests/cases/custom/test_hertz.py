"""`contact: hertz` of a description: keys that go together, moduli of spheres and walls, what the plan says, time step, a run."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import pytest

import pywet
from pywet.cases.custom.building import Building
from pywet.laws.hertz import HEAD_ON, Elastic
from tests.cases.custom.conftest import beads
from tests.error_codes import raises_code

GLASS = {"density_kg_per_m3": 2500, "youngs_modulus_Pa": 1e7, "poissons_ratio": 0.25}
STEEL = {"density_kg_per_m3": 7800, "youngs_modulus_Pa": 1e8, "poissons_ratio": 0.3}
CUP = {"name": "漏斗", "vessel": {"inner_width_mm": 24, "height_mm": 45, "origin_mm": (10, 10, -1)}}


def hertzian(**changes: Any) -> pywet.Scene:
    return pywet.Scene(**beads(**{"contact": "hertz", "materials": {"glass": GLASS}, **changes}))


@pytest.mark.parametrize(
    ("changes", "code", "words"),
    [
        (
            {"materials": {"glass": {**GLASS, "stiffness_N_per_m": 1e3}}},
            "config.inconsistent", "no stiffness_N_per_m of materials.glass with contact: hertz",
        ),
        ({"contact": "linear"}, "config.inconsistent",
         "contact: hertz for materials.glass.youngs_modulus_Pa; linear springs have stiffness_N_per_m"),
        ({"materials": {"glass": {"density_kg_per_m3": 2500}}},
         "config.inconsistent", "youngs_modulus_Pa of materials.glass with contact: hertz"),
        ({"materials": {"glass": {**GLASS, "restitution": 0.05}}},
         "config.inconsistent", "a restitution above 0.05 of materials.glass"),
        ({"effects": {"tolerance": {"value": 0.01, "source": "assumption", "reason": "x"}, "tangential_history": False}},
         "config.inconsistent", "tangential_history on or auto with contact: hertz"),
        ({"wall_material": "steel"}, "config.inconsistent", "wall_material to name a material (glass), not steel"),
        ({"materials": {"glass": {**GLASS, "poissons_ratio": 0.6}}}, "config.value", "poissons_ratio"),
    ],
)  # fmt: skip
def test_what_does_not_go_together_is_named(changes: dict[str, Any], code: str, words: str) -> None:
    with raises_code(code, re.escape(words)):
        hertzian(**changes)


def test_walls_have_a_material() -> None:
    """The spheres' own, or the one named, with which a contact is that with the walls; needed with several materials."""
    assert Building(hertzian(walls=[CUP])).hertz.walls == Elastic(youngs_modulus_Pa=1e7, poissons_ratio=0.25)
    both = {"glass": GLASS, "steel": STEEL}
    made = Building(
        hertzian(walls=[CUP], materials=both, wall_material="steel",
                 contacts=[{"between": ("glass", "steel"), "friction": 0.17, "restitution": 0.6}])
    )  # fmt: skip
    assert made.hertz.walls == Elastic(youngs_modulus_Pa=1e8, poissons_ratio=0.3)
    assert [p.friction for p in made.pairs if p.b == 0] == [0.17]
    entry = beads()["spheres"][0]
    with raises_code("config.inconsistent", says="wall_material"):
        hertzian(walls=[CUP], materials=both, spheres=[entry, {**entry, "name": "balls", "material": "steel"}],
                 contacts=[{"between": ("glass", "steel")}])  # fmt: skip


def test_the_plan_says_what_it_goes_by() -> None:
    """The speed, the shortest impact and the Rayleigh time, in time steps; a wall that is ten times faster shortens both."""
    made = Building(hertzian(walls=[CUP]))
    text = "\n".join(made.plan.table)
    assert f"two bodies at {made.speed:.3g} m/s each" in text and "Rayleigh time" in text and "stock loop" in text
    assert all(len(line) <= 80 for line in made.plan.table)
    one = 2500 * math.pi / 6 * 0.003**3
    # of a wall: m, R and E* of the sphere; 2.87 (m²/(R E² v))^(1/5)
    modulus = 1e7 / (2 * (1 - 0.25**2))
    shortest = 2.8682657 * ((one / 2) ** 2 / (0.00075 * modulus**2 * HEAD_ON * made.speed)) ** 0.2
    assert f"lasts {shortest:.3g} s: {shortest / made.time_step:.0f} time steps" in text
    assert 20 < shortest / made.time_step < 200
    shaken = {**CUP, "vibrates": {"amplitude_mm": (0, 0, 1), "frequency_Hz": 50 * 10 * made.speed}}
    fast = Building(hertzian(walls=[shaken]))
    ratio = (made.speed / fast.speed) ** 0.2
    assert fast.time_step / made.time_step == pytest.approx(ratio, rel=0.05)  # both are cut to two digits


@pytest.mark.engine
@pytest.mark.slow
def test_a_moist_scene_runs_and_is_replayed(tmp_path: Path) -> None:
    """Beads on a wall of another material with a name that no engine's script could hold, with checkpoints."""
    cup = {"name": CUP["name"], "vessel": {"inner_width_mm": 16, "height_mm": 16}}
    box = {"low_mm": (-7, -7, 0.2), "high_mm": (7, 7, 8)}
    entry = {
        "name": "beads",
        "material": "glass",
        "diameter_mm": 3,
        "count": 14,
        "box": box,
        "velocity_m_per_s": (0, 0, -0.4),
    }
    scene = hertzian(
        walls=[{**cup, "vibrates": {"amplitude_mm": (0, 0, 0.3), "frequency_Hz": 60}}], spheres=[entry],
        materials={"glass": {**GLASS, "youngs_modulus_Pa": 2e6}, "steel": STEEL}, wall_material="steel",
        contacts=[{"between": ("glass", "steel")}],
        liquid={"percent": 1.0}, duration_s=0.016, results={"checkpoints": 2, "windows": 3, "window_steps": 15},
    )  # fmt: skip
    output_text = pywet.run(scene, tmp_path).replay
    assert (
        output_text["ok"]
        and output_text["quantities"]["newton_force"]["largest"] < 1e-9
        and output_text["newton"]["dry_contacts"] > 50
    )
    deck = (tmp_path / "engine" / "setup.liggghts").read_text()
    assert "model hertz tangential history rolling_friction cdt" in deck and deck.isascii()
    assert json.loads((tmp_path / "scene.json").read_text())["contacts"] == "planes"
