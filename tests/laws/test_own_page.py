"""docs/howto-own-law.md as a reader follows it: the example as it is printed, in a configuration and as a single bridge."""

from __future__ import annotations

import json
import math
import re
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pywet import config
from pywet.cli.app import app
from pywet.laws import own
from pywet.screening import cases

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "howto-own-law.md").read_text()


def block(language: str) -> str:
    """The first block of a language on the page."""
    found = re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found
    return found.group(1)


@pytest.fixture
def followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the page's law and bridge, and a configuration that names the law, in a cache of its own."""
    monkeypatch.setenv("PYWET_CACHE", str(tmp_path / "cache"))
    study = tmp_path / "study"
    shutil.copytree(ROOT / "config", study)
    text = (study / "config.yaml").read_text()
    (study / "config.yaml").write_text(re.sub(r"^laws:\n(  .*\n)+", block("yaml"), text, count=1, flags=re.MULTILINE))
    (study / "my_law.py").write_text(block("python"))
    (study / "my_bridge.json").write_text(block("json"))
    return study


def test_a_configuration_finds_the_law_beside_it(followed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From whichever folder pywet is called; the plan has tried it."""
    monkeypatch.chdir("/")
    loaded = config.load(followed)
    assert loaded.settings.laws.capillary == f"{followed / 'my_law.py'}:constant_neck"
    plan = cases.effect_plan(loaded, 2, "smoke")
    assert plan.effects.capillary == f"{followed / 'my_law.py'}:constant_neck"


def test_the_law_of_a_run_is_tried_before_it_starts(followed: Path) -> None:
    law = followed / "my_law.py"
    law.write_text(law.read_text().replace("return 4.0", "return -4.0"))
    done = CliRunner().invoke(app, ["run", "2", "--config", str(followed), "--out", str(followed / "run")])
    assert done.exit_code == 1 and "expected a force of 0 or more" in done.stderr
    assert not (followed / "run" / "engine").exists()


@pytest.mark.engine
def test_the_bridge_of_the_page(followed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In Python and inside the engine the force is 4 pi sigma r_red cos(theta), whatever the gap."""
    monkeypatch.chdir(followed)
    wanted = 4.0 * math.pi * 0.0728 * 0.00125 * math.cos(math.radians(10.0))
    for more in ([], ["--engine", "liggghts"]):
        done = CliRunner().invoke(app, ["bridge", "my_bridge.json", "--trust", *more])
        assert done.exit_code == 0, done.stderr
        forces = json.loads(done.stdout)["force_N"]
        assert forces[f"{followed / 'my_law.py'}:constant_neck"] == pytest.approx([wanted] * 3, rel=1e-9)


LAWS = """
from pywet.laws.force_law import force_law

@force_law
def longer(volume, radius_i, radius_j, contact_angle_i, contact_angle_j):
    return 2.0 * volume ** (1.0 / 3.0)

@force_law
def drag(separation, volume, radius_i, radius_j, normal_velocity, viscosity):
    return -1e-3 * normal_velocity

@force_law
def slip(separation, radius_i, radius_j, viscosity):
    return 3.0 * viscosity * radius_i

@force_law
def steady(speed, viscosity, surface_tension):
    return 1.25

@force_law
def nearly(volume, radius_i, radius_j, angle_i, angle_j):
    return 1.0

sideways = (slip, slip)
"""


def test_a_bridge_takes_laws_of_every_kind_that_it_asks(followed: Path) -> None:
    """Each is told by its arguments; what they give is in the answer under their names."""
    file, query = followed / "laws.py", json.loads(block("json"))
    file.write_text(LAWS)
    query["laws"] = [f"laws.py:{name}" for name in ("longer", "drag", "sideways", "steady")]
    (followed / "q.json").write_text(json.dumps({**query, "velocity_m_per_s": 0.1, "viscosity_Pa_s": 0.01}))
    done = CliRunner().invoke(app, ["bridge", str(followed / "q.json"), "--trust"])
    assert done.exit_code == 0, done.stderr
    answer = json.loads(done.stdout)
    distance = 2.0 * 1e-10 ** (1 / 3)
    assert answer["rupture_distance_m"][f"{file}:longer"] == pytest.approx(distance)
    assert answer["rupture_used_m"]["rabinovich"] == pytest.approx(distance)
    assert answer["viscous_normal_N"][f"{file}:drag"] == pytest.approx([1e-4] * 3)
    assert answer["viscous_tangential_kg_per_s"][f"{file}:sideways"] == [pytest.approx([3e-2 * 0.0025] * 3)] * 2
    assert answer["dynamic_rupture_factor"] == 1.25


def test_a_law_of_other_arguments_is_told_what_its_kind_expects(followed: Path) -> None:
    (followed / "laws.py").write_text(LAWS)
    name = f"{followed / 'laws.py'}:nearly"
    assert own.kind_of(name) == "rupture"
    (followed / "q.json").write_text(json.dumps({**json.loads(block("json")), "laws": [name]}))
    done = CliRunner().invoke(app, ["bridge", str(followed / "q.json"), "--trust"])
    assert done.exit_code == 1
    assert "expected (volume, radius_i, radius_j, contact_angle_i, contact_angle_j)" in done.stderr
