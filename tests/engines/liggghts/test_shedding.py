"""Drops: when a film lets go, how much, and where it lands."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.cases.small.bodies import water
from pywet.engines.liggghts import driver
from pywet.geometry.initial import film_volume
from pywet.geometry.surface import Surface
from pywet.scene import Effects, EngineScene, Output
from pywet.schema import LARGE_WALL, NOTHING, SPHERE
from reference_impl.replay import plans
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of

pytestmark = pytest.mark.engine
R, G, RHO, SIGMA = 2.5e-3, 9.81, 998.2, 0.02
SOAPY = water(4.5e-4, tension=SIGMA, density=RHO)
FILM = film_volume(SOAPY.initial_film_thickness_m, R)
HANGS = 2.0 * math.pi * R * SIGMA / (RHO * G)
DRIPPING = small.PAPER.model_copy(update={"shedding": "tate"})


def falling(acceleration: float) -> float:
    """Return the volume of the drop [m3] by Harkins and Brown's curve in the form 3.60 Φ^2.81 = Bo."""
    bond = RHO * acceleration * R**2 / SIGMA
    return R**3 / ((bond / 3.60) ** (1.0 / 2.81)) ** 3


def drops_of(
    run_dir: Path, spheres: list[small.Sphere], walls: list[Surface] | None = None, steps: int = 4000
) -> pd.DataFrame:
    """Drops of a small scene under gravity; its liquid stays all there."""
    small.prepare(
        run_dir, spheres_of(R), spheres, contacts(1), liquid=SOAPY, effects=DRIPPING, walls=walls or [], steps=steps,
        gravity=(0.0, 0.0, -G), output_interval_s=1e-3, log_every_step=False,
    )  # fmt: skip
    small.run(run_dir, spheres)
    ledger = beds.table(run_dir, "history/ledger")
    total = ledger[["films", "bridges", "walls", "left"]].sum(axis=1)
    assert (total - len(spheres) * FILM).abs().max() < 1e-14 * FILM * len(spheres)
    return beds.table(run_dir, "history/drops")


def held(x: float, z: float) -> small.Sphere:
    """A sphere that does not move."""
    return small.Sphere(1, (x, 0.0, z), driven=True)


def test_a_held_sphere_drips_on_the_floor(tmp_path: Path) -> None:
    """The film is 1.3 times what hangs at rest: one drop once the film feels nearly g, and what is left holds."""
    assert 1.2 * HANGS < FILM < 1.4 * HANGS
    drops = drops_of(tmp_path, [held(0.0, 0.03)], [small.floor()])
    assert len(drops) == 1
    drop = drops.iloc[0]
    # 1 - exp(-t/tau) = HANGS/FILM, seen at the next whole millisecond
    tau = math.sqrt(3.0 * RHO * FILM / (32.0 * math.pi * SIGMA))
    waited = math.ceil(-tau * math.log(1.0 - HANGS / FILM) / 1e-3) * 1e-3
    assert drop["time"] == pytest.approx(waited, abs=1e-9)
    felt = G * (1.0 - math.exp(-waited / tau))
    assert drop[["felt_x", "felt_y", "felt_z"]].to_list() == pytest.approx([0.0, 0.0, felt], rel=1e-9)
    assert drop["volume"] == pytest.approx(falling(felt), rel=1e-9)
    assert drop["partner_kind"] == LARGE_WALL and drop["fallen"] == pytest.approx(0.03, rel=1e-12)
    end = beds.table(tmp_path, "history/ledger").iloc[-1]
    assert end["walls"] == pytest.approx(drop["volume"], rel=1e-12) and end["left"] == 0.0


def test_a_wall_film_thickened_by_a_drop_is_seen_at_once(tmp_path: Path) -> None:
    """Nothing moves and no list is made again: a drop raises the film on the floor to that of a sphere next to it."""
    side, gap = 4e-3, 6e-4
    beside = small.Sphere(1, (4e-3, 0.0, R + gap), driven=True, film=film_volume(3e-4, R))
    spheres = [held(1e-3, 0.03), beside]
    small.prepare(
        tmp_path, spheres_of(R), spheres, contacts(1), liquid=SOAPY, effects=DRIPPING, walls=[small.floor(side)], steps=2500,
        gravity=(0.0, 0.0, -G), output_interval_s=1e-3, log_every_step=False,
    )  # fmt: skip
    small.run(tmp_path, spheres)
    drops, events = (beds.table(tmp_path, f"history/{name}") for name in ("drops", "events"))
    assert len(drops) == 1 and drops["volume"].iloc[0] / (2.0 * side**2) > gap - 3e-4
    assert events["step"].to_list() == [drops["step"].iloc[0] + 1] and events["partner_kind"].iloc[0] == LARGE_WALL


