"""Spheres that lie in the bin are taken out at checkpoints: who, with which liquid, and that nobody else is touched by it.

The bin of these scenes is the floor of a bed, its lowest layer lies on it; the plane is three radii above what may be retired.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.engines import schedule
from pywet.engines.liggghts import driver
from pywet.errors import PywetError
from pywet.runs import retired
from pywet.runs.rundir import RunDir
from pywet.runs.tables import ledger_error
from pywet.scene import Effects, EngineScene
from pywet.schema import RAW
from pywet.util.files import read_table
from reference_impl.replay.io import ReplayError
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds, injected_in_bin

pytestmark = pytest.mark.engine
LENGTH = {"steps": 1200, "checkpoints": 11, "outputs": 100}
"""24 ms, looked at who has come to rest every 108 steps."""


def run(run_dir: Path, scene: EngineScene, ranks: int = 1) -> Path:
    """Run a scene whose directory is prepared."""
    (run_dir / "scene.json").write_text(EngineScene.model_validate(scene.model_dump()).model_dump_json())
    driver.run(run_dir, ranks, progress=False)
    return run_dir


@pytest.fixture(scope="module")
def moist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A moist bed of 95 spheres, of which those on the floor are retired."""
    run_dir = tmp_path_factory.mktemp("moist")
    return run(run_dir, beds.retiring(run_dir, **LENGTH))


def test_all_tables_hold_all_spheres(moist: Path) -> None:
    """A retired sphere lies where it was, with the film it left with; the ledger closes to 1e-12 of the liquid."""
    gone, line = beds.table(moist, "history/retired"), RunDir(moist).timeline
    films, trajectory = beds.table(moist, "history/films"), beds.table(moist, "trajectory")
    assert len(gone) > 10 and gone["id"].is_unique
    assert (trajectory.groupby("step").size() == 95).all() and (films.groupby("step").size() == 95).all()
    assert line.present.all()
    for row in gone.itertuples():
        after = trajectory[(trajectory["id"] == row.id) & (trajectory["step"] > row.step)]
        assert (after[["x", "y", "z"]] == [row.x_x, row.x_y, row.x_z]).all(axis=None)
        assert (after[["vx", "vy", "vz", "wx", "wy", "wz"]] == 0.0).all(axis=None)
        assert (films[(films["id"] == row.id) & (films["step"] >= row.step)]["film"] == row.film).all()
    ledger = beds.table(moist, "history/ledger")
    held = [gone["film"][gone["step"] <= step].sum() for step in ledger["step"]]
    assert ledger["retired"].to_numpy() == pytest.approx(held, rel=1e-13)
    assert ledger["retired"].iloc[-1] > 0.1 * ledger["initial"].iloc[-1] and ledger_error(ledger) < 1e-12


def test_who_is_retired_and_when(moist: Path) -> None:
    """Two largest diameters below the plane, slower than what lifts by a hundredth of that; at checkpoints outside the windows.

    By hand: 0.016 m - 2 x 5 mm, and sqrt(2 x 9.81 x 0.01 x 0.01) m/s. The trajectory holds who qualifies at these outputs.
    """
    scene, gone, left = EngineScene.read(moist / "scene.json"), beds.table(moist, "history/retired"), set()
    below, slower = 0.006, 0.0442944691807
    assert (scene.retire_below_m, scene.retire_slower_m_per_s) == pytest.approx((below, slower), rel=1e-9)
    trajectory = beds.table(moist, "trajectory")
    windows = [*range(290, 310), *range(890, 910)]
    for step in sorted(set(range(108, 1200, 108)) - set(windows)):
        here = trajectory[(trajectory["step"] == step) & ~trajectory["id"].isin(left)]
        speed = np.sqrt((here[["vx", "vy", "vz"]] ** 2).sum(axis=1))
        due = set(here["id"][(here["z"] < below) & (speed < slower)])
        assert set(gone["id"][gone["step"] == step]) == due
        left |= due
    assert set(gone["id"]) == left


def test_steps_at_which_spheres_are_retired(moist: Path) -> None:
    """They are outputs, a quarter of a second apart at most; without retirement as few as are asked for."""
    scene = EngineScene.read(moist / "scene.json")
    assert schedule.checkpoints(scene) == list(range(108, 1200, 108))
    slow = {"duration_s": 1.2, "output": scene.output.model_copy(update={"interval_s": 0.02, "checkpoints": 2})}
    assert schedule.checkpoint_every(scene.model_copy(update=slow)) == 12_000  # 0.24 s, twelve outputs
    assert schedule.checkpoint_every(scene.model_copy(update={**slow, "retire": False})) == 20000


