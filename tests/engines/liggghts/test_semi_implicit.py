"""Semi-implicit lubrication: stable for any viscosity at the contact time step, exact for dt -> 0, wrong to first order in dt."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

from pywet.cases.small import small
from pywet.cases.small.bodies import water
from pywet.laws import registry
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds, stability
from tests.engines.liggghts.scenes import contacts, spheres_of

pytestmark = pytest.mark.engine
R = 2.5e-3
STIFFNESS = 1e4
FILM = 1e-4


def drawn_together(run_dir: Path, viscosity: float, step: float, seconds: float, how: str = "semi_implicit") -> float:
    """Gap of two free spheres at the end that the bridge has drawn together from 0.1 mm at rest."""
    bodies = [small.Sphere(1, (0.0, 0.0, 0.0)), small.Sphere(1, (0.0, 0.0, 2 * R + 1e-4))]
    steps = round(seconds / step)
    small.prepare(
        run_dir, spheres_of(R), bodies, contacts(1, stiffness=STIFFNESS), liquid=water(FILM, viscosity), effects=stability.NORMAL,
        time_step_s=step, steps=steps, output_interval_s=steps * step, viscous_integration=how,
        log_every_step=False,
    )  # fmt: skip
    small.run(run_dir, bodies)
    end = beds.table(run_dir, "trajectory").query("step == @steps").sort_values("id")["z"].to_numpy()
    return float(end[1] - end[0] - 2 * R)


def exact_gap(run_dir: Path, viscosity: float, seconds: float) -> float:
    """Return the gap by an adaptive solver from the Python laws."""
    volume = float(beds.table(run_dir, "history/events")["volume"].iloc[0])
    capillary = registry.get("capillary", "rabinovich").functions[0].python
    viscous = registry.get("viscous_normal", "pitois").functions[0].python
    angle, half = math.radians(15.0), 0.5 * spheres_of(R)[0].mass_kg

    def slope(_: float, y: np.ndarray) -> list[float]:
        force = viscous(y[0], volume, R, R, y[1], viscosity) - capillary(y[0], volume, R, R, angle, angle, 0.07275)
        return [y[1], force / half]

    found = solve_ivp(slope, (0.0, seconds), [1e-4, 0.0], method="LSODA", rtol=1e-11, atol=1e-15)
    return float(found.y[0, -1])


def test_first_order_and_exact_in_the_limit(tmp_path: Path) -> None:
    """Halving the step halves the error against an adaptive solution (ratio within 1.7 to 2.3), at c dt/m = 0.3 to 5."""
    viscosity, seconds, errors = 1.0, 4e-3, []
    for k, step in enumerate((8e-5, 4e-5, 2e-5)):
        gap = drawn_together(tmp_path / str(k), viscosity, step, seconds)
        errors.append(abs(gap - exact_gap(tmp_path / str(k), viscosity, seconds)))
    ratios = [errors[0] / errors[1], errors[1] / errors[2]]
    assert all(1.7 < ratio < 2.3 for ratio in ratios), (errors, ratios)
    assert errors[-1] < 1e-2 * 1e-4


def test_creeping_pair_at_any_viscosity(tmp_path: Path) -> None:
    """At 10 Pa s (c dt/m up to 60 at the contact time step) the pair still creeps together as the adaptive solution says."""
    gap = drawn_together(tmp_path, 10.0, 4e-5, 8e-3)
    assert gap == pytest.approx(exact_gap(tmp_path, 10.0, 8e-3), abs=1e-2 * 1e-4)


@pytest.mark.parametrize(
    "viscosity",
    [1.0, 1000.0, pytest.param(1e-4, marks=pytest.mark.slow), pytest.param(10.0, marks=pytest.mark.slow)],
)
def test_a_packed_cluster_calms_down(tmp_path: Path, viscosity: float) -> None:
    """Thirteen spheres in close contact, each with up to 12 bridges, thrown about: kinetic energy never grows beyond its start.

    No gravity; the capillary forces add at most their stored energy, which is in the energy budget.
    """
    at = [(0.0, 0.0, 0.0)]
    for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        at += [(a, b, 0), (a, 0, b), (0, a, b)]
    random = np.random.default_rng(2)
    bodies = [
        small.Sphere(
            1, tuple(np.sqrt(2.0) * R * np.array(p)), tuple(random.normal(0, 0.05, 3)), tuple(random.normal(0, 20, 3))
        )
        for p in at
    ]
    steps = 1500
    small.prepare(
        tmp_path, spheres_of(R), bodies, contacts(1, stiffness=STIFFNESS), liquid=water(FILM, viscosity), effects=small.PAPER,
        time_step_s=2e-5, steps=steps, output_interval_s=100 * 2e-5, viscous_integration="semi_implicit",
    )  # fmt: skip
    small.run(tmp_path, bodies)
    energy = beds.table(tmp_path, "history/energy")
    moving = energy["kinetic"] + energy["spin"]
    given = energy["formed"].abs()
    assert (moving <= moving.iloc[0] + given).all()
    if viscosity >= 1.0:
        assert moving.iloc[-1] < 0.5 * moving.iloc[0]
    result = replay(tmp_path)
    bad = {name: q["largest"] for name, q in result["quantities"].items() if not q["ok"]}
    assert not bad and result["contacts"] > 10000
    log = beds.table(tmp_path, "history/contacts")
    assert isinstance(log, pd.DataFrame) and (log["factor_normal"] < 1.0).all() and log["sharing_i"].max() == 12


def test_rest_is_the_balance_of_spring_and_bridge(tmp_path: Path) -> None:
    """At 10 Pa s a pressed pair settles at the overlap F/k (1e-6): a drag does nothing to bodies at rest."""
    _, bodies = stability.pressed_pair(tmp_path, 10.0, 1e-4, "semi_implicit")
    overlap = 2 * R - bodies[1].position[2]
    small.run(tmp_path, bodies)
    end = beds.table(tmp_path, "trajectory").query("step == step.max()").sort_values("id")
    z, speed = end["z"].to_numpy(), end["vz"].to_numpy()
    assert 2 * R - (z[1] - z[0]) == pytest.approx(overlap, rel=1e-6) and abs(speed[1] - speed[0]) < 1e-12


def test_ranks_agree(tmp_path: Path) -> None:
    """Bridges across a rank boundary get the push of the other rank's sphere: the same run on one and two ranks."""
    ends = []
    for ranks in (1, 2):
        run_dir = tmp_path / str(ranks)
        bodies = [
            small.Sphere(
                1,
                ((k - 2.5) * 2.02 * R, 0.1 * R * (k % 2), 0.0),
                (0.02 * (2.5 - k), 0.0, 0.01 * k),
                (0.0, 5.0 * k, 0.0),
            )
            for k in range(6)
        ]
        small.prepare(
            run_dir, spheres_of(R), bodies, contacts(1, stiffness=STIFFNESS), liquid=water(FILM, 1.0), effects=small.PAPER,
            time_step_s=2e-5, steps=800, output_interval_s=1.6e-2, viscous_integration="semi_implicit",
        )  # fmt: skip
        small.run(run_dir, bodies, ranks)
        ends.append(beds.table(run_dir, "trajectory").query("step == 800").set_index("id")[["x", "y", "z"]].to_numpy())
    assert np.abs(ends[0] - ends[1]).max() < 1e-12 * R
