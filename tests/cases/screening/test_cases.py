"""From configuration to scene: amounts against the paper, film thickness, time step, files of a run directory."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.screening import cases
from pywet.cases.small import bodies
from pywet.config import Config, load
from pywet.planning import step_choice
from pywet.scene import EngineScene, SphereClass
from tests.error_codes import raises_code

CONFIG = load(Path(__file__).parents[3] / "config")
MOIST = [n for n, c in CONFIG.cases.items() if c.liquid_percent > 0]
SCALES = list(CONFIG.scales.scales)


def mass(classes: tuple[SphereClass, ...]) -> float:
    return sum(c.count * c.mass_kg for c in classes)


@pytest.mark.parametrize("number", [1, 7])
def test_full_scale_pom_is_three_times_250_g(number: int) -> None:
    classes = cases.ingredients(CONFIG, number, "full").classes
    for c in classes:  # whole spheres: within half a sphere of the class mass
        assert c.count * c.mass_kg == pytest.approx(0.250, abs=0.5 * c.mass_kg)
    assert mass(classes) == pytest.approx(0.75, abs=1e-3)


@pytest.mark.parametrize("number", [10, 16])
def test_full_scale_glass_is_the_same_volume_about_1410_g(number: int) -> None:
    glass = cases.ingredients(CONFIG, number, "full").classes
    pom = cases.ingredients(CONFIG, number - 9, "full").classes
    assert [(c.count, c.radius_m) for c in glass] == [(c.count, c.radius_m) for c in pom]
    assert mass(glass) == pytest.approx(1.41, abs=5e-3)  # table 2 gives three digits


@pytest.mark.parametrize("scale", ["smoke", "reduced"])
@pytest.mark.parametrize("number", [1, 7])
def test_small_scales_have_the_papers_mass_per_area(scale: str, number: int) -> None:
    classes = cases.ingredients(CONFIG, number, scale).classes
    spec = cases.apparatus_spec(CONFIG, CONFIG.case(number), CONFIG.scale(scale))
    expected = 0.75 * spec.width_m**2 / (math.pi / 4 * 0.2**2)
    half_spheres = 0.5 * sum(c.mass_kg for c in classes)
    assert mass(classes) == pytest.approx(expected, abs=half_spheres)


@pytest.mark.parametrize(("number", "pitches"), [(1, 5), (7, 7)])
def test_smoke_sieve_has_whole_pitches(number: int, pitches: int) -> None:
    spec = cases.apparatus_spec(CONFIG, CONFIG.case(number), CONFIG.scale("smoke"))
    assert spec.width_m == pytest.approx(pitches * (spec.aperture_m + spec.wire_diameter_m), rel=1e-12)
    assert spec.wire_sides == 6


@pytest.mark.parametrize("number", CONFIG.cases)
def test_classes_are_small_near_mesh_large(number: int) -> None:
    classes = cases.ingredients(CONFIG, number, "smoke").classes
    assert [(c.type, c.name, c.passes_aperture) for c in classes] == [
        (1, "small", True),
        (2, "near_mesh", True),
        (3, "large", False),
    ]


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("number", MOIST)
def test_film_holds_the_liquid(number: int, scale: str) -> None:
    made = cases.ingredients(CONFIG, number, scale)
    liquid, percent = made.liquid, CONFIG.case(number).liquid_percent
    assert liquid is not None
    h = liquid.initial_film_thickness_m
    held = sum(c.count * 4 / 3 * math.pi * (3 * c.radius_m**2 * h + 3 * c.radius_m * h**2 + h**3) for c in made.classes)
    # brentq finds the thickness to round-off; 1e-12 allows for round-off of the sums
    assert held * liquid.density_kg_per_m3 == pytest.approx(0.01 * percent * mass(made.classes), rel=1e-12)


def test_dry_case_has_no_liquid() -> None:
    made = cases.ingredients(CONFIG, 1, "smoke")
    assert made.liquid is None and not made.plan.effects.bridges


def test_motion_is_section_5_1() -> None:
    for number, vertical in ((1, 0.9e-3), (4, 0.72e-3)):
        vibration = cases.ingredients(CONFIG, number, "smoke").vibration
        assert vibration.amplitude_m[2] == pytest.approx(vertical, rel=1e-12)
        assert 0 < max(vibration.amplitude_m[:2]) < 1e-4
        assert vibration.frequency_Hz == 50.6


@pytest.mark.parametrize(("scale", "stiffness"), [("smoke", 1e3), ("reduced", 1e4), ("full", 1e5)])
def test_contacts_of_a_case(scale: str, stiffness: float) -> None:
    pairs = {(p.a, p.b): p for p in cases.ingredients(CONFIG, 11, scale).pairs}
    assert set(pairs) == {(1, 0), (2, 0), (3, 0), (1, 1), (1, 2), (1, 3), (2, 2), (2, 3), (3, 3)}
    for (_, b), pair in pairs.items():
        assert pair.normal_stiffness_N_per_m == pytest.approx(stiffness, rel=1e-12)
        assert pair.tangential_stiffness_N_per_m == pytest.approx(2 / 7 * stiffness, rel=1e-12)
        expected = (0.1966, 8.95e-5, 0.7808) if b else (0.2866, 1.09e-4, 0.4351)
        assert (pair.friction, pair.rolling_friction_m, pair.restitution) == expected


def test_collision_time_is_half_a_damped_period() -> None:
    (sphere,) = bodies.sphere_classes(2e-3, counts=2)
    pair = bodies.contact(1, 1, 1e4, restitution=0.5).model_copy(update={"tangential_stiffness_N_per_m": 1e3})
    m_eff = sphere.mass_kg / 2
    gamma = -2 * math.log(0.5) * math.sqrt(m_eff * 1e4) / math.hypot(math.pi, math.log(0.5))
    # m x'' + gamma x' + k x = 0: half period pi/sqrt(k/m - (gamma/2m)^2)
    expected = math.pi / math.sqrt(1e4 / m_eff - (gamma / (2 * m_eff)) ** 2)
    assert step_choice.collision_time(pair, [sphere]) == pytest.approx(expected, rel=1e-12)
    # m/c at S_min = 0.001 r (equal spheres), c = 6 pi eta (r/2)^2/S_min
    drag = 6 * math.pi * 0.1 * 1e-3**2 / 2e-6
    assert step_choice.damping_time(pair, [sphere], 0.1) == pytest.approx(m_eff / drag, rel=1e-12)
    assert step_choice.of_collisions([pair], [sphere], 0.05) == pytest.approx(0.05 * expected, rel=0.01)
    assert step_choice.of_collisions([pair], [sphere], 0.05) <= 0.05 * expected
    assert step_choice.of_collisions([pair], [sphere], 0.05, 1.0) == pytest.approx(0.05 * m_eff / drag / 10, rel=0.01)
    # a class without spheres has no collisions, whatever its stiffness
    none = sphere.model_copy(update={"type": 2, "count": 0})
    stiff = [
        pair.model_copy(update={"a": a, "b": b, "normal_stiffness_N_per_m": 1e6}) for a, b in ((2, 0), (1, 2), (2, 2))
    ]
    assert step_choice.of_collisions([pair, *stiff], [sphere, none], 0.05) == step_choice.of_collisions(
        [pair], [sphere], 0.05
    )


@pytest.mark.parametrize("number", CONFIG.cases)
@pytest.mark.parametrize("scale", SCALES)
def test_time_step_resolves_every_collision(number: int, scale: str) -> None:
    made = cases.ingredients(CONFIG, number, scale)
    shortest = min(step_choice.collision_time(p, made.classes) for p in made.pairs)
    wished = CONFIG.settings.time_step.fraction.value * shortest
    # cut to three digits, at most 1 % less; water's damping time is longer than a collision
    assert 0.99 * wished < made.time_step_s <= wished * (1 + 1e-12)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, EngineScene]:
    folder = tmp_path_factory.mktemp("smoke") / "case02"
    return folder, cases.build(CONFIG, 2, "smoke", folder)


def test_run_directory_is_complete(built: tuple[Path, EngineScene]) -> None:
    folder, scene = built
    assert EngineScene.read(folder / "scene.json") == scene
    found = {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}
    stl = {f"stl/{wall.name}.stl" for wall in scene.walls}
    history = {f"history/{name}.parquet" for name in ("spheres", "triangles", "parts")}
    assert (
        found
        == {".pywet-run", "scene.json", "plan.json", "config.json", "config_files.json", "spheres.parquet"}
        | stl
        | history
    )


def test_spheres_of_the_run(built: tuple[Path, EngineScene]) -> None:
    folder, scene = built
    spheres = pd.read_parquet(folder / "history" / "spheres.parquet")
    start = pd.read_parquet(folder / "spheres.parquet")
    assert spheres["type"].value_counts().to_dict() == {c.type: c.count for c in scene.classes}
    assert spheres["id"].tolist() == start["id"].tolist() == list(range(1, len(start) + 1))
    assert scene.liquid is not None
    water = scene.liquid.density_kg_per_m3 * spheres["film"].sum()
    assert water == pytest.approx(0.05 * mass(scene.classes), rel=1e-12)


def test_walls_of_the_run(built: tuple[Path, EngineScene]) -> None:
    folder, scene = built
    triangles = pd.read_parquet(folder / "history" / "triangles.parquet")
    parts = pd.read_parquet(folder / "history" / "parts.parquet")
    assert triangles["triangle"].tolist() == list(range(sum(len(w.triangle_part) for w in scene.walls)))
    assert parts["part"].tolist() == list(range(sum(len(w.part_half_width_m) for w in scene.walls)))
    assert np.allclose(triangles.groupby("part")["area"].sum(), parts["area"], rtol=1e-12)
    wires = parts[parts["reservoir"] == "wires"]
    assert wires["half_width"].tolist() == pytest.approx([1e-3] * len(wires))
    kinds = parts[["half_width", "contact_angle", "part_class"]].drop_duplicates()  # one class for each width and angle
    assert len(kinds) == kinds["part_class"].nunique() == len(kinds.drop(columns="part_class").drop_duplicates())
    angles = {w.reservoir: math.degrees(w.contact_angle_rad) for w in scene.walls}
    assert {h for h, a in angles.items() if a == pytest.approx(50)} == {"feed_bin", "slide"}
    assert all(a == pytest.approx(45) for h, a in angles.items() if h not in ("feed_bin", "slide"))


def test_slide_opens_on_a_steadily_moving_screen(built: tuple[Path, EngineScene]) -> None:
    _, scene = built
    assert scene.slide is not None and scene.vibration is not None
    assert scene.slide.opens_at_s * scene.vibration.frequency_Hz >= 10
    drawn = scene.slide.velocity_m_per_s[0] * scene.slide.travel_s
    assert drawn > 0.05  # farther than the width of the sieve, 50 mm
    assert scene.slide.opens_at_s + scene.slide.travel_s < scene.duration_s


def test_the_same_configuration_gives_the_same_files(built: tuple[Path, EngineScene], tmp_path: Path) -> None:
    folder, _ = built
    cases.build(CONFIG, 2, "smoke", tmp_path)
    for name in ("scene.json", "plan.json", "config.json", "stl/wires.stl", "spheres.parquet"):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


def test_an_interval_that_misses_the_end_is_named(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Outputs every 0.6 s of 1.6 s end at 1.2 s; those of the shipped scales do not."""
    with caplog.at_level("WARNING"):
        cases.build(CONFIG, 2, "smoke", tmp_path / "a")
        assert "last output" not in caplog.text
        smoke = CONFIG.scales.scales["smoke"]
        rare = smoke.model_copy(update={"output_interval_s": smoke.output_interval_s.model_copy(update={"value": 0.6})})
        scales = CONFIG.scales.model_copy(update={"scales": {**CONFIG.scales.scales, "smoke": rare}})
        cases.build(replace(CONFIG, scales=scales), 2, "smoke", tmp_path / "b")
    assert "the last output is at 1.2 s of 1.6 s" in caplog.text


