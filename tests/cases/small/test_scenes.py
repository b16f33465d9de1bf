"""Small scenes: what must come out of them, and that the independent replay agrees."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from pywet.cases.small import scenes, small
from pywet.cases.small.bodies import drum_walls
from pywet.cli.app import app
from pywet.laws import registry
from pywet.scene import EngineScene, Rotation
from reference_impl.replay.replay import replay
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of
from tests.error_codes import code_of, raises_code

pytestmark = pytest.mark.engine
WORKS = ["gravity", "contact", "capillary", "viscous_normal", "viscous_tangential", "wall_motion", "drive"]


def test_pull(tmp_path: Path) -> None:
    """The bridge breaks within a step's way behind the dynamic rupture distance; the CLI prints what the function returns."""
    done = CliRunner().invoke(app, ["scene", "pull", "--out", str(tmp_path), "--speed", "0.05"])
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / scenes.RESULT).read_text())
    assert f"{found['largest_force_N']:.6g}" in done.output
    event = pd.read_parquet(tmp_path / "history" / "events.parquet").query("kind == 1").iloc[0]
    limit = event["rupture_distance"] * (1.0 + math.sqrt(0.05 * 1e-3 / 0.0728))
    assert limit <= found["rupture_distance_m"] < limit + 0.05 * 1e-5 * 1.001
    angle = math.radians(15.0)
    r, volume = scenes.Choice().radius_m, float(event["volume"])
    touch = registry.get("capillary", "rabinovich").functions[0](0.0, volume, r, r, angle, angle, 0.0728)
    assert found["largest_force_N"] > touch


@pytest.mark.parametrize(
    ("speed", "percent", "viscosity"), [(0.05, 1.0, 1e-3), (1.0, 1.0, 1e-3), (0.05, 20.0, 1e-3), (0.5, 10.0, 0.1)]
)
def test_the_first_force_of_a_pull_and_its_end_at_any_speed(
    tmp_path: Path, speed: float, percent: float, viscosity: float
) -> None:
    """The largest force is that at touch by the laws; 5 %: the bridge acts from the first steps on, which are S_min/50 long."""
    choice = scenes.Choice(speed_m_per_s=speed, moisture_percent=percent, viscosity_Pa_s=viscosity)
    found = scenes.run("pull", tmp_path, choice)
    volume = float(pd.read_parquet(tmp_path / "history" / "events.parquet")["volume"].iloc[0])
    r, angle = choice.radius_m, math.radians(15.0)
    touch = registry.get("capillary", "rabinovich").functions[0](0.0, volume, r, r, angle, angle, 0.0728)
    touch -= registry.get("viscous_normal", "pitois").functions[0](0.0, volume, r, r, speed, viscosity)
    assert 0.95 * touch < found["largest_force_N"] <= touch
    assert found["rupture_distance_m"] > 0.25 * r


