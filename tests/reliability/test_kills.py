"""Kills and full disks: at every file operation of collection, and with every file of a resumption damaged.

A call that is made again ends with the tables of a run that was left alone, without simulating what was whole.
"""

from __future__ import annotations

import builtins
import contextlib
import errno
import os
import shutil
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pywet import run_folder
from pywet.cases.small import small
from pywet.engines import pipeline, run_store
from pywet.engines.liggghts import checkpoint, collecting, driver, logs, process
from pywet.engines.liggghts.restart_file import holds
from pywet.engines.run_store import RunStore
from pywet.errors import NotWhole, PywetError
from pywet.scene import EngineScene
from pywet.util.files import read_json
from tests.engines.liggghts import beds
from tests.error_codes import raises_code
from tests.reliability.kills import Stopped, assert_same, tables_of

pytestmark = pytest.mark.engine
KINDS = {"moist": small.PAPER, "dry": small.DRY}
WRITES = ("open", "os.mkdir", "os.rename")
REMOVALS = ("os.remove", "os.rmdir")


def prepare(run_dir: Path, kind: str, steps: int, side: tuple[int, int, int] = (4, 4, 3)) -> Path:
    """A small bed on a vibrating floor with a drawn plate, moist or dry, with checkpoints."""
    scene = beds.prepare(run_dir, beds.bed(side), steps, checkpoints=30)
    (run_dir / "scene.json").write_text(scene.model_copy(update={"effects": KINDS[kind]}).model_dump_json())
    return run_dir


def never(*_: object) -> process.Usage:
    """A launch that must not happen."""
    raise AssertionError("the engine was started although it had come to its end")