def test_drops_where_outputs_are_a_prime_number_of_steps(tmp_path: Path) -> None:
    """Of 97 steps two checks of 48, at which bridges act: the replay applies both as they are logged, to round-off."""
    made = beds.prepare(tmp_path, beds.bed((5, 5, 4)), 970, effects=DRIPPING, liquid=SOAPY)
    scene = EngineScene(**{**made.model_dump(), "bridges_every": 2})
    (tmp_path / "scene.json").write_text(scene.model_dump_json())
    driver.run(tmp_path, progress=False)
    drops, events = (beds.table(tmp_path, f"history/{name}") for name in ("drops", "events"))
    assert (scene.drop_every, scene.output_every) == (48, 96) and (drops["step"] % 48 == 0).all()
    assert (drops["step"] % 96 == 48).sum() > 5 and (drops["step"] % 96 == 0).sum() > 5
    assert len(events) > 50 and (events["step"] % 2 == 0).all()
    output_text = replay(tmp_path)
    assert output_text["ok"], output_text["diagnosis"]
    assert output_text["quantities"]["drop_volume"]["count"] == len(drops)


def test_in_free_flight_nothing_lets_go(tmp_path: Path) -> None:
    """A sphere that falls feels nothing, whatever hangs on it."""
    assert drops_of(tmp_path, [small.Sphere(1, (0.0, 0.0, 0.05), (0.1, 0.0, 0.3))]).empty


def test_drops_fall_on_what_is_below_and_else_leave(tmp_path: Path) -> None:
    """The first surface below the centre, at its height there; next to it there is nothing, and the ledger says so."""
    spheres = [held(0.0, 0.03), held(1e-3, 0.01), held(0.02, 0.03)]
    every = drops_of(tmp_path, spheres, steps=1300)
    drops = every.drop_duplicates("i").set_index("i")
    top = 0.01 + math.sqrt(R**2 - 1e-6)
    assert drops.loc[1, "partner_kind"] == SPHERE and drops.loc[1, "j"] == 2
    assert drops.loc[1, "fallen"] == pytest.approx(0.03 - top, rel=1e-12)
    assert drops.loc[3, "partner_kind"] == NOTHING and drops.loc[3, "j"] == -1
    assert drops.loc[2, "partner_kind"] == NOTHING
    left = beds.table(tmp_path, "history/ledger")["left"].iloc[-1]
    assert left == pytest.approx(every.loc[every["partner_kind"] == NOTHING, "volume"].sum(), rel=1e-12)


def test_a_shaken_film_feels_the_mean_of_a_millisecond(tmp_path: Path) -> None:
    """x = A sin(2 pi t/T), 5 g at the peak: mean of the specific force in each millisecond, followed with the film's own time.

    The engine's speeds are half a step old: 5 microseconds of 20 ms shift the force by at most 0.2 % of 5 g.
    """
    amplitude, period = 5.0 * G * (0.02 / (2.0 * math.pi)) ** 2, 0.02
    start = (0.0, 0.0, amplitude * 2.0 * math.pi / period)
    sphere = small.Sphere(1, (0.0, 0.0, 0.03), start, driven=True, wiggle=((0.0, 0.0, amplitude), period))
    drop = drops_of(tmp_path, [sphere], [small.floor()]).iloc[0]
    omega = 2.0 * math.pi / period
    tau = math.sqrt(3.0 * RHO * FILM / (32.0 * math.pi * SIGMA))
    felt, times = 0.0, np.arange(0.0, 0.04, 1e-3)
    for before, end in pairwise(times):
        mean = amplitude * omega * (math.cos(omega * end) - math.cos(omega * before)) / 1e-3 + G
        felt += (1.0 - math.exp(-1e-3 / tau)) * (mean - felt)
        if abs(felt) > G * HANGS / FILM:
            break
    assert drop["time"] == pytest.approx(end, abs=1e-9) and end > 2e-3
    assert drop["felt_z"] == pytest.approx(felt, abs=0.002 * 5.0 * G)


def test_gravity_aslant(tmp_path: Path) -> None:
    """Each component of the force on a held film is minus gravity's times the same share; the drop falls along gravity."""
    g = np.array([4.0, -3.0, -G])
    small.prepare(
        tmp_path, spheres_of(R), [held(0.0, 0.03)], contacts(1), liquid=SOAPY, effects=DRIPPING, walls=[small.floor(0.1)],
        steps=4000, gravity=(4.0, -3.0, -G), output_interval_s=1e-3, log_every_step=False,
    )  # fmt: skip
    small.run(tmp_path, [held(0.0, 0.03)])
    drop = beds.table(tmp_path, "history/drops").iloc[0]
    felt = drop[["felt_x", "felt_y", "felt_z"]].to_numpy(float)
    assert felt == pytest.approx(-g * np.linalg.norm(felt) / np.linalg.norm(g), rel=1e-9)
    assert drop["fallen"] == pytest.approx(0.03 * np.linalg.norm(g) / G, rel=1e-12)
    assert replay(tmp_path)["ok"]


