"""Hertz–Mindlin contacts in the engine: the exact elastic impact, restitution, no-slip stiffness, Coulomb's limit, replay."""

from __future__ import annotations

import json
import math
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pywet.cases.small import bodies, small
from pywet.laws import contact
from pywet.laws.hertz import HEAD_ON, Elastic, Hertz, effective_shear_modulus
from pywet.planning import time_steps
from pywet.scene import EngineScene
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER, spheres_of
from tests.error_codes import raises_code
from tests.reference_impl import newton_scenes as scenes

pytestmark = pytest.mark.engine
R, SPEED = 2.5e-3, 0.5
SOFT, HARD = (Elastic(youngs_modulus_Pa=e, poissons_ratio=nu) for e, nu in ((1e7, 0.3), (3e7, 0.25)))
HERTZ = Hertz(spheres=(SOFT, HARD), walls=HARD, impact_speed_m_per_s=SPEED)
CLASSES = spheres_of(R, 2e-3)


def contacts(restitution: float = 1.0, friction: float = 0.3, rolling_m: float = 0.0) -> tuple[Any, ...]:
    """All pairs of the two types with each other and with walls."""
    how = {"restitution": restitution, "friction": friction, "rolling_m": rolling_m}
    return bodies.hertzian(CLASSES, bodies.contacts(2, 1.0, **how), HERTZ)


def impact(folder: Path, step: float, steps: int, restitution: float, wall: bool, gap: float = 0.0) -> Any:
    """Gap [m] and closing speed [m/s] at every step of a head-on impact at `SPEED`: of two types, or of one and a wall."""
    thrown = [small.Sphere(1, (0.0, 0.0, R + gap), (0.0, 0.0, -SPEED))]
    if not wall:
        thrown.append(small.Sphere(2, (0.0, 0.0, -2e-3), (0.0, 0.0, 0.0)))
    small.prepare(
        folder, CLASSES, thrown, contacts(restitution), walls=[small.floor()] if wall else [], time_step_s=step,
        steps=steps, log_every_step=False, hertz=HERTZ,
    )  # fmt: skip
    small.run(folder, thrown)
    table = beds.table(folder, "trajectory").sort_values(["step", "id"])
    z, v = (table[c].to_numpy().reshape(steps + 1, -1) for c in ("z", "vz"))
    return (z[:, 0] - R, v[:, 0]) if wall else (z[:, 0] - z[:, 1] - R - 2e-3, v[:, 0] - v[:, 1])


def exact(wall: bool) -> tuple[float, float]:
    """Largest overlap (15 m v²/(16 E √R))^(2/5) and duration 2.87 (m²/(R E² v))^(1/5), typed again."""
    one, two = CLASSES
    m = one.mass_kg if wall else one.mass_kg * two.mass_kg / (one.mass_kg + two.mass_kg)
    r = R if wall else R * 2e-3 / (R + 2e-3)
    e = 1.0 / ((1 - 0.3**2) / 1e7 + (1 - 0.25**2) / 3e7)
    return (15 * m * SPEED**2 / (16 * e * math.sqrt(r))) ** 0.4, 2.8682657 * (m**2 / (r * e**2 * SPEED)) ** 0.2


@pytest.mark.parametrize("wall", [False, True])
def test_an_elastic_impact_is_that_of_hertz(tmp_path: Path, wall: bool) -> None:
    """A hundredth of the duration as step gives both to 1e-4; errors fall with the square of the step, and no energy is lost."""
    depth, lasts = exact(wall)
    off = []
    for n in (50, 100, 200, 400):
        gap, speed = impact(tmp_path / str(n), lasts / n, n + 6, 1.0, wall)
        out = int(np.flatnonzero((gap[1:] > 0.0) & (gap[:-1] <= 0.0))[-1])
        end = (out + gap[out] / (gap[out] - gap[out + 1])) * lasts / n
        k = int(np.argmin(gap))
        low = gap[k] - (gap[k + 1] - gap[k - 1]) ** 2 / (8.0 * (gap[k + 1] - 2.0 * gap[k] + gap[k - 1]))
        off.append([abs(-low / depth - 1.0), abs(end / lasts - 1.0), abs(speed[-1] / SPEED - 1.0)])
    errors = np.array(off)
    assert errors[1].max() < 1e-4 and errors[1, 2] < 1e-6
    assert (errors[3, :2] < errors[1, :2] / 12.0).all()  # second order: 1/16 of the error with 1/4 of the step