@pytest.fixture(scope="module", params=list(KINDS))
def ended(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run killed when its engine had come to its end and nothing was collected, over the tables of an earlier run."""
    run_dir = prepare(tmp_path_factory.mktemp("ended") / "run", request.param, 300)

    def stop(*_: object) -> None:
        raise Stopped

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(collecting, "make", stop)
        with pytest.raises(Stopped):
            driver.run(run_dir, progress=False)
    for name in (
        "trajectory.parquet",
        "history/events.parquet",
        "replay.json",
        "engine/log.liggghts",
        "results/old.csv",
    ):
        (run_dir / name).parent.mkdir(exist_ok=True)
        (run_dir / name).write_text("of an earlier run")
        run_folder.record(run_dir, [name])
    return run_dir


def collect(run_dir: Path) -> None:
    """Collect as `driver.run` does after the engine has ended, without preparing the plugin and the laws."""
    scene = EngineScene.read(run_dir / "scene.json")
    store = RunStore(run_dir, mark_of(run_dir))
    account, damaged = store.finished()
    assert account is not None and damaged is None
    pipeline.collect(pipeline.Raw(pipeline.Job(scene, store, "LIGGGHTS", "3.8.0", None), account))


def mark_of(run_dir: Path) -> str:
    """Fingerprint of a run under way or finished."""
    for path in (run_dir / "engine.partial" / run_store.FINGERPRINT, run_dir / "engine" / run_store.INDEX):
        if path.exists():
            return str(pd.read_json(path, typ="series")["fingerprint"])
    raise AssertionError(f"neither a run under way nor a finished one in {run_dir}")


def fails_at(
    number: int, names: tuple[str, ...], blow: Callable[[], None]
) -> Callable[[str, tuple[object, ...]], None]:
    """An audit hook that strikes from the `number`-th of the file operations `names` that change something."""
    seen = 0

    def hook(event: str, given: tuple[object, ...]) -> None:
        nonlocal seen
        if event not in names or (event == "open" and not int(str(given[2])) & (os.O_WRONLY | os.O_RDWR)):
            return
        seen += 1
        if seen > number:
            blow()

    return hook


def killed() -> None:
    """The end without a word."""
    os.kill(os.getpid(), signal.SIGKILL)


def full() -> None:
    """A full disk."""
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def struck(work: Callable[[], None], number: int, names: tuple[str, ...], blow: Callable[[], None]) -> int:
    """Do the work in a forked process that is struck; 0: it came through, -9: killed, 3: it ended as a full disk should."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            sys.addaudithook(fails_at(number, names, blow))
            work()
            status = 0
        except (OSError, PywetError) as error:
            status = 3 if "No space left" in str(error) else 4
        finally:
            os._exit(status)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


@pytest.mark.parametrize("every", [7, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("names", "blow"), [((*WRITES, *REMOVALS), killed), (WRITES, full)], ids=["kill", "full disk"])
def test_file_operations_of_collection(
    ended: Path, tmp_path: Path, names: tuple[str, ...], blow: Callable[[], None], every: int
) -> None:
    """Struck at its n-th file operation, for every n or each seventh, collection is done again, or was done."""
    shutil.copytree(ended, tmp_path / "unbroken")
    collect(tmp_path / "unbroken")
    wanted = tables_of(tmp_path / "unbroken")
    assert "results" not in os.listdir(tmp_path / "unbroken") and not list((tmp_path / "unbroken").rglob("replay.json"))
    number, status = 0, -1
    while status != 0:
        run_dir = shutil.copytree(ended, tmp_path / str(number))
        status = struck(lambda: collect(run_dir), number, names, blow)  # noqa: B023
        assert status in (0, -9 if blow is killed else 3), f"ended with {status} at operation {number}"
        if not RunStore(run_dir, mark_of(run_dir)).account():
            collect(run_dir)
        RunStore(run_dir, mark_of(run_dir)).tidy()
        assert_same(wanted, tables_of(run_dir))
        assert not list((run_dir / "engine").glob("*.bin")) and not (run_dir / "engine.partial").exists()
        shutil.rmtree(run_dir)
        number += every
    assert number > 20


def test_the_next_call_does_not_simulate_again(ended: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Killed before or after its folder had its name, a finished run is collected or left unchanged."""
    run_dir = shutil.copytree(ended, tmp_path / "run")
    first = driver.run(run_dir, progress=False, launch=never, keep=True)
    assert "the engine had come to its end; its output is collected" in caplog.text
    assert driver.run(run_dir, progress=False, launch=never, keep=True) == first
    assert "was simulated already" in caplog.text
    with open(run_dir / "trajectory.parquet", "ab") as table:
        table.write(b"x")
    with pytest.raises(AssertionError, match="the engine was started"):
        driver.run(run_dir, progress=False, launch=never, keep=True)


def test_raw_files_that_do_not_hold_what_was_planned(ended: Path, tmp_path: Path) -> None:
    """A frame that is missing is named, nothing of an earlier run is touched, and the next call begins again."""
    run_dir = shutil.copytree(ended, tmp_path / "run")
    folder = run_dir / "engine.partial"
    text = (folder / logs.TRAJECTORY).read_text().split("ITEM: TIMESTEP\n")
    (folder / logs.TRAJECTORY).write_text("ITEM: TIMESTEP\n".join(text[:4] + text[5:]))
    scene = EngineScene.read(run_dir / "scene.json")
    with raises_code("run.steps", given=10, expected=11):
        collecting.make(scene, folder, RunStore(run_dir, mark_of(run_dir)).put)
    sums = {path.name: logs.checked(path) for path in logs.files(folder)}
    RunStore(run_dir, mark_of(run_dir)).finish(sums, RunStore(ended, mark_of(run_dir)).finished()[0] or {})
    with pytest.raises(NotWhole):
        collect(run_dir)
    assert (run_dir / "replay.json").exists()
    mark = mark_of(run_dir) if (folder / run_store.FINGERPRINT).exists() else ""
    assert RunStore(run_dir, mark).finished() == (None, None)


@pytest.fixture(scope="module", params=list(KINDS))
def cut_off(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Run a scene twice: in one piece, and killed when it had two checkpoints."""
    folder = tmp_path_factory.mktemp("cut")
    steps = 12000 if request.param == "dry" else 6000
    whole, killed_ = (prepare(folder / name, request.param, steps) for name in ("whole", "killed"))
    driver.run(whole, progress=False)

    def launch(
        command: list[str], at: Path, scene: EngineScene, report: process.Report, watch: Callable[[], None]
    ) -> object:
        def look() -> None:
            watch()
            if len(list((at / run_store.CHECKPOINTS).glob("sums.*.json"))) == checkpoint.STORED:
                raise Stopped

        return process.execute(command, at, scene, report, look)

    with pytest.raises(Stopped):
        driver.run(killed_, progress=False, launch=launch)
    return whole, killed_


def flip(path: Path, at: int) -> None:
    """One bit of a byte, counted from the start."""
    with open(path, "r+b") as file:
        file.seek(at)
        byte = file.read(1)[0]
        file.seek(at)
        file.write(bytes([byte ^ 4]))


def points(run_dir: Path) -> tuple[checkpoint.Checkpoint, checkpoint.Checkpoint]:
    """The older and the newer checkpoint of a run that was cut off."""
    folder = run_dir / "engine.partial"
    newer, passed = checkpoint.find(folder)
    assert newer is not None and not [p for p in passed if "without check sums" not in p]
    sums = newer.engine.with_name(f"sums.{newer.step}.json")
    hidden = sums.rename(sums.with_name("hidden"))
    older, _ = checkpoint.find(folder)
    hidden.rename(sums)
    assert older is not None and older.step < newer.step
    return older, newer


DAMAGES: dict[str, Callable[[Path, int], object]] = {
    "flipped": flip,
    "cut": os.truncate,
    "emptied": lambda path, at: os.truncate(path, 0),
    "missing": lambda path, at: path.unlink(),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_every_damaged_file_is_passed_over(cut_off: tuple[Path, Path], tmp_path: Path, damage: str) -> None:
    """One file at a time: the older checkpoint where that does not need what is gone, else none; the file is named."""
    older, newer = points(cut_off[1])
    partial, sums = cut_off[1] / "engine.partial", newer.engine.with_name(f"sums.{newer.step}.json")
    cases = [(path, path.stat().st_size // 2, True) for path in (newer.engine, newer.state, sums) if path]
    for name, (size, _) in newer.logs.items():
        first = older.logs.get(name, (0, 0))[0]
        if size > first:  # after the part that the older checkpoint needs
            cases.append((partial / name, size - 1, first == 0 or damage in ("flipped", "cut")))
        if first > 0:
            cases.append((partial / name, first - 1, False))
    for path, at, fall_back in cases:
        run_dir = shutil.copytree(cut_off[1], tmp_path / "run")
        DAMAGES[damage](run_dir / path.relative_to(cut_off[1]), at)
        found, passed = checkpoint.find(run_dir / "engine.partial")
        assert (found.step if found else None) == (older.step if fall_back else None), (path, at, passed)
        output_text = next(phrase for phrase in passed if phrase.startswith(f"step {newer.step} ("))
        assert path.name in output_text or path == sums, output_text
        shutil.rmtree(run_dir)


def test_any_flipped_byte_of_the_sums_is_noticed(cut_off: tuple[Path, Path], tmp_path: Path) -> None:
    """Also where it is a number of an empty log, of which nothing is needed."""
    _, newer = points(cut_off[1])
    partial = shutil.copytree(cut_off[1] / "engine.partial", tmp_path / "run")
    sums = partial / run_store.CHECKPOINTS / f"sums.{newer.step}.json"
    whole = sums.read_bytes()
    for at in range(len(whole) - 1):
        flip(sums, at)
        assert isinstance(checkpoint._read(partial, newer.step), str), at
        sums.write_bytes(whole)
    assert isinstance(checkpoint._read(partial, newer.step), checkpoint.Checkpoint)


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_end_is_not_collected(ended: Path, tmp_path: Path, damage: str) -> None:
    """Any raw file that is not what the engine left, or its list: the end is passed over and the file named."""
    partial, mark = ended / "engine.partial", mark_of(ended)
    victims = [path for path in (*logs.files(partial), partial / run_store.FINISHED) if path.stat().st_size]
    for path in victims:
        run_dir = tmp_path / "run"
        damaged = shutil.copytree(partial, run_dir / "engine.partial") / path.name
        DAMAGES[damage](damaged, path.stat().st_size // 2)
        account, why = RunStore(run_dir, mark).finished()
        assert account is None
        if path.name != run_store.FINISHED:
            assert why is not None and path.name in why
        shutil.rmtree(run_dir)


def test_strangers_among_the_checkpoints_are_ignored(cut_off: tuple[Path, Path], tmp_path: Path) -> None:
    """Files and folders of other names, and half-written ones, neither help nor hinder, and are not lost."""
    _, newer = points(cut_off[1])
    run_dir = shutil.copytree(cut_off[1], tmp_path / "run")
    at = run_dir / "engine.partial" / run_store.CHECKPOINTS
    for name in ("notes.txt", "engine", "engine.abc", "state.9999999.partial", "sums.json", ".sums.5.1.partial.json"):
        (at / name).write_text("x")
    (at / "engine.99999999").mkdir()
    found, _ = checkpoint.find(run_dir / "engine.partial")
    assert found is not None and found.step == newer.step
    checkpoint.cut_back(run_dir / "engine.partial", found)
    assert (at / "notes.txt").exists() and (at / "engine.99999999").is_dir()
    shutil.rmtree(at)
    assert checkpoint.find(run_dir / "engine.partial") == (None, [])


def test_goes_on_from_the_older_one_and_says_so(
    cut_off: tuple[Path, Path], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """One flipped bit in the newest restart file: one line names it, and the tables are those of the unbroken run."""
    whole, killed_ = cut_off
    older, newer = points(killed_)
    run_dir = shutil.copytree(killed_, tmp_path / "run")
    flip(run_dir / newer.engine.relative_to(killed_), newer.engine.stat().st_size // 2)
    at = driver.run(run_dir, progress=False).resumed_at_step
    assert at == older.step
    output_text = [line for line in caplog.text.splitlines() if "passed over" in line]
    assert len(output_text) == 1 and f"step {newer.step} (checkpoint/engine.{newer.step} was changed)" in output_text[0]
    assert_same(tables_of(whole), tables_of(run_dir))


def test_begins_anew_and_says_so(cut_off: tuple[Path, Path], tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A trajectory that is gone cannot be gone on with: the run begins at its start."""
    whole, killed_ = cut_off
    run_dir = shutil.copytree(killed_, tmp_path / "run")
    (run_dir / "engine.partial" / logs.TRAJECTORY).unlink()
    assert driver.run(run_dir, progress=False).resumed_at_step is None
    assert "starts again; passed over: step" in caplog.text
    assert_same(tables_of(whole), tables_of(run_dir))


def test_a_restart_file_that_the_engine_refuses_is_tried_once(cut_off: tuple[Path, Path], tmp_path: Path) -> None:
    """One sphere more in its head than records, and sums of that: the first call says so, the next resumes from the older one.

    A file that was cut off would not do: the engine then reads what its memory happened to hold, at times for ever.
    """
    older, newer = points(cut_off[1])
    run_dir = shutil.copytree(cut_off[1], tmp_path / "run")
    engine = run_dir / newer.engine.relative_to(cut_off[1])
    whole, count = engine.read_bytes(), struct.pack("<iq", 23, 16)  # the key of the number of spheres, and the number
    assert whole.count(count) == 1
    engine.write_bytes(whole.replace(count, struct.pack("<iq", 23, 17)))
    sums = engine.with_name(f"sums.{newer.step}.json")
    name = f"{run_store.CHECKPOINTS}/{engine.name}"
    given = read_json(sums, "")
    given["states"][name] = logs.checked(engine)
    logs.write_signed(sums, {part: given[part] for part in ("states", "logs")})
    with raises_code("engine.stopped", says="Did not assign all atoms"):
        driver.run(run_dir, progress=False)
    assert driver.run(run_dir, progress=False).resumed_at_step == older.step


def test_an_engine_that_is_killed_as_it_starts_loses_no_checkpoint(cut_off: tuple[Path, Path], tmp_path: Path) -> None:
    """By SIGKILL, as where memory is short, before it has read its restart file: the next call resumes from the same one."""
    whole, killed_ = cut_off
    _, newer = points(killed_)
    run_dir = shutil.copytree(killed_, tmp_path / "run")

    def launch(
        command: list[str], at: Path, scene: EngineScene, report: process.Report, watch: Callable[[], None]
    ) -> object:
        setup = at / "setup.liggghts"
        setup.write_text(setup.read_text().replace("read_restart", "shell kill -KILL 0\nread_restart", 1))
        return process.execute(command, at, scene, report, watch)

    for _ in range(2):
        with raises_code("engine.stopped", says="ended by signal 9"):
            driver.run(run_dir, progress=False, launch=launch)
        found, passed = checkpoint.find(run_dir / "engine.partial")
        assert found is not None and (found.step, passed) == (newer.step, [])
    assert driver.run(run_dir, progress=False).resumed_at_step == newer.step
    assert_same(tables_of(whole), tables_of(run_dir))


ENDS = {
    "ERROR: Did not assign all atoms correctly (../read_restart.cpp:391)": True,
    "ERROR on proc 1: Invalid flag in header section of restart file (../read_restart.cpp:812)": True,
    "ERROR on proc 0: Cannot open restart file checkpoint/engine.500 (../read_restart.cpp:75)": False,
    "ERROR on proc 0: Failed to allocate 6442450944 bytes for array atom:x (../memory.cpp:66)": False,
    "ERROR: this needs more memory than there is (Unable to allocate 6 GiB); expected a smaller input": False,
    "ERROR: log.liggghts: No space left on device; expected a path that can be read or written": False,
    "mpirun noticed that process rank 1 with PID 7 on node read_restart.cpp:3 exited on signal 9 (Killed).": False,
    "": False,
}
"""The engine's last message -> whether it is on the content of its restart file."""


@pytest.mark.parametrize("message", ENDS)
def test_only_what_the_engine_says_of_a_checkpoint_excludes_it(message: str, tmp_path: Path) -> None:
    (tmp_path / checkpoint.LOG).write_text("read_restart    checkpoint/engine.500\n")
    (tmp_path / process.OUTPUT).write_text(f"LIGGGHTS 3.8.0\nReading restart file ...\n{message}\n")
    assert checkpoint.refused(tmp_path) == ENDS[message]


@pytest.mark.parametrize("name", [run_store.FINGERPRINT, f"{run_store.CHECKPOINTS}/sums."])
def test_a_file_that_cannot_be_read_now_is_not_damaged(
    cut_off: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """A failing disk or too many open files: the call is refused, and the next one resumes from the latest checkpoint."""
    run_dir = shutil.copytree(cut_off[1], tmp_path / "run")
    _, newer = points(run_dir)
    whole = {path: path.read_bytes() for path in (run_dir / "engine.partial").rglob("*") if path.is_file()}
    opened = builtins.open

    def fails(file: Any, *more: Any, **how: Any) -> Any:
        if str(run_dir / "engine.partial" / name) in str(file):
            raise OSError(errno.EIO, os.strerror(errno.EIO), str(file))
        return opened(file, *more, **how)

    with monkeypatch.context() as patch:
        patch.setattr(builtins, "open", fails)
        with raises_code("file.unread"):
            driver.run(run_dir, progress=False, launch=never)
    assert whole == {path: path.read_bytes() for path in (run_dir / "engine.partial").rglob("*") if path.is_file()}
    assert driver.run(run_dir, progress=False).resumed_at_step == newer.step


def test_a_restart_file_that_was_cut_off_is_noticed(cut_off: tuple[Path, Path]) -> None:
    """Before its sums are taken, wherever it was cut off: no checkpoint is made of it."""
    data = points(cut_off[1])[1].engine.read_bytes()
    assert holds(data, 16) and not holds(data, 15)
    for cut in (1, 8, 400, len(data) // 2, len(data)):
        assert not holds(data[: len(data) - cut], 16), cut


def test_a_restart_file_that_the_stock_program_would_read_for_ever(
    cut_off: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a full disk it writes an empty one, reads it back and never ends: it is ended once that has not changed for a while.

    The clock has no say in it: the file's time may be in the past or, the clock set back with the engine at work, ahead; nor
    has another file, that the killed call was writing.
    """
    newer, run_dir = points(cut_off[1])[1], tmp_path / "run"
    shutil.copytree(cut_off[1], run_dir)
    last = run_dir / "engine.partial" / run_store.CHECKPOINTS / f"engine.{10**9}.partial"
    whole, scene, now = newer.engine.read_bytes(), EngineScene.read(run_dir / "scene.json"), time.monotonic()
    last.with_name(f"engine.{10**9 - 1}.partial").write_bytes(whole)
    monkeypatch.setattr(checkpoint.time, "monotonic", lambda: now)
    for content, later, ends in ((b"", b"", True), (whole, whole, False), (b"", whole[:-8], False)):
        for ahead in (-60.0, 3600.0):
            recorder = checkpoint.Recorder(run_dir / "engine.partial", scene, False, 16, newer)
            last.write_bytes(content)
            os.utime(last, (time.time() + ahead,) * 2)
            recorder.watch()
            last.write_bytes(later)
            os.utime(last, (time.time() + ahead,) * 2)
            now += 2.0 * checkpoint.WRITTEN_S
            with raises_code("checkpoint.steps") if ends else contextlib.nullcontext():
                recorder.watch()


def test_logs_are_bounded(tmp_path: Path) -> None:
    """A program that only writes is ended; its log keeps the beginning."""
    scene = EngineScene.read(prepare(tmp_path, "dry", 100) / "scene.json")
    with (
        pytest.MonkeyPatch.context() as patch,
        raises_code("engine.flood"),
    ):
        patch.setattr(process, "LARGEST_LOG", 10**6)
        process.execute(["yes"], tmp_path, scene, lambda done, total: None)
    assert (tmp_path / "output.log").stat().st_size == 10**6


def test_a_dry_run_leaves_nothing_of_a_moist_one(tmp_path: Path) -> None:
    """Nor does a refused scene take anything away."""
    prepare(tmp_path, "moist", 300)
    driver.run(tmp_path, progress=False)
    for name in ("replay.json", "results/liquid_by_holder.csv", "status/replay.json"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("{}")
        run_folder.record(tmp_path, [name])
    before = tables_of(tmp_path)
    prepare(tmp_path, "dry", 300)
    scene = EngineScene.read(tmp_path / "scene.json")
    (tmp_path / "scene.json").write_text(scene.model_copy(update={"box_high_m": (1e-3, 1e-3, 1e-3)}).model_dump_json())
    with raises_code("scene.outside_box"):
        driver.run(tmp_path, progress=False)
    assert_same(before, tables_of(tmp_path))
    (tmp_path / "scene.json").write_text(scene.model_dump_json())
    driver.run(tmp_path, progress=False)
    left = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()}
    moist = {f"history/{name}.parquet" for name in (*logs.RAW, "transfer")} | {"history/meta.json"}
    assert not left & (moist | {"replay.json", "results/liquid_by_holder.csv", "status/replay.json"})


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_full_disks(tmp_path: Path, kind: str) -> None:
    """Disks of nine sizes: the call ends in a sentence, and with free space again the next one ends with the same tables."""
    steps, disk = 3000, tmp_path / "disk"
    driver.run(prepare(tmp_path / "whole", kind, steps), progress=False)
    wanted = tables_of(tmp_path / "whole")
    disk.mkdir()
    stopped = 0
    for size in np.linspace(150, {"moist": 1100, "dry": 500}[kind], 9, dtype=int):
        if subprocess.run(
            ["mount", "-t", "tmpfs", "-o", f"size={size}k", "tmpfs", disk], capture_output=True
        ).returncode:
            pytest.skip("only root can mount a small disk")
        try:
            run_dir = prepare(disk / "run", kind, steps)
            try:
                driver.run(run_dir, progress=False)
            except PywetError:
                stopped += 1
                subprocess.run(["mount", "-o", "remount,size=100m", disk], check=True)
                driver.run(run_dir, progress=False)
                assert_same(wanted, tables_of(run_dir))
        finally:
            subprocess.run(["umount", "-l", disk], check=True)
    assert stopped > 5


@pytest.mark.slow
@pytest.mark.parametrize(("case", "seed"), [(case, seed) for case in (1, 2) for seed in range(3)])
def test_kills_at_random_moments_of_a_case(
    short_case: tuple[Path, dict[int, Path]], tmp_path: Path, case: int, seed: int
) -> None:
    """`pywet run` killed five times at random moments of all stages, the next call going on, ends as the unbroken one."""
    config, whole = short_case
    random, run_dir, kills = np.random.default_rng(seed), tmp_path / "run", 0
    seconds = float((whole[case] / "seconds").read_text())
    while kills < 5:
        child = called(config, case, run_dir)
        try:
            child.wait(float(random.uniform(0.0, seconds)))
            assert child.returncode == 0
            assert_whole(whole[case], run_dir)
            shutil.rmtree(run_dir)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()
            kills += 1
    assert called(config, case, run_dir).wait(600) == 0
    assert_whole(whole[case], run_dir)


def called(config: Path, case: int, run_dir: Path) -> subprocess.Popen[bytes]:
    """`pywet run` in a process of its own."""
    command = [sys.executable, "-m", "pywet.cli.app", "run", str(case), "--config", str(config), "--out", str(run_dir)]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL)


@pytest.fixture(scope="module")
def short_case(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[int, Path]]:
    """The dry and the moist case of one size, 0.3 s long, run in one piece; with the seconds that took."""
    folder = tmp_path_factory.mktemp("case")
    config = shutil.copytree(Path(__file__).parents[2] / "config", folder / "config")
    text = (config / "scales.yaml").read_text()
    for name, before, after in (("duration_s", 1.6, 0.3), ("slide_opens_at_s", 0.2, 0.02)):
        assert f"{name}: {{value: {before}," in text
        text = text.replace(f"{name}: {{value: {before},", f"{name}: {{value: {after},", 1)
    (config / "scales.yaml").write_text(text)
    whole = {case: folder / str(case) for case in (1, 2)}
    for case, run_dir in whole.items():
        started = time.monotonic()
        assert called(config, case, run_dir).wait(600) == 0
        (run_dir / "seconds").write_text(str(time.monotonic() - started))
    return config, whole


def assert_whole(wanted: Path, found: Path) -> None:
    """The unbroken run's tables and results."""
    for one, two in zip((tables_of(wanted), results_of(wanted)), (tables_of(found), results_of(found)), strict=True):
        assert_same(one, two)


def results_of(run_dir: Path) -> dict[str, pd.DataFrame]:
    """The tables of the stage results."""
    return {path.stem: pd.read_parquet(path) for path in sorted((run_dir / "results").glob("*.parquet"))}
