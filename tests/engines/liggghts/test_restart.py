"""A run killed with SIGKILL resumes from its checkpoint and ends with the same tables as the unbroken one, to the last bit.

Why that can be: at each checkpoint an unbroken run empties the engine and resumes from the files it has just written, as a
killed one does. Every column of every table is compared: trajectory, events, contacts, films, bridges, ledger, energy, and motion
and springs in the windows.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.engines import run_store, schedule
from pywet.engines.liggghts import deck, driver
from pywet.runs.tables import ledger_error
from pywet.scene import EngineScene
from pywet.util.files import read_table
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER

pytestmark = pytest.mark.engine
STEPS, CHECKPOINTS = 2500, 24
SMALL = {"steps": 1200, "checkpoints": 11, "outputs": 100}
"""About a hundred spheres for 24 ms, a checkpoint at every hundredth step; the slide is drawn from step 360 to 960."""
DRIPPING = small.PAPER.model_copy(update={"liquid_weight": True, "shedding": "tate"})
SOAPY = WATER.model_copy(update={"surface_tension_N_per_m": 0.02, "initial_film_thickness_m": 4.5e-4})
CHANGES = {
    "moist": {},
    "semi_implicit": {"viscous_integration": "semi_implicit"},
    "exact": {"effects": small.EXACT},
    "impulses": {"bridges_every": 4},
    "drops": {"effects": DRIPPING},
    "dry": {"effects": small.DRY},
    "hertz": {},  # see beds.hertzian
}


def saved(run_dir: Path) -> list[int]:
    """Steps of the checkpoints that are there and whole."""
    folder = run_dir / "engine.partial" / run_store.CHECKPOINTS
    return sorted(int(path.name.split(".")[1]) for path in folder.glob("sums.*.json"))


def killed(run_dir: Path, ranks: int = 1, after: int = 1, moment: float = 0.0) -> int:
    """Start a run in a process group of its own, SIGKILL it `moment` seconds after it has a checkpoint at step `after` or later.

    Returns the step of the last checkpoint.
    """
    code = f"from pywet.engines.liggghts import driver; driver.run({str(run_dir)!r}, {ranks}, progress=False)"
    child = subprocess.Popen([sys.executable, "-c", code], start_new_session=True)
    deadline = time.monotonic() + 120.0
    while max(saved(run_dir), default=0) < after and time.monotonic() < deadline and child.poll() is None:
        time.sleep(0.002)
    time.sleep(moment)
    os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    return max(saved(run_dir))


def same_bits(unbroken: Path, resumed: Path) -> None:
    """Expect the same tables with the same rows and the same bits in every column."""
    tables = sorted(path.relative_to(unbroken) for path in unbroken.rglob("*.parquet"))
    assert tables == sorted(path.relative_to(resumed) for path in resumed.rglob("*.parquet"))
    for name in tables:
        one, two = (pd.read_parquet(folder / name) for folder in (unbroken, resumed))
        assert len(one) == len(two) and list(one) == list(two), name
        for column in one:
            a, b = one[column], two[column]
            bits = a.dtype.kind in "fiub" and a.to_numpy().tobytes() == b.to_numpy().tobytes()
            assert bits or (a.dtype.kind not in "fiub" and a.equals(b)), f"{name}: {column}"


def prepare(run_dir: Path, kind: str, **more: int) -> EngineScene:
    """A small bed between a vibrating floor and a drawn plate."""
    liquid = SOAPY if kind == "drops" else WATER
    if kind == "retired":
        scene = beds.retiring(run_dir, **{**SMALL, **more})
        (run_dir / "scene.json").write_text(scene.model_dump_json())
        return scene
    scene = beds.prepare(run_dir, beds.bed((5, 5, 5)), **{**SMALL, **more}, liquid=liquid).model_copy(
        update=CHANGES[kind]
    )
    scene = beds.hertzian(scene) if kind == "hertz" else scene
    (run_dir / "scene.json").write_text(scene.model_dump_json())
    return scene


def kill_and_compare(tmp_path: Path, kind: str, ranks: int, moments: tuple[int, ...]) -> None:
    """One run in one piece; for each of the steps one that is killed after its checkpoint there and goes on."""
    # a dry step is fast, and the run must last until it is killed
    more = {"steps": 6000, "checkpoints": 59} if kind == "dry" else {}
    prepare(tmp_path / "whole", kind, **more)
    driver.run(tmp_path / "whole", ranks, progress=False)
    if kind != "dry":
        events = beds.table(tmp_path / "whole", "history/events")
        # soft spheres do not separate again in so short a run
        ends = {"retired": {0, 1, 2}, "hertz": {0}}.get(kind, {0, 1})
        assert len(events) > 70 and set(events["kind"]) == ends and set(events["partner_kind"]) >= {0, 1}
        assert (len(beds.table(tmp_path / "whole", "history/drops")) > 20) == (kind == "drops")
    for step in moments:
        folder = tmp_path / str(step)
        prepare(folder, kind, **more)
        last = killed(folder, ranks, step)
        at = driver.run(folder, ranks, progress=False).resumed_at_step
        assert (
            at is not None and step - schedule.checkpoint_every(EngineScene.read(folder / "scene.json")) <= at <= last
        )
        same_bits(tmp_path / "whole", folder)


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A moist bed of more than 500 spheres on a vibrating floor, with a plate drawn through it, run in one piece."""
    run_dir = tmp_path_factory.mktemp("unbroken")
    spheres = beds.bed((9, 9, 7))
    assert len(spheres) >= 500
    beds.prepare(run_dir, spheres, STEPS, CHECKPOINTS)
    small.run(run_dir, spheres)
    ledger = beds.table(run_dir, "history/ledger").iloc[-1]
    assert ledger["formations"] > 1000 and ledger["ruptures"] > 200
    return run_dir