def test_a_pull_that_ends_before_the_rupture_is_named(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert math.isnan(scenes.run("pull", tmp_path, scenes.Choice(seconds=1e-3))["rupture_distance_m"])
    assert "the bridge has not ruptured after 0.001 s" in caplog.text


def test_collision_loses_more_with_more_liquid(tmp_path: Path) -> None:
    """Dry restitution is 0.8; a thin film takes some of it, and more viscous liquid more."""
    thin, thick = (
        scenes.run("collision", tmp_path / f"{eta}", scenes.Choice(viscosity_Pa_s=eta, moisture_percent=0.2))[
            "restitution"
        ]
        for eta in (1e-3, 1e-2)
    )
    assert 0.0 <= thick < thin < 0.8


@pytest.mark.parametrize(("speed", "parts", "times"), [(2.0, True, 5.0), (0.5, False, 2.0)])
def test_the_restitution_does_not_depend_on_the_end_of_the_run(
    tmp_path: Path, speed: float, parts: bool, times: float
) -> None:
    """10 % of a liquid of 0.1 Pa s: fast spheres part, slow ones are held by the bridge, by default and in a longer run."""
    choice = scenes.Choice(moisture_percent=10.0, viscosity_Pa_s=0.1, speed_m_per_s=speed)
    found = scenes.run("collision", tmp_path / "default", choice)["restitution"]
    lasts = EngineScene.read(tmp_path / "default" / "scene.json").duration_s
    longer = scenes.run("collision", tmp_path / "longer", replace(choice, seconds=times * lasts))["restitution"]
    assert (found > 0.0) is parts and found == pytest.approx(longer, rel=1e-9)


def test_a_run_that_ends_before_the_spheres_part_knows_no_restitution(tmp_path: Path) -> None:
    """Before they touch, and while the bridge between them is drawn; a notice says so, and the file holds null."""
    choice = scenes.Choice(moisture_percent=0.2)
    assert scenes.run("collision", tmp_path / "whole", choice)["restitution"] > 0.0
    events = pd.read_parquet(tmp_path / "whole" / "history" / "events.parquet").set_index("kind")["time"]
    for name, seconds in (("before", 0.5 * events[0]), ("drawn", 0.9 * events[1])):
        found = scenes.run("collision", tmp_path / name, replace(choice, seconds=float(seconds)))
        assert math.isnan(found["restitution"])
        assert json.loads((tmp_path / name / scenes.RESULT).read_text())["restitution"] is None


def test_a_scene_with_hertz_contacts(tmp_path: Path) -> None:
    """`--contact hertz` takes the modulus that is given; a collision returns less than the dry 0.8, and its replay agrees."""
    words = ["scene", "collision", "--moisture", "0.2", "--contact", "hertz", "--youngs-modulus", "2e7"]
    done = CliRunner().invoke(app, [*words, "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    scene = EngineScene.read(tmp_path / "scene.json")
    assert scene.hertz is not None and scene.hertz.spheres[0].youngs_modulus_Pa == 2e7
    found = json.loads((tmp_path / scenes.RESULT).read_text())
    assert 0.5 < found["restitution"] < 0.8 and replay(tmp_path)["ok"]
    refused = CliRunner().invoke(app, [*words, "--contact", "jkr", "--out", str(tmp_path)])
    assert (refused.exit_code, code_of(refused)) == (1, "small.contact_model")


def test_bed_comes_to_rest(tmp_path: Path) -> None:
    """A bed of 125 moist spheres: slow, as dense as a loose to random packing, held by bridges; replay agrees."""
    found = scenes.run("bed", tmp_path, scenes.Choice(spheres=125, seconds=0.25))
    assert found["mean_speed_m_per_s"] < 0.01
    assert 0.3 < found["solid_fraction"] < 0.64
    assert found["bridges_per_sphere"] > 3.0
    assert replay(tmp_path)["ok"]


def test_turning_wall_carries_its_velocity(tmp_path: Path) -> None:
    """A sphere held over a turning disc: the wall's velocity at the closest point is omega x r, liquid and work included."""
    r, at, period = 2.5e-3, 0.02, 0.05
    mantle, low, _ = drum_walls(0.04, 0.02)
    bodies = [small.Sphere(1, (at, 0.0, -0.01 + r + 1e-4), driven=True)]
    small.prepare(
        tmp_path, spheres_of(r), bodies, contacts(1), liquid=WATER, effects=small.PAPER, walls=[mantle, low],
        wall_angle_rad=0.5, time_step_s=1e-5, steps=1500, output_interval_s=1e-3,
        rotation=Rotation(origin_m=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), period_s=period),
    )  # fmt: skip
    small.run(tmp_path, bodies)
    log = pd.read_parquet(tmp_path / "history" / "contacts.parquet")
    late = log[log["step"] > 0]
    speed = 2.0 * math.pi / period * at
    assert len(late) > 1000 and len(late["triangle"].unique()) > 1
    assert np.abs(late["vj_y"] - speed).max() < 1e-9 * speed and np.abs(late["vj_x"]).max() < 1e-9 * speed
    assert np.abs(late[["xj_x", "xj_y"]].to_numpy() - [at, 0.0]).max() < 1e-9
    energy = pd.read_parquet(tmp_path / "history" / "energy.parquet").iloc[-1]
    drag = late["viscous_tangential_y"].to_numpy()
    assert energy["wall_motion"] == pytest.approx(drag.sum() * speed * 1e-5, rel=5e-3)
    assert replay(tmp_path)["ok"]


def test_a_drum_turns_by_half_a_turn_at_least(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """30 s at one turn a minute, 1.5 s at 20 and more."""
    asked: list[float] = []
    monkeypatch.setattr(scenes, "_run", lambda *given, **_: asked.append(given[5]))
    for turns in (1.0, 20.0, 60.0):
        with raises_code("run.no_scene"):
            scenes.drum(tmp_path, scenes.Choice(spheres=60, turns_per_minute=turns))
    assert asked == pytest.approx([30.0, 1.5, 1.5])


def test_drum(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Sixty moist spheres in a turning drum lean to the rising side; the budget of energy closes to round-off, walls turning."""
    found = scenes.run("drum", tmp_path, scenes.Choice(spheres=60, seconds=0.25, turns_per_minute=40.0))
    assert 5.0 < found["dynamic_angle_deg"] < 80.0
    assert "the drum turned by 30° before its angle was averaged" in caplog.text
    energy = pd.read_parquet(tmp_path / "history" / "energy.parquet")
    moving = energy["kinetic"] + energy["spin"]
    left = moving - moving.iloc[0] - energy[WORKS].sum(axis=1) - energy["half_kick"]
    assert left.abs().max() < 1e-12 * energy[WORKS].abs().sum(axis=1).max()
    assert energy["wall_motion"].iloc[-1] > 0.0
    assert replay(tmp_path)["ok"]


@pytest.mark.slow
def test_angle_grows_with_moisture(tmp_path: Path) -> None:
    """The dynamic angle of 400 spheres is steeper with 1 % of water than with none worth naming."""
    angles = [
        scenes.run("drum", tmp_path / f"{moisture}", scenes.Choice(spheres=400, moisture_percent=moisture, seconds=1.5))
        for moisture in (1e-3, 1.0)
    ]
    assert angles[1]["dynamic_angle_deg"] > angles[0]["dynamic_angle_deg"] + 2.0


def test_unknown_scene(tmp_path: Path) -> None:
    """The sentence lists what exists."""
    with raises_code("small.unknown_scene"):
        scenes.run("chute", tmp_path)
