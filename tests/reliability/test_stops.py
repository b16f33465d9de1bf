"""Runs stopped from outside: the parent or the engine killed alone, signals, a moved folder, what a kill leaves half-written."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pywet import run_folder
from pywet.engines import run_store
from pywet.engines.liggghts import checkpoint, driver
from pywet.util import files
from tests.engines.liggghts import beds
from tests.error_codes import raises_code
from tests.reliability.kills import assert_same, tables_of

WORDS = ("scene", "bed", "--spheres", "12", "--seconds", "0.05")


def called(run_dir: Path) -> subprocess.Popen[str]:
    """A small moist bed by the command line, in a process group of its own; it heeds signals that nohup and & ignore."""

    def heed() -> None:
        for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)

    command = [sys.executable, "-m", "pywet.cli.app", *WORDS, "--out", str(run_dir)]
    return subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True, preexec_fn=heed
    )


def engines(run_dir: Path) -> list[int]:
    """Processes whose command line names the run directory."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            if os.fsencode(run_dir) in path.read_bytes().split(b"\0"):
                found.append(int(path.parent.name))
    return found


def at_work(run_dir: Path, call: subprocess.Popen[str]) -> int:
    """The engine's process once the run has two checkpoints."""
    for _ in range(6000):
        if len(list((run_dir / "engine.partial" / run_store.CHECKPOINTS).glob("sums.*.json"))) >= 2:
            return next(pid for pid in engines(run_dir) if pid != call.pid)
        assert call.poll() is None, call.communicate()[1]
        time.sleep(0.01)
    raise AssertionError("no checkpoint was written")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run the scene in one piece."""
    run_dir = tmp_path_factory.mktemp("whole") / "run"
    assert called(run_dir).wait(600) == 0
    return run_dir


STOPS = {
    "parent killed": ("parent", signal.SIGKILL, -9, ""),
    "engine killed": ("engine", signal.SIGKILL, 1, "LIGGGHTS stopped: the program was ended by signal 9 (Killed)"),
    "engine ended": ("engine", signal.SIGTERM, 1, "LIGGGHTS stopped: the program was ended by signal 15 (Terminated)"),
    "Ctrl-C": ("group", signal.SIGINT, 130, "ended by SIGINT (Ctrl-C); what is written is whole"),
    "interrupted": ("parent", signal.SIGINT, 130, "ended by SIGINT (Ctrl-C); what is written is whole"),
    "group ended": ("group", signal.SIGTERM, 143, "ended by SIGTERM; what is written is whole"),
    "parent ended": ("parent", signal.SIGTERM, 143, "ended by SIGTERM; what is written is whole"),
    "terminal closed": ("group", signal.SIGHUP, 129, "ended by SIGHUP; what is written is whole"),
}
QUICK = ("parent killed", "engine killed", "group ended")


@pytest.mark.engine
@pytest.mark.parametrize("how", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in STOPS])
def test_a_stopped_run_goes_on(whole: Path, tmp_path: Path, how: str) -> None:
    """One sentence, no process left; moved elsewhere and called again it ends with the unbroken run's tables, bit for bit.

    A file of the user's and nothing half-written lie in the folder at the end.
    """
    whom, number, code, says = STOPS[how]
    run_dir, moved = tmp_path / "run", tmp_path / "moved"
    call = called(run_dir)
    engine = at_work(run_dir, call)
    (run_dir / "notes.txt").write_text("mine")
    gone = f".trajectory.{call.pid}.0123abcd.partial.parquet"
    (run_dir / gone).write_text("half")
    if whom == "group":
        os.killpg(call.pid, number)
    else:
        os.kill(call.pid if whom == "parent" else engine, number)
    output_text = call.communicate(timeout=60)[1]
    assert call.returncode == code, output_text
    assert says in output_text and "Traceback" not in output_text
    assert len(output_text.strip().splitlines()) == (1 if says else 0), output_text
    for _ in range(500):
        if not engines(run_dir):
            break
        time.sleep(0.01)
    assert not engines(run_dir)
    run_dir.rename(moved)
    again = called(moved)
    output_text = again.communicate(timeout=600)[1]
    assert again.returncode == 0, output_text
    assert '"resumed_at_step": null' not in (moved / "engine" / "run.json").read_text()
    assert_same(tables_of(whole), tables_of(moved))
    assert (moved / "notes.txt").read_text() == "mine" and not (moved / gone).exists()
    stored = {str(p.relative_to(moved)) for p in moved.rglob("*")} - {"notes.txt"}
    assert {n for n in stored if "log.until-" not in n} == {str(p.relative_to(whole)) for p in whole.rglob("*")}


def test_half_written_files_of_killed_processes_go(tmp_path: Path) -> None:
    """Expect that partial files of a living process, of a nested run directory and files of other names stay."""
    run = tmp_path / "run"
    run_folder.claim(run)
    run_folder.claim(run / "work" / "inner")
    with subprocess.Popen(["true"]) as ended:
        pass
    dead = f".ledger.{ended.pid}.0123abcd.partial.parquet"
    (run / "engine.partial" / "checkpoint").mkdir(parents=True)
    stay = [
        f".a.{os.getppid()}.0123abcd.partial.json",
        f"work/inner/{dead}",
        ".x.partial",
        f".ledger.{ended.pid}.partial",
    ]
    for name in (dead, f"engine.partial/checkpoint/{dead}", *stay):
        (run / name).write_text("x")
    with run_folder.hold(run, shared=True):
        assert (run / dead).exists()
    with run_folder.hold(run):
        left = {str(p.relative_to(run)) for p in run.rglob("*") if p.is_file()}
    assert left == {*stay, run_folder.LIST, run_folder.LOCK, f"work/inner/{run_folder.LIST}"}


def test_a_line_of_the_list_cut_off_by_a_full_disk(tmp_path: Path) -> None:
    """It names nothing, above all no folder that it does not mean, and the next one is a line of its own."""
    run = tmp_path / "run"
    run_folder.claim(run)
    (run / run_folder.LIST).write_text("+ scene.json\n+ history/")
    assert run_folder.listed(run) == {"scene.json"}
    files.write_json(run / "history" / "meta.json", 1)
    assert run_folder.listed(run) == {"scene.json", "history/meta.json"}
    (run / "history" / "notes.txt").write_text("mine")
    run_folder.remove_listed(run, ["history"])
    assert os.listdir(run / "history") == ["notes.txt"]


def test_a_folder_moved_aside_while_it_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A call that has opened the lock when another moves the folder aside is refused: it would hold the moved one."""
    run, real = tmp_path / "run", run_folder.fcntl.flock

    def late(lock: int, how: int) -> None:
        run.rename(tmp_path / "run.1")
        real(lock, how)

    monkeypatch.setattr(run_folder.fcntl, "flock", late)
    with raises_code("lock.active"), run_folder.hold(run):
        raise AssertionError("the folder was held")


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP])
def test_a_file_system_without_locks_is_named_and_no_file_stays_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    """A run that simulates, one that is read, and a part of one."""

    def refused(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    run_folder.claim(tmp_path)
    monkeypatch.setattr(run_folder.fcntl, "flock", refused)
    before = len(os.listdir("/proc/self/fd"))
    for lock in (
        run_folder.hold(tmp_path),
        run_folder.hold(tmp_path, shared=True),
        run_folder.hold_part(tmp_path, "vtk"),
    ):
        with raises_code("lock.unsupported"), lock:
            raise AssertionError("the folder was held")
    assert len(os.listdir("/proc/self/fd")) == before


CLOCKED = {
    "pywet/report/scene_page.py": "whether a picture is older than the summary: it is deleted with the run that it shows",
    "pywet/cases/screening/identity.py": "a file for Snakemake, newer than another whatever the clock says",
    "pywet/cost/cost.py": "a date to read",
    "pywet/compare/digest.py": "a date to read",
}
"""Modules that read the clock or the times of files, and what for."""


def test_where_the_clock_is_read() -> None:
    """Nowhere between the start of a run and its tables: a clock set back with the engine at work changes nothing."""
    clock = re.compile(r"\bst_mtime|\bgetmtime|\btime\.time(_ns)?\b|\bdatetime\b|from datetime")
    root = Path(__file__).parents[2]
    paths = [p for folder in ("pywet", "reference_impl", "workflow") for p in (root / folder).rglob("*.py")]
    assert {str(p.relative_to(root)) for p in paths if clock.search(p.read_text())} == set(CLOCKED)


@pytest.mark.engine
def test_a_clock_set_back_with_the_engine_at_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By an hour at every call, over checkpoints whose files are from the future: the tables are those of an undisturbed run."""
    runs, calls = [tmp_path / "whole", tmp_path / "run"], 0

    def earlier() -> float:
        nonlocal calls
        calls += 1
        return 1e9 - 3600.0 * calls

    watch = checkpoint.Recorder.watch

    def disturbed(recorder: checkpoint.Recorder) -> None:
        watch(recorder)
        for path in (recorder.folder / run_store.CHECKPOINTS).glob("*"):
            with contextlib.suppress(FileNotFoundError):
                os.utime(path, (time.time(), 4e9))

    for run in runs:
        beds.prepare(run, beds.bed((3, 3, 2)), 600, checkpoints=20)
        if run == runs[1]:
            monkeypatch.setattr(time, "time", earlier)
            monkeypatch.setattr(checkpoint.Recorder, "watch", disturbed)
        driver.run(run, 1, progress=False)
    assert calls and not (runs[1] / "engine.partial").exists()
    assert_same(tables_of(runs[0]), tables_of(runs[1]))
