"""The shipped configuration against the paper's tables, its schemas, and what a user can get wrong."""

from __future__ import annotations

import csv
import json
import math
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from typer.testing import CliRunner

from pywet import stages
from pywet.cases.screening import cases
from pywet.cli.app import app
from pywet.config import load
from pywet.config.loading import of_run
from pywet.config.schema import schemas
from pywet.errors import PywetError
from pywet.scene_stages import read_scene
from tests.error_codes import raises_code

ROOT = Path(__file__).parents[1]
CONFIG = ROOT / "config"
SWITCHES = {"cases", "ranks", "seed", "seeds", "contact_windows", "contact_window_steps", "window_trajectories", "checkpoints",
            "bridges_every"}  # fmt: skip
"""Numbers of config.yaml that say what to run, not what is so; they need no source."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the configuration."""
    return Path(shutil.copytree(CONFIG, tmp_path / "config"))


def entries(node: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Every number of a YAML file with its path; an entry with a source counts as one."""
    if isinstance(node, dict) and "source" in node:
        yield ".".join(path), node
    elif isinstance(node, dict):
        for key, value in node.items():
            if key not in SWITCHES:
                yield from entries(value, (*path, str(key)))
    elif isinstance(node, list):
        for k, value in enumerate(node):
            yield from entries(value, (*path, str(k)))
    elif isinstance(node, (int, float)) and not isinstance(node, bool):
        yield ".".join(path), node


def test_every_number_has_a_source() -> None:
    count = 0
    for name in ("config.yaml", "materials.yaml", "scales.yaml"):
        for path, node in entries(yaml.safe_load((CONFIG / name).read_text())):
            assert isinstance(node, dict), f"{name}: {path} is a bare number"
            origin = node.get("table") or node.get("section") if node["source"] == "paper" else node.get("reason")
            assert origin, f"{name}: {path} does not say where it comes from"
            count += 1
    assert count > 100  # the loop found the keys of the files


def test_a_screen_as_open_as_its_wire_and_a_material_of_one_size_are_taken() -> None:
    """The limits themselves; a wire thicker than the aperture is among what is refused."""
    materials = load(CONFIG).materials
    screen = materials.screens[0].model_dump()
    screen["aperture_mm"]["value"] = screen["wire_diameter_mm"]["value"]
    assert type(materials.screens[0]).model_validate(screen)
    spheres = next(iter(materials.spheres.values()))
    one = type(spheres).model_validate({**spheres.model_dump(), "sizes": spheres.model_dump()["sizes"][:1]})
    assert len(one.sizes) == 1


def test_a_square_sieve_has_whole_pitches_and_a_round_one_its_diameter() -> None:
    """50 mm and a pitch of 6.6 mm: 8 pitches; the area of a circle."""
    square = load(CONFIG).scales.scales["smoke"]
    width = square.width_mm.model_copy(update={"value": 50.0})
    square, circle = (square.model_copy(update={"shape": shape, "width_mm": width}) for shape in ("square", "cylinder"))
    assert square.sieve_width_m(6.6e-3) == pytest.approx(52.8e-3, rel=1e-14)
    assert square.sieve_area_m2(6.6e-3) == pytest.approx(52.8e-3**2, rel=1e-14)
    assert circle.sieve_width_m(6.6e-3) == pytest.approx(50e-3, rel=1e-14)
    assert circle.sieve_area_m2(6.6e-3) == pytest.approx(0.25 * math.pi * 50e-3**2, rel=1e-14)


def test_a_round_sieve_without_a_width_is_that_of_the_feed(folder: Path) -> None:
    """One key turns both, so that the feed stays the paper's: (200/185)² = 1.169 times as deep a bed, 1.33 large per aperture."""
    path = folder / "materials.yaml"
    assert load(folder).scale("full").asked_width_mm == 200 and not load(folder).readings
    path.write_text(path.read_text().replace("sieve_diameter_mm: {value: 200", "sieve_diameter_mm: {value: 185"))
    narrow = load(folder)
    assert narrow.scale("full").asked_width_mm == 185
    assert narrow.readings == ["reading: feed.sieve_diameter_mm is 185 (default 200)"]
    counts = [[c.count for c in cases.sphere_classes(c, c.case(1), c.scale("full"))] for c in (load(CONFIG), narrow)]
    assert counts[0] == counts[1] == [2813, 1042, 356]
    assert 356 / (0.25 * math.pi * 185**2 / 10**2) == pytest.approx(1.32, abs=0.01)
    scales = folder / "scales.yaml"
    scales.write_text(scales.read_text().replace("    shape: cylinder", "    shape: square"))
    with raises_code("config.inconsistent", says="expected width_mm together with shape: square"):
        load(folder)


def test_readings_that_are_not_the_default_are_in_the_plan(folder: Path) -> None:
    turned = {"small_wall": "half_facet", "sphere_mass": "weighed", "liquid_amount": "less_residual"}
    change_readings(folder, turned)
    output_text = call(["plan", "2", "--config", str(folder)])
    assert [line for line in output_text.splitlines() if line.startswith("reading")] == [
        "reading: readings.small_wall is half_facet (default wire_radius)",
        "reading: readings.liquid_amount is less_residual (default full)",
        "reading: readings.sphere_mass is weighed (default density)",
    ]
    assert "reading" not in call(["plan", "2"])
    assert json.loads(call(["plan", "2", "--config", str(folder), "--json"]))["readings"][0].endswith(
        "(default wire_radius)"
    )


def test_weighed_spheres_are_as_many_as_their_masses_say(folder: Path) -> None:
    """250 g of 0.0935, 0.2459 and 0.721 g each, and 250 g in a class of the size's density: 1428.6 kg/m3 at 5 mm."""
    change_readings(folder, {"sphere_mass": "weighed"})
    found = load(folder)
    classes = cases.sphere_classes(found, found.case(1), found.scale("full"))
    assert [c.count for c in classes] == [2674, 1017, 347]
    assert [c.count * c.mass_kg for c in classes] == pytest.approx([0.25] * 3, rel=1e-3)
    text = (folder / "materials.yaml").read_text()
    (folder / "materials.yaml").write_text(
        text.replace("        mass_g: {value: 0.0935, tolerance: 0.02, source: paper, table: 1}\n", "")
    )
    bare = load(folder)
    with raises_code("config.no_mass"):
        cases.sphere_classes(bare, bare.case(1), bare.scale("full"))


def test_the_residual_is_taken_from_the_liquid(folder: Path) -> None:
    """A tenth of it, whatever the case; without a number for its material it is asked for."""
    change_readings(folder, {"liquid_amount": "less_residual"})
    found = load(folder)
    assert [found.liquid_percent(n) for n in (1, 2, 3, 11)] == pytest.approx([0.0, 4.5, 9.0, 2.25])
    text = (folder / "materials.yaml").read_text()
    (folder / "materials.yaml").write_text(re.sub(r"    residual_liquid_percent: .*\n", "", text))
    with raises_code("config.residual"):
        load(folder).liquid_percent(2)


def test_readings_of_equations_that_are_not_used_are_refused(folder: Path) -> None:
    change_readings(folder, {"capillary_spheres": "as_printed"})
    assert load(folder).settings.laws_as_read.capillary == "rabinovich_spheres_as_printed"
    path = folder / "config.yaml"
    path.write_text(path.read_text().replace("preset: paper", "preset: exact"))
    with raises_code("config.inconsistent", says="these readings apply to rabinovich"):
        load(folder)


def change_readings(folder: Path, values: dict[str, str]) -> None:
    """Other readings in config.yaml, each of them with its comment."""
    path = folder / "config.yaml"
    text = path.read_text()
    for key, value in values.items():
        text, count = re.subn(rf"^  {key}: \w+", f"  {key}: {value}", text, flags=re.MULTILINE)
        assert count == 1, key
    path.write_text(text)


def call(words: list[str]) -> str:
    """Return the output of the command."""
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    return done.output


def test_rolling_resistance_is_off_for_an_engine_without_it(tmp_path: Path) -> None:
    """In plan.json, in the configuration that the run stores, and in the effects of its scene."""
    stages.build(load(CONFIG).without_rolling(), 1, "smoke", tmp_path)
    (row,) = (row for row in json.loads((tmp_path / "plan.json").read_text())["rows"] if row["effect"] == "rolling")
    assert (row["on"], row["why"]) == (False, "effects.rolling is off in config.yaml")
    assert of_run(tmp_path)[0].settings.effects.rolling is False
    assert json.loads((tmp_path / "scene.json").read_text())["effects"]["rolling"] is False


def test_cases_are_table_4() -> None:
    cases = load(CONFIG).cases
    assert list(cases) == list(range(1, 19))
    assert [c.liquid_percent for c in cases.values()] == [0, 5, 10] * 3 + [0, 2.5, 5] * 3
    assert [c.set_amplitude_mm for c in cases.values()] == ([1] * 3 + [0.8] * 3 + [1] * 3) * 2
    assert [c.aperture_mm for c in cases.values()] == ([8] * 6 + [5.6] * 3) * 2
    assert {c.diameters_mm for c in cases.values() if c.aperture_mm == 8} == {(5, 7, 10)}
    assert {c.diameters_mm for c in cases.values() if c.aperture_mm == 5.6} == {(3, 5, 7)}
    assert [c.material for c in cases.values()] == ["POM"] * 9 + ["glass"] * 9
    assert all(c.source == "paper table 4" for c in cases.values())


@pytest.mark.parametrize(
    ("material", "masses", "densities", "young", "poisson", "angle"),
    [
        ("POM", [0.0192, 0.0935, 0.2459, 0.7210], [1357.0, 1358.0, 1335.6, 1342.5], 2.84e9, 0.35, 40),
        ("glass", [0.0353, 0.1636, 0.4490, 1.3090], [2524.0, 2535.1, 2537.3, 2530.0], 5.0e10, 0.2, 15),
    ],
)
def test_spheres_are_table_1(
    material: str, masses: list[float], densities: list[float], young: float, poisson: float, angle: float
) -> None:
    data = load(CONFIG).materials.spheres[material]
    assert [s.diameter_mm.value for s in data.sizes] == [3, 5, 7, 10]
    assert [s.mass_g and s.mass_g.value for s in data.sizes] == masses
    assert [s.density_kg_per_m3.value for s in data.sizes] == densities
    tolerances = {
        (s.diameter_mm.tolerance, s.mass_g and s.mass_g.tolerance, s.density_kg_per_m3.tolerance) for s in data.sizes
    }
    assert tolerances == {(0.1, 0.02, 1.5)}
    assert data.youngs_modulus_Pa and data.poissons_ratio
    assert (data.youngs_modulus_Pa.value, data.poissons_ratio.value) == (young, poisson)
    assert data.stiffness_sphere_sphere_N_per_m.value == data.stiffness_sphere_wall_N_per_m.value == 1e5
    assert data.contact_angle_deg.value == angle


def test_contacts_are_table_3_and_pvc_is_taken_as_steel() -> None:
    data = load(CONFIG).materials
    assert data.contact("POM", "steel").numbers == (0.3484, 5.97e-5, 0.8473)
    assert data.contact("POM", "POM").numbers == (0.3725, 4.63e-5, 0.8038)
    assert data.contact("glass", "steel").numbers == (0.2866, 1.09e-4, 0.4351)
    assert data.contact("glass", "glass").numbers == (0.1966, 8.95e-5, 0.7808)
    for material in ("POM", "glass"):
        pvc = data.contact(material, "PVC")
        assert pvc.numbers == data.contact(material, "steel").numbers
        assert pvc.friction.source == pvc.restitution.source == "assumption"


def test_schemas_are_in_step_with_the_types() -> None:
    stored = {path.name: json.loads(path.read_text()) for path in (ROOT / "workflow" / "schemas").iterdir()}
    assert stored == schemas(), "run: python -m pywet.config.schema workflow/schemas"


@pytest.mark.parametrize("name", ["config", "materials", "scales"])
def test_shipped_files_pass_their_schema(name: str) -> None:
    schema = json.loads((ROOT / "workflow" / "schemas" / f"{name}.schema.json").read_text())
    jsonschema.validate(yaml.safe_load((CONFIG / f"{name}.yaml").read_text()), schema)


def test_shipped_cases_pass_their_schema() -> None:
    schema = json.loads((ROOT / "workflow" / "schemas" / "cases.schema.json").read_text())
    numbers = {key for key, kind in schema["properties"].items() if kind.get("type") in ("number", "integer")}
    for row in csv.DictReader((CONFIG / "cases.csv").read_text().splitlines()):
        typed = {k: (float(v) if k in numbers else v) for k, v in row.items()}
        jsonschema.validate(typed, schema)


Edit = Callable[[dict[str, Any]], Any]


def _set(*path: str | int, to: Any) -> Edit:
    def edit(data: Any) -> None:
        for key in path[:-1]:
            data = data[key]
        data[path[-1]] = to

    return edit


def _rename(*path: str | int, to: str) -> Edit:
    def edit(data: Any) -> None:
        for key in path[:-1]:
            data = data[key]
        data[to] = data.pop(path[-1])

    return edit


def _twice(*path: str) -> Edit:
    """Another first entry, like the last one."""

    def edit(data: Any) -> None:
        for key in path:
            data = data[key]
        data.insert(0, data[-1])

    return edit


LISTS = [("contacts",), ("screens",), ("motion", "strokes"), ("spheres", "POM", "sizes")]
SIZE = ("spheres", "POM", "sizes", 1)
BAD = {
    "materials.yaml": {
        "wrong unit in the key": (
            _rename(*SIZE, "density_kg_per_m3", to="density_g_per_cm3"),
            "config.unknown_key",
            "spheres.POM.sizes.1.density_g_per_cm3",
        ),
        "density of another material": (
            _set(*SIZE, "density_kg_per_m3", "value", to=2500),
            "config.inconsistent",
            "spheres.POM.sizes.1",
        ),
        "density in g/cm3": (
            _set(*SIZE, "density_kg_per_m3", "value", to=1.358),
            "config.implausible",
            "spheres.POM.sizes.1.density_kg_per_m3.value",
        ),
        "missing key": (
            lambda data: data["spheres"]["POM"]["sizes"][1].pop("density_kg_per_m3"),
            "config.missing_key",
            "spheres.POM.sizes.1.density_kg_per_m3",
        ),
        "negative size": (
            _set(*SIZE, "diameter_mm", "value", to=-5),
            "config.value",
            "spheres.POM.sizes.1.diameter_mm.value",
        ),
        "aperture smaller than the wire": (
            _set("screens", 0, "aperture_mm", "value", to=1.5),
            "config.inconsistent",
            "screens.0",
        ),
        "bare number": (
            _set("liquid", "viscosity_Pa_s", to=1e-3),
            "config.value",
            "liquid.viscosity_Pa_s",
        ),
        "walls of two dry materials": (
            _set("contacts", 2, "friction", "value", to=0.5),
            "config.reference",
            "",
        ),
        "unknown wall material": (
            _set("wall_materials", "slide", "material", to="wood"),
            "config.inconsistent",
            "",
        ),
        **{f"twice in {'.'.join(path)}": (_twice(*path), "config.inconsistent", "") for path in LISTS},
    },
    "scales.yaml": {
        "unknown shape": (
            _set("scales", "smoke", "shape", to="round"),
            "config.value",
            "scales.smoke.shape",
        ),
        "slide opens too late": (
            _set("scales", "smoke", "slide_opens_at_s", "value", to=300),
            "config.inconsistent",
            "scales.smoke",
        ),
    },
    "config.yaml": {
        "unknown scale": (
            _set("scale", to="huge"),
            "config.unknown_name",
            "scale",
        ),
        "unknown case": (
            _set("cases", to=[19]),
            "config.unknown_name",
            "case",
        ),
        "no number": (
            _set("ranks", to="many"),
            "config.value",
            "ranks",
        ),
        "misspelt key": (
            _set("rank", to=1),
            "config.unknown_key",
            "rank",
        ),
    },
}
"""File -> mistakes in it by name: what is edited, the code of the error and its key."""


@pytest.mark.parametrize(
    ("file", "edit", "code", "key"),
    [pytest.param(file, *case, id=name) for file, cases in BAD.items() for name, case in cases.items()],
)
def test_a_mistake_is_one_sentence(folder: Path, file: str, edit: Edit, code: str, key: str) -> None:
    data = yaml.safe_load((folder / file).read_text())
    edit(data)
    (folder / file).write_text(yaml.safe_dump(data))
    with raises_code(code, key=key) as caught:
        load(folder)
    text = str(caught.value)
    assert file in text
    assert "\n" not in text and "pydantic" not in text


ROW = "2,POM,5,7,10,8,1,5,paper table 4"


@pytest.mark.parametrize(
    ("row", "code", "says"),
    [
        ("2,POM,-5,7,10,8,1,5,paper table 4", "config.value", "small_mm"),
        ("2,POM,7,5,10,8,1,5,paper table 4", "config.inconsistent", "small_mm < near_mesh_mm < large_mm"),
        ("2,steel,5,7,10,8,1,5,paper table 4", "config.reference", "spheres has no steel"),
        ("2,POM,5,6,10,8,1,5,paper table 4", "config.reference", "spheres.POM.sizes has no 6 mm"),
        ("2,POM,5,7,10,6.3,1,5,paper table 4", "config.reference", "screens has no aperture of 6.3 mm"),
        ("2,POM,5,7,10,8,2,5,paper table 4", "config.reference", "motion.strokes has no set amplitude 2 mm"),
        ("2,POM,5,7,10,8,1,500,paper table 4", "config.value", "liquid_percent"),
        ("2,POM,5,7,10,8,1", "config.row_length", ""),
        ("1,POM,5,7,10,8,1,0,paper table 4", "config.case_twice", ""),
    ],
)
def test_a_mistake_in_a_case_is_one_sentence(folder: Path, row: str, code: str, says: str) -> None:
    path = folder / "cases.csv"
    assert ROW in path.read_text()
    path.write_text(path.read_text().replace(ROW, row))
    with raises_code(code, says) as caught:
        load(folder)
    assert "cases.csv" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "code"),
    [(None, "file.unread"), ("scale: [", "config.not_yaml"), ("- 1", "config.not_keys")],
)
def test_an_unreadable_file_is_one_sentence(folder: Path, text: str | None, code: str) -> None:
    path = folder / "config.yaml"
    path.unlink()
    if text is not None:
        path.write_text(text)
    with raises_code(code):
        load(folder)