def test_killed_and_resumed(unbroken: Path, tmp_path: Path) -> None:
    """One kill of the large bed at a random moment; both runs pass the replay."""
    beds.prepare(tmp_path, beds.bed((9, 9, 7)), STEPS, CHECKPOINTS)
    last = killed(tmp_path, moment=float(np.random.default_rng().uniform(0.0, 1.0)))
    assert driver.run(tmp_path, progress=False).resumed_at_step == last
    same_bits(unbroken, tmp_path)
    result = replay(unbroken)
    assert result["ok"] and result["quantities"]["newton_force"]["count"] > 10_000
    assert replay(tmp_path)["quantities"] == result["quantities"]


@pytest.mark.parametrize(
    ("kind", "ranks", "moments"),
    [
        ("moist", 1, (500,)),
        ("moist", 2, (700,)),
        ("impulses", 1, (500,)),
        ("dry", 1, (2500,)),
        ("drops", 1, (500,)),
        ("hertz", 1, (500,)),
        ("retired", 1, (500,)),
        ("retired", 2, (700,)),
    ],
)
def test_the_same_bits(tmp_path: Path, kind: str, ranks: int, moments: tuple[int, ...]) -> None:
    """While the slide is drawn, on one rank and two; a dry run on the stock program."""
    kill_and_compare(tmp_path, kind, ranks, moments)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "ranks", "moments"),
    [
        ("moist", 2, (100, 300, 900, 1100)),
        ("semi_implicit", 1, (200, 600, 1000)),
        ("semi_implicit", 2, (200, 600, 1000)),
        ("impulses", 2, (200, 600, 1000)),
        ("exact", 1, (200, 600, 1000)),
        ("exact", 2, (200, 600, 1000)),
        ("dry", 1, (600, 2000, 3600, 5000)),
        ("dry", 2, (600, 2000, 3600, 5000)),
        ("hertz", 2, (200, 600, 1000)),
    ],
)
def test_the_same_bits_of_all_kinds(tmp_path: Path, kind: str, ranks: int, moments: tuple[int, ...]) -> None:
    """Every way in which drag is integrated, the exact force, and dry; before, while and after the slide is drawn."""
    kill_and_compare(tmp_path, kind, ranks, moments)


@pytest.mark.parametrize(("first", "then"), [(2, 1), pytest.param(1, 4, marks=pytest.mark.slow)])
def test_goes_on_with_other_ranks(tmp_path: Path, first: int, then: int) -> None:
    """The state of a checkpoint is of spheres and bridges, not of ranks: the same events and ledger as on one rank, 8 ms long."""
    more = {"steps": 400, "checkpoints": 7, "outputs": 20}
    prepare(tmp_path / "whole", "drops", **more)
    driver.run(tmp_path / "whole", progress=False)
    prepare(tmp_path / "other", "drops", **more)
    killed(tmp_path / "other", first)
    assert driver.run(tmp_path / "other", then, progress=False).resumed_at_step
    runs = (tmp_path / "whole", tmp_path / "other")
    events, same = (beds.table(p, "history/events") for p in runs)
    assert len(events) > 20
    pd.testing.assert_frame_equal(events[beds.LOOKS], same[beds.LOOKS])
    pd.testing.assert_frame_equal(*(beds.table(p, "history/ledger") for p in runs), rtol=1e-9, atol=1e-21)
    assert beds.apart(*runs).max() < 1e-9 * beds.RADIUS