@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize("restitution", [0.9, 0.5, 0.2])
def test_restitution_is_the_prescribed_one(tmp_path: Path, restitution: float, wall: bool) -> None:
    """At a step of a hundredth of the duration within 1 %: 1e-4 at 0.9, 8e-4 at 0.5, 8e-3 at 0.2 (of first order in the step)."""
    _, lasts = exact(wall)
    _, speed = impact(tmp_path, lasts / 100, 400, restitution, wall, gap=1e-7)
    assert speed[-1] / SPEED == pytest.approx(restitution, rel=0.01)


def test_no_slip_stiffness_and_coulombs_limit(tmp_path: Path) -> None:
    """A sphere pressed on another and drawn sideways: 8 G* a at small displacement, a = √(R* δ); then μ 4/3 E* a δ."""
    depth, speed, friction = 5e-5, 1e-3, 0.3
    pressed = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(2, (0.0, 0.0, R + 2e-3 - depth), (speed, 0.0, 0.0), driven=True),
    ]
    small.prepare(
        tmp_path, CLASSES, pressed, contacts(friction=friction), time_step_s=1e-5, steps=3000, window_trajectories=True,
        hertz=HERTZ,
    )  # fmt: skip
    small.run(tmp_path, pressed)
    rows = beds.table(tmp_path, "history/window_states").query("id == 2").sort_values("step")
    force, way = -rows["fx"].to_numpy(), rows["step"].to_numpy() * speed * 1e-5
    r = R * 2e-3 / (R + 2e-3)
    radius = math.sqrt(r * depth)
    small_way = (way > 2e-7) & (way < 1e-6)
    stiffness = float(np.polyfit(way[small_way], force[small_way], 1)[0])
    pair = next(p for p in contacts() if (p.a, p.b) == (1, 2))
    normal = 4.0 / 3.0 * HERTZ.moduli(pair)[0] * radius * depth
    turned = normal / (R + 2e-3 - depth)  # the normal force rotates with the line of centres
    assert stiffness + turned == pytest.approx(8.0 * effective_shear_modulus(SOFT, HARD) * radius, rel=1e-4)
    apart = math.hypot(R + 2e-3 - depth, way[-1])
    tilted = R + 2e-3 - apart
    side = friction * normal * (tilted / depth) ** 1.5
    line = way[-1] / apart
    assert force[-1] == pytest.approx(side * math.sqrt(1 - line**2) - side / friction * line, rel=1e-6)


def test_the_step_is_refused_beyond_the_stiffest_contact(tmp_path: Path) -> None:
    """The limit of a pair is that of the spring with the slope 2 E* √(R* δ) at the overlap of two that meet head on."""
    spheres = [small.Sphere(1, (0.0, 0.0, 0.0)), small.Sphere(1, (0.0, 0.0, 2.1 * R))]
    scene = small.prepare(tmp_path, CLASSES[:1], spheres, contacts()[:2], time_step_s=1e-6, hertz=HERTZ.model_copy(
        update={"spheres": (SOFT,)}))  # fmt: skip
    pair = scene.pairs[1]
    assert scene.hertz is not None
    depth = scene.hertz.overlap(scene.classes, pair, HEAD_ON * SPEED)
    shear = 8.0 * scene.hertz.moduli(pair)[1] * math.sqrt(0.5 * R * depth)
    limit = 2.0 * math.sqrt(contact.pair_mass(scene.classes, pair) / (3.5 * shear))
    advice = time_steps.advise(scene)
    found = next(row.time_step_s for row in advice.limits if row.effect == "contact" and "wall" not in row.bodies)
    assert found == pytest.approx(limit, rel=1e-9)  # elastic: no dashpot; sliding with spin is stiffer than pushing
    assert {row.effect for row in advice.limits if not row.stability} == {"Hertz impact / 20", "Rayleigh time / 5"}
    with raises_code("step.unstable"):
        time_steps.refuse_unstable(scene.model_copy(update={"time_step_s": 1.01 * limit, "duration_s": 101 * limit}))


