"""A description refuses what cannot be meant: every mistake on a line, said so that it can be mended."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import TypeAdapter, ValidationError

import pywet
from pywet.cases.custom.building import Building
from pywet.cases.custom.description import WALLS
from pywet.cases.custom.materials import Percent
from pywet.engines.liggghts.contact_model import property_matrices
from pywet.errors import ConfigError
from pywet.scene_stages import read_scene
from tests.cases.custom.conftest import beads
from tests.error_codes import raises_code

PAGE = Path(__file__).parents[3] / "docs" / "own-scene.md"


def refusal(**changes: Any) -> str:
    with pytest.raises(ConfigError) as error:
        pywet.Scene(**beads(**changes))
    return str(error.value)


@pytest.mark.parametrize(("percent", "is_one"), [(0, True), (0.5, True), (100, True), (-0.1, False), (100.1, False)])
def test_a_percentage_is_from_0_to_100(percent: float, is_one: bool) -> None:
    with nullcontext() if is_one else pytest.raises(ValidationError):
        TypeAdapter(Percent).validate_python(percent)


def test_all_mistakes_of_a_file_are_reported_at_once(tmp_path: Path) -> None:
    """Each on a line of its own with the file, the key, what was given and what was expected."""
    wrong = beads(duration_s=-1, gravity=[0, 0, -9.81], materials={"glass": {"density_kg_per_m3": 2.5}})
    wrong["spheres"][0]["diameter_mm"] = "3 mm"
    file = tmp_path / "scene.yaml"
    file.write_text(yaml.safe_dump({**wrong, "spheres": wrong["spheres"]}))
    with pytest.raises(ConfigError) as error:
        read_scene(file)
    lines = str(error.value).splitlines()
    assert len(lines) == 4
    for line, words in zip(
        lines, ["gravity is not known, expected gravity_m_per_s2", "duration_s", "density_kg_per_m3 is 2.5", "diameter_mm"],
        strict=True,
    ):  # fmt: skip
        assert words in line and "expected" in line


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"walls": [{"name": "floor"}]}, "one of stl, block, tube, disc, vessel, bars, punched, not none"),
        ({"walls": [{"name": "w", "block": {"low_mm": (0, 0, 0), "high_mm": (1, 1, 0)}}]}, "low_mm to be less"),
        (
            {"materials": {"glass": {"density_kg_per_m3": 2500, "rolling_friction": 0.1, "rolling_friction_m": 1e-5}}},
            "rolling_friction (without unit) or rolling_friction_m (a length), not both",
        ),
        ({"liquid": {"percent": 1, "film_um": 3}}, "at most one of percent, film_um"),
        ({"materials": {"steel": {"density_kg_per_m3": 7800}}}, "spheres beads to name a material (steel), not glass"),
    ],
)
def test_what_does_not_go_together_is_named(changes: dict[str, Any], words: str) -> None:
    assert words in refusal(**changes)


ENTRY = beads()["spheres"][0]
INSERTED = {"velocity_m_per_s": (0, 0, -1), "insertion": {"for_s": 0.005, "pulse_share": 0.2}}
STROKE = {"amplitude_mm": 2, "frequency_Hz": 20}
DECK = {"length_mm": 60, "width_mm": 30, "aperture_mm": 4, "wire_mm": 1}
BARS = {"diameter_mm": 1, "pitch_mm": 5, "length_mm": 18, "count": 4}
PSD = {"log_normal": {"median_mm": 3, "sigma": 0.2}, "smallest_mm": 2}
ORE = {"name": "ore", "material": "glass", "psd": PSD, "mass_g": 1, "box": ENTRY["box"]}
IDLE = {
    "share only without time_step_s": {"time_step": {"time_step_s": 1e-6, "share": 0.05}},
    "window_steps only with windows": {"results": {"windows": 0, "window_steps": 3}},
    "pulse_share only with profile: pulsed": {"spheres": [{**ENTRY, **INSERTED}]},
    "ratio only with kind: elliptic": {"deck": {**DECK, "stroke": {**STROKE, "ratio": 0.4}}},
    "forward only with kind: circular or elliptic": {"deck": {**DECK, "stroke": {**STROKE, "forward": False}}},
    "plate_mm only with mesh: punched": {"deck": {**DECK, "stroke": STROKE, "plate_mm": 2}},
    "first_crossing_mm only with crimp_mm": {"walls": [{"name": "deck", "bars": {**BARS, "first_crossing_mm": 2}}]},
    "stl_unit and half_width_mm only with stl": {
        "walls": [{"name": "deck", "bars": BARS, "stl_unit": "m", "half_width_mm": 1, "shell_thickness_mm": None}]
    },
    "feature_angle_deg only without bars": {"walls": [{"name": "deck", "bars": BARS, "feature_angle_deg": 20}]},
    "feature_angle_deg only without bars and half": {
        "walls": [{"name": "deck", "stl": "a.stl", "half_width_mm": 1, "feature_angle_deg": 20}]
    },
    "moisture_of only with moisture_percent": {"feed": [{**ORE, "moisture_of": "moist"}]},
    "rate_of only with rate_t_per_h": {"feed": [{**ORE, "rate_of": "moist", "moisture_percent": 1}]},
    "classes only without file": {"feed": [{**ORE, "psd": {"file": "a.csv", "classes": 4}}]},
}


@pytest.mark.parametrize("words", IDLE)
def test_a_key_without_effect_is_refused(words: str) -> None:
    assert f"expected {words}" in refusal(**IDLE[words])


RUBBER = {"glass": {"density_kg_per_m3": 2500}, "rubber": {"density_kg_per_m3": 1100, "friction": 0.9}}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"contacts": [{"between": ("glass", "walls"), "friction": 0.1}, {"between": ("walls", "glass")}]},
            "contacts of different pairs (glass and walls is there 2 times)",
        ),
        (
            {
                "materials": RUBBER,
                "wall_material": "rubber",
                "contacts": [{"between": ("glass", "walls")}, {"between": ("rubber", "glass"), "friction": 0.1}],
            },
            "contacts of different pairs (glass and walls is there 2 times)",
        ),
        ({"contacts": [{"between": ("walls", "walls")}]}, "contacts to name a material (glass), not walls"),
        ({"materials": {**RUBBER, "walls": RUBBER["glass"]}}, "materials of other names than walls"),
        ({"materials": RUBBER, "wall_material": "rubber"}, "an entry in contacts with between: [glass, rubber]"),
        ({"feed": [ORE, ORE]}, "feed of different names (ore is there 2 times)"),
        ({"liquid": {"viscosity_Pa_s": 0.01}}, "an amount of liquid"),
        ({"liquid": {}, "spheres": [], "feed": [ORE]}, "an amount of liquid"),
        ({"results": {"interval_s": 1}}, "results.interval_s of at most duration_s, 0.01 s, not 1"),
    ],
)
def test_what_would_be_ignored_is_named(changes: dict[str, Any], words: str) -> None:
    assert words in refusal(**changes)


@pytest.mark.parametrize(
    "changes",
    [
        {
            "materials": RUBBER,
            "wall_material": "rubber",
            "contacts": [{"between": ("rubber", "glass"), "friction": 0.7}],
        },
        {
            "materials": RUBBER,
            "wall_material": "rubber",
            "contacts": [{"between": ("glass", "walls"), "friction": 0.7}],
        },
    ],
)
def test_walls_have_the_contact_that_is_given_for_their_material(changes: dict[str, Any]) -> None:
    assert [p.friction for p in Building(pywet.Scene(**beads(**changes))).pairs if p.b == 0] == [0.7]


def test_some_effects_are_given_without_a_tolerance() -> None:
    """The tolerance is that of a scene without effects; one that is given holds."""
    usual = pywet.Scene(**beads()).effects
    assert pywet.Scene(**beads(effects={"shedding": True})).effects == usual.model_copy(update={"shedding": True})
    tenth = {"tolerance": {"value": 0.1, "source": "assumption"}}
    assert pywet.Scene(**beads(effects=tenth)).effects.tolerance.value == 0.1


def test_bodies_and_regions_may_be_larger_than_spheres() -> None:
    """A drum of 0.8 m: its lid and a region in it need no reason, a sphere of that size does."""
    cylinder = {"diameter_mm": 790, "height_mm": 100}
    entry = {**ENTRY, "box": None, "cylinder": cylinder}
    lid = {"name": "lid", "disc": {"diameter_mm": 800, "origin_mm": (0, 0, -9)}}
    scene = pywet.Scene(**beads(spheres=[entry], walls=[lid]))
    assert scene.walls[0].disc and scene.walls[0].disc.diameter_mm == 800
    with raises_code("config.implausible", key="spheres.0.diameter_mm", given=800):
        pywet.Scene(**beads(spheres=[{**entry, "diameter_mm": 800}]))
    with raises_code("config.implausible", key="walls.0.disc.diameter_mm"):
        pywet.Scene(**beads(walls=[{**lid, "disc": {"diameter_mm": 2e4}}]))


def test_two_materials_need_their_contact() -> None:
    two = {"glass": {"density_kg_per_m3": 2500}, "pom": {"density_kg_per_m3": 1400}}
    spheres = [*beads()["spheres"], {**beads()["spheres"][0], "name": "plastic", "material": "pom"}]
    assert "between: [glass, pom]" in refusal(materials=two, spheres=spheres)
    scene = pywet.Scene(
        **beads(materials=two, spheres=spheres, contacts=[{"between": ("pom", "glass"), "friction": 0.2}])
    )
    found = scene.dry("glass", "pom")
    assert found is not None and found.friction == 0.2


GRAINS = {"density_kg_per_m3": 2650, "stiffness_N_per_m": 12000, "restitution": 0.6}
STEEL = {"density_kg_per_m3": 7800, "stiffness_N_per_m": 12000, "restitution": 0.6}
OF_BOTH = {"stiffness_N_per_m": 12000, "friction": 0.4, "restitution": 0.6, "rolling_friction_m": 2e-5}


@pytest.mark.parametrize("wall", ["steel", "walls"])
@pytest.mark.parametrize(
    "given", [{}, {"friction": 0.3}, {"stiffness_N_per_m": 500, "restitution": 0.9}, {"rolling_friction_m": 1e-6}]
)
def test_a_contact_has_the_values_of_both_materials_where_it_has_none(given: dict[str, Any], wall: str) -> None:
    """And the plan lists them; the walls' own material counts, whether it or `walls` is named."""
    more = {"materials": {"glass": GRAINS, "steel": STEEL}, "wall_material": "steel"}
    scene = pywet.Scene(**beads(**more, contacts=[{"between": ("glass", wall), **given}]))
    dry = scene.dry("glass", WALLS)
    assert dry is not None and {key: getattr(dry, key) for key in OF_BOTH} == OF_BOTH | given
    line = f"contact glass–{wall}, as in materials: "
    values = ", ".join(f"{key} {x:g}" for key, x in OF_BOTH.items() if key not in given)
    assert [found for found in Building(scene).plan.table if found.startswith("contact")] == [line + values]