def test_bridges_end_with_the_shares_of_a_rupture(moist: Path) -> None:
    """A bridge of a retired sphere gives both sides what it would have given them at rupture; there is none of it afterwards."""
    events, gone = beds.table(moist, "history/events"), beds.table(moist, "history/retired").set_index("id")["step"]
    ended = events[events["kind"] == 2]
    assert set(ended["partner_kind"]) == {0, 1} and len(ended) > 10
    first = ended["i"].map(gone).fillna(1e9).to_numpy()
    first = np.minimum(first, ended["j"].where(ended["partner_kind"] == 0).map(gone).fillna(1e9).to_numpy())
    assert (first == ended["step"]).all()
    half = ended[(ended["partner_kind"] == 0) & (ended["share_i"] == ended["share_j"])]
    assert (ended["share_i"] + ended["share_j"]).to_numpy() == pytest.approx(ended["volume"].to_numpy(), rel=1e-14)
    assert len(half) < len(ended)  # the transfer law depends on both radii, so shares are unequal
    bridges = beds.table(moist, "history/bridges")
    late = bridges["i"].map(gone).fillna(1e9) <= bridges["step"]
    assert not late.any()


def test_the_replay_agrees(moist: Path) -> None:
    """Everything is recomputed from the start films, retirement included, and Newton's law closes for those that stay."""
    result = replay(moist)
    assert result["ok"], [name for name, q in result["quantities"].items() if not q["ok"]]
    rows, gone = result["quantities"], len(beds.table(moist, "history/retired"))
    assert all(rows[f"retired_{name}"]["count"] == gone for name in ("who", "place", "speed", "film"))
    assert rows["newton_force"]["count"] < 2 * 19 * 95  # spheres retired before a window are excluded


def test_who_stays_is_not_touched(tmp_path: Path) -> None:
    """A second heap, 4 cm above the first and in motion: its spheres are where they are without retirement, to 1e-12 of a radius.

    A part of its contacts slides: tangential springs must have stayed with their pairs.
    """
    random, runs = np.random.default_rng(3), []
    lower = [
        small.Sphere(1, (0.006 * i, 0.006 * j, beds.RADIUS), (0.0, 0.0, 0.0))
        for i in range(-2, 2)
        for j in range(-2, 2)
    ]
    upper = [
        small.Sphere(1 + (i + j + k) % 2, (0.0049 * i, 0.0049 * j, 0.05 + 0.0049 * k), tuple(random.normal(0.0, 0.1, 3)))
        for i in range(-2, 2) for j in range(-2, 2) for k in range(3)
    ]  # fmt: skip
    for bin_z in (0.016, -1.0):
        run_dir = tmp_path / str(bin_z)
        scene = beds.prepare(run_dir, lower + upper, steps=600, checkpoints=3, outputs=20)
        output = scene.output.model_copy(update={"energy": False})
        walls = {"walls": tuple(w for w in scene.walls if w.name == "shaken"), "vibration": None}
        walls["walls"] = tuple(w.model_copy(update={"motion": "fixed"}) for w in scene.walls)
        scene = scene.model_copy(update={"retire": True, "bin_z_m": bin_z, "output": output, "slide": None, **walls})
        runs.append(run(run_dir, scene))
    gone, nobody = (beds.table(p, "history/retired") for p in runs)
    assert len(nobody) == 0 and set(gone["id"]) <= set(range(1, 17)) and len(gone) > 8
    a, b = (beds.table(p, "trajectory").query("id > 16").set_index(["step", "id"])[["x", "y", "z"]] for p in runs)
    assert np.abs(a - b).max(axis=None) < 1e-12 * beds.RADIUS
    events = beds.table(runs[0], "history/events")
    assert (events["i"] > 16).sum() > 50


@pytest.mark.parametrize("effects", [small.PAPER, small.DRY], ids=["moist", "dry"])
def test_all_are_retired(tmp_path: Path, effects: Effects) -> None:
    """A layer at rest in the bin leaves at the first checkpoint: all tables hold it at all outputs, and are made once."""
    layer = [small.Sphere(1, (0.006 * i, 0.006 * j, beds.RADIUS)) for i in range(-2, 2) for j in range(-2, 2)]
    scene = beds.prepare(tmp_path, layer, **LENGTH, effects=effects)
    output = scene.output.model_copy(update={"energy": False, "contact_windows": 10})
    fixed = tuple(w.model_copy(update={"motion": "fixed"}) for w in scene.walls)
    still = {"walls": fixed, "vibration": None, "slide": None}
    run(tmp_path, scene.model_copy(update={"retire": True, "bin_z_m": 0.016, "output": output, **still}))
    gone, trajectory = (beds.table(tmp_path, name) for name in ("history/retired", "trajectory"))
    assert len(gone) == 16 and (gone["step"] == 108).all()
    assert trajectory.groupby("step").size().to_dict() == dict.fromkeys(range(0, 1201, 12), 16)
    at = gone.set_index("id")[["x_x", "x_y", "x_z"]].sort_index().to_numpy()
    last = trajectory[trajectory["step"] == 1200].sort_values("id")
    assert (last[[*"xyz"]].to_numpy() == at).all() and (last[["vx", "vy", "vz"]] == 0.0).all(axis=None)
    assert beds.table(tmp_path, "history/window_states")["step"].max() < 108
    if effects.bridges:
        films = beds.table(tmp_path, "history/films")
        assert films.groupby("step").size().to_dict() == dict.fromkeys(range(0, 1201, 12), 16)
        assert ledger_error(beds.table(tmp_path, "history/ledger")) < 1e-12
    assert replay(tmp_path)["ok"]
    assert driver.run(tmp_path, progress=False, keep=True).resumed_at_step is None


