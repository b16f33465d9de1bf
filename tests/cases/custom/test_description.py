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
from pywet.cases.custom.description import Percent
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


def test_two_materials_need_their_contact() -> None:
    two = {"glass": {"density_kg_per_m3": 2500}, "pom": {"density_kg_per_m3": 1400}}
    spheres = [*beads()["spheres"], {**beads()["spheres"][0], "name": "plastic", "material": "pom"}]
    assert "between: [glass, pom]" in refusal(materials=two, spheres=spheres)
    scene = pywet.Scene(
        **beads(materials=two, spheres=spheres, contacts=[{"between": ("pom", "glass"), "friction": 0.2}])
    )
    found = scene.dry("glass", "pom")
    assert found is not None and found.friction == 0.2


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