def test_what_is_unusual_is_taken_with_a_reason(folder: Path) -> None:
    path = folder / "materials.yaml"
    path.write_text(path.read_text().replace("value: 0.07275", "value: 1.8, unusual: molten iron in argon"))
    assert load(folder).materials.liquid.surface_tension_N_per_m.value == 1.8


def test_anchors_and_merged_keys_are_no_duplicates(folder: Path) -> None:
    """Accept keys that replace merged ones, and a table with the byte order mark of a spreadsheet."""
    path = folder / "scales.yaml"
    text = path.read_text().replace("  smoke:\n", "  smoke: &smoke\n")
    path.write_text(
        f"{text}  wide:\n    <<: *smoke\n    width_mm: {{value: 70, source: assumption, reason: wider than smoke}}\n"
    )
    table = folder / "cases.csv"
    table.write_bytes(b"\xef\xbb\xbf" + table.read_bytes())
    scales = load(folder).scales.scales
    assert (scales["wide"].width_mm.value, scales["wide"].wire_sides) == (70, scales["smoke"].wire_sides)


def custom_material(folder: Path) -> None:
    """A material of sizes that the paper's do not have, a liquid, and two cases, added to a copy of the configuration."""
    data = yaml.safe_load((folder / "materials.yaml").read_text())
    output_text = {"source": "measured"}
    size = {"density_kg_per_m3": {"value": 2000, **output_text}}
    sizes = [
        {
            "diameter_mm": {"value": d, **output_text},
            "mass_g": {"value": 2e-3 * math.pi / 6 * d**3, **output_text},
            **size,
        }
        for d in (4, 6, 9)
    ]
    data["spheres"]["ore"] = {**data["spheres"]["POM"], "sizes": sizes}
    contacts = [{**c, "sphere": "ore", "partner": "ore" if c["partner"] == "POM" else c["partner"]}
           for c in data["contacts"] if c["sphere"] == "POM"]  # fmt: skip
    data["contacts"] += contacts
    oil = {"surface_tension_N_per_m": 0.03, "viscosity_Pa_s": 0.1, "density_kg_per_m3": 900}
    data["liquids"] = {"oil": {key: {"value": value, **output_text} for key, value in oil.items()}}
    (folder / "materials.yaml").write_text(yaml.safe_dump(data))
    lines = (folder / "cases.csv").read_text().splitlines()
    rows = [lines[0] + ",class_mass_g,class_volume_cm3,liquid", *(line + ",,," for line in lines[1:])]
    rows += ["50,ore,4,6,9,8,1,3,measured,300,,oil", "51,ore,4,6,9,8,1,3,measured,,150,oil"]
    (folder / "cases.csv").write_text("\n".join(rows) + "\n")


