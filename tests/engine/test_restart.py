"""A moist run killed with SIGKILL at a random moment goes on from its checkpoint and ends as the unbroken run does.

What is equal and why: the resumed run starts from the same numbers as the unbroken one has at the checkpoint (the engine's
restart file and the plugin's state are binary, forces included), and the engine makes its neighbour lists anew at checkpoints
in both. What may differ is the order of spheres in memory, hence of sums: round-off, which collisions amplify with time.
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

from pywet import small
from pywet.engines.liggghts import checkpoint, deck, driver
from pywet.scene import Scene
from reference_impl.replay import replay
from tests.engine import beds

pytestmark = pytest.mark.engine
STEPS, CHECKPOINTS = 2500, 24
ROUND_OFF = 1e-9
"""Of a radius: round-off of 1e-16 m, amplified by the collisions of 50 ms; a wrong phase or a lost spring shows at 1e-6 m."""


def killed(run_dir: Path, moment: float, ranks: int = 1, after: str = "*[0-9]") -> int:
    """Start a run in a process of its own, SIGKILL it `moment` seconds after it has a checkpoint (`after`: that one).

    Returns the step of the last whole checkpoint.
    """
    code = f"from pywet.engines.liggghts import driver; driver.run({str(run_dir)!r}, {ranks}, progress=False)"
    child = subprocess.Popen([sys.executable, "-c", code], start_new_session=True)
    folder = run_dir / "engine.partial" / checkpoint.FOLDER
    deadline = time.monotonic() + 120.0
    while not list(folder.glob(f"sums.{after}.json")) and time.monotonic() < deadline and child.poll() is None:
        time.sleep(0.01)
    time.sleep(moment)
    os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    return max(int(path.name.split(".")[1]) for path in folder.glob("sums.*.json"))


def compare(unbroken: Path, resumed: Path) -> None:
    """Same events and bridges, the same ledger and trajectory to round-off; nothing twice and nothing missing in the logs."""
    events, again = (beds.table(p, "history/events") for p in (unbroken, resumed))
    pd.testing.assert_frame_equal(events[beds.LOOKS], again[beds.LOOKS])
    assert np.allclose(events["volume"], again["volume"], rtol=1e-9, atol=0.0)
    pd.testing.assert_frame_equal(beds.standing(unbroken), beds.standing(resumed))
    ledger, after = (beds.table(p, "history/ledger") for p in (unbroken, resumed))
    assert ledger["step"].tolist() == after["step"].tolist()
    for column in ("films", "bridges", "walls"):
        assert np.allclose(ledger[column], after[column], rtol=0.0, atol=1e-12 * ledger["initial"].iloc[0])
    assert beds.apart(unbroken, resumed).max() < ROUND_OFF * beds.RADIUS
    for name in ("contacts", "films", "energy", "window_states", "window_pair_springs"):
        assert len(beds.table(unbroken, f"history/{name}")) == len(beds.table(resumed, f"history/{name}"))
    work, same = (beds.table(p, "history/energy").iloc[-1] for p in (unbroken, resumed))
    for column in ("contact", "capillary", "viscous_normal", "wall_motion"):
        assert same[column] == pytest.approx(work[column], rel=1e-9)
    for run_dir in (unbroken, resumed):
        result = replay(run_dir)
        assert result["ok"] and result["quantities"]["newton_force"]["count"] > 10_000


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
    """One kill at a random moment."""
    beds.prepare(tmp_path, beds.bed((9, 9, 7)), STEPS, CHECKPOINTS)
    last = killed(tmp_path, float(np.random.default_rng().uniform(0.0, 1.0)))
    info = driver.run(tmp_path, progress=False)
    stops = deck.boundaries(Scene.read(tmp_path / "scene.json"))
    assert info.resumed_at_step == last or last in stops
    compare(unbroken, tmp_path)


def test_killed_just_after_the_plate_has_stopped(unbroken: Path, tmp_path: Path) -> None:
    """The checkpoint of the step at which a stage ends is not one to go on from: what moved until then is not in it."""
    scene = beds.prepare(tmp_path, beds.bed((9, 9, 7)), STEPS, CHECKPOINTS)
    (stop,) = {s for s in deck.boundaries(scene) - {STEPS} if s % deck.checkpoint_every(scene) == 0}
    killed(tmp_path, 0.0, after=str(stop))
    assert driver.run(tmp_path, progress=False).resumed_at_step != stop
    compare(unbroken, tmp_path)


def test_dry_run_goes_on_too(tmp_path: Path) -> None:
    """A dry run goes on from the engine's own file, whose contact springs are one step old and whose first half kick is new.

    Both are of the order of one step: at the first output after the resumption spheres are within 1e-3 of a radius.
    """
    spheres, steps = beds.bed((9, 9, 7)), 6000
    for name in ("whole", "killed"):
        scene = beds.prepare(tmp_path / name, spheres, steps, checkpoints=59, outputs=300)
        dry = scene.model_copy(update={"effects": small.DRY})
        (tmp_path / name / "scene.json").write_text(dry.model_dump_json())
    driver.run(tmp_path / "whole", progress=False)
    code = f"from pywet.engines.liggghts import driver; driver.run({str(tmp_path / 'killed')!r}, progress=False)"
    child = subprocess.Popen([sys.executable, "-c", code], start_new_session=True)
    folder = tmp_path / "killed" / "engine.partial"
    while not list(folder.glob("checkpoint/sums.*.json")) and child.poll() is None:
        time.sleep(0.01)
    os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    at = driver.run(tmp_path / "killed", progress=False).resumed_at_step
    assert at is not None and at > 0
    distance = beds.apart(tmp_path / "whole", tmp_path / "killed")
    assert len(distance) == 301 and distance[distance.index <= at].max() == 0.0
    assert distance[distance.index > at].iloc[0] < 1e-3 * beds.RADIUS


@pytest.mark.slow
@pytest.mark.parametrize("number", range(10))
def test_ten_kills(unbroken: Path, tmp_path: Path, number: int) -> None:
    """Ten kills, some of runs on two ranks that go on with one."""
    beds.prepare(tmp_path, beds.bed((9, 9, 7)), STEPS, CHECKPOINTS)
    killed(tmp_path, float(np.random.default_rng().uniform(0.0, 1.5)), ranks=1 + number % 2)
    assert driver.run(tmp_path, progress=False).resumed_at_step is not None
    compare(unbroken, tmp_path)
