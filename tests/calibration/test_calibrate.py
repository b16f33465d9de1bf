"""`pywet calibrate` from file to answer: hidden values found again, stored runs not repeated, mistakes in a sentence."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from scipy import stats
from typer.testing import CliRunner

from pywet import scene_stages as commands
from pywet.calibration import answer as answering
from pywet.calibration import experiments
from pywet.calibration import question as asking
from pywet.calibration.search import find
from pywet.cli.app import app
from pywet.engines.liggghts import build
from pywet.util import sources
from tests.error_codes import code_of, raises_code

EXAMPLES = Path(__file__).parents[2] / "examples"
PULL = {
    "name": "surface tension from a pull",
    "targets": [{"bridge": str(EXAMPLES / "bridge.json"), "changes": {"laws": ["willett"]}, "quantity": "pull_off_force_N",
                 "value": 7e-4, "scatter": 4e-5}],
    "parameters": {"surface tension": {"keys": ["surface_tension_N_per_m"], "low": 0.02, "high": 0.1}},
}  # fmt: skip


SIEVED = {"name": "rest", "material": "glass", "mass_g": 1.0, "psd": {"file": "sieve.csv"},
          "box": {"low_mm": [-13, 1, -14], "high_mm": [13, 11, 14]}}  # fmt: skip
"""Feed with a sieve analysis."""


def ask(folder: Path, content: dict[str, Any]) -> Path:
    """A file of a calibration."""
    path = folder / "ask.yaml"
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    return path


def held(file: Path, hidden: dict[str, float], random: np.random.Generator) -> list[bool]:
    """Targets made with hidden values (by name) and noise of their scatter: whether each value is in its interval."""
    question, asked = asking.read(file)
    settings = {key: hidden[name] for name, p in question.parameters.items() for key in p.keys}
    targets = tuple(
        t.model_copy(update={"value": e.value(t.quantity, settings) + random.normal(0, t.error)})
        for t, e in zip(question.targets, asked, strict=True)
    )
    question = question.model_copy(update={"targets": targets})
    solved = find(question, asked, file.parent, 1, print).problem
    return [
        any(p.at(r.low) <= hidden[name] <= p.at(r.high) for r in solved.intervals(k))
        for k, (name, p) in enumerate(question.parameters.items())
    ]


def test_two_hundred_hidden_surface_tensions(tmp_path: Path) -> None:
    """190 are expected within 95 %; 180 and 199 are three standard deviations away."""
    file, random = ask(tmp_path, PULL), np.random.default_rng(7)
    inside = [held(file, {"surface tension": s}, random)[0] for s in random.uniform(0.03, 0.09, 200)]
    assert 180 <= sum(inside) <= 199
    assert sum(inside[:10]) >= 9  # at least nine of ten hidden values


def test_ten_hidden_viscosities(tmp_path: Path) -> None:
    """Find ten hidden viscosities of a layer from rebounds at two speeds: nine or ten intervals contain them."""
    content = yaml.safe_load((EXAMPLES / "calibrations" / "binder.yaml").read_text())
    targets = [{**t, "wall": str(EXAMPLES / "wall_wet.json")} for t in content["targets"]]
    viscosity = {"viscosity": content["parameters"]["viscosity in Pa s"]}
    file, random = ask(tmp_path, {**content, "targets": targets, "parameters": viscosity}), np.random.default_rng(3)
    assert sum(held(file, {"viscosity": v}, random)[0] for v in random.uniform(1e-3, 3e-3, 10)) >= 9


def test_two_parameters_of_one_target_are_reported_indistinguishable(tmp_path: Path) -> None:
    """Surface tension and contact angle of one pull-off force; each pair of values that fit alike gives that force."""
    angle = {"keys": ["bodies.0.contact_angle_deg", "bodies.1.contact_angle_deg"], "low": 0.0, "high": 60.0}
    file = ask(tmp_path, {**PULL, "parameters": {**PULL["parameters"], "contact angle": angle}})  # type: ignore[dict-item]
    answer = answering.calibrate(file, tmp_path / "out")
    (group,) = answer["not_told_apart"]
    assert group["parameters"] == ["surface tension", "contact angle"]
    assert sum("surface tension and contact angle cannot be distinguished" in line for line in answer["sentences"]) == 1
    _, (pull,) = asking.read(file)
    for row in group["alike"]:
        settings = {
            "surface_tension_N_per_m": row["surface tension"],
            **dict.fromkeys(angle["keys"], row["contact angle"]),
        }
        assert abs(pull.value("pull_off_force_N", settings) - 7e-4) <= 1.97 * 4e-5
    assert json.loads((tmp_path / "out" / "calibration.json").read_text())["not_told_apart"] == [group]


def test_what_does_not_matter_and_what_is_not_reached_are_reported(tmp_path: Path) -> None:
    """Viscosity in a static force; a force that no surface tension between the bounds gives, which is exit code 1."""
    viscosity = {"keys": ["viscosity_Pa_s"], "low": 1e-3, "high": 1e-1, "log": True}
    idle = ask(tmp_path, {**PULL, "parameters": {"viscosity": viscosity, **PULL["parameters"]}})  # type: ignore[dict-item]
    lines = answering.calibrate(idle, tmp_path / "idle")["sentences"]
    assert any(line.startswith("viscosity cannot be determined") for line in lines)
    far = ask(tmp_path, {**PULL, "targets": [{**PULL["targets"][0], "value": 5e-3}]})  # type: ignore[dict-item]
    done = CliRunner().invoke(app, ["calibrate", str(far), "--out", str(tmp_path / "far")])
    assert done.exit_code == 1 and "no values between the bounds reproduce the targets" in done.stdout
    assert "ends at 0.1 because that is its bound" in done.stdout
    assert (tmp_path / "far" / "calibration.svg").read_text().startswith("<?xml")


def test_an_interval_cut_off_by_the_search_is_not_called_one_at_its_bound(tmp_path: Path) -> None:
    """Bounds 0.1 to 0.9 and intervals that are open above at 0.4 and at 0.9."""
    question, _ = asking.read(ask(tmp_path, PULL))
    for high, says in ((0.4, "friction is cut off at 0.4"), (0.9, "friction ends at 0.9 because that is its bound")):
        interval = {"low": 0.25, "high": high, "open_low": False, "open_high": True}
        friction = {"best": 0.3, "bounds": [0.1, 0.9], "intervals": [interval]}
        answer = {"parameters": {"friction": friction}, "targets": [], "reached": True, "not_told_apart": []}
        assert any(line.startswith(says) for line in answering.sentences(question, answer))


def bridges_of(scene: Any) -> float:
    """Ten times the friction, scattered by the seed; no number for a high friction."""
    friction = scene.materials["glass"].friction
    noise = np.random.default_rng(scene.seed).normal(0, 0.1)
    return float(10 * friction + noise) if friction < 0.45 else np.nan


@pytest.fixture
def engine(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """In place of the engine: `bridges_of` a scene; the scenes that ran."""
    ran: list[Any] = []

    def run(scene: Any, folder: Path, ranks: int) -> Any:
        assert ranks == 1
        ran.append(scene)
        folder.mkdir(parents=True)
        return SimpleNamespace(contact_statistics=pd.DataFrame({"bridges_per_sphere": [bridges_of(scene)]}))

    monkeypatch.setattr(commands, "run", run)
    return ran


def drum(folder: Path, **parameter: Any) -> Path:
    """A question to the small drum."""
    target = {
        "scene": str(EXAMPLES / "calibrations" / "small_drum.yaml"),
        "quantity": "bridges_per_sphere",
        "value": 3.0,
    }
    friction = {"keys": ["materials.glass.friction"], "low": 0.1, "high": 0.44, **parameter}
    return ask(folder, {"name": "n", "targets": [{**target, "scatter": 0.3}], "parameters": {"friction": friction}})


def test_runs_have_distinct_seeds_and_are_stored(tmp_path: Path, engine: list[Any]) -> None:
    """Friction 0.3 ± 0.06; called again nothing runs again, and where a file is gone that run alone."""
    output_text: list[str] = []
    first = answering.calibrate(drum(tmp_path), tmp_path / "out", say=output_text.append)
    count = len(engine)
    assert len({scene.seed for scene in engine}) == count == first["runs"]["count"] + 3 == len(output_text) + 3
    assert "this round ends in about" in output_text[0] and "this round ends in about 0 s," in output_text[-1]
    (friction,) = first["parameters"]["friction"]["intervals"]
    assert 0.5 * (friction["low"] + friction["high"]) == pytest.approx(0.3, abs=0.02)
    assert friction["high"] - friction["low"] == pytest.approx(0.12, abs=0.03)
    assert first["check"][0]["mean"] == pytest.approx(3.0, abs=0.3)
    low, high = stats.t(2, scale=stats.sem([bridges_of(scene) for scene in engine[-3:]])).interval(first["confidence"])
    assert first["check"][0]["half_width"] == pytest.approx(0.5 * (high - low), rel=1e-9)
    assert answering.calibrate(drum(tmp_path), tmp_path / "out")["parameters"] == first["parameters"]
    assert len(engine) == count
    lost = next((tmp_path / "out" / "runs").iterdir())
    (lost / "calibration.json").unlink()
    lost.rmdir()
    answering.calibrate(drum(tmp_path), tmp_path / "out")
    assert len(engine) == count + 1


@pytest.fixture
def fresh() -> Iterator[None]:
    """The program's hash is worked out again, before and after."""
    experiments._program.cache_clear()
    yield
    experiments._program.cache_clear()


