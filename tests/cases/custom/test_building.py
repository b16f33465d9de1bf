"""From a description to a scene: amounts, first places, the box, what is refused before anything runs."""

from __future__ import annotations

import json
import math
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

import pywet
from pywet.cases.custom.building import Building, write
from pywet.cli import scene_check
from pywet.cli.app import app
from pywet.planning import time_steps
from pywet.products.deck import Stroke
from pywet.scene import EngineScene
from reference_impl.scene import check
from tests.cases.custom.conftest import beads, example
from tests.error_codes import raises_code

SPHERE_KG = 2500 * math.pi / 6 * 0.003**3


def test_mass_and_per_cent_are_those_of_the_classes() -> None:
    """Grams become a number of spheres; a class's own liquid does not change that of the others."""
    entry = beads()["spheres"][0]
    wet = {**entry, "name": "wet", "percent": 4.0, "mass_g": 1e3 * 30 * SPHERE_KG}
    del wet["count"]
    film = {**entry, "name": "coated", "film_um": 12.0, "diameter_mm": 2}
    made = Building(pywet.Scene(**beads(spheres=[entry, wet, film], liquid={"percent": 1.0, "density_kg_per_m3": 800})))
    table = made.spheres
    assert [c.count for c in made.classes] == [20, 30, 20]
    liquid_kg = 800 * table.groupby("type")["film"].sum()
    assert liquid_kg[1] == pytest.approx(0.01 * 20 * SPHERE_KG) and liquid_kg[2] == pytest.approx(0.04 * 30 * SPHERE_KG)
    shell = 4 / 3 * math.pi * ((1e-3 + 12e-6) ** 3 - 1e-9)
    assert table.loc[table["type"] == 3, "film"].to_numpy() == pytest.approx(shell)
    assert made.liquid is not None and made.liquid.initial_film_thickness_m == max(made.thickness)


def test_the_first_films_are_what_the_engine_starts_from(tmp_path: Path) -> None:
    entry = beads()["spheres"][0]
    scene = pywet.Scene(**beads(spheres=[entry, {**entry, "name": "wet", "percent": 3.0}], liquid={}))
    write(scene, tmp_path)
    films = pywet.load(tmp_path)._run.spheres
    assert films.loc[films["type"] == 1, "film"].max() == 0.0
    assert 1000 * films["film"].sum() == pytest.approx(0.03 * 20 * SPHERE_KG)
    assert EngineScene.read(tmp_path / "scene.json").effects.bridges


def test_no_region_has_the_packing_of_another_nor_of_another_seed() -> None:
    """Three equal boxes and three seeds: the spheres of each of the nine are elsewhere in their box, by 0.1 mm at least."""
    entry, found = beads()["spheres"][0], []
    boxes = [{"low_mm": (30 * k, 0, 0), "high_mm": (30 * k + 20, 20, 20)} for k in range(3)]
    spheres = [{**entry, "name": f"beads{k}", "box": box} for k, box in enumerate(boxes)]
    for seed in (1, 2, 3):
        table = Building(pywet.Scene(**beads(spheres=spheres, seed=seed))).spheres
        found += [table.loc[table["type"] == k + 1, [*"xyz"]].to_numpy() - [0.03 * k, 0.0, 0.0] for k in range(3)]
    assert min(np.abs(a - b).max() for a, b in combinations(found, 2)) > 1e-4


def test_spheres_lie_in_their_region_and_do_not_touch() -> None:
    box = {"low_mm": (10, -30, 5), "high_mm": (40, -20, 60)}
    made = Building(pywet.Scene(**beads(spheres=[{**beads()["spheres"][0], "box": box, "count": 60}])))
    at = 1e3 * made.spheres[[*"xyz"]].to_numpy()
    assert (at.min(axis=0) >= np.array(box["low_mm"]) + 1.5).all() and (
        at.max(axis=0) <= np.array(box["high_mm"]) - 1.5
    ).all()
    assert at[:, 2].max() < 20  # the lowest part, at a solid fraction of 0.28 or a little less
    low, high = made.box
    assert (low < at.min(axis=0) * 1e-3 - 0.0015).all() and (high > at.max(axis=0) * 1e-3 + 0.0015).all()


def test_a_wall_that_moves_after_the_end_is_named() -> None:
    """Not refused: a trial run of a scene is short."""
    shape = {"block": {"low_mm": (0, 0, -9), "high_mm": (20, 20, -5)}}
    motions = [{"removed": {"at_s": at, "towards": (1, 0, 0)}} for at in (0.005, 0.01)]
    motions.append({"moves": {"velocity_m_per_s": (0, 0, -1), "from_s": 5, "for_s": 1}})
    walls = [{"name": f"w{k}", **shape, **motion} for k, motion in enumerate(motions)]
    warned = [w for w in Building(pywet.Scene(**beads(walls=walls))).warnings if "does not move" in w]
    assert [w.split(":")[0] for w in warned] == ["wall w1 does not move", "wall w2 does not move"]