@pytest.mark.parametrize(
    ("steel", "given", "words"),
    [
        (
            {"stiffness_N_per_m": 2000},
            {"friction": 0.3},
            "stiffness_N_per_m in contacts between glass and steel, whose own",
        ),
        ({"stiffness_N_per_m": 2000}, {"stiffness_N_per_m": 2000}, None),
        ({"friction": 0.1, "restitution": 0.9}, {}, "friction and restitution in contacts"),
        ({"rolling_friction": 0.1}, {}, "rolling_friction or rolling_friction_m in contacts"),
        ({"rolling_friction": 0.1}, {"rolling_friction_m": 1e-6}, None),
        ({"rolling_friction": 0.1}, {"rolling_friction_m": 1e-6, "rolling_friction": 0.1}, "at most one of rolling"),
    ],
)
def test_a_contact_of_materials_that_differ_needs_its_value(
    steel: dict[str, float], given: dict[str, float], words: str | None
) -> None:
    more = {"materials": {"glass": GRAINS, "steel": {**STEEL, **steel}}, "wall_material": "steel"}
    more["contacts"] = [{"between": ("glass", "steel"), **given}]
    if words is None:
        scene = pywet.Scene(**beads(**more))
        dry = scene.dry("glass", WALLS)
        assert dry is not None and all(getattr(dry, key) == x for key, x in given.items())
        return
    assert words in refusal(**more)