def test_a_custom_material_is_added_to_the_papers(folder: Path) -> None:
    """Its feed is a mass or a volume of its own (300 g of 2 g/cm3), its liquid the case's; other cases stay as they were."""
    custom_material(folder)
    before, loaded = load(ROOT / "config"), load(folder)
    by_mass, by_volume = (cases.ingredients(loaded, number, "full") for number in (50, 51))
    assert [c.count for c in by_mass.classes] == [c.count for c in by_volume.classes]
    share = loaded.scale("full").sieve_area_m2(0.01) / (math.pi / 4 * 0.2**2)
    for c in by_mass.classes:
        assert c.count * c.mass_kg == pytest.approx(0.3 * share, abs=c.mass_kg)
    assert by_mass.liquid is not None and by_mass.liquid.viscosity_Pa_s == 0.1
    wet = sum(c.count * 4 / 3 * math.pi * ((c.radius_m + by_mass.liquid.initial_film_thickness_m) ** 3 - c.radius_m**3)
              for c in by_mass.classes)  # fmt: skip
    assert 900 * wet == pytest.approx(0.03 * sum(c.count * c.mass_kg for c in by_mass.classes))
    assert cases.ingredients(loaded, 2, "smoke") == cases.ingredients(before, 2, "smoke")
    assert loaded.resolved(50, "smoke")["materials"]["liquid"]["viscosity_Pa_s"]["value"] == 0.1


