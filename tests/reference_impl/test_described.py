"""User-defined scenes against their descriptions: the shipped examples agree, faults injected while building are named."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pywet.cases.custom import building, feeding
from pywet.cases.custom.description import Scene
from pywet.cases.custom.materials import Contact
from pywet.cases.custom.walls import Bars, Wall
from pywet.cases.small import bodies
from pywet.planning import numbers
from pywet.products import deck
from pywet.products.deck import Deck, Stroke
from pywet.products.feed import FeedAmount
from pywet.products.size_classes import SizeDistribution
from pywet.scene import Insertion
from reference_impl.scene import check
from tests.cases.custom.conftest import beads
from tests.reference_impl.injected_files import put

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples" / "scenes").glob("*.yaml"))


def scene(path: Path, **changes: object) -> Scene:
    """An example's scene."""
    return Scene(**{**yaml.safe_load(path.read_text()), **changes}, folder=path.parent)


def example(name: str, **changes: object) -> Scene:
    """A shipped one, or the slotted deck with entries of spheres that are inserted during the run."""
    folder = ROOT / ("tests/cases/custom" if name == "slotted_deck" else "examples/scenes")
    return scene(folder / f"{name}.yaml", **changes)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_no_false_alarm_on_the_shipped_scenes(tmp_path: Path, path: Path) -> None:
    building.write(scene(path), tmp_path)
    found = check.check(tmp_path)
    (quantity,) = [q for q in found.quantities if q.name == "scene_description"]
    assert quantity.ok and quantity.count > 40, [f["sentence"] for f in found.findings]


PSDS: dict[str, dict[str, Any]] = {
    "Rosin-Rammler, tail cut": {"rosin_rammler": {"size_mm": 5, "spread": 2.5}, "smallest_mm": 3, "sizes_per_class": 2},
    "log-normal by size": {"log_normal": {"median_mm": 5, "sigma": 0.4}, "smallest_mm": 3, "within": "size"},
    "Gaudin-Schuhmann": {"gaudin_schuhmann": {"largest_mm": 8, "exponent": 2}, "smallest_mm": 3},
    "a file": {"file": "sieves.csv"},
}


@pytest.mark.parametrize("psd", PSDS)
def test_no_false_alarm_on_feeds_and_decks(tmp_path: Path, psd: str) -> None:
    """Each distribution, moist moisture, an ellipse that goes back, slots, an origin; of a file it is said."""
    (tmp_path / "sieves.csv").write_text("3,4,40\n4,5,60\n")
    given = yaml.safe_load((ROOT / "examples" / "scenes" / "deck.yaml").read_text())
    given["feed"][0] |= {"psd": PSDS[psd], "moisture_of": "moist"}
    given["deck"] |= {"mesh": "slotted", "sections": 1}
    given["deck"]["stroke"] |= {"kind": "elliptic", "forward": False, "angle_deg": 70}
    building.write(Scene(**given, origin_mm=[10, 20, 30], folder=tmp_path), tmp_path / "run")
    found = check.check(tmp_path / "run")
    assert found.findings == []
    assert any("numbers of spheres that follow from a mass" in s for s in found.not_checked)
    assert any("which are in sieves.csv" in s for s in found.not_checked) == (psd == "a file")


def test_plain_gravity_with_an_inclined_deck_is_found(tmp_path: Path) -> None:
    """The description of an inclined deck has the default, whose place the inclination takes."""
    building.write(example("deck"), tmp_path)
    put("gravity_m_per_s2", [0.0, 0.0, -9.81], "scene.json")(tmp_path)
    assert any("gravity_m_per_s2.x is 0" in f["sentence"] for f in check.check(tmp_path).findings)


@pytest.mark.parametrize("name", ["漏斗", "Rüttelsieb 2", "2nd", "x" * 41, "deck"])
def test_no_false_alarm_on_a_wall_with_a_name_in_any_script(tmp_path: Path, name: str) -> None:
    given = yaml.safe_load((ROOT / "examples" / "scenes" / "hopper.yaml").read_text())
    given["walls"][-1]["name"] = name
    building.write(Scene(**given, folder=ROOT / "examples" / "scenes"), tmp_path / "run")
    assert check.check(tmp_path / "run").findings == []