def test_a_wall_has_one_motion() -> None:
    block = {"low_mm": (0, 0, -9), "high_mm": (9, 9, -5)}
    ways = {"turns": {"turns_per_minute": 10, "axis": (0, 0, 1)}, "moves": {"velocity_m_per_s": (1, 0, 0), "for_s": 1}}
    assert "at most one of vibrates, turns, moves, removed" in refusal(walls=[{"name": "a", "block": block, **ways}])


def test_dimensionless_rolling_friction_is_the_number_of_the_engine() -> None:
    """Times r_red: 0.75 mm of two spheres of 3 mm, 1.5 mm at a wall; the deck holds the number itself again."""
    glass = {"glass": {"density_kg_per_m3": 2500, "rolling_friction": 0.1}}
    walls = [{"name": "floor", "block": {"low_mm": (-30, -30, -5), "high_mm": (30, 30, -2)}}]
    made = Building(pywet.Scene(**beads(materials=glass, walls=walls)))
    of = {(p.a, p.b): p.rolling_friction_m for p in made.pairs}
    assert of == {(1, 0): pytest.approx(1.5e-4), (1, 1): pytest.approx(0.75e-4)}
    matrix = property_matrices(made.scene())["coefficientRollingFriction"].split()
    assert [float(x) for x in matrix[:3]] == pytest.approx([0.1, 0.1, 0.1])