def add_the_material_of_the_page(folder: Path) -> None:
    """Add the material, the liquid and the case of docs/configuration.md to a configuration, as the page describes."""
    page = (ROOT / "docs" / "configuration.md").read_text().partition("## Add a material")[2]
    spheres, contacts, liquids = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)[:3]
    header, row = re.findall(r"```csv\n(.*?)```", page, re.DOTALL)[0].splitlines()
    text = (folder / "materials.yaml").read_text()
    text = text.replace("\nspheres:\n", f"\nspheres:\n{spheres}").replace("\ncontacts:\n", f"\ncontacts:\n{contacts}")
    (folder / "materials.yaml").write_text(f"{text}\n{liquids}")
    rows = (folder / "cases.csv").read_text().splitlines()
    (folder / "cases.csv").write_text("\n".join([header, *rows[1:], row]) + "\n")


def test_the_material_of_the_page(folder: Path) -> None:
    """It has 300 g of each class on the sieve of 200 mm and its liquid; case 2 is unchanged."""
    add_the_material_of_the_page(folder)
    loaded = load(folder)
    made = cases.ingredients(loaded, 50, "full")
    share = loaded.scale("full").sieve_area_m2(0.01) / (math.pi / 4 * 0.2**2)
    for c in made.classes:
        assert c.count * c.mass_kg == pytest.approx(0.3 * share, abs=c.mass_kg)
    assert made.liquid is not None and made.liquid.viscosity_Pa_s == 1.6e-3
    assert cases.ingredients(loaded, 2, "smoke") == cases.ingredients(load(ROOT / "config"), 2, "smoke")


