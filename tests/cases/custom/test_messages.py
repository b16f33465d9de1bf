"""A message names keys that its reader has: of a scene none of the screening cases, of those none of a scene."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

import pywet
from pywet import config
from pywet.cases.custom.building import write
from pywet.cases.custom.description import Scene
from pywet.cases.screening import cases
from pywet.errors import PywetError
from pywet.scene import EngineScene
from tests.cases.custom.conftest import beads
from tests.error_codes import raises_code

ROOT = Path(__file__).parents[3]
BOX = {"low_mm": (0, 0, 0), "high_mm": (20, 20, 20)}
BEADS = {"name": "beads", "material": "glass", "diameter_mm": 3, "count": 20, "box": BOX}
BLOCK = {"name": "w", "block": {"low_mm": (-5, -5, -5), "high_mm": (30, 30, -1)}}
INSERTED = {**BEADS, "velocity_m_per_s": (0, 0, -0.3), "insertion": {"for_s": 0.005}}
FAULTY: dict[str, dict[str, Any]] = {
    "too many for their box": {"spheres": [{**BEADS, "count": 2000}]},
    "too many for their cylinder": {"spheres": [{**BEADS, "box": None, "cylinder": {"diameter_mm": 4, "height_mm": 9}}]},
    "larger than their box": {"spheres": [{**BEADS, "diameter_mm": 40}]},
    "beyond memory": {"spheres": [{**BEADS, "count": 2_000_000_000}]},
    "less than half a sphere": {"spheres": [{**BEADS, "count": None, "mass_g": 1e-3}]},
    "in each other": {"spheres": [{**BEADS, "count": None, "box": None, "at_mm": [(0, 0, 0), (1, 0, 0)]}]},
    "in a wall": {"walls": [{"name": "w", "block": BOX}]},
    "drops of mercury": {"liquid": {"surface_tension_N_per_m": 1e9, "percent": 1}},
    "a stiffness that is none": {"materials": {"glass": {"density_kg_per_m3": 2500, "stiffness_N_per_m": 1e-9}}},
    "a density of air": {"materials": {"glass": {"density_kg_per_m3": 1e-3}}},
    "a duration below a step": {"duration_s": 1e-9},
    "too many to feed": {"spheres": [{**INSERTED, "count": 3000}]},
    "inserted from a narrow region": {"spheres": [{**INSERTED, "diameter_mm": 40}]},
    "inserted after the end": {"spheres": [{**INSERTED, "insertion": {"from_s": 9.0, "for_s": 1.0}}]},
    "no law of this name": {"laws": {"capillary": "rabinovitch"}, "liquid": {"percent": 1}},
    "a drag with inertia by its coefficient": {"laws": {"viscous_normal": "buck_water"}, "liquid": {"percent": 1}},
    "an effect of no name": {"effects": {"gravitation": "on"}},
    "a bridge without liquid": {"effects": {"bridges": "on"}},
    "a wall without size": {"walls": [{"name": "w", "disc": {"diameter_mm": 1e-9}}]},
    "a wall that is fast": {"walls": [{**BLOCK, "vibrates": {"amplitude_mm": (1e5, 0, 0), "frequency_Hz": 1e5}}]},
    "two walls of one name": {"walls": [BLOCK, BLOCK]},
    "no file": {"walls": [{"name": "w", "stl": "nowhere.stl"}]},
    "far from its origin": {
        "origin_mm": (1, 0, 0), "spheres": [{**BEADS, "box": {"low_mm": (1e7, 0, 0), "high_mm": (1e7 + 20, 20, 20)}}],
    },
}  # fmt: skip
WORD = re.compile(r"[A-Za-z]\w*_\w+")


def of_models(start: Any) -> set[str]:
    """All keys of a model and of the models in it."""
    schema = start.model_json_schema()
    groups = [schema, *schema.get("$defs", {}).values()]
    return {key for group in groups for key in group.get("properties", {})}


def of_schemas() -> set[str]:
    """All keys of the screening cases' files."""
    found: set[str] = set()
    for path in (ROOT / "workflow" / "schemas").glob("*.schema.json"):
        schema = json.loads(path.read_text())
        for group in (schema, *schema.get("$defs", {}).values()):
            found |= set(group.get("properties", {}))
    return found


CUSTOM = of_models(Scene)
SCREENING = of_schemas()
NO_KEY = (of_models(EngineScene) | SCREENING) - CUSTOM
"""Keys of the screening cases and of what the engine is given, which a scene does not have."""


UNSTABLE = {"time_step": {"time_step_s": 1e-3}, "walls": [BLOCK], "liquid": {"percent": 1}, "duration_s": 0.01}


def message_of(of: dict[str, Any], folder: Path) -> str:
    with pytest.raises(PywetError) as error:
        write(pywet.Scene(**beads(**of), folder=folder), folder / "run")
    return str(error.value)


@pytest.mark.parametrize("name", FAULTY)
def test_a_scene_is_refused_by_keys_that_a_scene_has(name: str, tmp_path: Path) -> None:
    output_text = message_of(FAULTY[name], tmp_path)
    assert not set(WORD.findall(output_text)) & NO_KEY, output_text
    assert "the box" not in output_text, output_text


def test_an_unstable_step_is_reported_in_words_of_a_scene(tmp_path: Path) -> None:
    """It is refused when all is written and before the engine starts."""
    with raises_code("step.unstable") as error:
        pywet.run(pywet.Scene(**beads(**UNSTABLE)), tmp_path / "run")
    assert not set(WORD.findall(str(error.value))) & NO_KEY, str(error.value)


@pytest.mark.parametrize(
    ("file", "pattern", "replacement"),
    [
        ("scales.yaml", r"feed_bin_height_mm: \{value: [\d.]+", "feed_bin_height_mm: {value: 12"),
        ("scales.yaml", r"width_mm: \{value: 50", "width_mm: {value: -1"),
        ("scales.yaml", r"stiffness_factor: ", "stiffness: "),
        ("config.yaml", r"seed: ", "sead: "),
    ],
)
def test_a_screening_case_is_refused_by_keys_that_it_has(
    tmp_path: Path, file: str, pattern: str, replacement: str
) -> None:
    folder = Path(shutil.copytree(ROOT / "config", tmp_path / "config"))
    text, count = re.subn(pattern, replacement, (folder / file).read_text())
    assert count
    (folder / file).write_text(text)
    with pytest.raises(PywetError) as error:
        cases.build(config.load(folder), 2, "smoke", tmp_path / "run")
    assert not set(WORD.findall(str(error.value))) & (CUSTOM - SCREENING), str(error.value)
