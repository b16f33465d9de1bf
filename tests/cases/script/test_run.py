"""Scripts of the user's own in the engine: dry as the stock program, wet with bridges and a ledger that closes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.script import folder
from pywet.cases.script.folder import SCRIPT
from pywet.runs import record
from pywet.schema import RAW
from reference_impl.replay.command import outcome
from tests.cases.script.scripts import AFTER, BEFORE, LINE, PLATE_ALONE, SHAKEN, WET, read, run, write

pytestmark = pytest.mark.engine


@pytest.mark.parametrize(
    "before", [BEFORE, pytest.param(SHAKEN, marks=pytest.mark.slow)], ids=["planes", "vibrating mesh"]
)
def test_without_liquid_the_motion_is_that_of_the_stock_program(tmp_path: Path, before: str) -> None:
    stock, ours = tmp_path / "stock", tmp_path / "ours"
    for where, line, wet in ((stock, "", WET), (ours, LINE, WET.replace("1.0", "0"))):
        where.mkdir()
        write(where, before=before, line=line, wet=wet)
    assert run(stock, "liggghts").returncode == 0
    done = run(ours)
    assert done.returncode == 0, done.stderr
    dumped = (stock / "dump.txt").read_text()
    assert dumped.count("ITEM: TIMESTEP") == 6
    assert (ours / "dump.txt").read_text() == dumped


@pytest.mark.slow
@pytest.mark.parametrize(
    "models",
    [
        "hooke tangential no_history",
        "hooke tangential history rolling_friction cdt",
        "hertz tangential history rolling_friction epsd2",
        "hertz tangential no_history rolling_friction cdt",
    ],
)
def test_contact_models_are_those_of_the_script(tmp_path: Path, models: str) -> None:
    """Without liquid bit for bit the stock program; with liquid the ledger closes."""
    materials = """fix             m5 all property/global coefficientRollingFriction peratomtypepair 1 0.1
fix             m6 all property/global coefficientRollingViscousDamping peratomtypepair 1 0.1
fix             m7 all property/global characteristicVelocity scalar 0.5
pair_style"""
    text = BEFORE.replace("model hertz tangential history", f"model {models}").replace("pair_style", materials)
    text = text.replace("model hertz &\n                tangential history", f"model {models}")
    after = AFTER.replace("run             1500", "run             1000")
    for name, line, wet in (("stock", "", WET), ("ours", LINE, WET.replace("1.0", "0")), ("wet", LINE, WET)):
        (tmp_path / name).mkdir()
        write(tmp_path / name, before=text, line=line, wet=wet, after=after)
    assert run(tmp_path / "stock", "liggghts").returncode == 0
    for name in ("ours", "wet"):
        done = run(tmp_path / name)
        assert done.returncode == 0, done.stderr
    dumped = (tmp_path / "stock" / "dump.txt").read_text()
    assert dumped.count("ITEM: TIMESTEP") > 2 and (tmp_path / "ours" / "dump.txt").read_text() == dumped
    ledger = table(tmp_path / "wet", "ledger")
    assert np.abs((ledger["films"] + ledger["bridges"]) / ledger["initial"] - 1).max() < 1e-12
    assert ledger["formations"].iloc[-1] > 10


@pytest.mark.slow
def test_with_liquid_bridges_form_as_the_law_says_and_nothing_is_lost(tmp_path: Path) -> None:
    """Shares of every formation by Shi and McCarthy's law, from the film that the sphere had, which its bridges leave enough."""
    write(tmp_path)
    done = run(tmp_path)
    assert done.returncode == 0, done.stderr
    events, ledger = (table(tmp_path, name) for name in ("events", "ledger"))
    formed = events[events["kind"] == 0]
    assert len(formed) > 50 and (events["kind"] == 1).sum() > 5
    assert ledger["step"].tolist() == list(range(1, 3002, 100))
    total = ledger["films"] + ledger["bridges"]
    assert np.abs(total / ledger["initial"] - 1).max() < 1e-12
    films = table(tmp_path, "films")
    first = films[films["step"] == 1].set_index("id")["film"]
    radius = pd.Series(np.where(np.cbrt(first / (0.01 * 2.5) * 3 / (4 * np.pi)) < 0.0025, 0.002, 0.003), first.index)
    r_i, r_j = radius[formed["i"]].to_numpy(), radius[formed["j"]].to_numpy()
    share = 0.5 * (1 - np.sqrt(1 - (r_j / (r_i + r_j)) ** 2))
    assert formed["share_i"].to_numpy() == pytest.approx(share * formed["film_i_before"].to_numpy(), rel=1e-9)


