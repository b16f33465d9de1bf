"""Nothing of a user's is lost: what a call may delete or overwrite, who may work in a run directory, moved and linked folders."""

from __future__ import annotations

import ast
import json
import os
import re
import shutil
import stat
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from typer.testing import CliRunner

import pywet
from pywet import PywetError, run_folder, shipped
from pywet.cases.screening import identity
from pywet.cases.small import scenes
from pywet.cli.app import app
from pywet.engines.run_store import forget
from pywet.runs import record
from pywet.util import files
from tests.cases.custom.conftest import beads
from tests.cases.screening import synthetic
from tests.error_codes import error_of, raises_code

ROOT = Path(__file__).parents[2]


def call(*words: object) -> tuple[int, str]:
    """Exit code and all that a command said, on one line."""
    result = CliRunner(env={"COLUMNS": "400", "NO_COLOR": "1"}).invoke(app, [str(w) for w in words])
    assert result.exception is None or isinstance(result.exception, SystemExit), repr(result.exception)
    return result.exit_code, re.sub(r"\s+", " ", result.stderr + result.stdout)


def content(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.mark.parametrize(
    "words",
    [
        ("run", "2"),
        ("scene", "pull"),
        ("run-scene", ROOT / "examples/scenes/hopper.yaml"),
        ("sweep", ROOT / "examples/sweeps/rebound.yaml"),
        ("calibrate", ROOT / "examples/calibrations/binder.yaml"),
    ],
    ids=lambda words: words[0],
)
@pytest.mark.parametrize("out", [".", ""])
def test_a_folder_of_others_is_refused_as_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[object, ...], out: str
) -> None:
    """`--out .` and `--out ""` (an unset variable) leave results of all cases, pictures and movies as they are.

    A calibration writes files of its own name next to them."""
    for name in (
        "results/smoke/case05/trajectory.parquet",
        "vtk/a.vtu",
        "engine/run.json",
        "picture.png",
        "movie.mp4",
        "report.html",
        "sweep.csv",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("days of work")
    shipped.begin(tmp_path)
    monkeypatch.chdir(tmp_path)
    before = content(tmp_path)
    code, output_text = call(*words, "--out", out)
    if words[0] == "calibrate" and out:
        assert code == 0 and {name: content(tmp_path)[name] for name in before} == before
        return
    says = "holds sweep.csv and no sweep" if words[0] == "sweep" else "no list of what a run wrote"
    assert code == 1 and (says if out else "the argument of --out is empty") in output_text
    assert content(tmp_path) == before


def test_only_what_is_listed_is_deleted(tmp_path: Path) -> None:
    """Expect that only the outputs that a run wrote are deleted; a user's files next to them stay and are never overwritten."""
    run = tmp_path / "run"
    run_folder.claim(run)
    files.write_json(run / "results" / "ours.json", 1)
    files.write_json(run / "replay.json", 1)
    (run / "results" / "notes.txt").write_text("mine")
    (run / "picture.png").write_text("mine")
    forget(run)
    assert sorted(content(run)) == [".pywet-run", "picture.png", "results/notes.txt"]
    with raises_code("folder.stranger"):
        files.write_json(run / "picture.png", 1)
    assert (run / "picture.png").read_text() == "mine"
    (run / "engine").mkdir()
    (run / "engine" / "notes.txt").write_text("mine")
    for work in (lambda: forget(run), lambda: run_folder.make_folder(run, "engine")):
        with raises_code("folder.stranger"):
            work()
    assert (run / "engine" / "notes.txt").read_text() == "mine"


def test_a_list_reaches_nothing_outside(tmp_path: Path) -> None:
    """Paths with .. and absolute ones in a list count as nothing."""
    (tmp_path / "precious").write_text("mine")
    run = tmp_path / "run"
    run_folder.claim(run)
    (run / run_folder.LIST).write_text(f"+ ../precious\n+ {tmp_path}/precious\n+ good\n")
    assert run_folder.listed(run) == {"good"}
    with pytest.raises(PywetError):
        run_folder.remove(run, "../precious")
    assert (tmp_path / "precious").exists()


@pytest.mark.parametrize("name", [*run_folder.FOLDERS, run_folder.LOCK, run_folder.LIST])
def test_links_in_a_run_are_refused(tmp_path: Path, name: str) -> None:
    """A linked folder, lock or list of a run: its target stays as it is, and one sentence names the link."""
    victim = tmp_path / "victim"
    if name in run_folder.FOLDERS:
        victim.mkdir()
        (victim / "precious").write_text("mine")
    else:
        victim.write_text("mine")
    run = tmp_path / "run"
    run.mkdir()
    (run / name).symlink_to(victim)
    with (
        raises_code("folder.link"),
        run_folder.hold(run),
    ):
        raise AssertionError("the folder was held")
    assert (victim / "precious" if victim.is_dir() else victim).read_text() == "mine"


def test_the_lock_comes_first(tmp_path: Path) -> None:
    """Two calls on one folder in every order: the second is refused at once, and nothing of the first is changed."""
    run = tmp_path / "run"
    calls = {
        "run": ("run", "2", "--seed", "7", "--out", run),
        "scene": ("scene", "pull", "--out", run),
        "run-scene": ("run-scene", ROOT / "examples/scenes/hopper.yaml", "--out", run),
        "replay": ("replay", run),
        "view": ("view", run),
        "report": ("report", run),
        "screen": ("screen", run),
        "kinetics": ("kinetics", run),
        "app": ("app", run, "--to", tmp_path / "app.html"),
        "plot": ("plot", run, "--out", tmp_path / "curves.svg"),
        "compare": ("compare", run, run),
        "digest": ("digest", run, "--out", tmp_path / "digest.json"),
    }
    synthetic.make(run)
    (run / "history").rename(tmp_path / "stays")
    for path in [p for p in run.rglob("*") if p.is_file()]:
        path.unlink()
    run_folder.claim(run)
    files.write_json(run / "scene.json", synthetic.scene().model_dump(mode="json"))
    before = content(run)
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        with run_folder.hold(run):
            os.write(writer, b"x")
            time.sleep(600)
        os._exit(0)
    try:
        os.read(reader, 1)
        for name, words in calls.items():
            code, output_text = call(*words)
            expected = 1 + (name in ("compare", "digest", "replay"))
            assert code == expected and "another run is active in" in output_text, (name, output_text)
            assert {k: v for k, v in content(run).items() if k != run_folder.LOCK} == before, name
    finally:
        os.kill(child, 9)
        os.waitpid(child, 0)
    with run_folder.hold(run):  # the lock ended with its process
        pass


def test_evaluations_go_side_by_side(tmp_path: Path) -> None:
    """Two that share a finished run hold it together; one that simulates does not join them."""
    run_folder.claim(tmp_path)
    with run_folder.hold(tmp_path, shared=True):
        child = os.fork()
        if child == 0:
            try:
                with run_folder.hold(tmp_path, shared=True):
                    pass
                with run_folder.hold(tmp_path):
                    os._exit(3)
            except PywetError as error:
                os._exit(0 if "another run is active" in str(error) else 4)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_a_folder_that_is_moved_is_noticed(tmp_path: Path) -> None:
    """The run says so, and writes nothing under the old path."""
    run = tmp_path / "run"
    with run_folder.hold(run):
        run_folder.check_held(run)
        run.rename(tmp_path / "elsewhere")
        with raises_code("lock.moved"):
            run_folder.check_held(run)
    assert not run.exists()


def test_devices_pipes_and_links_are_written_to(tmp_path: Path) -> None:
    """Never replaced by a file: a device file of the user, a full one, a pipe, a link to a file and one to nothing yet."""
    linked = tmp_path / "link"
    linked.symlink_to("target.json")
    files.write_json(linked, 1)
    files.write_json(linked, 2)
    assert linked.is_symlink() and (tmp_path / "target.json").read_text() == "2\n"
    os.mkfifo(tmp_path / "pipe")
    end = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    files.write_json(tmp_path / "pipe", 3)
    assert os.read(end, 10) == b"3\n" and stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
    os.close(end)
    try:
        os.mknod(tmp_path / "nul", 0o666 | stat.S_IFCHR, os.makedev(1, 3))
        os.mknod(tmp_path / "full", 0o666 | stat.S_IFCHR, os.makedev(1, 7))
        files.write_json(tmp_path / "nul", 1)
    except OSError:
        pytest.skip("devices cannot be made here")
    except PywetError:
        pytest.skip("devices cannot be opened here")
    with raises_code("file.unwritten"):
        files.write_json(tmp_path / "full", 1)
    assert all(stat.S_ISCHR((tmp_path / name).stat().st_mode) for name in ("nul", "full"))
    code, _ = call("collide", "wall", ROOT / "examples/wall_sweep.json", "--csv", tmp_path / "nul")
    assert code == 0 and stat.S_ISCHR((tmp_path / "nul").stat().st_mode)
    assert not list(tmp_path.glob(".*partial*"))


def test_another_configuration_is_moved_aside(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """The folder of an earlier run gets a number, and a notice names it; the same configuration stays, and each is locked."""
    run = tmp_path / "case02"
    for word in ("five", "five", "seven", "nine"):
        with run_folder.hold(run):
            record.begin(run, word)
            with raises_code("lock.active"), ThreadPoolExecutor(1) as other:
                other.submit(run_folder.hold(run).__enter__).result()
            files.write_json(run / "engine" / "run.json", word)
    stored = {p.name: json.loads((p / "engine" / "run.json").read_text()) for p in tmp_path.iterdir()}
    assert stored == {"case02.1": "five", "case02.2": "seven", "case02": "nine"}
    assert f"held a run of another configuration or version of pywet, which is {run}.1" in caplog.text


def _case(run: Path) -> None:
    """A case whose feed bin is too low for the feed."""
    shutil.copytree(ROOT / "config", config := run.parent / "config")
    text = (config / "scales.yaml").read_text()
    (config / "scales.yaml").write_text(
        text.replace("feed_bin_height_mm: {value: 120", "feed_bin_height_mm: {value: 20")
    )
    result = CliRunner().invoke(app, ["run", "1", "--scale", "smoke", "--config", str(config), "--out", str(run)])
    raise error_of(result) or AssertionError(result.output)


CLOSE = {"name": "beads", "material": "glass", "diameter_mm": 3, "at_mm": [(0, 0, 0), (2, 0, 0)]}
UNBUILT: dict[str, tuple[Callable[[Path], object], str]] = {
    "case": (_case, "cli.stage_failed"),
    "scene": (lambda run: pywet.run(pywet.Scene(**beads(spheres=[CLOSE])), run), "scene.overlap"),
    "small scene": (lambda run: scenes.run("pull", run, scenes.Choice(seconds=1e-9)), "small.short"),
}
"""Kind of run -> a call of one that cannot be built, and the code of its mistake. Cases of the workflow: test_workflow.py."""


@pytest.mark.parametrize("kind", UNBUILT)
def test_a_run_that_cannot_be_built_leaves_the_one_in_its_folder(tmp_path: Path, kind: str) -> None:
    run, (start, code) = tmp_path / "run", UNBUILT[kind]
    with run_folder.hold(run):
        record.begin(run, "earlier")
        files.write_json(run / "engine" / "run.json", 1)
    with raises_code(code):
        start(run)
    assert record.left_identity(run) == "earlier" and (run / "engine" / "run.json").exists()
    assert not [*tmp_path.glob("run.*")]


def test_the_working_folder_is_not_moved_aside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_folder.claim(tmp_path)
    files.write_json(tmp_path / "engine" / "run.json", 1)
    monkeypatch.chdir(tmp_path)
    with raises_code("folder.not_moved"), run_folder.hold(Path(".")):
        record.begin(Path("."), "other")


@pytest.mark.parametrize("text", ["[1]", "{}", "3", "null", '"x"', '{"identity": 4}', "{", ""])
def test_an_identity_of_any_shape_is_not_the_same(tmp_path: Path, text: str) -> None:
    (tmp_path / record.IDENTITY).write_text(text)
    assert record.left_identity(tmp_path) is None


def test_what_a_run_promises(tmp_path: Path) -> None:
    """Each table that is gone, or shorter than it was made, is named; then the run is done again."""
    run = tmp_path / "run"
    for name in (
        "trajectory",
        "mesh_motion",
        "history/spheres",
        "history/events",
        "results/fraction_retained",
        "results/liquid_by_holder",
    ):
        (run / f"{name}.parquet").parent.mkdir(parents=True, exist_ok=True)
        (run / f"{name}.parquet").write_text("12345")
    for name in ("engine/run.json", "summary.json", "replay.json", "history/meta.json", "history/transfer.parquet"):
        (run / name).parent.mkdir(exist_ok=True)
        (run / name).write_text("12345")
    sizes = {name: [5, 0] for name in ("trajectory.parquet", "history/events.parquet")}
    (run / "engine" / "tables.json").write_text(json.dumps({"files": sizes}))
    assert record.missing(run) is None
    for path in [p for p in run.rglob("*") if p.is_file() and p.name != "tables.json"]:
        path.rename(tmp_path / "stays")
        assert record.missing(run) == str(path.relative_to(run))
        (tmp_path / "stays").rename(path)
    (run / "history" / "events.parquet").write_text("123")
    assert record.missing(run) == "history/events.parquet"


def test_snakemake_is_notified_of_another_configuration(tmp_path: Path) -> None:
    """The fingerprint's file is as old as a run of the same configuration, newer than one of another, whatever the clock says."""
    run, file = tmp_path / "case02", tmp_path / "fingerprints" / "case02"
    record.leave_identity(run, "five")
    files.write_json(run / "status" / "scene.json", 1)
    newest = (run / "status" / "scene.json").stat().st_mtime_ns + 10**15  # the clock was set back since
    os.utime(run / "status" / "scene.json", ns=(newest, newest))
    assert identity.expect(run, "five", file).stat().st_mtime_ns <= newest
    assert identity.expect(run, "seven", file).stat().st_mtime_ns > newest
    assert file.read_text() == "seven"
    assert identity.expect(run, "five", file).stat().st_mtime_ns <= newest


def test_init_completes_an_interrupted_call(tmp_path: Path) -> None:
    """After a full disk: a part of the files as they are written; never over a changed one, or a whole folder."""
    shipped.begin(tmp_path / "a")
    (tmp_path / "a" / "README.md").unlink()
    (tmp_path / "a" / "config" / "scales.yaml").unlink()
    shipped.begin(tmp_path / "a")
    assert (tmp_path / "a" / "config" / "scales.yaml").exists()
    for change in (lambda: None, lambda: (tmp_path / "a" / "config" / "cases.csv").write_text("mine")):
        change()
        with raises_code("init.there"):
            shipped.begin(tmp_path / "a")
    assert (tmp_path / "a" / "config" / "cases.csv").read_text() == "mine"


CALLS = {"unlink", "rmdir", "rename", "symlink_to"}
OF_MODULES = {
    "shutil": {"rmtree", "move", "copyfile", "copytree"},
    "os": {"remove", "truncate", "rmdir", "rename", "replace"},
}


def deletes(path: Path) -> bool:
    """Return whether a module deletes, renames, cuts or opens files to write over them by itself."""
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.Call):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        on = ast.unparse(node.func.value) if isinstance(node.func, ast.Attribute) else ""
        table = any(k.arg in ("columns", "index") for k in node.keywords)
        if name in OF_MODULES.get(on, ()) or (name in CALLS and not table):
            return True
        if name == "truncate" or (name == "replace" and len(node.args) == 1 and not node.keywords):
            return True
        modes = [a.value for a in node.args if isinstance(a, ast.Constant) and isinstance(a.value, str)]
        if name == "open" and any(re.fullmatch(r"[wa]\+?b?|r\+b?", m) for m in modes):
            return True
    return False


def test_the_table_of_deletions_is_whole() -> None:
    """docs/reliability.md has a row for each module that deletes or overwrites files, and for no other."""
    packages = ("pywet", "workflow", "reference_impl", "benchmarks", "studies")
    found = {str(p.relative_to(ROOT)) for package in packages for p in (ROOT / package).rglob("*.py") if deletes(p)}
    section = (
        (ROOT / "docs" / "reliability.md").read_text().partition("## What may be deleted")[2].partition("\n## ")[0]
    )
    reported = {
        name for row in re.findall(r"^\| (.*?) \|", section, re.MULTILINE) for name in re.findall(r"`([^`]+\.py)`", row)
    }
    assert found == reported


def test_runs_of_a_study_are_discarded_by_their_lists(tmp_path: Path) -> None:
    """Expect that the files of the runs are deleted, and the folder if it is empty; a user's file and a linked folder stay."""
    for name in ("study/a", "study/b"):
        run_folder.claim(tmp_path / name)
        files.write_json(tmp_path / name / "results" / "x.json", 1)
        (run_folder.make_folder(tmp_path / name, "engine.partial") / "log").write_text("x")
    run_folder.discard(tmp_path / "study" / "b")
    assert [p.name for p in (tmp_path / "study").iterdir()] == ["a"]
    (tmp_path / "study" / "a" / "notes.txt").write_text("mine")
    run_folder.discard(tmp_path / "study")
    assert content(tmp_path) == {"study/a/notes.txt": b"mine"}
    run_folder.discard(tmp_path / "nothing")
