"""Dry contacts inside the engine: the restitution that comes out is the one configured, for each material pair."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pywet import config
from pywet.cases.screening import cases
from pywet.cases.small import small
from pywet.engines.liggghts import contact_model
from pywet.scene import ContactPair, SphereClass

pytestmark = pytest.mark.engine
ROOT = Path(__file__).parents[3]
CONFIG = config.load(ROOT / "config")
PHASES = 8
PAIRS = [(case, scale, partner) for case in (1, 10) for scale in ("smoke", "full") for partner in ("sphere", "wall")]


def bodies(partner: str, radius: float, time_step: float) -> tuple[list[small.Sphere], list[object]]:
    """PHASES head-on collisions at 0.1 m/s side by side, each touching at another instant between two steps."""
    spheres, speed = [], 0.1
    for k in range(PHASES):
        x, gap = 5 * radius * (k - PHASES / 2), 1e-5 + speed * time_step * k / PHASES
        if partner == "wall":
            spheres.append(small.Sphere(1, (x, 0.0, radius + gap), (0.0, 0.0, -speed)))
        else:
            spheres.append(small.Sphere(1, (x, 0.0, 0.0), (0.0, 0.0, 0.5 * speed)))
            spheres.append(small.Sphere(1, (x, 0.0, 2 * radius + gap), (0.0, 0.0, -0.5 * speed)))
    return spheres, [small.floor(0.08)] if partner == "wall" else []


def pairs_of_one_type(pairs: tuple[ContactPair, ...]) -> list[ContactPair]:
    """Contacts of type 1 with itself and with the walls."""
    return [p for p in pairs if p.a == 1 and p.b in (0, 1)]


@pytest.mark.parametrize(("case", "scale", "partner"), PAIRS)
def test_restitution_is_the_configured_one(tmp_path: Path, case: int, scale: str, partner: str) -> None:
    """Within 1 % in the mean over the instant of touch, at the case's own time step, for POM and glass, on themselves and steel.

    A single collision scatters by up to 5 % with the instant of touch at that step (first order in it, from the step that
    first sees the overlap).
    """
    made = cases.ingredients(CONFIG, case, scale)
    first: SphereClass = made.classes[0]
    spheres, walls = bodies(partner, first.radius_m, made.time_step_s)
    pairs = pairs_of_one_type(made.pairs)
    pair = next(p for p in pairs if p.b == (0 if partner == "wall" else 1))
    steps = round(4e-4 / made.time_step_s) + 60
    small.prepare(
        tmp_path, [first], spheres, pairs, walls=walls, time_step_s=made.time_step_s, steps=steps,
        output_interval_s=steps * made.time_step_s,
    )  # fmt: skip
    small.run(tmp_path, spheres)
    end = pd.read_parquet(tmp_path / "trajectory.parquet").query("step == @steps")["vz"].to_numpy()
    rebound = (end[1::2] - end[0::2]) / 0.1 if partner == "sphere" else end / 0.1
    assert rebound.mean() == pytest.approx(pair.restitution, rel=0.01)


def test_rolling_friction_is_a_length(tmp_path: Path) -> None:
    """The deck divides the paper's length by the engine's reduced radius, so that the torque is μ_roll |F_n|."""
    scene = cases.build(CONFIG, 1, "smoke", tmp_path)
    values = [float(x) for x in contact_model.property_matrices(scene)["coefficientRollingFriction"].split()]
    n = len(scene.classes) + 1
    r = [c.radius_m for c in scene.classes]
    assert values[0 * n + 1] * r[0] * r[1] / (r[0] + r[1]) == pytest.approx(4.63e-5, rel=1e-12)  # table 3, POM-POM
    assert values[2 * n + 3] * r[2] == pytest.approx(5.97e-5, rel=1e-12)  # table 3, POM-steel