@pytest.mark.slow
def test_velocities_are_of_the_step_itself(tmp_path: Path) -> None:
    """In free flight the mean velocity of two outputs is the way over the time, and their difference is that by gravity."""
    write(tmp_path)
    assert run(tmp_path).returncode == 0
    at = pd.read_parquet(tmp_path / "wet" / "trajectory.parquet").sort_values(["id", "step"])
    then = at.groupby("id").shift()
    time = 1e-5 * (at["step"] - then["step"])
    free = ((at["vz"] - then["vz"]) / time + 9.81).abs() < 1e-7
    off = (at["z"] - then["z"]) / time - 0.5 * (at["vz"] + then["vz"])
    assert free.sum() > 20 and off[free].abs().max() < 1e-8
    (noted,) = (tmp_path / "wet").rglob(SCRIPT)
    assert json.loads(noted.read_text())["other_forces"] == []  # gravity is the same for all and at all times


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changed", "code"),
    [
        (("neighbor        0.002 bin", "neighbor        0.0001 bin"), "wet.skin"),
        (("fix             integr all nve/sphere\n", ""), "wet.integrate"),
        (("neigh_modify    delay 0", "neigh_modify    delay 5"), "wet.neighbour"),
    ],
)
def test_what_only_the_engine_knows_is_refused_at_the_line(tmp_path: Path, changed: tuple[str, str], code: str) -> None:
    from pywet.cases.script.refusals import SENTENCES

    write(tmp_path, before=BEFORE.replace(*changed))
    done = run(tmp_path)
    start = SENTENCES[code][0].split("{")[0]
    assert done.returncode == 1 and start in done.stderr, done.stderr
    assert not (tmp_path / "wet").exists()


def test_a_script_that_runs_no_step_after_the_line(tmp_path: Path) -> None:
    write(tmp_path, after="")
    done = run(tmp_path)
    assert done.returncode == 1 and "ran no step with fix pywet; expected a `run`" in read(done.stderr), done.stderr
    assert not (tmp_path / "wet").exists()


@pytest.mark.slow
def test_a_run_that_is_refused_keeps_the_tables_of_the_one_before(tmp_path: Path) -> None:
    write(tmp_path, after="run 500\ntimestep 0.000005\nrun 500\n")
    done = run(tmp_path)
    assert done.returncode == 1 and "time step" in done.stderr
    assert table(tmp_path, "ledger")["step"].max() == 501


def test_bridges_are_counted_to_the_end_of_the_script(tmp_path: Path) -> None:
    """Of a script that ends 900 steps after its last output."""
    named = f"{WET}first_films: [{{type: 1, high_mm: [-99, 0, 0], percent: 5}}]\n"
    write(tmp_path, line="fix wet all pywet liquid wet.yaml", after="run 1900\n", wet=named)
    done = run(tmp_path)
    assert done.returncode == 0, done.stderr
    assert "wet.yaml: entry 1 of first_films applied to no sphere" in read(done.stderr)
    events, ledger = (table(tmp_path, name) for name in ("events", "ledger"))
    assert ledger["step"].tolist() == [1, 1001] and folder.ended_at_step(tmp_path / "wet") == 1901
    formed, ruptured = (int((events["kind"] == kind).sum()) for kind in (0, 1))
    assert formed > ledger["formations"].iloc[-1] > 0 and folder.counts(tmp_path / "wet") == (formed, ruptured)
    assert f"{formed} bridges formed, {ruptured} ruptured; ledger closed to" in read(done.stdout)
    assert "up to the output at step 1001" in read(done.stdout)


def test_a_law_of_the_user_and_its_reference_are_those_of_the_replay(tmp_path: Path) -> None:
    """Both files are named in the liquid's file, next to it."""
    arguments = "separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension"
    gives = f"def neck({arguments}):\n    return surface_tension / (1.0 / radius_i + 1.0 / radius_j)\n"
    (tmp_path / "law.py").write_text(f"from pywet.laws.force_law import force_law\n\n\n@force_law\n{gives}")
    (tmp_path / "second.py").write_text(gives)
    laws = "laws: {capillary: law.py:neck, reference: {capillary: second.py:neck}}\n"
    write(tmp_path, after="run 1000\n", wet=f"{WET}{laws}")
    done = run(tmp_path)
    assert done.returncode == 0, done.stderr
    second = record.reference(tmp_path / "wet")
    assert second == {"capillary": f"{tmp_path / 'second.py'}:neck"}
    found = outcome(tmp_path / "wet", functions=second)
    assert found["status"] == "in part" and found["quantities"]["capillary"]["count"] > 20  # no motion is recorded


def test_a_line_that_the_engine_reads_otherwise_than_the_text(tmp_path: Path) -> None:
    jump = "variable f string oil.yaml\njump SELF on\nvariable f string wet.yaml\nlabel on\n"
    write(tmp_path, line=f"{jump}fix wet all pywet liquid ${{f}}")
    done = run(tmp_path)
    assert done.returncode == 1 and "`fix wet all pywet liquid oil.yaml log wet" in read(done.stderr), done.stderr
    assert "expected `fix wet all pywet liquid wet.yaml log wet" in read(done.stderr)
    assert not (tmp_path / "wet").exists()


FULL = """
from pywet.cases.script import folder
from pywet.cli.app import app
from pywet.errors import PywetError

def full(*_):
    raise PywetError("No space left on device")

folder._mesh_motion = full
app()
"""
"""`pywet` with a disk that is full when half of the tables are made."""