def test_what_water_does_not_wet_is_refused_where_there_are_bridges() -> None:
    """A wall of 110 deg: the plan of a moist case is refused, that of a dry case and of one without wall films is made."""
    walls = dict(CONFIG.materials.walls)
    angle = walls["PVC"].contact_angle_deg.model_copy(update={"value": 110.0})
    walls["PVC"] = walls["PVC"].model_copy(update={"contact_angle_deg": angle})
    waxed = replace(CONFIG, materials=CONFIG.materials.model_copy(update={"walls": walls}))
    with raises_code("case.not_wetted", key="walls.PVC.contact_angle_deg", given=110.0):
        cases.ingredients(waxed, 2, "smoke")
    assert not cases.ingredients(waxed, 1, "smoke").plan.effects.bridges
    effects = waxed.settings.effects.model_copy(update={"wall_films": False})
    apart = replace(waxed, settings=waxed.settings.model_copy(update={"effects": effects}))
    assert cases.ingredients(apart, 2, "smoke").plan.effects.bridges


def test_semi_implicit_drag_with_a_law_of_water_that_has_inertia_is_refused() -> None:
    """Integrated explicitly it is planned, and in a dry case it has no effect."""
    settings = CONFIG.settings
    laws = settings.laws.model_copy(update={"viscous_normal": "buck_water"})

    def integrated(how: str) -> Config:
        step = settings.time_step.model_copy(update={"viscous_integration": how})
        return replace(CONFIG, settings=settings.model_copy(update={"laws": laws, "time_step": step}))

    assert cases.ingredients(integrated("explicit"), 2, "smoke").plan.effects.viscous_normal == "buck_water"
    assert not cases.ingredients(integrated("semi_implicit"), 1, "smoke").plan.effects.bridges
    with raises_code("step.not_proportional", key="time_step.viscous_integration", where="config.yaml"):
        cases.ingredients(integrated("semi_implicit"), 2, "smoke")