def test_half_width_of_the_bodies_of_an_stl_file(tmp_path: Path) -> None:
    """Each body is one part with the half width that is given."""
    walls = yaml.safe_load((ROOT / "examples" / "scenes" / "hopper.yaml").read_text())["walls"]
    building.write(example("hopper", walls=[{**walls[0], "half_width_mm": 1}, *walls[1:]]), tmp_path)
    assert check.check(tmp_path).findings == []
    built = json.loads((tmp_path / "scene.json").read_text())
    hopper = next(wall for wall in built["walls"] if wall["name"] == "hopper")
    hopper |= {"part_half_width_m": [0.5 * w for w in hopper["part_half_width_m"]], "feature_angle_deg": 60.0}
    (tmp_path / "scene.json").write_text(json.dumps(built))
    found = " ".join(f["sentence"] for f in check.check(tmp_path).findings)
    assert "walls.hopper.part_half_width_m is 0.0005, expected 0.001" in found
    assert "walls.hopper.feature_angle_deg is 60, expected 180" in found


def test_no_false_alarm_with_an_origin_and_materials_of_walls(tmp_path: Path) -> None:
    """Plant coordinates, two materials, a contact of their own, a film by thickness, given positions."""
    output_text = {
        "name": "plant", "duration_s": 0.1, "origin_mm": [1000.0, 2000.0, 30.0], "wall_material": "steel",
        "materials": {"glass": {"density_kg_per_m3": 2500, "rolling_friction": 0.02},
                      "steel": {"density_kg_per_m3": 7800, "contact_angle_deg": 40}},
        "contacts": [{"between": ["glass", "steel"], "friction": 0.2, "rolling_friction": 0.01}],
        "liquid": {"percent": 1.0},
        "spheres": [
            {"name": "a", "material": "glass", "diameter_mm": 3, "at_mm": [[1001, 2000, 40], [1006, 2000, 40]]},
            {"name": "b", "material": "glass", "diameter_mm": 4, "film_um": 10, "at_mm": [[1001, 2008, 40]]},
        ],
        "walls": [{"name": "floor", "block": {"low_mm": [980, 1980, 20], "high_mm": [1020, 2020, 30]},
                   "turns": {"turns_per_minute": 6, "axis": [0, 0, 2], "origin_mm": [1000, 2000, 30]}}],
    }  # fmt: skip
    building.write(Scene(**output_text), tmp_path)
    assert check.check(tmp_path).findings == []


TOLERANCE = {"tolerance": {"value": 0.01, "source": "assumption", "reason": "a test"}}
OFF = dict.fromkeys(("viscous_normal", "sharing_by_size", "rolling", "gravity"), False)
SWITCHES: dict[str, dict[str, Any]] = {
    "a preset": {"laws": {"preset": "exact"}},
    "laws by kind": {"laws": {"capillary": "lambert", "shedding": "tate"}, "effects": {"shedding": True, **TOLERANCE}},
    "off by hand": {"effects": {**OFF, **TOLERANCE}},
    "decided by numbers": {"effects": {"decide": "tolerance", **TOLERANCE}},
    "dry": {"liquid": None},
}


@pytest.mark.parametrize("switches", SWITCHES)
def test_no_false_alarm_on_effects_and_laws(tmp_path: Path, switches: str) -> None:
    building.write(example("drum", **SWITCHES[switches]), tmp_path)
    found = check.check(tmp_path)
    assert found.findings == []
    assert any("decided by numbers" in s for s in found.not_checked) == (switches == "decided by numbers")