@pytest.mark.parametrize(
    ("wall", "material", "degrees"),
    [({}, {}, 40.0), ({}, {"contact_angle_deg": 75}, 75.0), ({"contact_angle_deg": 0}, {"contact_angle_deg": 75}, 0.0)],
)
def test_walls_have_the_contact_angle_of_their_material(
    wall: dict[str, float], material: dict[str, float], degrees: float, tmp_path: Path
) -> None:
    """Unless they have their own; spheres without any have 15 degrees; the reference agrees."""
    scene = beads(
        materials={"glass": {"density_kg_per_m3": 2500}, "steel": {"density_kg_per_m3": 7800, **material}},
        contacts=[{"between": ["glass", "steel"]}], wall_material="steel",
        walls=[{"name": "cup", "vessel": {"inner_width_mm": 24, "height_mm": 45, "origin_mm": (10, 10, -1)}, **wall}],
    )  # fmt: skip
    made = write(pywet.Scene(**scene), tmp_path)
    angles = [w.contact_angle_rad for w in made.walls] + [c.contact_angle_rad for c in made.classes]
    assert np.degrees(angles) == pytest.approx([degrees, 15.0])
    assert check.check(tmp_path).findings == []


@pytest.mark.parametrize(
    ("first", "second", "more"),
    [
        ({"density_kg_per_m3": 7800}, {"density_kg_per_m3": 2500}, {"stiffness_N_per_m": 2e5}),
        (
            {"density_kg_per_m3": 1100, "youngs_modulus_Pa": 1e6, "poissons_ratio": 0.4},
            {"density_kg_per_m3": 7800, "youngs_modulus_Pa": 1e8, "poissons_ratio": 0.3}, {},
        ),
    ],
    ids=["linear", "hertz"],
)  # fmt: skip
def test_the_order_of_spheres_changes_no_time_step(
    first: dict[str, float], second: dict[str, float], more: dict[str, float]
) -> None:
    """A large sphere and a small one, whose own contacts have the default stiffness, or another Rayleigh time and overlap."""
    entries = [
        {"name": "large", "material": "first", "diameter_mm": 10, "at_mm": [[0, 0, 0]]},
        {"name": "small", "material": "second", "diameter_mm": 1, "at_mm": [[20, 0, 0]]},
    ]
    hertz = {} if more else {"contact": "hertz", "wall_material": "second"}
    given = {
        "materials": {"first": first, "second": second},
        "contacts": [{"between": ["first", "second"], **more}],
        **hertz,
    }
    made, swapped = (Building(pywet.Scene(**beads(spheres=e, **given))) for e in (entries, entries[::-1]))
    assert made.time_step == swapped.time_step
    if more:  # a tenth, cut to two digits
        assert 0.9 < made.time_step / (0.1 * time_steps.packed_step(made.classes, made.pairs)) <= 1.0
    limits, others = (sorted(m.time_step_s for m in time_steps.advise(b.scene()).limits) for b in (made, swapped))
    assert limits == pytest.approx(others, rel=1e-9)
    lines, reverse = (sorted(" ".join(b.plan.contact).replace(",", "").split()) for b in (made, swapped))
    assert lines == reverse


def test_a_plan_does_not_depend_on_the_height_of_a_wall() -> None:
    """At 0.1 m/s, (ln(1 + 2 h/S_min) + v sqrt(m/(2 k))/S_min)/St of films of 20 um, 1/St = 3 pi eta r^2/(m v), S_min = r/1000."""
    shaken = {"amplitude_mm": (0, 0, 0.3), "frequency_Hz": 0.1 / (2 * math.pi * 3e-4)}
    given = {
        "materials": {"glass": {"density_kg_per_m3": 2500, "stiffness_N_per_m": 1e5}},
        "liquid": {"film_um": 20, "viscosity_Pa_s": 1e-3},
        "effects": {"decide": "tolerance", "tolerance": {"value": 0.01, "source": "assumption", "reason": "a test"}},
    }
    numbers = []
    for height in (60, 300):
        vessel = {"inner_width_mm": 60, "height_mm": height, "origin_mm": (10, 10, -1)}
        made = Building(pywet.Scene(**beads(walls=[{"name": "cup", "vessel": vessel, "vibrates": shaken}], **given)))
        row = made.plan.row("viscous_normal")
        assert row.on and made.plan.effects.viscous_normal
        numbers.append(row.number)
    films = math.log(1 + 40e-6 / 1.5e-6) + 0.1 * math.sqrt(0.5 * SPHERE_KG / 1e5) / 1.5e-6
    assert numbers == pytest.approx([3 * math.pi * 1e-3 * 1.5e-3**2 / (SPHERE_KG * 0.1) * films] * 2, rel=1e-9)


