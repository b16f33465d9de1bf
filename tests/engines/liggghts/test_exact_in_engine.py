"""The law `young_laplace` inside the engine against the direct solution, on a thousand random bridges drawn apart."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.engines.liggghts import driver
from pywet.laws import registry
from pywet.laws.contact import film_volume
from pywet.laws.exact_bridge import solve
from pywet.laws.transfer import V_STAR_GRID
from pywet.util.files import write_table
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of

pytestmark = pytest.mark.engine
RADII = tuple(np.geomspace(0.5e-3, 5e-3, 20))
THICKEST = {"0deg": 0.1, "60deg": 0.1, "floor": 0.3}
"""Thickest film over radius: V* up to half between very unequal spheres, 0.04 on the floor."""
HEAVY = 1e16
"""Density [kg/m3]: so heavy that forces of millinewtons do not change the speed a sphere starts with."""
STEPS, STEP = 100, 1e-5
EXACT_FORCE = small.PAPER.model_copy(
    update={"capillary": "young_laplace", "rupture": "young_laplace", "dynamic_rupture": None}
)
SCENES = {
    "0deg": (334, (0.0, 0.0)),
    "60deg": (333, (60.0, 60.0)),
    "floor": (333, (math.degrees(0.2), math.degrees(0.5))),
}
"""Bridges and contact angles [deg] of each scene; `floor`: spheres on a plate."""


def drawn(films: np.ndarray, kinds: np.ndarray, floor: bool) -> np.ndarray:
    """Volume of each bridge by the law of formation."""
    draw = registry.get("formation", "shi_mccarthy").functions[0]
    radii = np.array(RADII)[kinds]
    if floor:
        return np.asarray(draw(films[:, 0], radii[:, 0], np.full(len(radii), math.inf)))
    return np.asarray(draw(films[:, 0], *radii.T) + draw(films[:, 1], *radii.T[::-1]))


def pull(run_dir: Path, name: str) -> pd.DataFrame:
    """Contact log of all bridges of a scene; each is drawn from touch to its rupture at its own speed."""
    count, angles = SCENES[name]
    floor = name == "floor"
    rng = np.random.default_rng(len(name))
    kinds = rng.integers(0, len(RADII), (count, 1 if floor else 2))
    radii = np.array(RADII)[kinds]
    films = np.vectorize(film_volume)(radii * THICKEST[name] * 10 ** rng.uniform(-5, 0, radii.shape), radii)
    volumes = drawn(films, kinds, floor)
    rad = [math.radians(a) for a in angles]
    far = math.inf if floor else radii[:, 1]
    limit = registry.get("rupture", "young_laplace").functions[0](volumes, radii[:, 0], far, *rad)
    start = -2.5 * limit / STEPS  # a new bridge acts from the next step on: the first rows still overlap
    speed = 1.05 * limit / (STEPS * STEP)
    bodies = []
    if floor:
        side = math.ceil(math.sqrt(count))
        for k in range(count):
            at = 13e-3 * (np.array([k % side, k // side]) - 0.5 * side)
            bodies.append(small.Sphere(int(kinds[k, 0]) + 1, (*at, radii[k, 0] + start[k]), (0.0, 0.0, speed[k])))
    else:
        for k in range(count):
            at = 28e-3 * (np.array([k % 7, k // 7 % 7, k // 49]) - 3.0)
            n = rng.normal(size=3)
            n /= np.linalg.norm(n)
            apart = (radii[k].sum() + start[k]) * n
            bodies.append(small.Sphere(int(kinds[k, 0]) + 1, tuple(at + 0.5 * apart), tuple(0.5 * speed[k] * n)))
            bodies.append(small.Sphere(int(kinds[k, 1]) + 1, tuple(at - 0.5 * apart), tuple(-0.5 * speed[k] * n)))
    small.prepare(
        run_dir,
        spheres_of(*RADII, density=HEAVY, angle_deg=angles[0]),
        bodies,
        contacts(len(RADII)),
        liquid=WATER.model_copy(update={"initial_film_thickness_m": THICKEST[name] * RADII[0]}),
        effects=EXACT_FORCE,
        walls=[small.floor(half_side=0.15)] if floor else [],
        wall_angle_rad=rad[1],
        time_step_s=STEP,
        steps=STEPS,
        output_interval_s=STEPS * STEP,
        box=0.16,
    )
    held = run_dir / "history" / "spheres.parquet"
    write_table(pd.read_parquet(held).assign(film=films.ravel()), held)  # a different film on each sphere
    small.run(run_dir, bodies)
    log = pd.read_parquet(run_dir / "history" / "contacts.parquet")
    index = log["i"] - 1 if floor else (log[["i", "j"]].min(axis=1) - 1) // 2
    assert np.abs(log["volume"] / volumes[index] - 1).max() < 1e-9  # bridge volumes follow from these films
    other = math.inf if floor else np.array(RADII)[kinds[index, 1]]
    return log.assign(bridge=index, radius_i=np.array(RADII)[kinds[index, 0]], radius_j=other)


@pytest.mark.parametrize("name", SCENES)
def test_capillary_force_is_within_a_thousandth_of_the_direct_solution(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One logged step of each bridge; the error is measured in the exact force of touching bodies."""
    # sharing after rupture is irrelevant here, and tables of 210 pairs of sizes would take minutes
    monkeypatch.setitem(registry.TRANSFER, "parabola", lambda *_, **__: np.full(V_STAR_GRID.shape, 0.5))
    count, angles = SCENES[name]
    rad = [math.radians(a) for a in angles]
    log = pull(tmp_path, name)
    rows = log.groupby("bridge").sample(1, random_state=1)
    assert len(rows) == count
    errors, shares = [], []
    for row in rows.itertuples():
        case = (row.volume, row.radius_i, row.radius_j, *rad)
        exact, touching = solve(row.separation, *case), solve(0.0, *case)
        assert exact is not None and touching is not None
        sigma = WATER.surface_tension_N_per_m
        errors.append(abs(row.capillary - exact.force(sigma)) / touching.force(sigma))
        shares.append(row.separation / row.rupture_distance)
    assert max(errors) <= 1e-3, f"{name}: worst {max(errors):.1e}, median {np.median(errors):.1e}"
    # the thousand records cover separations from touch to rupture, and several orders of magnitude of V*
    assert min(shares) < 0.03 and max(shares) > 0.97
    effective = 2 / (1 / rows["radius_i"] + 1 / rows["radius_j"])
    v_star = rows["volume"] / effective**3
    assert v_star.min() < 1e-5 and 0.03 < v_star.max() < 0.5


def test_numbers_prepared_for_a_bridge_stay_with_it(tmp_path: Path) -> None:
    """In a bed whose bridges are sorted whenever lists are made again, the replay solves the logged forces again."""
    beds.prepare(tmp_path, beds.bed((4, 4, 3)), 4000, effects=EXACT_FORCE)
    driver.run(tmp_path, progress=False)
    found = replay(tmp_path)
    assert found["ok"], [name for name, q in found["quantities"].items() if not q["ok"]]
    assert found["quantities"]["capillary"]["count"] > 30