def test_no_false_alarm_on_a_law_in_a_file_of_the_user(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text((ROOT / "pywet" / "laws" / "capillary.py").read_text())
    given = yaml.safe_load((ROOT / "examples" / "scenes" / "drum.yaml").read_text())
    given["laws"] = {"capillary": "mine.py:rabinovich"}
    building.write(Scene(**given, folder=tmp_path, file=tmp_path / "drum.yaml"), tmp_path / "run")
    assert check.check(tmp_path / "run").findings == []
    text = (tmp_path / "run" / "scene.json").read_text()
    (tmp_path / "run" / "scene.json").write_text(text.replace("mine.py:rabinovich", "mine.py:willett_full"))
    assert any("effects.capillary" in f["sentence"] for f in check.check(tmp_path / "run").findings)


SOLIDS = {
    "glass": {"density_kg_per_m3": 2500, "youngs_modulus_Pa": 1e7, "poissons_ratio": 0.25},
    "steel": {"density_kg_per_m3": 7800, "youngs_modulus_Pa": 1e8, "poissons_ratio": 0.3},
}


def hertzian(folder: Path, walls: str | None = "steel") -> Path:
    """Hertz contacts of glass beads in a cup of steel, or of glass."""
    given = beads(contact="hertz", materials=SOLIDS if walls else {"glass": SOLIDS["glass"]}, wall_material=walls)
    contacts = [{"between": ["glass", walls]}] if walls else []
    building.write(Scene(**given, contacts=contacts), folder)
    return folder


@pytest.mark.parametrize("walls", ["steel", None])
def test_no_false_alarm_on_hertz_contacts(tmp_path: Path, walls: str | None) -> None:
    found = check.check(hertzian(tmp_path, walls))
    assert found.findings == [] and any("impact speed of Hertz contacts" in s for s in found.not_checked)


def test_moduli_of_the_spheres_for_the_walls_are_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    sound = building.Hertz
    monkeypatch.setattr(
        building, "Hertz", lambda spheres, walls, **more: sound(spheres=spheres, walls=spheres[0], **more)
    )
    found = [f["sentence"] for f in check.check(hertzian(tmp_path)).findings]
    assert any("hertz.walls.youngs_modulus_Pa is 10000000, expected 100000000" in sentence for sentence in found), found


Plant = Callable[[pytest.MonkeyPatch], None]


PARTLY: dict[str, dict[str, Any]] = {
    "nothing given": {},
    "friction": {"friction": 0.2},
    "rolling friction as a length": {"rolling_friction_m": 1e-4},
    "rolling friction without unit": {"rolling_friction": 0.3},
}


def partly(folder: Path, given: dict[str, Any], walls: str = "steel") -> Path:
    """Steel walls, of whose contact with glass some keys are given; both materials have the others."""
    common = {"stiffness_N_per_m": 9000, "friction": 0.6, "restitution": 0.55, "rolling_friction": 0.05}
    materials = {name: {"density_kg_per_m3": 2500, **common} for name in ("glass", "steel")}
    contacts = [{"between": [walls, "glass"], **given}]
    building.write(Scene(**beads(materials=materials, wall_material="steel"), contacts=contacts), folder)
    return folder


@pytest.mark.parametrize("given", PARTLY)
@pytest.mark.parametrize("walls", ["steel", "walls"])
def test_contacts_have_the_values_of_their_materials(tmp_path: Path, given: str, walls: str) -> None:
    assert check.check(partly(tmp_path, PARTLY[given], walls)).findings == []


def test_a_contact_with_the_values_of_no_material_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(Contact, "taken", lambda self, material: {})
    found = [f["sentence"] for f in check.check(partly(tmp_path, {"friction": 0.2})).findings]
    for words in ("normal_stiffness_N_per_m is 2000, expected 9000", "restitution is 0.8, expected 0.55"):
        assert any(f"pairs.1-0.{words}" in sentence for sentence in found), found


def contact(patch: pytest.MonkeyPatch) -> None:
    """Friction at walls times 0.8."""
    sound = bodies.contact

    def wrong(a: int, b: int, stiffness: float, **how: float):  # type: ignore[no-untyped-def]
        return sound(a, b, stiffness, **{**how, "friction": (0.8 if b == 0 else 1.0) * how["friction"]})

    patch.setattr(bodies, "contact", wrong)


def wall_angle(patch: pytest.MonkeyPatch) -> None:
    """The angle of the spheres' material is used for the walls."""
    sound = building.wall_mesh
    patch.setattr(building, "wall_mesh", lambda surface, angle, *more: sound(surface, np.radians(15.0), *more))


def waiting(by: float) -> Plant:
    """Inserted spheres wait further away."""

    def plant(patch: pytest.MonkeyPatch) -> None:
        sound = feeding.times
        patch.setattr(feeding, "times", lambda c: [(1.0 + by) * t for t in sound(c)])

    return plant


def film(patch: pytest.MonkeyPatch) -> None:
    """Films a tenth too thick."""
    sound = building._film
    patch.setattr(building, "_film", lambda *given: 1.1 * sound(*given))


def inserted_longer(patch: pytest.MonkeyPatch) -> None:
    """Insertion takes twice as long."""
    patch.setattr(building.typed, "Insertion", lambda for_s, **more: Insertion(for_s=2.0 * for_s, **more))


def density(patch: pytest.MonkeyPatch) -> None:
    """The liquid's density is water's, whatever is given."""
    sound = building.typed.Liquid
    patch.setattr(
        building.typed, "Liquid", lambda **given: sound(**{**given, "viscosity_Pa_s": 1.1 * given["viscosity_Pa_s"]})
    )


def inclination(patch: pytest.MonkeyPatch) -> None:
    """A deck inclined upwards."""
    sound = Deck.gravity.fget  # type: ignore[attr-defined]
    patch.setattr(Deck, "gravity", property(lambda d: (-sound(d)[0], *sound(d)[1:])))


def stroke(patch: pytest.MonkeyPatch) -> None:
    """The stroke in place of half of it."""
    sound = Stroke.vibrates

    def wrong(self: Stroke) -> dict[str, Any]:
        return sound(self.model_copy(update={"amplitude_mm": 2.0 * self.amplitude_mm}))

    patch.setattr(Stroke, "vibrates", wrong)


def outlet(patch: pytest.MonkeyPatch) -> None:
    """Outlets of the unders at half their depth."""
    patch.setattr(deck, "BELOW", 3.0)


def sizes(patch: pytest.MonkeyPatch) -> None:
    """Classes stand for their arithmetic middle."""
    sound = SizeDistribution.sizes
    patch.setattr(
        SizeDistribution, "sizes", lambda self, *where: sound(self.model_copy(update={"within": "size"}), *where)
    )


def moisture(patch: pytest.MonkeyPatch) -> None:
    """Moisture of the dry mass taken as of the moist one."""
    patch.setattr(
        FeedAmount, "dry_percent", property(lambda f: 100.0 * f.moisture_percent / (100.0 - f.moisture_percent))
    )


def law(patch: pytest.MonkeyPatch) -> None:
    """The built plan has another rupture law than the preset's."""
    sound = building.plan_effects

    def wrong(*given: Any) -> Any:
        plan = sound(*given)
        return replace(plan, effects=plan.effects.model_copy(update={"rupture": "lian"}))

    patch.setattr(building, "plan_effects", wrong)


def bars(patch: pytest.MonkeyPatch) -> None:
    """Bars with their diameter for their half width."""
    sound = Bars.parts
    patch.setattr(Bars, "parts", lambda self: [(corners, 2.0 * width) for corners, width in sound(self)])


def folds(patch: pytest.MonkeyPatch) -> None:
    """Faces of an STL file that end at another angle."""
    patch.setattr(Wall, "fold_deg", property(lambda wall: 2.0 * wall.feature_angle_deg))


FAULTS: dict[str, tuple[Plant, str, str]] = {
    "angle of a wall replaced by the spheres'": (wall_angle, "drum", "walls.mantle.contact_angle_rad is 0.261799388"),
    "friction at walls times 0.8": (contact, "drum", "pairs.1-0.friction is 0.4, expected 0.5"),
    "inserted spheres wait a hundredth too far": (waiting(0.01), "slotted_deck", "waiting to enter"),
    "inserted spheres wait a millionth too far": (waiting(1e-6), "slotted_deck", "waiting to enter"),
    "films a tenth thick": (film, "drum", "first film of beads"),
    "insertion twice as long": (inserted_longer, "slotted_deck", "classes.fine.insertion.for_s is 0.9, expected 0.45"),
    "an inclined deck turned round": (inclination, "deck", "gravity_m_per_s2.x is -2.53"),
    "the whole stroke for its half": (stroke, "deck", "walls.screen.motion_parameters.amplitude_m.x"),
    "unders leave too early": (outlet, "deck", "outlets.unders_1.high_m.z is -0.015, expected -0.03"),
    "sizes in the middle of their classes": (sizes, "deck", "classes is "),
    "moisture of the moist mass": (moisture, "deck", "first film of ore"),
    "another law": (law, "drum", "effects.rupture is lian, expected willett_unequal"),
    "bars twice as wide": (bars, "slotted_deck", "walls.deck.part_half_width_m is 0.002, expected 0.001"),
    "faces of an STL file up to another angle": (folds, "hopper", "walls.hopper.feature_angle_deg is "),
    "viscosity a tenth high": (density, "drum", "liquid.viscosity_Pa_s is 0.0011"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_of_the_builder_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, fault: str) -> None:
    plant, name, words = FAULTS[fault]
    plant(monkeypatch)
    building.write(example(name), tmp_path)
    found = [f["sentence"] for f in check.check(tmp_path).findings]
    assert any(words in sentence for sentence in found), found


def test_a_plan_with_the_film_of_the_largest_on_the_smallest_size_is_found(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """By the numbers of the plan; with a moisture each size of the deck has its own film."""
    monkeypatch.setattr(numbers, "_of_class", lambda liquid, *more: liquid)
    building.write(example("deck"), tmp_path)
    found = [f["sentence"] for f in check.check(tmp_path).findings]
    assert any("plan.bridges.number is 0.0457" in sentence for sentence in found), found
