"""User-defined scenes against their descriptions: the shipped examples agree, faults injected while building are named."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml

from pywet.cases.custom import building, feeding
from pywet.cases.custom.description import Scene
from pywet.cases.small import bodies
from pywet.scene import Fed
from reference_impl.scene import check

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples" / "scenes").glob("*.yaml"))


def scene(path: Path, **changes: object) -> Scene:
    """An example's scene."""
    return Scene(**{**yaml.safe_load(path.read_text()), **changes}, folder=path.parent)


def example(name: str, **changes: object) -> Scene:
    return scene(ROOT / "examples" / "scenes" / f"{name}.yaml", **changes)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_no_false_alarm_on_the_shipped_scenes(tmp_path: Path, path: Path) -> None:
    building.write(scene(path), tmp_path)
    found = check.check(tmp_path)
    (quantity,) = [q for q in found.quantities if q.name == "scene_description"]
    assert quantity.ok and quantity.count > 40, [f["sentence"] for f in found.findings]


def test_no_false_alarm_with_an_origin_and_materials_of_walls(tmp_path: Path) -> None:
    """Plant coordinates, two materials, a contact of their own, a film by thickness, given positions."""
    said = {
        "name": "plant", "duration_s": 0.1, "origin_mm": [1000.0, 2000.0, 30.0], "wall_material": "steel",
        "materials": {"glass": {"density_kg_per_m3": 2500, "rolling_friction": 0.02},
                      "steel": {"density_kg_per_m3": 7800, "contact_angle_deg": 40}},
        "contacts": [{"between": ["glass", "steel"], "friction": 0.2}],
        "liquid": {"percent": 1.0},
        "spheres": [
            {"name": "a", "material": "glass", "diameter_mm": 3, "at_mm": [[1001, 2000, 40], [1006, 2000, 40]]},
            {"name": "b", "material": "glass", "diameter_mm": 4, "film_um": 10, "at_mm": [[1001, 2008, 40]]},
        ],
        "walls": [{"name": "floor", "block": {"low_mm": [980, 1980, 20], "high_mm": [1020, 2020, 30]},
                   "turns": {"turns_per_minute": 6, "axis": [0, 0, 2], "origin_mm": [1000, 2000, 30]}}],
    }  # fmt: skip
    building.write(Scene(**said), tmp_path)
    assert check.check(tmp_path).findings == []


Plant = Callable[[pytest.MonkeyPatch], None]


def contact(patch: pytest.MonkeyPatch) -> None:
    """Friction at walls times 0.8."""
    sound = bodies.contact

    def wrong(a: int, b: int, stiffness: float, **how: float):  # type: ignore[no-untyped-def]
        return sound(a, b, stiffness, **{**how, "friction": (0.8 if b == 0 else 1.0) * how["friction"]})

    patch.setattr(bodies, "contact", wrong)


def wall_angle(patch: pytest.MonkeyPatch) -> None:
    """The angle of the spheres' material stands for that of the walls."""
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


def fed(patch: pytest.MonkeyPatch) -> None:
    """Insertion takes twice as long."""
    patch.setattr(building.typed, "Fed", lambda from_s, for_s: Fed(from_s=from_s, for_s=2.0 * for_s))


def density(patch: pytest.MonkeyPatch) -> None:
    """The liquid's density is water's, whatever is given."""
    sound = building.typed.Liquid
    patch.setattr(
        building.typed, "Liquid", lambda **given: sound(**{**given, "viscosity_Pa_s": 1.1 * given["viscosity_Pa_s"]})
    )


FAULTS: dict[str, tuple[Plant, str, str]] = {
    "angle of a wall replaced by the spheres'": (wall_angle, "drum", "walls.mantle.contact_angle_rad is 0.261799388"),
    "friction at walls times 0.8": (contact, "drum", "pairs.1-0.friction is 0.4, expected 0.5"),
    "inserted spheres wait a hundredth too far": (waiting(0.01), "deck", "waiting to enter"),
    "inserted spheres wait a millionth too far": (waiting(1e-6), "deck", "waiting to enter"),
    "films a tenth thick": (film, "drum", "first film of beads"),
    "insertion twice as long": (fed, "deck", "classes.fine.fed.for_s is 0.9, expected 0.45"),
    "viscosity a tenth high": (density, "drum", "liquid.viscosity_Pa_s is 0.0011"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_of_the_builder_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, fault: str) -> None:
    plant, name, words = FAULTS[fault]
    plant(monkeypatch)
    building.write(example(name), tmp_path)
    found = [f["sentence"] for f in check.check(tmp_path).findings]
    assert any(words in sentence for sentence in found), found
