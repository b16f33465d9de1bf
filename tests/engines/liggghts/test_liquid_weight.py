"""The liquid weighs: on a scale, in free fall, in a bridge, in the budget of energy."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.geometry.initial import film_volume
from pywet.scene import Effects
from pywet.schema import WORKS
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of

pytestmark = pytest.mark.engine
R, K, G = 2.5e-3, 1e4, 9.81
HEAVY = small.PAPER.model_copy(update={"liquid_weight": True})
BARE = HEAVY.model_copy(update={"wall_films": False, "capillary": None})
DRY_MASS = spheres_of(R)[0].mass_kg
FILM = film_volume(WATER.initial_film_thickness_m, R)


def at_end(run_dir: Path, spheres: list[small.Sphere], effects: Effects, steps: int, **more: object) -> pd.DataFrame:
    """The trajectory of a small wet scene under gravity."""
    given = {"liquid": WATER, "gravity": (0.0, 0.0, -G), "output_interval_s": 1e-3, "log_every_step": False, **more}
    small.prepare(run_dir, spheres_of(R), spheres, contacts(1, 0.3, K), effects=effects, steps=steps, **given)  # type: ignore[arg-type]
    small.run(run_dir, spheres)
    return beds.table(run_dir, "trajectory")


@pytest.mark.parametrize("effects", [BARE, BARE.model_copy(update={"liquid_weight": False})], ids=["heavy", "light"])
def test_a_scale_shows_sphere_and_liquid(tmp_path: Path, effects: Effects) -> None:
    """At rest the floor pushes with k δ = (m + ρ L) g: the film of 8.2 mm³ is 5 % of a glass sphere. Damped to 1e-9 of δ."""
    sphere = small.Sphere(1, (0.0, 0.0, R - (DRY_MASS + 998.2 * FILM) * G / K))
    end = at_end(tmp_path, [sphere], effects, 20000, walls=[small.floor()]).iloc[-1]
    liquid = 998.2 * FILM if effects.liquid_weight else 0.0
    assert liquid < 0.06 * DRY_MASS
    assert K * (R - end["z"]) == pytest.approx((DRY_MASS + liquid) * G, rel=1e-9)


def test_what_falls_freely_falls_with_g(tmp_path: Path) -> None:
    """Return whether wet or in pairs held by a bridge: z = z0 - g t²/2, to round-off of the sum of 1000 steps."""
    spheres = [small.Sphere(1, (x, 0.0, 0.05)) for x in (-0.02, 0.0, 2.0 * R)]
    moved = at_end(tmp_path, spheres, HEAVY, 1000, gravity=(0.0, 0.0, -G))
    fall = moved[moved["step"] == 1000].set_index("id")
    alone, pair = fall.loc[1, "z"], fall.loc[[2, 3], "z"]
    assert alone - 0.05 == pytest.approx(-0.5 * G * 0.01**2, rel=1e-12)
    assert pair.mean() - 0.05 == pytest.approx(-0.5 * G * 0.01**2, rel=1e-12)


def test_inertia_of_the_liquid(tmp_path: Path) -> None:
    """A wet sphere on a floor without liquid on it swings with k over m + ρ L: the period, to 1e-4 (the step's own error)."""
    step = 1e-6
    effects = BARE.model_copy(update={"viscous_normal": None, "viscous_tangential": None})
    period = 2.0 * math.pi * math.sqrt((DRY_MASS + 998.2 * FILM) / K)
    sphere = small.Sphere(1, (0.0, 0.0, R - 1e-5))  # oscillates about its equilibrium without losing contact
    small.prepare(
        tmp_path, spheres_of(R), [sphere], contacts(1, 1.0, K), effects=effects, liquid=WATER, walls=[small.floor()],
        time_step_s=step, steps=round(2.5 * period / step), gravity=(0.0, 0.0, -1000.0), log_every_step=False,
    )  # fmt: skip
    small.run(tmp_path, [sphere])
    path = beds.table(tmp_path, "trajectory")
    z, v = path["z"].to_numpy(), path["vz"].to_numpy()
    assert z.max() < R
    up = np.flatnonzero((v[:-1] < 0) & (v[1:] >= 0))
    turns = up + v[up] / (v[up] - v[up + 1])
    assert np.diff(turns)[0] * step == pytest.approx(period, rel=1e-4)


def test_a_bridge_weighs_on_both_its_ends(tmp_path: Path) -> None:
    """Two spheres that touch on the floor and hold a bridge: together the floor bears both and all their liquid."""
    depth = (DRY_MASS + 998.2 * FILM) * G / K
    spheres = [small.Sphere(1, (x, 0.0, R - depth)) for x in (-R, R)]
    end = at_end(tmp_path, spheres, BARE, 20000, walls=[small.floor()])
    assert len(beds.table(tmp_path, "history/events")) == 1
    z = end[end["step"] == 20000]["z"]
    assert K * (2.0 * R - z.sum()) == pytest.approx(2.0 * (DRY_MASS + 998.2 * FILM) * G, rel=1e-9)


def test_budget_of_a_bed_closes(tmp_path: Path) -> None:
    """Kinetic energy that liquid brings and takes is in the budget, which closes to round-off as without weight."""
    spheres = beds.bed((6, 6, 6))
    beds.prepare(tmp_path, spheres, 1000, effects=HEAVY)
    small.run(tmp_path, spheres, 2)
    energy = beds.table(tmp_path, "history/energy")
    works = energy[WORKS]
    moving = energy["kinetic"] + energy["spin"]
    left = moving - moving.iloc[0] - works.sum(axis=1) - energy["half_kick"]
    assert left.abs().max() < 1e-12 * works.abs().sum(axis=1).iloc[-1]
    assert energy["drive"].abs().iloc[-1] > 1e-9


def test_without_density_nothing_changes(tmp_path: Path) -> None:
    """The limit of a liquid without mass is the run without the effect, to round-off (1e-9 of a radius over 6 ms)."""
    light = WATER.model_copy(update={"density_kg_per_m3": 1e-12})
    spheres = beds.bed((4, 4, 4))
    for name, effects in (("on", HEAVY), ("off", small.PAPER)):
        beds.prepare(tmp_path / name, spheres, 300, effects=effects, liquid=light)
        small.run(tmp_path / name, spheres)
    assert beds.apart(tmp_path / "on", tmp_path / "off").max() < 1e-9 * R
