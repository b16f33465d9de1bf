"""A description refuses what cannot be meant: every mistake on a line, said so that it can be mended."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

import pywet
from pywet.errors import ConfigError
from pywet.own_scene.commands import read_scene
from tests.own_scene.conftest import beads


def refusal(**changes: Any) -> str:
    with pytest.raises(ConfigError) as error:
        pywet.Scene(**beads(**changes))
    return str(error.value)


def test_all_mistakes_of_a_file_are_said_at_once(tmp_path: Path) -> None:
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
        ({"walls": [{"name": "floor"}]}, "one of stl, block, tube, disc, vessel, bars, not none"),
        ({"walls": [{"name": "w", "block": {"low_mm": (0, 0, 0), "high_mm": (1, 1, 0)}}]}, "low_mm to be less"),
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