def test_what_a_full_disk_left_of_a_script_is_collected_by_the_next_call(tmp_path: Path) -> None:
    """To the end of the script, which is after its last output; a second time there is nothing left to collect."""
    write(tmp_path, line="fix wet all pywet liquid wet.yaml windows 7", after="run 1900\n")
    done = run(tmp_path, sys.executable, "-c", FULL, "liggghts")
    assert done.returncode == 1 and "No space left on device" in done.stderr, done.stderr
    assert not (tmp_path / "wet" / "trajectory.parquet").exists()
    for collected in (True, False):
        done = run(tmp_path)
        assert done.returncode == 1 and "holds something already" in read(done.stderr), done.stderr
        assert ("of a run that was cut off, were collected" in read(done.stderr)) == collected
    events, ledger = (table(tmp_path, name) for name in ("events", "ledger"))
    assert ledger["step"].tolist() == [1, 1001] and events["step"].max() > 1001
    assert folder.ended_at_step(tmp_path / "wet") == 1901 and not folder.logged(tmp_path / "wet")
    assert json.loads((tmp_path / "wet" / SCRIPT).read_text())["window_steps"] == 7
    assert outcome(tmp_path / "wet")["status"] == "in part"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_script_that_a_signal_ends_leaves_the_tables_of_its_outputs(tmp_path: Path, number: signal.Signals) -> None:
    """In the middle of a record of the contact log, which is longer than its buffer between two outputs.

    After SIGKILL the next call makes them; as long as the script runs a second call does not touch its logs.
    """

    def heed() -> None:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)

    write(tmp_path, line="fix wet all pywet liquid wet.yaml every 1000 windows 1000", after="run 1000000\n")
    command = [sys.executable, "-m", "pywet.cli.app", "liggghts", "-in", "in.script"]
    call = subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=heed,
    )  # fmt: skip
    ledger, contacts = (tmp_path / "wet" / "engine" / f"{name}.0.bin" for name in ("ledger", "contacts"))
    until = time.monotonic() + 120
    while not (
        ledger.exists()
        and ledger.stat().st_size >= 2 * RAW["ledger"].itemsize
        and contacts.stat().st_size % RAW["contacts"].itemsize
    ):
        assert call.poll() is None and time.monotonic() < until, call.communicate()[1]
        time.sleep(0.01)
    if number == signal.SIGKILL:
        assert "another run is active in wet" in read(run(tmp_path).stderr)
    os.kill(call.pid, number)
    message = read(call.communicate(timeout=60)[1])
    if number == signal.SIGKILL:
        done = run(tmp_path)
        assert (call.returncode, done.returncode) == (-9, 1) and "were collected" in read(done.stderr), done.stderr
    else:
        assert call.returncode == 143 and "ended by SIGTERM; its outputs are in wet/history" in message, message
    assert "checkpoint" not in message
    with pytest.raises(ProcessLookupError):
        os.killpg(call.pid, 0)
    steps = table(tmp_path, "ledger")["step"].tolist()
    assert steps[:2] == [1, 1001] and table(tmp_path, "contacts")["step"].max() == steps[-1]
    assert table(tmp_path, "films")["step"].max() == steps[-1]


@pytest.mark.slow
def test_films_on_a_mesh_that_vibrates(tmp_path: Path) -> None:
    """Its triangles are the engine's, its pose at every step of an event is where the script's wiggle has it."""
    write(tmp_path, before=SHAKEN, wet=WET.replace("dry", PLATE_ALONE))
    done = run(tmp_path)
    assert done.returncode == 0, done.stderr
    events, ledger, poses = (table(tmp_path, name) for name in ("events", "ledger", "poses"))
    assert (events["partner_kind"] == 1).sum() > 30 and ledger["walls"].iloc[-1] > 0
    total = ledger["films"] + ledger["bridges"] + ledger["walls"]
    assert np.abs(total / ledger["initial"] - 1).max() < 1e-12
    z = 0.0005 * np.sin(2 * np.pi * poses["step"] * 1e-5 / 0.02)
    first = poses["step"] == poses["step"].min()
    # its displacement in one step
    assert poses["shift_z"].to_numpy() == pytest.approx((z - z[first].iloc[0]).to_numpy(), abs=1.6e-6)


def table(where: Path, name: str) -> pd.DataFrame:
    return pd.read_parquet(where / "wet" / "history" / f"{name}.parquet")


def test_state_of_a_script_is_json() -> None:
    """What script.cpp writes has the keys that are asked."""
    source = (Path(__file__).parents[3] / "pywet/engines/liggghts/plugin/script.cpp").read_text()
    from pywet.cases.script.refusals import of_state
    from tests.cases.script.test_refusals import STATE

    assert (
        all(f'\\"{key}\\":' in source for key in STATE) and list(of_state(json.loads(json.dumps(STATE)), "dry")) == []
    )