def test_parts_of_the_steps_after_the_last_retirement(monkeypatch: pytest.MonkeyPatch) -> None:
    """Seven steps with three spheres each, in parts of about two steps."""
    monkeypatch.setattr(retired, "ROWS", 6)
    gone = np.zeros(3, RAW["retired"])
    gone["step"], gone["id"] = 4, [1, 2, 3]
    start = pd.DataFrame(
        {"step": [0], "time": [0.0], "id": [1], "type": [1], **dict.fromkeys([*"xyz", *retired.MOTION], 1.0)}
    )
    first, *parts = retired.with_places(iter([start]), gone, 0.1, np.arange(5, 12))
    assert len(first) == 1 and [len(part) for part in parts] == [6, 6, 6, 3]
    assert pd.concat(parts)["step"].tolist() == np.repeat(np.arange(5, 12), 3).tolist()


def test_two_ranks_retire_the_same(moist: Path, tmp_path: Path) -> None:
    """Expect the same spheres at the same steps with the same films, to round-off."""
    two = run(tmp_path, beds.retiring(tmp_path, **LENGTH), ranks=2)
    one, other = (beds.table(p, "history/retired").sort_values(["step", "id"], ignore_index=True) for p in (moist, two))
    pd.testing.assert_frame_equal(one, other, rtol=1e-9, atol=1e-12)
    events, same = (beds.table(p, "history/events") for p in (moist, two))
    pd.testing.assert_frame_equal(events[beds.LOOKS], same[beds.LOOKS])
    assert ledger_error(read_table(two / "history" / "ledger.parquet")) < 1e-12 and replay(two)["ok"]


def test_a_dry_run(tmp_path: Path) -> None:
    """Without liquid the plugin is there for retirement alone; the replay says who and goes on."""
    scene = beds.retiring(tmp_path, **LENGTH).model_copy(update={"effects": small.DRY})
    result = replay(run(tmp_path, scene))
    gone = beds.table(tmp_path, "history/retired")
    assert result["ok"] and len(gone) > 10 and (gone["film"] == 0.0).all()
    assert result["quantities"]["retired_missed"]["count"] == 101 * 95


@pytest.mark.parametrize("name", injected_in_bin.FAULTS)
def test_injected_faults_are_found(moist: Path, tmp_path: Path, name: str) -> None:
    """Change what a correct run has written: the quantity disagrees, and a sentence names it."""
    table, change, quantity, words = injected_in_bin.FAULTS[name]
    shutil.copytree(moist, tmp_path, dirs_exist_ok=True)
    frame = beds.table(tmp_path, table)
    frame.attrs["gone"] = int(beds.table(moist, "history/retired")["id"].iloc[0])
    change(frame).to_parquet(tmp_path / f"{table}.parquet", index=False)
    result = replay(tmp_path)
    assert not result["ok"] and not result["quantities"][quantity]["ok"]
    output_text = [s for f in result["diagnosis"]["findings"] for s in (f["sentence"], *f["consequences"])]
    assert any(words in sentence for sentence in output_text), output_text


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [
        ("step", 120, "no checkpoint outside the windows"),
        ("id", 96, "the start does not have"),
        ("type", 3, "the start does not have"),
    ],
)
def test_a_table_that_cannot_be_is_refused(moist: Path, tmp_path: Path, column: str, value: int, words: str) -> None:
    shutil.copytree(moist, tmp_path, dirs_exist_ok=True)
    table = beds.table(tmp_path, "history/retired")
    table.loc[0, column] = value
    table.to_parquet(tmp_path / "history" / "retired.parquet", index=False)
    with pytest.raises(ReplayError, match=words):
        replay(tmp_path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"output": {"checkpoints": 0}}, "output.checkpoints is 0"),
        ({"output": {"energy": True}}, "its budget is of all spheres"),
        ({"effects": {"shedding": "tate"}}, "drops may land on spheres in the bin"),
        ({"gravity_m_per_s2": (9.81, 0.0, 0.0)}, "nothing comes to rest in the bin"),
    ],
)
def test_refused_where_something_is_asked_of_the_bin(moist: Path, change: dict, words: str) -> None:
    given = EngineScene.read(moist / "scene.json").model_dump()
    for key, value in change.items():
        given[key] = {**given[key], **value} if isinstance(value, dict) else value
    with pytest.raises((PywetError, ValueError), match=words):
        EngineScene.model_validate(given)
