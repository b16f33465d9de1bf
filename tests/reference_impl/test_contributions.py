"""Contributions of effects in scenes of one or two bodies that can be worked out by hand."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.scene import ContactPair
from reference_impl.replay.replay import replay
from tests.engines.liggghts.scenes import WATER, spheres_of

pytestmark = pytest.mark.engine
R, STEP = 2.5e-3, 1e-5
SIGMA, ETA = WATER.surface_tension_N_per_m, WATER.viscosity_Pa_s
MASS = 2500.0 * 4.0 / 3.0 * math.pi * R**3
WEIGHT = MASS * 9.81
STIFF = ContactPair(
    a=1, b=1, normal_stiffness_N_per_m=1e3, tangential_stiffness_N_per_m=300.0, friction=0.3, rolling_friction_m=5e-5,
    restitution=0.7,
)  # fmt: skip
CONTACTS = [STIFF, STIFF.model_copy(update={"b": 0})]


def measured(folder: Path, spheres: list[small.Sphere], steps: int, **more: Any) -> dict[str, Any]:
    """Run, replay, and what was written."""
    small.prepare(
        folder, spheres_of(R), spheres, CONTACTS, time_step_s=STEP, steps=steps, window_trajectories=True, **more
    )
    small.run(folder, spheres)
    result = replay(folder)
    assert result["ok"], {n: q["largest"] for n, q in result["quantities"].items() if not q["ok"]}
    return dict(json.loads((folder / "contributions.json").read_text()))


def test_falling_sphere(tmp_path: Path) -> None:
    """Weight alone: impulse m g t, energy that of the fall; steps 0 to 100 are 101 forces."""
    found = measured(tmp_path, [small.Sphere(1, (0.0, 0.0, 0.05))], 100, gravity=(0.0, 0.0, -9.81))
    weight = found["effects"]["weight"]
    assert weight["impulse_share"] == 1.0 and weight["energy_share"] == 1.0
    assert weight["impulse_Ns"] == pytest.approx(WEIGHT * 101 * STEP, rel=1e-12)
    # speeds in the middle of the steps: g dt (k - 1/2) for k = 1 ... 100, their sum g dt 100^2/2
    assert weight["energy_J"] == pytest.approx(WEIGHT * STEP * 9.81 * STEP * 100**2 / 2, rel=1e-9)
    assert found["effects"]["contact_normal"]["impulse_share"] == 0.0


def test_pressed_pair(tmp_path: Path) -> None:
    """Two driven spheres pressed by 1e-5 m next to a falling one: k delta over its weight; nothing moves, nothing is lost."""
    spheres = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(1, (2 * R - 1e-5, 0.0, 0.0), driven=True),
        small.Sphere(1, (0.0, 0.0, 0.05)),
    ]
    found = measured(tmp_path, spheres, 50, gravity=(0.0, 0.0, -9.81))["effects"]
    assert found["contact_normal"]["impulse_share"] == pytest.approx(1e3 * 1e-5 / WEIGHT, rel=1e-9)
    assert found["contact_normal"]["energy_J"] == found["rolling"]["impulse_Ns"] == 0.0


def test_rolling_and_friction(tmp_path: Path) -> None:
    """A driven sphere dragged over a held one at full slip: friction mu F_n, rolling moment mu_roll k delta over r_red."""
    speed, overlap = 0.02, 1e-5
    spheres = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(1, (2 * R - overlap, 0.0, 0.0), (0.0, speed, 0.0), (0.0, 0.0, 50.0), driven=True),
        small.Sphere(1, (0.0, 0.0, 0.05)),
    ]
    found = measured(tmp_path, spheres, 100, gravity=(0.0, 0.0, -9.81))["effects"]
    # the displacement reduces the overlap by v^2 t^2/(4 R), below 0.4 % at the end; the spring soon reaches its limit
    pressed = 1e3 * overlap / WEIGHT
    assert found["contact_tangential"]["impulse_share"] == pytest.approx(0.3 * pressed, rel=0.1)
    assert found["rolling"]["impulse_share"] == pytest.approx(5e-5 / (R / 2) * pressed, rel=0.005)
    # the spin reverses the slip; the first mu k delta/k_t of it stretches the spring to its limit
    grip, slid = 0.3 * 1e3 * overlap, (50.0 * (R - overlap / 2) - speed) * 100 * STEP
    assert found["contact_tangential"]["dissipated_J"] == pytest.approx(grip * (slid - grip / 300.0), rel=0.005)


def wet_pair(folder: Path, velocity: tuple[float, float, float], steps: int, gap: float = 5e-5) -> dict[str, Any]:
    """Two driven wet spheres, the second one moving."""
    spheres = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(1, (2 * R + gap, 0.0, 0.0), velocity, driven=True),
    ]
    return measured(folder, spheres, steps, liquid=WATER, effects=small.PAPER)


def volume_of(folder: Path) -> float:
    """The bridge's volume; what it should be is tested with the replay of the liquid."""
    return float(pd.read_parquet(folder / "history" / "events.parquet")["volume"].iloc[0])