@pytest.mark.parametrize("name", ["漏斗", "Rüttelsieb 2", "поддон", "deck"])
def test_a_wall_has_a_name_in_any_script(name: str) -> None:
    """Its word is an engine's; of a plain name it is the name."""
    walls = [
        {"name": n, "block": {"low_mm": (-30, -30, z), "high_mm": (30, 30, z + 3)}} for n, z in ((name, -5), ("b", -9))
    ]
    scene = pywet.Scene(**beads(walls=walls))
    words = [w.name for w in Building(scene).scene().walls]
    assert words[0].isascii() and words[0].isidentifier() and words[1] == "b"
    assert (words[0] == name) == (name == "deck")
    twice = [{**w, "name": name} for w in walls]
    assert f"walls of different names ({name} is there 2 times)" in refusal(walls=twice)


def test_a_scene_does_not_change_but_gives_another() -> None:
    """Setting a key is refused in a sentence that names the way; the other scene is checked as any."""
    scene = pywet.Scene(**beads(liquid={"percent": 5}))
    with raises_code("scene.frozen"):
        scene.seed = 2
    other = scene.with_(liquid=pywet.Liquid(percent=7), seed=2)
    assert (scene.seed, other.seed) == (1, 2) and other.spheres == scene.spheres
    assert scene.liquid and other.liquid and (scene.liquid.percent, other.liquid.percent) == (5, 7)
    with raises_code("config.value", key="duration_s", given=-1):
        scene.with_(duration_s=-1)


@pytest.mark.parametrize(
    ("region", "words"),
    [
        ({"box": {"low_mm": (0, 0, 0), "high_mm": (20, 20, 20)}}, "box: .* set high_mm of their box higher"),
        ({"cylinder": {"diameter_mm": 20, "height_mm": 20}}, "cylinder: .* raise height_mm or diameter_mm"),
    ],
)
def test_spheres_that_do_not_fit_are_refused_by_keys_that_the_scene_has(region: dict[str, Any], words: str) -> None:
    entry = {"name": "beads", "material": "glass", "diameter_mm": 3, "count": 5000, **region}
    with raises_code("packing.crowded", says=words) as error:
        _ = Building(pywet.Scene(**beads(spheres=[entry]))).spheres
    assert "feed" not in str(error.value)


def test_every_key_of_a_scene_has_its_meaning() -> None:
    """From which the page of all keys is made; a key without one would be an empty row."""
    models = [c for c in (getattr(pywet, name) for name in pywet.__all__) if hasattr(c, "model_fields")]
    assert len(models) >= 20
    silent = [f"{c.__name__}.{k}" for c in models for k, field in c.model_fields.items() if not field.description]
    assert silent == []


@pytest.mark.parametrize(
    "key", ["seed", "interval_s", "half_width_mm", "thickness_mm", "sides", "rolling_friction", "mass_g"]
)
def test_the_page_of_scenes_names_the_key(key: str) -> None:
    assert f"`{key}" in PAGE.read_text() or f"{key}:" in PAGE.read_text()