def test_the_box_holds_walls_wherever_they_move() -> None:
    """A block on the x axis turns about z: its far corner comes to every side."""
    block = {"low_mm": (30, -1, -1), "high_mm": (50, 1, 1)}
    turns = {"turns_per_minute": 60, "axis": (0, 0, 1)}
    made = Building(pywet.Scene(**beads(walls=[{"name": "arm", "block": block, "turns": turns}])))
    low, high = made.box
    assert (low[:2] < -0.05).all() and (high[:2] > 0.05).all()
    assert made.speed == pytest.approx(2 * math.pi * math.hypot(0.05, 0.001), rel=1e-6) or made.speed > 0.3


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"spheres": [{**beads()["spheres"][0], "count": 5000}]}, "packing.crowded"),
        ({"walls": [{"name": "floor", "block": {"low_mm": (0, 0, 0), "high_mm": (20, 20, 9)}}]}, "scene.in_wall"),
        ({"walls": [{"name": "lid", "stl": "none.stl"}]}, "stl.missing"),
        ({"walls": [{"name": "w", "disc": {"diameter_mm": 9}, "half_width_mm": 2}]}, "config.inconsistent"),
        ({"walls": [{"name": "w", "disc": {"diameter_mm": 9}, "origin_mm": [0, 0, 9]}]}, "config.inconsistent"),
        ({"walls": [{"name": "gravity", "vessel": {"inner_width_mm": 90, "height_mm": 90}}]}, "config.inconsistent"),
    ],
)
def test_what_cannot_be_built_is_refused_in_a_sentence(changes: dict, code: str, tmp_path: Path) -> None:
    with raises_code(code):
        write(pywet.Scene(**beads(**changes)), tmp_path)


def test_overlapping_spheres_are_refused() -> None:
    at = {"name": "two", "material": "glass", "diameter_mm": 3, "at_mm": [(0, 0, 0), (2, 0, 0)]}
    with raises_code("scene.overlap"):
        _ = Building(pywet.Scene(**beads(spheres=[at]))).spheres


def test_the_plan_leaves_out_bridges_of_a_dry_scene() -> None:
    assert not pywet.plan(pywet.Scene(**beads())).effects.bridges
    assert pywet.plan(pywet.Scene(**beads(liquid={"percent": 1}))).effects.bridges


def test_a_plan_refuses_what_a_run_refuses(tmp_path: Path) -> None:
    """A strip 24 mm wide, where over 25.15 mm is needed; a file is planned as its scene is."""
    box = {"low_mm": (-15, -10, 0), "high_mm": (15, 10, 60)}
    spheres = [{"name": "beads", "material": "glass", "diameter_mm": 11, "count": 2, "box": box}]
    given = beads(spheres=spheres, periodic={"axis": "y", "low_mm": -12, "high_mm": 12})
    for refused in (pywet.plan, scene_check.lines):
        with raises_code("scene.periodic", key="periodic"):
            refused(pywet.Scene(**given))
    path = tmp_path / "beads.yaml"
    path.write_text(yaml.safe_dump(json.loads(json.dumps(beads(liquid={"percent": 1})))))
    assert pywet.plan(path) == pywet.plan(str(path)) == pywet.plan(pywet.read_scene(path))


def test_a_check_of_a_feed_fits_80_columns() -> None:
    """The mass left out of the deck example, 1 - exp(-(3/5)^2.5) = 24 % and exp(-(8/5)^2.5) = 3.9 %; reasons on demand.

    What is off though not negligible has the key that switches it on.
    """
    scene = pywet.read_scene(Path(pywet.__file__).parents[1] / "examples" / "scenes" / "deck.yaml")
    found = scene_check.lines(scene)
    (feed,) = (line for line in found if line.startswith("feed "))
    assert feed.endswith("left out: 16 % of its mass finer and 3.9 % of its mass coarser")
    assert all(len(line) <= 80 for line in found if not line.startswith("feed "))
    (hint,) = (line for line in found if line.startswith("off, though"))
    assert hint == "off, though not negligible (effects.NAME: on): liquid_weight, shedding"
    assert any("film / radius = " in line for line in scene_check.lines(scene, reasons=True))