def test_killed_where_the_plate_stops(tmp_path: Path) -> None:
    """A checkpoint at the step at which the slide stops, which is then no longer drawn, is one to go on from."""
    for name in ("whole", "killed"):
        prepare(tmp_path / name, "moist", checkpoints=4)
    pieces = deck.runs(EngineScene.read(tmp_path / "whole" / "scene.json"))
    (stop,) = (piece.checkpoint for piece in pieces if piece.after)
    assert stop == 960
    driver.run(tmp_path / "whole", progress=False)
    killed(tmp_path / "killed", after=stop)
    assert driver.run(tmp_path / "killed", progress=False).resumed_at_step == stop
    same_bits(tmp_path / "whole", tmp_path / "killed")


def test_checkpoints_change_nothing_but_round_off(tmp_path: Path) -> None:
    """Emptying the engine loses nothing: with and without checkpoints a moist run is the same to 1e-9 of a radius over 24 ms.

    A dry run takes half a kick at each checkpoint with the speeds of the step, not half a step back: less than 1e-3 of a radius.
    """
    for kind, limit in (("moist", 1e-9), ("dry", 1e-3)):
        for count in (0, 11):
            prepare(tmp_path / f"{kind}{count}", kind, checkpoints=count)
            driver.run(tmp_path / f"{kind}{count}", progress=False)
        distance = beds.apart(tmp_path / f"{kind}0", tmp_path / f"{kind}11")
        assert len(distance) == 101 and distance.max() < limit * beds.RADIUS


def test_pieces_of_a_run(tmp_path: Path) -> None:
    """Cut at checkpoints and where the slide starts and stops; while it is drawn each piece says so: the engine was emptied."""
    scene = prepare(tmp_path, "moist", checkpoints=3)
    pieces = deck.runs(scene)
    assert [piece.steps for piece in pieces] == [300, 60, 240, 300, 60, 240]
    assert [piece.checkpoint for piece in pieces] == [300, None, 600, 900, None, None]
    assert [len(piece.before) for piece in pieces] == [0, 0, 1, 1, 1, 0]
    assert [len(piece.after) for piece in pieces] == [0, 0, 0, 0, 1, 0]
    assert deck.runs(scene, 600) == pieces[3:]


def test_a_dry_run_is_not_set_up_anew_in_a_window(tmp_path: Path) -> None:
    """Motion in a window is checked against the forces recorded, and a dry run takes those of a checkpoint again."""
    for kind, expected in (("moist", [300, 600, 900]), ("dry", [309, 600, 909])):
        pieces = deck.runs(prepare(tmp_path / kind, kind, checkpoints=3))  # windows: 290-309 and 890-909
        assert [piece.checkpoint for piece in pieces if piece.checkpoint] == expected


@pytest.mark.slow
@pytest.mark.parametrize("number", range(10))
def test_ten_kills(unbroken: Path, tmp_path: Path, number: int) -> None:
    """Ten kills of the large bed at random moments."""
    beds.prepare(tmp_path, beds.bed((9, 9, 7)), STEPS, CHECKPOINTS)
    killed(tmp_path, moment=float(np.random.default_rng().uniform(0.0, 1.5)))
    # the engine may have come to its end before, so that there was nothing to resume
    ended = any((tmp_path / name).exists() for name in ("engine.partial/finished.json", "engine/run.json"))
    assert driver.run(tmp_path, progress=False).resumed_at_step is not None or ended
    same_bits(unbroken, tmp_path)


@pytest.mark.slow
def test_another_number_of_ranks(tmp_path: Path) -> None:
    """A run of two ranks that goes on with one sums forces in another order: the same events, positions to 1e-9 of a radius."""
    for name in ("whole", "killed"):
        prepare(tmp_path / name, "moist")
    driver.run(tmp_path / "whole", 2, progress=False)
    killed(tmp_path / "killed", 2, 500)
    assert driver.run(tmp_path / "killed", 1, progress=False).resumed_at_step is not None
    events, same = (beds.table(tmp_path / name, "history/events")[beds.LOOKS] for name in ("whole", "killed"))
    pd.testing.assert_frame_equal(events, same)
    assert beds.apart(tmp_path / "whole", tmp_path / "killed").max() < 1e-9 * beds.RADIUS
    assert 0.0 <= ledger_error(read_table(tmp_path / "killed" / "history" / "ledger.parquet")) < 1e-12
