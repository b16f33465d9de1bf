"""The file of a sweep: every mistake is one sentence that names it, before anything runs; constraints run no code."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

import pywet
from pywet import shipped
from pywet.cases.custom.building import Building
from pywet.config.dotted_keys import dotted, filled, holds
from pywet.cost import needs
from pywet.errors import ConfigError
from pywet.sweep import constraints, costs, plan, points, run_numbers
from pywet.sweep.description import Axis
from tests.error_codes import raises_code
from tests.sweep.files import EXAMPLES, WALL, write

SPEEDS = {"normal_velocity_m_per_s": [0.5, 1.0]}
BAD: list[tuple[dict[str, Any], str, str]] = [
    ({"base": None}, "config.value", ""),
    ({"base": {"script": "in.liggghts"}}, "file.unread", ""),
    ({"base": {"wall": "a.json", "seed": "s"}}, "config.inconsistent", "expected seed with a script only"),
    ({"base": {"script": "in.script", "seed": "s"}, "axes": {"script.s": [3, 5]}, "seeds": 2}, "config.inconsistent",
     "expected the key seeds in place of the axis script.s, which is the seed in base"),
    ({"base": {"wall": "a.json", "bridge": "b.json"}}, "config.inconsistent",
     "at most one of case, scene, script, wall, bridge, not wall and bridge"),
    ({"base": {}}, "config.inconsistent", "expected one of case, scene, script, wall, bridge"),
    ({"base": {"wall": "a.json", "scale": "smoke"}}, "config.inconsistent", "config and scale with a case only"),
    ({"base": {"wall": "missing.json"}}, "file.unread", ""),
    ({"axis": {}}, "config.unknown_key", ""),
    ({"axes": {}}, "config.value", ""),
    ({"axes": {"frction": [0.1, 0.2]}}, "config.unknown_key", ""),
    ({"axes": {"friction": []}}, "config.inconsistent", "axes.friction is not consistent, expected at least one value"),
    ({"axes": {"friction": [0.1, 0.2, 0.1]}}, "config.inconsistent", "expected each value once (0.1 is there 2 times)"),
    ({"axes": {"friction": [0.1, "much"]}}, "config.inconsistent", "expected only numbers or only text"),
    ({"axes": {"friction": {"linspace": [0.1, 0.5, 1]}}}, "config.inconsistent", "expected linspace: [first, last, count]"),
    ({"axes": {"friction": {"logspace": [0.0, 0.5, 3]}}}, "config.inconsistent",
     "expected numbers above 0 on a logarithmic scale"),
    ({"axes": {"friction": {"values": [0.0, 0.1], "log": True}}}, "config.inconsistent",
     "expected numbers above 0 on a logarithmic scale"),
    ({"axes": {"friction": {"linspace": [0.0, 0.5, 3], "log": True}}}, "config.inconsistent",
     "expected numbers above 0 on a logarithmic scale"),
    ({"axes": {"friction": {"low": 0.5, "high": 0.1}}, "design": {"sobol": 8}}, "config.inconsistent",
     "expected low less than high"),
    ({"axes": {"friction": {"low": 0.1, "high": 0.5}}}, "config.inconsistent", "expected a design with the range of friction"),
    ({"axes": {"friction": [0.1]}, "design": {"sobol": 8}}, "config.inconsistent",
     "expected an axis with low and high for the design"),
    ({"axes": {"friction": {"low": 0.1, "high": 0.5}}, "design": {"seed": 3}}, "config.inconsistent",
     "expected latin_hypercube or sobol"),
    ({"axes": {"friction": [0.1], **SPEEDS}, "zips": [["friction", "normal_velocity_m_per_s"]]}, "config.inconsistent",
     "friction has 1"),
    ({"zips": [["friction", "speed"]]}, "config.inconsistent", "expected zips of axes with listed values, not speed"),
    ({"axes": {"particle.radius": [1e-3]}}, "config.unknown_key", ""),
    ({"axes": {"particle": [1e-3]}}, "sweep.axis_group", ""),
    ({"axes": {"friction": [0.1, 12.0]}}, "config.value", "point 2 (friction 12): "),
    ({"constraints": ["friction <"]}, "sweep.constraint_syntax", ""),
    ({"constraints": ["__import__('os').system('touch x')"]}, "sweep.constraint_word", ""),
    ({"constraints": ["speed < 1"]}, "sweep.constraint_name", ""),
    ({"constraints": ["friction > 1"]}, "sweep.no_point", ""),
    ({"constraints": ["1 / (friction - 0.1) > 0"]}, "sweep.constraint_value", "at combination 1 (friction 0.1"),
    ({"constraints": ["9 ** 9 ** 9 * friction > 0"]}, "sweep.constraint_value", ""),
    ({"seeds": 3}, "sweep.seeds", ""),
    ({"gather": ["e_N"]}, "sweep.unknown_result", ""),
    ({"gather": ["e_n", "e_n"]}, "config.inconsistent", "each gathered result once (e_n is there twice)"),
    ({"goal": {"maximise": "e_t"}}, "config.inconsistent", "expected goal to name a gathered result (e_n, duration_s), not e_t"),
    ({"gather": ["mine.py:depth"]}, "sweep.no_function_file", ""),
    ({"gather": [f"{EXAMPLES / 'gallery.py'}:main"]}, "sweep.untrusted", ""),
    ({"axes": {"friction": {"linspace": [0.1, 0.5, 10001]}}}, "sweep.many_runs", ""),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "code", "says"), BAD)
def test_a_mistake_is_one_sentence_before_anything_runs(
    tmp_path: Path, changes: dict[str, Any], code: str, says: str
) -> None:
    file = write(tmp_path, {**WALL, **changes})
    with raises_code(code, re.escape(says)) as caught:
        _ = plan.read(file, tmp_path / "out", tmp_path / "store").runs
    assert "\n" not in str(caught.value)
    assert "sweep.yaml" in str(caught.value) or "missing.json" in str(caught.value)
    assert not (tmp_path / "store").exists() and not (tmp_path / "x").exists()


@pytest.mark.parametrize("text", ["name: [", "- a\n", "name: a\nname: b\n"])
def test_a_file_that_is_no_sweep_is_one_sentence(tmp_path: Path, text: str) -> None:
    (tmp_path / "sweep.yaml").write_text(text)
    with pytest.raises(ConfigError) as caught:
        plan.read(tmp_path / "sweep.yaml")
    assert caught.value.code in ("config.not_yaml", "config.not_keys")
    assert "\n" not in str(caught.value)


def test_a_mistake_at_point_17_names_the_combination_before_the_start(tmp_path: Path) -> None:
    """Either angle is allowed alone; at one of 24 combinations both together are no toroid."""
    axes = {"liquid.contact_angle_deg": [15, 40, 85], "liquid.half_filling_angle_deg": [88, 40, 45, 50, 55, 60, 65, 70]}
    asked = plan.read(write(tmp_path, {**WALL, "axes": axes}), tmp_path / "out", tmp_path / "store")
    with pytest.raises(ConfigError) as caught:
        _ = asked.runs
    assert "point 17 (liquid.contact_angle_deg 85, liquid.half_filling_angle_deg 88): " in str(caught.value)
    assert "contact_angle_deg + half_filling_angle_deg of at most 170" in str(caught.value)
    assert "\n" not in str(caught.value) and not (tmp_path / "store").exists()


@pytest.mark.parametrize(("seed", "code"), [("one", "config.value"), (None, "config.value"), (True, "config.switch")])
def test_a_seed_of_a_scene_that_is_no_number_is_one_sentence(tmp_path: Path, seed: Any, code: str) -> None:
    """That of the scene, for every seed of the point."""
    scene = yaml.safe_load((EXAMPLES / "sweeps" / "small_drum_scene.yaml").read_text())
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump({**scene, "seed": seed}))
    content = {"name": "drum", "base": {"scene": "scene.yaml"}, "axes": {"liquid.percent": [1.0]}, "seeds": 2}
    asked = plan.read(write(tmp_path, {**content, "gather": ["ruptures"]}), tmp_path / "out", tmp_path / "store")
    with raises_code(code, re.escape("scene.yaml: seed is ")) as caught:
        _ = asked.runs
    assert "\n" not in str(caught.value)


def test_several_mistakes_are_listed_with_their_points(tmp_path: Path) -> None:
    """The first five, each with its first point; the others are counted."""
    content = {**WALL, "axes": {"friction": [0.1, *range(11, 18)], "normal_velocity_m_per_s": [1.0, 2.0]}}
    with pytest.raises(ConfigError) as caught:
        _ = plan.read(write(tmp_path, content), tmp_path, tmp_path).runs
    lines = str(caught.value).splitlines()
    assert len(lines) == plan.LISTED + 1 and lines[-1].endswith("2 more mistakes at other points")
    assert "point 3 (friction 11, normal_velocity_m_per_s 1): " in lines[0] and "(and at 1 other points)" in lines[0]


def test_grid_zip_and_design_make_the_points(tmp_path: Path) -> None:
    """Two zipped axes count as one; a design is crossed with listed axes; a longer Sobol design begins with the shorter one."""
    content = {**WALL, "axes": {"a": [1, 2], "b": [10, 20], "c": ["x", "y", "z"]}, "zips": [["a", "b"]]}
    found = points.numbered(plan.description.read(write(tmp_path, content)), tmp_path)
    rows = [tuple(p.values.values()) for p in found]
    assert rows[:4] == [(1, 10, "x"), (1, 10, "y"), (1, 10, "z"), (2, 20, "x")]
    assert [p.number for p in found] == [1, 2, 3, 4, 5, 6]
    of_range = {"low": 1e-3, "high": 1e-1, "log": True}
    drawn = {}
    for design in ({"sobol": 5}, {"sobol": 8}, {"latin_hypercube": 8}):
        content = {**WALL, "axes": {"v": of_range, "n": {"low": 1, "high": 9, "whole": True}}, "design": design}
        sweep = plan.description.read(write(tmp_path, content))
        drawn[next(iter(design)), sweep.count] = points.drawn(sweep)
    assert drawn["sobol", 8][:5] == drawn["sobol", 5]
    shares = sorted(int(8 * (3 + math.log10(p["v"])) / 2) for p in drawn["latin_hypercube", 8])
    assert shares == list(range(8))  # one point in each eighth of the logarithmic scale
    assert all(isinstance(p["n"], int) and 1 <= p["n"] <= 9 for p in drawn["sobol", 8])


def test_spaced_axes_have_both_ends() -> None:
    assert Axis(linspace=(0.0, 1.0, 3)).listed == (0.0, 0.5, 1.0)
    assert Axis(logspace=(1e-3, 1e-1, 3)).listed == (1e-3, 1e-2, 1e-1)


def test_a_constraint_is_called_by_the_last_word_of_an_axis() -> None:
    axes = ["liquid.viscosity_Pa_s", "spheres.0.diameter_mm", "law"]
    rule = constraints.read("viscosity_Pa_s * 1e3 < 5 and diameter_mm in [2, 3] or law == 'willett'", axes)
    at = {"liquid.viscosity_Pa_s": 1e-3, "spheres.0.diameter_mm": 2, "law": "a"}
    assert rule.holds(at) and not rule.holds({**at, "spheres.0.diameter_mm": 4})
    assert rule.holds({**at, "liquid.viscosity_Pa_s": 1.0, "law": "willett"})
    with raises_code("sweep.constraint_name"):
        constraints.read("x > 0", ["a.x", "b.x"])


@pytest.mark.parametrize(
    "code", ["open('x')", "().__class__", "[a for a in b]", "lambda: 0", "a if b else c", "f'{a}'", "a[0]", "(a := 1)",
             "b'x'", "sqrt(x=1)", "max.__self__"],
)  # fmt: skip
def test_an_expression_holds_nothing_that_could_run(code: str) -> None:
    with pytest.raises(ConfigError) as caught:
        constraints.read(code, ["a", "b", "c"])
    assert caught.value.code in ("sweep.constraint_word", "sweep.constraint_name", "sweep.constraint_syntax")


def test_keys_lead_into_groups_lists_and_entries_with_a_source() -> None:
    """By number or name of a list's entry; an entry of the configuration gets its `value`; the editor's notation too."""
    content = {
        "walls": [{"name": "mantle", "turns": {"turns_per_minute": 1}}],
        "liquid": {"v": {"value": 1, "source": "a"}},
    }
    changed = filled(content, {"walls.mantle.turns.turns_per_minute": 60, "liquid.v": 2, "liquid.new": 3})
    assert changed["walls"][0]["turns"] == {"turns_per_minute": 60}
    assert changed["liquid"] == {"v": {"value": 2, "source": "a"}, "new": 3} and content["liquid"]["v"]["value"] == 1
    assert holds(content, "walls.0.name") and not holds(content, "walls.1.name")
    assert dotted("materials.yaml: feed sieve_diameter_mm value") == "materials.feed.sieve_diameter_mm.value"
    with raises_code("sweep.axis_entry", given="front"):
        filled(content, {"walls.front.turns": 1})


def test_the_examples_are_sweeps() -> None:
    for file in sorted((EXAMPLES / "sweeps").glob("*.yaml")):
        if "base" in yaml.safe_load(file.read_text()):
            assert plan.read(file).sweep.name


def test_the_first_sweep_of_the_documentation_is_checked_as_a_new_user_does(tmp_path: Path) -> None:
    """The page shows the file that `pywet init` writes: 24 runs in less than a tenth of a core-hour."""
    block = re.search(r"```yaml\n(.*?)```", (EXAMPLES.parent / "docs" / "sweep.md").read_text(), re.DOTALL)
    file = next(path for path in shipped.begin(tmp_path / "mysweep", "sweep") if path.name == "small_drum.yaml")
    assert block is not None and yaml.safe_load(block[1]) == yaml.safe_load(file.read_text())
    asked = plan.read(file, tmp_path / "out", tmp_path / "store")
    predicted = asked.cost()
    assert len(asked.runs) == len(predicted) == 24
    assert sum(cost.seconds for _, cost in predicted) < 360.0


@pytest.mark.parametrize(("name", "outputs"), [("deck", 125), ("drum", 50)])
def test_the_prediction_has_the_outputs_of_the_run(name: str, outputs: int) -> None:
    """A deck of 2.5 s stores an output every 0.02 s, as it has outlets; a drum fifty. The memory is that of the replay."""
    scene = pywet.read_scene(EXAMPLES / "scenes" / f"{name}.yaml")
    asked = scene.results.model_copy(update={"interval_s": scene.duration_s / outputs})
    assert scene.results.interval_s is None and len(Building(scene).scene().output_steps) == 1 + outputs
    cost, spheres = costs.of_scene(Building(scene)), sum(c.count for c in Building(scene).classes)
    assert cost == costs.of_scene(Building(scene.with_(results=asked)))
    assert cost.memory_B == needs.REPLAY_B + needs.REPLAY_SPHERE_B * spheres


@pytest.mark.parametrize("duration", [0.8, 2.5, 10.0])
def test_a_continuous_deck_is_predicted_by_the_spheres_on_it(duration: float) -> None:
    """A deck of 160 mm at 2 mm and 20 Hz: for 2 · 160 mm/(0.251 m/s) = 1.27 s each, fed at a constant rate over the run.

    Of N spheres those of the last 1.27 s are there at the end: the mean is N t/T (1 - t/(2 T)), with 1.27 s for t, and N/2
    if all stay. Shortly before they enter they exist as well.
    """
    scene = pywet.read_scene(EXAMPLES / "scenes" / "deck.yaml")
    insertion = scene.feed[0].insertion.model_copy(update={"for_s": duration})
    inserted = scene.with_(duration_s=duration, feed=(scene.feed[0].model_copy(update={"insertion": insertion}),))
    made = Building(inserted)
    number, share = sum(c.count for c in made.classes), min(0.16 / (20 * 2 * math.pi * 0.002) * 2 / duration, 1.0)
    held, entered = costs.present(made)
    assert entered == pytest.approx(number * share * (1.0 - 0.5 * share), rel=0.01)
    assert made.ahead_s is not None and entered < held < entered + 1.01 * number * made.ahead_s / duration
    resting = scene.deck.stroke.model_copy(update={"amplitude_mm": 0.5})
    still = Building(inserted.with_(deck=scene.deck.model_copy(update={"stroke": resting})))
    assert costs.present(still)[1] == pytest.approx(0.5 * number, rel=0.01)
    assert costs.of_scene(still).memory_B == costs.of_scene(made).memory_B


def test_without_outlets_inserted_spheres_exist_from_the_start() -> None:
    """They are moved while they wait, but touch nothing: half of them on average, and those that lie there from the start."""
    box = {"low_mm": (0, 0, 0), "high_mm": (20, 20, 20)}
    entry = {"material": "glass", "diameter_mm": 3, "box": box, "count": 10}
    later = {
        **entry,
        "name": "b",
        "box": {"low_mm": (0, 0, 30), "high_mm": (20, 20, 40)},
        "velocity_m_per_s": (0, 0, -1),
    }
    scene = pywet.Scene(
        name="a", duration_s=0.2, materials={"glass": pywet.Material(density_kg_per_m3=2500)},
        spheres=[{**entry, "name": "a"}, {**later, "insertion": {"for_s": 0.2}}],
    )  # fmt: skip
    assert costs.present(Building(scene)) == pytest.approx((20.0, 15.0))


def test_results_of_a_deck_have_names() -> None:
    """Walls of a deck and sizes of a feed are gathered by name as those that the scene lists itself."""
    names = run_numbers.of_scene(pywet.read_scene(EXAMPLES / "scenes" / "deck.yaml"))
    assert {"liquid_wall_screen_share", "liquid_wall_cross_wires_share"} <= {*names}
    assert sum(name.startswith("liquid_spheres_ore_") and name.endswith("_share") for name in names) == 6
    assert {"liquid_outlet_overs_share", "screen_d50_mm", "screen_efficiency", "screen_pegged_share"} <= {*names}
    drum = run_numbers.of_scene(pywet.read_scene(EXAMPLES / "scenes" / "drum.yaml"))
    assert not any(name.startswith("screen_") for name in drum)