def test_a_check_of_a_deck_has_its_acceleration_and_adhesion_number() -> None:
    """2 mm at 20 Hz and 45°, inclined by 15°: 22.33 m/s² over g cos 15°; 2πrσ cos 30°/(m g cos 15° (Γ - 1)) of the 4.059 mm."""
    where, ratio, adhesion = scene_check.lines(example("deck"))[-3:]
    assert (
        where == "positions are relative to the deck, gravity there is (2.54, 0, -9.48) m/s2"
    )  # 9.81 of sin and cos of 15°
    acceleration = 0.002 * (40 * math.pi) ** 2 * math.sin(math.radians(45))
    normal = 9.81 * math.cos(math.radians(15))
    assert ratio == f"throw number {acceleration / normal:.3g}" == "throw number 2.36"
    number = 6 * 0.0728 * math.cos(math.radians(30)) / (2650 * 0.0040586**2 * (acceleration - normal))
    assert adhesion.startswith(f"adhesion number {number:.2g} (ore 4.059 mm)")
    deck = example("deck").deck
    assert deck is not None
    slow = deck.model_copy(update={"stroke": Stroke(amplitude_mm=2, frequency_Hz=10)})
    assert math.isinf(slow.adhesion_number(1e-3, 2650.0, 0.0, 0.07))


def test_each_of_several_decks_has_the_adhesion_number_of_its_near_mesh_size() -> None:
    """Apertures of 7 and 4 mm, sizes of 6.0 and 3.4 mm: the number goes with 1/d², a factor of 3 by the ratio of sizes √3."""
    path = Path(pywet.__file__).parents[1] / "examples" / "decks" / "double_deck.yaml"
    found = [line for line in scene_check.lines(pywet.read_scene(path)) if line.startswith("adhesion")]
    numbers = [float(line.split()[2]) for line in found]
    assert [line.split("(")[1].split(")")[0] for line in found] == ["deck 1, ore 5.961 mm", "deck 2, ore 3.442 mm"]
    assert numbers[1] == pytest.approx(3.0 * numbers[0], rel=0.05) and all(len(line) <= 80 for line in found)


def test_an_amount_of_liquid_that_no_sphere_has_is_named() -> None:
    """Where each entry of spheres has its own amount, that of `liquid` has no effect."""
    spheres = beads()["spheres"][0]
    for percent, warned in ((3, True), (None, False)):
        given = beads(spheres=[{**spheres, "percent": percent}], liquid={"percent": 5})
        warnings = Building(pywet.Scene(**given)).warnings
        assert [w.startswith("liquid.percent has no effect") for w in warnings] == [True] * warned


def test_an_output_interval_that_misses_the_end_is_named(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """By the check and by the run; one as long as the run and the default do not miss it."""
    for interval, named in ((0.004, True), (0.01, False), (None, False)):
        scene = pywet.Scene(**beads(results={"interval_s": interval}))
        caplog.clear()
        with caplog.at_level("WARNING"):
            built = write(scene, tmp_path / str(interval))
        assert ("the last output is at 0.008 s of 0.01 s" in caplog.text) == named
        assert any("the last output" in line for line in scene_check.lines(scene)) == named
        assert named or built.output_steps[-1] > 0.98 * built.steps


def test_a_check_prints_what_would_be_run_and_writes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Spheres and steps are those of the scene that is built; effects have their reasons; a mistake is one sentence."""
    monkeypatch.chdir(tmp_path)
    given = json.loads(json.dumps(beads(liquid={"percent": 1})))
    Path("beads.yaml").write_text(yaml.safe_dump(given))
    call = CliRunner(env={"COLUMNS": "300"})
    done = call.invoke(app, ["run-scene", "beads.yaml", "--check"])
    steps = Building(pywet.read_scene("beads.yaml")).scene().steps
    assert done.exit_code == 0 and f"test: 20 spheres, {steps} steps of " in done.output, done.output
    assert (
        "predicted " in done.output
        and "bridges            on " in done.output
        and "liquid_weight      off" in done.output
    )
    assert done.output.strip().endswith("no mistake was found; nothing was run or written")
    Path("beads.yaml").write_text(yaml.safe_dump({**given, "duration_s": -1}))
    wrong = call.invoke(app, ["run-scene", "beads.yaml", "--check"])
    assert wrong.exit_code == 1 and "duration_s" in wrong.stderr and len(wrong.stderr.strip().splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["beads.yaml"]


def test_speed_of_a_thrown_sphere_that_falls() -> None:
    """Its kinetic energy is that of the throw and of the fall."""
    scene = beads()
    scene["spheres"][0]["velocity_m_per_s"] = (3.0, 0.0, 0.0)
    made = Building(pywet.Scene(**scene))
    assert made.speed**2 == pytest.approx(3.0**2 + 2.0 * 9.81 * np.ptp(made.spheres["z"]), rel=1e-12)


@pytest.mark.parametrize("names", [("粗", "细"), ("glass +4 mm", "glass -4 mm")])
def test_classes_whose_columns_would_have_one_name_are_refused(names: tuple[str, str]) -> None:
    scene = beads()
    scene["spheres"] = [{**scene["spheres"][0], "name": name} for name in names]
    with raises_code("config.inconsistent", says="whose names differ in a to z or digits"):
        pywet.Scene(**scene)
