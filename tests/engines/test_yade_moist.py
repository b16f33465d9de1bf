"""YADE with the plugin: small moist scenes that the reference replays, and the same scenes in LIGGGHTS.

Each run takes some four seconds of processor time, most of it the start of Python, YADE and the laws.
"""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import bodies, small
from pywet.cases.small.bodies import contacts, sphere_classes, water
from pywet.engines.yade import driver, memory
from pywet.errors import EngineError
from pywet.geometry.solids import plate
from pywet.geometry.surface import Surface, make_surface
from pywet.scene import Output, Slide, Vibration
from pywet.schema import RUPTURE
from pywet.util.files import read_json, read_table
from reference_impl.replay.replay import replay
from studies.cross_code import forces
from studies.cross_code.pairs import pairs
from studies.cross_code.replayed import momenta
from tests.engines.liggghts.scenes import THROWN
from tests.error_codes import raises_code

R = 2.5e-3
CLASSES = sphere_classes(R, 2e-3)
needs_yade = pytest.mark.skipif(shutil.which("yade") is None, reason="YADE is not installed: make peers")


def agrees(folder: Path) -> dict[str, Any]:
    """The replay, which finds nothing."""
    found = replay(folder)
    assert found["ok"], [name for name, q in found["quantities"].items() if not q["ok"]]
    assert read_json(folder / "engine" / "run.json", "")["ledger_error"] < 1e-12
    return found


def thrown(folder: Path, engine: str, **how: float) -> pd.DataFrame:
    """Three wet spheres of two sizes that meet, and where they are at the end."""
    small.prepare(
        folder, CLASSES, THROWN, contacts(2, 1e4, **how), liquid=water(1e-4), effects=small.PAPER, time_step_s=1e-5, steps=2500,
        output_interval_s=1e-3,
    )  # fmt: skip
    small.run(folder, THROWN, engine=engine)
    return bodies.last(folder)


@needs_yade
@pytest.mark.engine
def test_free_wet_spheres_are_replayed(tmp_path: Path) -> None:
    """Formation, rupture, sharing, forces, torques, works: all that the reference recomputes agrees; momentum is conserved."""
    thrown(tmp_path, "yade", friction=0.2)
    assert read_json(tmp_path / "engine" / "run.json", "")["engine"] == "YADE"
    found = agrees(tmp_path)
    counts = {name: q["count"] for name, q in found["quantities"].items()}
    looked_at = (
        "volume",
        "share_i",
        "force",
        "torque_i",
        "ledger",
        "energy_budget",
        "flight_place",
        "between_momentum",
    )
    assert min(counts[name] for name in looked_at) > 0
    linear, _, (size, _) = momenta(read_table(tmp_path / "trajectory.parquet"), CLASSES)
    assert np.abs(linear - linear[0]).max() < 1e-12 * size


@needs_yade
@pytest.mark.engine
def test_without_friction_and_dashpot_liggghts_and_yade_end_at_the_same_places(tmp_path: Path) -> None:
    """Springs, bridges, films and leapfrog are then the same, from the first half step on."""
    ends = [thrown(tmp_path / e, e, friction=0.0, restitution=1.0) for e in ("yade", "liggghts")]
    for columns, scale in (([*"xyz"], R), (["vx", "vy", "vz"], 0.1), (["wx", "wy", "wz"], 0.1 / R)):
        assert ends[0][columns].to_numpy() == pytest.approx(ends[1][columns].to_numpy(), abs=1e-7 * scale, rel=0.0)


@needs_yade
@pytest.mark.engine
def test_a_vibrating_plate_and_one_that_is_drawn_away(tmp_path: Path) -> None:
    """Wet spheres on walls that move in YADE: their films and bridges are where the reference has the walls."""
    square = 0.012 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    walls = (
        make_surface("table", "wires", plate(square, -0.002, 0.0), "vibrates"),
        make_surface("belt", "slide", plate(square + np.array([0.03, 0.0]), -0.002, 0.0), "slides"),
    )
    spheres = [small.Sphere(1, (x, 0.001, R + 1e-5)) for x in (0.0, 0.03)] + [small.Sphere(2, (0.004, 0.0, 2.2e-3))]
    small.prepare(
        tmp_path, CLASSES, spheres, contacts(2, 1e3, friction=0.2, rolling_m=2e-5), liquid=water(1e-4), effects=small.PAPER,
        walls=walls, wall_angle_rad=math.radians(45.0), gravity=(0.0, 0.0, -9.81), time_step_s=2e-5, steps=2000,
        output=Output(interval_s=1e-3, contact_windows=2, contact_window_steps=50, energy=False),
        vibration=Vibration(amplitude_m=(2e-4, 0.0, 5e-4), phase_rad=(0.3, 0.0, 0.1), frequency_Hz=50.0),
        slide=Slide(velocity_m_per_s=(0.3, 0.0, 0.0), opens_at_s=0.01, travel_s=0.02),
    )  # fmt: skip
    small.run(tmp_path, spheres, engine="yade")
    found = agrees(tmp_path)
    assert min(found["quantities"][name]["count"] for name in ("capillary", "event_triangle", "snapshot_triangle")) > 0
    assert read_table(tmp_path / "history" / "ledger.parquet")["walls"].max() > 0


