"""What a run was made from against the configuration's files: faults injected into the reader are named by file and key."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pywet import config
from pywet.config import Config, Materials
from pywet.config.cases import Case
from reference_impl.diagnosis.held import Section
from reference_impl.scene import files

ROOT = Path(__file__).parents[2]
CONFIG = config.load(ROOT / "config")


def sections(loaded: Config, case: int = 2) -> Section:
    """Return the replay's section on a case's configuration."""
    section, texts = Section("scene"), config.texts(loaded)
    section.add("scene_configuration", "itself", files.held(texts, loaded.resolved(case, "smoke")), "values")
    section.not_checked += files.not_checked(texts)
    return section


def test_sound_configuration_agrees_in_every_value() -> None:
    found = sections(CONFIG)
    assert found.quantities[0].count > 400 and found.quantities[0].ok and found.not_checked == []


def scaled(part: Any, key: str, factor: float) -> Any:
    """A model with an entry times a factor."""
    entry = getattr(part, key)
    if not hasattr(entry, "value"):
        return part.model_copy(update={key: factor * entry})
    return part.model_copy(update={key: entry.model_copy(update={"value": factor * entry.value})})


def of_liquid(key: str, factor: float) -> Callable[[pytest.MonkeyPatch], None]:
    def plant(patch: pytest.MonkeyPatch) -> None:
        sound = Materials.liquid_named
        patch.setattr(Materials, "liquid_named", lambda self, name: scaled(sound(self, name), key, factor))

    return plant


def of_scale(key: str, factor: float) -> Callable[[pytest.MonkeyPatch], None]:
    def plant(patch: pytest.MonkeyPatch) -> None:
        sound = Config.scale
        patch.setattr(Config, "scale", lambda self, name: scaled(sound(self, name), key, factor))

    return plant


def of_case(key: str, change: Callable[[Any], Any]) -> Callable[[pytest.MonkeyPatch], None]:
    def plant(patch: pytest.MonkeyPatch) -> None:
        sound = Config.case

        def wrong(self: Config, number: int) -> Case:
            case = sound(self, number)
            return case.model_copy(update={key: change(getattr(case, key))})

        patch.setattr(Config, "case", wrong)

    return plant


FAULTS = {
    "viscosity a tenth high where the liquid is looked up": (
        of_liquid("viscosity_Pa_s", 1.1), "materials.liquid.viscosity_Pa_s.value is 0.0011", "materials.yaml"),
    "surface tension in mN/m": (
        of_liquid("surface_tension_N_per_m", 1000.0), "materials.liquid.surface_tension_N_per_m.value", "thousandths"),
    "density of the liquid": (
        of_liquid("density_kg_per_m3", 0.999), "materials.liquid.density_kg_per_m3.value", "0.999 times"),
    "slide opens late": (of_scale("slide_opens_at_s", 1.5), "scale.slide_opens_at_s.value", "scales.yaml"),
    "softer contacts": (of_scale("stiffness_factor", 0.5), "scale.stiffness_factor.value", "half of it"),
    "moisture of the next case": (of_case("liquid_percent", lambda m: 2.0 * m), "case.liquid_percent is 10", "cases.csv"),
    "the other material": (of_case("material", lambda _: "glass"), "case.material is glass, expected POM", "cases.csv"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_of_the_reader_is_named(monkeypatch: pytest.MonkeyPatch, fault: str) -> None:
    """With the value, the expected one and the file that says so."""
    plant, *words = FAULTS[fault]
    plant(monkeypatch)
    output_text = [f["sentence"] for f in sections(CONFIG).findings]
    assert any(all(word in sentence for word in words) for sentence in output_text), output_text


def test_wrong_row_of_a_list_is_named() -> None:
    """A stroke's amplitude changed after reading: its part is not the file's any more, and that is said."""
    strokes = tuple(s.model_copy() for s in CONFIG.materials.motion.strokes)
    motion = CONFIG.materials.motion.model_copy(update={"strokes": strokes})
    other = replace(CONFIG, materials=CONFIG.materials.model_copy(update={"motion": motion}))
    assert sections(other).not_checked == ["scene: materials.yaml, replaced in memory"]


def test_what_a_command_sets_is_reported_and_not_a_fault() -> None:
    found = sections(CONFIG.with_seed(4).with_preset("exact"))
    assert found.quantities[0].ok
    assert found.not_checked == ["scene: set after config.yaml was read: seed, laws"]