def test_capillary_force_at_rest(tmp_path: Path) -> None:
    """A bridge at constant gap: Rabinovich's force by hand, all of the impulse, no energy."""
    found = wet_pair(tmp_path, (0.0, 0.0, 0.0), 100)["effects"]
    s, v = 5e-5, volume_of(tmp_path)
    d = (v / (math.pi * R)) / (s + math.sqrt(s * s + 2 * v / (math.pi * R)))
    phi, theta = math.sqrt(2 * d / R), math.radians(15.0)
    force = 2 * math.pi * SIGMA * R * math.cos(theta) / (1 + s / (2 * d))
    force += 2 * math.pi * SIGMA * R * math.sin(phi) * math.sin(phi + theta)
    # it forms in step 0 and acts in steps 1 to 100; 1e-9: the gap is a difference of positions
    assert found["capillary"]["impulse_Ns"] == pytest.approx(force * 100 * STEP, rel=1e-9)
    assert found["capillary"]["impulse_share"] == pytest.approx(1.0)
    assert found["capillary"]["energy_J"] == found["viscous_normal"]["impulse_Ns"] == 0.0


def test_drawn_pair(tmp_path: Path) -> None:
    """Drawn apart at 0.4 m/s to rupture: viscous impulse by hand, stretch sqrt(v eta/sigma), equal shares of liquid."""
    speed, steps = 0.4, 700
    found = wet_pair(tmp_path, (speed, 0.0, 0.0), steps)["effects"]
    rupture = pd.read_parquet(tmp_path / "history" / "events.parquet").query("kind == 1").iloc[0]
    a, v, impulse, energy = R / 2, volume_of(tmp_path), 0.0, 0.0
    for n in range(1, int(rupture["step"])):
        h = 5e-5 + speed * n * STEP + 0.001 * R
        force = 6 * math.pi * ETA * a * a * speed / h * (1 - 1 / math.sqrt(1 + v / (math.pi * a * h * h))) ** 2
        impulse += force * STEP
        energy += force * speed * STEP
    assert found["viscous_normal"]["impulse_Ns"] == pytest.approx(impulse, rel=1e-9)
    assert found["viscous_normal"]["energy_J"] == pytest.approx(energy, rel=1e-9)
    assert found["dynamic_rupture"]["mean_stretch"] == pytest.approx(math.sqrt(speed * ETA / SIGMA), rel=1e-9)
    assert found["dynamic_rupture"]["ruptures"] == 1
    assert found["sharing_by_size"]["liquid_share"] == pytest.approx(0.0, abs=1e-12)
    assert found["wall_films"]["liquid_share"] == 0.0


def test_liquid_of_walls(tmp_path: Path) -> None:
    """A sphere drawn from a dry wall leaves it the wall's part of the bridge: over all that moved, once in and once out."""
    spheres = [small.Sphere(1, (0.0, 0.0, R + 5e-5), (0.0, 0.0, 0.8), driven=True)]
    found = measured(
        tmp_path, spheres, 600, liquid=WATER, effects=small.PAPER, walls=[small.floor()], wall_angle_rad=0.8
    )["effects"]
    events = pd.read_parquet(tmp_path / "history" / "events.parquet")
    formed, broke = events.iloc[0], events.iloc[1]
    assert formed["share_j"] == 0.0 and broke["share_j"] > 0.0
    assert found["wall_films"]["liquid_share"] == pytest.approx(broke["share_j"] / (2.0 * formed["volume"]), rel=1e-12)


def test_effect_that_was_off(tmp_path: Path) -> None:
    """Without drag in the run, what drag would have done is still measured, marked, and not part of the whole."""
    without = small.PAPER.model_copy(update={"viscous_normal": None})
    spheres = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(1, (2 * R + 5e-5, 0.0, 0.0), (0.1, 0.0, 0.0), driven=True),
    ]
    found = measured(tmp_path, spheres, 50, liquid=WATER, effects=without)["effects"]
    assert not found["viscous_normal"]["acting"]
    drag, pull = found["viscous_normal"]["impulse_Ns"], found["capillary"]["impulse_Ns"]
    assert found["capillary"]["impulse_share"] == pytest.approx(1.0)
    assert found["viscous_normal"]["impulse_share"] == pytest.approx(drag / (drag + pull)) and drag > 0.0