@needs_yade
@pytest.mark.engine
def test_bodies_drawn_apart_feel_the_law(tmp_path: Path) -> None:
    """The compiled law called by its address from YADE against the equation of the reference, at every step."""
    pair = pairs()[1]
    log, _ = forces.pulled(pair, "paper", tmp_path, "yade")
    events = read_table(tmp_path / "history" / "events.parquet")
    apart = log[log["separation"] > 0]
    assert len(apart) > 1000
    assert apart["capillary"].to_numpy() == pytest.approx(pair.paper(apart["separation"].to_numpy()), rel=1e-9)
    broken = events.loc[events["kind"] == RUPTURE, "rupture_distance"].to_numpy()
    assert broken == pytest.approx([pair.limit("paper")], rel=1e-9)


@needs_yade
@pytest.mark.engine
def test_rolling_resistance_has_a_constant_torque(tmp_path: Path) -> None:
    """A sphere that rolls on a floor loses 5/7 g mu_r/r per second, whatever its speed, as in LIGGGHTS; one that rests stays."""
    rest = R - CLASSES[0].mass_kg * 9.81 / 1e3
    mu, speed, ends = 2e-4, 0.1, []
    spheres = [
        small.Sphere(1, (0.0, 0.0, rest), (speed, 0.0, 0.0), (0.0, speed / R, 0.0)),
        small.Sphere(1, (0.0, 0.03, rest)),
    ]
    for engine in ("yade", "liggghts"):
        small.prepare(
            tmp_path / engine, CLASSES, spheres, contacts(2, 1e3, friction=0.5, rolling_m=mu), walls=(small.floor(),),
            gravity=(0.0, 0.0, -9.81), time_step_s=2e-5, steps=2000, output_interval_s=4e-4,
        )  # fmt: skip
        small.run(tmp_path / engine, spheres, engine=engine)
        table = read_table(tmp_path / engine / "trajectory.parquet")
        moving = table[table["id"] == 1]
        slope = np.polyfit(moving["time"], moving["vx"], 1)[0]
        assert slope == pytest.approx(-5.0 / 7.0 * 9.81 * mu / R, rel=0.02)
        ends.append(moving["x"].iloc[-1])
        assert abs(table.loc[table["id"] == 2, "x"]).max() < 1e-9
    assert ends[0] == pytest.approx(ends[1], rel=1e-4)


@needs_yade
@pytest.mark.engine
def test_a_moist_bed_is_replayed(tmp_path: Path) -> None:
    """Sixty spheres fall into a box: neighbours by YADE's sorts, no formation missed, no liquid lost; Newton's law of those that
    touch nothing, and of all how forces change the motion."""
    poured, vessel = bodies.loose_box(60, 1.5e-3, 1)
    sphere = sphere_classes(1.5e-3, counts=60)
    walls: tuple[Surface, ...] = (vessel,)
    small.prepare(
        tmp_path, sphere, poured, contacts(1, 2e3, rolling_m=2e-5), liquid=bodies.wetting(sphere, 1.0), effects=small.PAPER,
        walls=walls, wall_angle_rad=0.5, gravity=(0.0, 0.0, -9.81), time_step_s=1e-5, steps=6000,
        output=Output(interval_s=5e-3, contact_windows=6, contact_window_steps=2, energy=False, window_trajectories=True),
    )  # fmt: skip
    small.run(tmp_path, poured, engine="yade")
    counts = {name: q["count"] for name, q in agrees(tmp_path)["quantities"].items()}
    assert min(counts[n] for n in ("newton_force", "newton_kick", "wall_closest_point", "formation_missed")) > 100


@needs_yade
def test_another_layout_of_memory_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Places, or containers, that lie elsewhere than assumed: one sentence, and nothing is run."""
    one = [small.Sphere(1, (0.0, 0.0, 0.0))]
    for name in ("spin", "torques", "listed", "geometry", "depth"):
        folder = tmp_path / name
        small.prepare(folder, CLASSES, one, contacts(2, 1e4), steps=10)
        command = f"from pywet.engines.yade import memory, worker; memory.LAYOUT[{name!r}] += 8; worker.main()"
        monkeypatch.setattr(driver, "WORKER", ["-c", command])
        with raises_code("yade.stopped", says="YADE's memory holds"):
            small.run(folder, one, engine="yade")


def test_an_address_without_memory_is_refused() -> None:
    with pytest.raises(EngineError) as raised:
        memory.read(8, memory.POINTER)
    assert raised.value.code == "yade.memory"