def test_the_reference_counts_a_custom_feed_as_the_configuration_says(folder: Path) -> None:
    from reference_impl.scene import amounts

    custom_material(folder)
    loaded = load(folder)
    for number in (2, 50, 51):
        found = amounts.classes(loaded.resolved(number, "smoke"))
        assert [c.count for c in found] == [c.count for c in cases.ingredients(loaded, number, "smoke").classes]


SEVERAL = """
duration_s: 1e9
seed: yes
gravity_m_per_s2: [0, 0, off]
materials:
  glass: {density_kg_per_m3: 2500000, restitution: 1.5}
  steel: {density_kg_per_m3: 7800, friction: high, colour: grey}
spheres:
  - {name: a, material: glass, diameter_mm: -3, count: 10, box: {low_mm: [0, 0, 0], high_mm: [30, 30, 30]}}
  - {name: b, material: steel, diameter_mm: 3000000, box: {low_mm: [0, 0, 0], high_mm: [30, 30, 30]}}
results: {windows: -3}
"""


def test_mistakes_that_hide_others_are_reported_with_them(tmp_path: Path) -> None:
    """A switch for a number hides all of its group, a wrong entry the ranges of its group and of the groups around it; that
    spheres b have no count is no independent mistake, and b is not called inconsistent without its diameter."""
    file = tmp_path / "several.yaml"
    file.write_text("name: several" + SEVERAL)
    done = CliRunner().invoke(app, ["run-scene", str(file), "--check"])
    lines = done.stderr.splitlines()
    assert done.exit_code == 1 and all(line.startswith(f"{file}: ") for line in lines)
    given = ["key materials.steel.colour is not known", "gravity_m_per_s2 is [0, 0, False]", "seed is True",
             "materials.glass.restitution is 1.5", "materials.steel.friction is 'high'", "spheres.0.diameter_mm is -3",
             "results.windows is -3", "spheres.1.diameter_mm is 3000000", "materials.glass.density_kg_per_m3 is 2500000",
             "duration_s is 1000000000"]  # fmt: skip
    assert sorted(
        line.removeprefix(f"{file}: ").partition(", expected")[0].removesuffix(".0") for line in lines
    ) == sorted(given)
    with raises_code("config.unknown_key", key="materials.steel.colour", given="grey"):
        read_scene(file)


def test_mistakes_in_all_files_are_reported_at_once(folder: Path) -> None:
    """Two in one file, one in each of two others: four lines, each with its file."""
    for name, *changes in (
        ("config.yaml", ("seed:", "sed:"), ("ranks: 1", "ranks: none")),
        ("materials.yaml", ("  surface_tension_N_per_m", "  tension_N_per_m")),
        ("cases.csv", ("1,POM,5,7,10", "1,POM,9,7,10")),
    ):
        text = (folder / name).read_text()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        (folder / name).write_text(text)
    with pytest.raises(PywetError) as error:
        load(folder)
    lines = str(error.value).splitlines()
    assert [Path(line.split(":")[0].split(" line")[0]).name for line in lines] == [
        "config.yaml", "config.yaml", "materials.yaml", "cases.csv",
    ]  # fmt: skip