@pytest.mark.parametrize(
    ("output_s", "step_s", "looks"),
    [(0.02, 1e-5, 20), (0.05, 1e-5, 50), (0.1, 2e-5, 100), (5e-4, 1e-5, 1), (9e-4, 2e-5, 1)],
)
def test_films_are_looked_at_every_millisecond(output_s: float, step_s: float, looks: int) -> None:
    """An output interval has whole numbers of both."""
    made = timed(output_s, step_s)
    assert made.drop_every * step_s == pytest.approx(output_s / looks, rel=1e-12)
    assert made.output_every * step_s == pytest.approx(output_s, rel=1e-12)


def timed(output_s: float, step_s: float, every: int = 1, effects: Effects = DRIPPING) -> EngineScene:
    """Return the part of a scene from which the steps of outputs and drops follow."""
    output = Output(interval_s=output_s)
    return EngineScene.model_construct(output=output, time_step_s=step_s, bridges_every=every, effects=effects)


@pytest.mark.parametrize("every", [1, 2, 3, 7, 16])
@pytest.mark.parametrize(
    ("output_s", "steps"), [(0.02, 1307), (0.02, 1667), (0.05, 7541), (0.1, 3497), (0.1, 30211), (0.1, 22124)]
)
def test_films_are_looked_at_every_millisecond_whatever_the_step(output_s: float, steps: int, every: int) -> None:
    """Outputs of prime numbers of steps, or nearly: checks within the steps of a bridge of 1 ms, outputs within one check."""
    step_s = output_s / steps
    made, dry = timed(output_s, step_s, every), timed(output_s, step_s, every, small.PAPER)
    assert 0.0 <= 1e-3 - made.drop_every * step_s < every * step_s
    assert made.output_every % made.drop_every == made.drop_every % every == 0
    assert 0 <= steps - made.output_every < made.drop_every
    assert dry.output_every == steps - steps % every
    for scene in (made, dry):
        given = json.loads(scene.model_dump_json())
        assert plans.outputs_every(given) == scene.output_every and plans.drops_every(given) == scene.drop_every


def test_ranks_agree_on_drops(tmp_path: Path) -> None:
    """A bed of 200 spheres on a vibrating floor drips alike on one rank and two, and loses nothing."""
    spheres = beds.bed((6, 6, 6))
    effects = DRIPPING.model_copy(update={"liquid_weight": True})
    for ranks in (1, 2):
        beds.prepare(tmp_path / str(ranks), spheres, 700, effects=effects, liquid=SOAPY)
        small.run(tmp_path / str(ranks), spheres, ranks)
    one, two = (beds.table(tmp_path / str(ranks), "history/drops") for ranks in (1, 2))
    assert len(one) > 30 and set(one["partner_kind"]) >= {SPHERE, LARGE_WALL}
    same = ["step", "i", "j", "partner_kind"]
    pd.testing.assert_frame_equal(one[same], two[same])
    assert np.allclose(one["volume"], two["volume"], rtol=1e-7)
    ledger = beds.table(tmp_path / "2", "history/ledger")
    held_in_all = ledger[["films", "bridges", "walls", "left"]].sum(axis=1)
    assert (held_in_all / ledger["initial"] - 1.0).abs().max() < 1e-13


def test_where_nothing_is_wet_or_falls_it_is_refused(tmp_path: Path) -> None:
    """One sentence: without bridges there is neither effect, without gravity no drop falls."""
    for effect in ({"liquid_weight": True}, {"shedding": "tate"}):
        with pytest.raises(ValueError, match="liquid_weight or shedding is on but bridges are off; expected both off"):
            Effects(bridges=False, **effect)
    with pytest.raises(ValueError, match="shedding is tate but there is no gravity for drops to fall; expected none"):
        small.prepare(tmp_path, spheres_of(R), [held(0.0, 0.0)], contacts(1), liquid=SOAPY, effects=DRIPPING)
    assert not (tmp_path / "scene.json").exists()


def test_water_in_a_thin_film_never_drips(tmp_path: Path) -> None:
    """Switched on where nothing is due it changes no bit."""
    spheres = beds.bed((3, 3, 3))
    for name, effects in (("on", DRIPPING), ("off", small.PAPER)):
        beds.prepare(tmp_path / name, spheres, 200, effects=effects, liquid=WATER)
        small.run(tmp_path / name, spheres)
    assert beds.table(tmp_path / "on", "history/drops").empty
    assert beds.apart(tmp_path / "on", tmp_path / "off").max() == 0.0