@pytest.mark.parametrize("changed", ["law", "wall", "sieve", "plugin", "engine", "order", None])
def test_a_stored_run_is_of_the_same_law_plugin_and_engine(
    changed: str | None, tmp_path: Path, engine: list[Any], fresh: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A changed law, STL file, sieve analysis, source of the plugin or version of the engine: the run is done again; else, as
    where materials are in another order, it is not."""
    scene = yaml.safe_load((EXAMPLES / "calibrations" / "small_drum.yaml").read_text())
    scene["materials"] |= {"steel": {"density_kg_per_m3": 7850}}
    file, law, plugin = tmp_path / "scene.yaml", tmp_path / "mine.py", tmp_path / "plugin"
    walls = [*scene["walls"], {"name": "lid", "stl": "lid.stl"}]
    more = {"walls": walls, "feed": [SIEVED], "laws": {"capillary": "mine.py:pull"}}
    file.write_text(yaml.safe_dump({**scene, **more}, sort_keys=False))
    (tmp_path / "lid.stl").write_text("solid lid")
    (tmp_path / "sieve.csv").write_text("1,2,60\n2,3,40\n")
    law.write_text("def pull(): return 1")
    shutil.copytree(build.SOURCES, plugin)
    others = [path for path in sources.of_a_run() if build.SOURCES not in path.parents]
    monkeypatch.setattr(sources, "of_a_run", lambda: [*others, *sorted(plugin.rglob("*.*"))])
    monkeypatch.setattr(experiments, "package_version", lambda package: "3.8")

    def run() -> None:
        experiments._program.cache_clear()
        experiments.Experiment.read("scene", file, {}).run(
            ("bridges_per_sphere",), {"materials.glass.friction": 0.3}, 0, tmp_path / "runs", 1
        )

    run()
    if changed == "law":
        law.write_text("def pull(): return 2")
    elif changed == "wall":
        (tmp_path / "lid.stl").write_text("solid lid ")
    elif changed == "sieve":
        (tmp_path / "sieve.csv").write_text("1,2,50\n2,3,50\n")
    elif changed == "plugin":
        source = next(plugin.glob("*.cpp"))
        source.write_text(source.read_text() + "\n")
    elif changed == "engine":
        monkeypatch.setattr(experiments, "package_version", lambda package: "3.9")
    elif changed == "order":
        given = yaml.safe_load(file.read_text())
        file.write_text(
            yaml.safe_dump({**given, "materials": dict([*given["materials"].items()][::-1])}, sort_keys=False)
        )
    run()
    assert len(engine) == (1 if changed in (None, "order") else 2)


@pytest.mark.parametrize("changed", ["mine.py", "lid.stl", "sieve.csv"])
def test_another_file_that_a_target_names_is_another_question(changed: str, tmp_path: Path, engine: list[Any]) -> None:
    """The answer with the former law, STL file or sieve analysis is stored under a number; with the same files it is replaced."""
    scene = yaml.safe_load((EXAMPLES / "calibrations" / "small_drum.yaml").read_text())
    for name in ("mine.py", "lid.stl", "sieve.csv"):
        (tmp_path / name).write_text("1,2,60\n2,3,40\n")
    more = {"walls": [*scene["walls"], {"name": "lid", "stl": "lid.stl"}], "feed": [SIEVED]}
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump({**scene, **more, "laws": {"capillary": "mine.py:pull"}}))
    content = yaml.safe_load(drum(tmp_path).read_text())
    content["targets"][0]["scene"] = "scene.yaml"
    out, lines = tmp_path / "out", list[str]()
    for _ in range(2):
        answering.calibrate(ask(tmp_path, content), out, say=lines.append)
    assert not (out / "calibration.1.json").exists()
    (tmp_path / changed).write_text("1,2,50\n2,3,50\n")
    answering.calibrate(ask(tmp_path, content), out, say=lines.append)
    assert (out / "calibration.1.json").exists()


def test_a_changed_law_of_a_bridge_is_another_question(tmp_path: Path) -> None:
    content = {**PULL, "targets": [{**PULL["targets"][0], "changes": {"laws": [f"{tmp_path}/mine.py:pull"]}}]}  # type: ignore[index]
    words = set()
    for force in (1, 2):
        (tmp_path / "mine.py").write_text(
            "def pull(separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension):\n"
            f"    return {force}\n"
        )
        words.add(answering.fingerprint(*asking.read(ask(tmp_path, content))))
    assert len(words) == 2


def test_a_run_without_a_number_ends_in_a_sentence(tmp_path: Path, engine: list[Any]) -> None:
    with raises_code("calibration.no_number", key="bridges_per_sphere"):
        answering.calibrate(drum(tmp_path, high=0.5), tmp_path / "out")


def test_runs_that_no_polynomial_follows_are_reported(
    tmp_path: Path, engine: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        sys.modules[__name__], "bridges_of", lambda s: 3.0 + np.sin(40.0 * s.materials["glass"].friction)
    )
    lines = answering.calibrate(drum(tmp_path), tmp_path / "out")["sentences"]
    assert any("do not follow the polynomial" in line for line in lines)


def test_a_seed_of_a_scene_that_is_no_number_is_one_sentence(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text((EXAMPLES / "calibrations" / "small_drum.yaml").read_text() + "\nseed: one\n")
    with raises_code("calibration.bounds", "scene.yaml: seed is 'one', expected"):
        experiments.Experiment.read("scene", file, {}).built({}, 1)


def test_the_answer_to_another_question_is_renamed(tmp_path: Path) -> None:
    """The same file again replaces its answer; another file, or an answer that cannot be read, keeps the first under a number."""
    out, lines = tmp_path / "out", list[str]()
    answering.calibrate(ask(tmp_path, PULL), out)
    first = (out / "calibration.json").read_bytes()
    answering.calibrate(ask(tmp_path, PULL), out, say=lines.append)
    assert (out / "calibration.json").read_bytes() == first and sorted(p.name for p in out.glob("*.1.*")) == []
    other = json.loads(json.dumps(PULL))
    other["targets"][0]["value"] = 6e-4
    answering.calibrate(ask(tmp_path, other), out, say=lines.append)
    assert (out / "calibration.1.json").read_bytes() == first and (out / "calibration.1.svg").exists()
    assert "calibration.1.json" in lines[-1]
    (out / "calibration.json").write_text("broken")
    answering.calibrate(ask(tmp_path, other), out)
    assert (out / "calibration.2.json").read_text() == "broken"


def test_bounds_belong_to_what_is_accepted(tmp_path: Path) -> None:
    """Two measurements tell their scatter with one degree of freedom; one does not tell it."""
    target = PULL["targets"][0]  # type: ignore[index]
    for change in ({"confidence": 0.5}, {"confidence": 0.999}, {"most_runs": 10}, {"seeds": 2}, {"check_runs": 2}):
        asking.read(ask(tmp_path, {**PULL, **change}))
    for given, freedom in (
        ({}, np.inf),
        ({"repeats": 1}, np.inf),
        ({"repeats": 2}, 1.0),
        ({"repeats": 10_000}, 9999.0),
    ):
        question, _ = asking.read(ask(tmp_path, {**PULL, "targets": [{**target, **given}]}))
        assert question.targets[0].freedom == freedom
        assert question.targets[0].error == pytest.approx(4e-5 / np.sqrt(given.get("repeats", 1)), rel=1e-12)


def test_mistakes_of_the_file(tmp_path: Path) -> None:
    """One sentence for each: what was given, what was expected."""
    target, tension = PULL["targets"][0], PULL["parameters"]["surface tension"]  # type: ignore[index,call-overload]
    for change, code, words in (
        ({"targets": [{**target, "quantity": "e_n"}]}, "config.inconsistent", "quantity to be one of pull_off_force_N"),
        ({"targets": [{**target, "wall": "x.json"}]}, "config.inconsistent", "one of bridge, wall, scene, not bridge and wall"),
        ({"targets": [{**target, "bridge": "none.json"}]}, "file.unread", ""),
        ({"targets": [{**target, "scatter": 0}]}, "config.value", "targets.0.scatter is 0"),
        ({"targets": [{**target, "changes": {"lawz": []}}]}, "calibration.unknown_key", ""),
        ({"targets": [{**target, "changes": {}}]}, "bridge.capillary_laws", ""),
        ({"parameters": {"s": {**tension, "low": 0.2}}}, "config.inconsistent", "low less than high"),
        ({"parameters": {"s": {**tension, "low": 0.0, "log": True}}}, "config.inconsistent", "more than 0, as log is true"),
        ({"parameters": {"s": {**tension, "keys": ["sigma"]}}}, "calibration.parameter_key", ""),
        ({"parameters": {"s": {**tension, "high": 7e6}}}, "calibration.bounds", ""),
        ({"parameters": dict.fromkeys("abcd", tension)}, "config.value", "at most 3 items"),
        ({"most_runs": 5}, "config.inconsistent", "most_runs of at least 10"),
        ({"seed": 3}, "config.unknown_key", "key seed is not known"),
    ):  # fmt: skip
        done = CliRunner().invoke(
            app, ["calibrate", str(ask(tmp_path, {**PULL, **change})), "--out", str(tmp_path / "out")]
        )
        output_text = " ".join(done.stderr.split())
        assert (done.exit_code, code_of(done)) == (1, code) and words in output_text, output_text