def on_walls(folder: Path, **more: Any) -> Path:
    """Spheres of two types thrown onto crossing wires, spinning; with everything that a contact has."""
    spheres = scenes.thrown(8, 0.0038, wide=4.6e-3, down=0.3)
    small.prepare(
        folder, CLASSES, spheres, contacts(0.7, rolling_m=5e-5), walls=[scenes.wires()], time_step_s=5e-6, steps=1200,
        gravity=scenes.DOWN, window_trajectories=True, output_interval_s=6e-3, hertz=HERTZ, **more,
    )  # fmt: skip
    small.run(folder, spheres)
    return folder


@pytest.mark.parametrize("analytic_wires", [[], ["wires"]])
def test_newton_closes_on_walls(tmp_path: Path, analytic_wires: list[str]) -> None:
    """Triangles by the stock program, analytic wires by the plugin with the engine's own wall law."""
    quantities, found = scenes.closed(on_walls(tmp_path, analytic_wires=analytic_wires))
    assert {n: q.largest for n, q in quantities.items() if not q.ok} == {}
    assert quantities["newton_force"].largest < 1e-9
    assert sum(int(f.touches.wall.sum()) for f in found) > 100
    assert any((f.contacts.slid > 0.0).any() for f in found)


@pytest.fixture(scope="module")
def moist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Thirty wet spheres of two types on a shaken floor, in four windows; the plugin takes part and `contacts` is planes."""
    folder, spheres = tmp_path_factory.mktemp("moist"), scenes.thrown(32, 0.003)
    small.prepare(
        folder, CLASSES, spheres, contacts(0.7, rolling_m=5e-5), liquid=WATER, effects=small.PAPER,
        walls=[scenes.moving(small.floor(), "vibrates")], wall_angle_rad=math.radians(45.0), time_step_s=8e-6, steps=3000,
        gravity=scenes.DOWN, vibration=scenes.SHAKING, hertz=HERTZ, viscous_integration="semi_implicit",
        output=small.Output(interval_s=0.004, contact_windows=4, contact_window_steps=60, window_trajectories=True),
    )  # fmt: skip
    small.run(folder, spheres)
    return folder


def test_a_moist_bed_is_replayed(moist: Path) -> None:
    """Forces of all contacts and bridges; contacts fall to the stock loop, for batches hold the linear spring alone."""
    result = replay(moist)
    assert result["ok"], {n: q["largest"] for n, q in result["quantities"].items() if not q["ok"]}
    assert result["quantities"]["newton_force"]["largest"] < 1e-9
    assert result["newton"]["dry_contacts"] > 300
    assert EngineScene.read(moist / "scene.json").contacts == "planes"
    assert json.loads((moist / "engine" / "held.json").read_text())["contacts_in_batches"] == 0


@pytest.mark.parametrize(
    ("body", "key", "factor"),
    [
        ("walls", "youngs_modulus_Pa", 1.1),
        pytest.param(0, "youngs_modulus_Pa", 1.1, marks=pytest.mark.slow),
        (1, "poissons_ratio", 0.8),
        pytest.param("walls", "poissons_ratio", 1.5, marks=pytest.mark.slow),
    ],
)
def test_a_wrong_modulus_is_found(moist: Path, tmp_path: Path, body: int | str, key: str, factor: float) -> None:
    """Give one body a wrong modulus: Newton's law fails by more than a thousand times its limit, and the diagnosis names
    the body, the modulus and the factor of the engine's value over that of the scene."""
    shutil.copytree(moist, tmp_path / "wrong")
    file = tmp_path / "wrong" / "scene.json"
    output_text = json.loads(file.read_text())
    (output_text["hertz"]["walls"] if body == "walls" else output_text["hertz"]["spheres"][body])[key] *= factor
    file.write_text(json.dumps(output_text))
    result = replay(tmp_path / "wrong")
    assert not result["ok"] and result["quantities"]["newton_force"]["largest"] > 1e-6
    name = "the walls" if body == "walls" else f"class {output_text['classes'][body]['name']}"
    what = {"youngs_modulus_Pa": "Young's modulus", "poissons_ratio": "Poisson's ratio"}[key]
    sentences = " ".join(finding["sentence"] for finding in result["diagnosis"]["findings"])
    named = re.search(rf"the {what} of {name} is ([0-9.]+) times what it should be", sentences)
    assert named and float(named[1]) == pytest.approx(1.0 / factor, rel=1e-5), sentences
