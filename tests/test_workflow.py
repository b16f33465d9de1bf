"""The workflow: it plans before anything is built, its lint finding is the one answered, a failed case stops nothing else."""

from __future__ import annotations

import json
import math
import os
import platform
import re
import runpy
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pywet import config, run_folder, stages
from pywet.cli import workflow_lock
from pywet.cost import needs
from pywet.runs import record
from pywet.util import sources
from pywet.util.files import write_json
from tests.error_codes import raises_code

ROOT = Path(__file__).parent.parent


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of what the workflow is made of, without any result."""
    shutil.copy(ROOT / "Snakefile", tmp_path)
    for name in ("config", "workflow", "liggghts_inputs"):
        shutil.copytree(ROOT / name, tmp_path / name)
    return tmp_path


def _snakemake(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(folder / "cache")}
    command = [sys.executable, "-m", "snakemake", "--cores", "2", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def _jobs(text: str) -> dict[str, int]:
    """Rule -> number of jobs in the job statistics."""
    return {name: int(count) for name, count in re.findall(r"^(\w+) +(\d+)$", text, flags=re.MULTILINE)}


def test_dry_run_plans_all_cases_before_anything_is_built(folder: Path) -> None:
    done = _snakemake(folder, "-n")
    assert done.returncode == 0, done.stderr
    per_case = dict.fromkeys(("scene", "simulate", "evaluate"), 19)  # 18 and one with preset exact
    assert _jobs(done.stdout + done.stderr) == {
        **per_case,
        "picture": 1,
        "report": 1,
        "verdict": 1,
        "all": 1,
        "total": 61,
    }
    assert not (folder / "results").exists()


def test_scale_and_cases_are_chosen_on_the_command_line(folder: Path) -> None:
    done = _snakemake(folder, "-n", "--config", "scale=reduced", "cases=[2,11]")
    text = done.stdout + done.stderr
    assert done.returncode == 0, text
    assert _jobs(text)["simulate"] == 3  # both, and case 2 with preset exact
    assert "results/reduced/case11/status/simulate.json" in text
    assert "results/smoke" not in text


def test_seeds_make_so_many_runs_of_each_case(folder: Path) -> None:
    """With the next seeds, in folders as `pywet run --seeds` makes them; also the run of another preset; one report of all."""
    done = _snakemake(folder, "-n", "--config", "cases=[2,11]", "seeds=3")
    text = done.stdout + done.stderr
    jobs = _jobs(text)
    assert (jobs["simulate"], jobs["evaluate"], jobs["report"], jobs["verdict"]) == (9, 9, 1, 1), text
    for name in ("case02", "case02-10008", "case02_exact-10009", "case11-10009"):
        assert f"results/smoke/{name}/status/simulate.json" in text


def test_memory_is_requested_by_core_and_doubled_for_every_rule(folder: Path) -> None:
    """SLURM takes `mem_mb` for each node, and `mem_mb_per_cpu` wherever the ranks are; rule scene has the profile's defaults."""
    profile = ("--profile", "workflow/profiles/slurm", "--executor", "dryrun")
    done = _snakemake(folder, "-n", *profile, "--config", "cases=[2]", "ranks=4", "both_presets=false")
    text = done.stdout + done.stderr
    assert done.returncode == 0, text
    ((memory, of_core),) = {
        (int(a), int(b)) for a, b in re.findall(r"resources:.*?mem_mb=(\d+).*?mem_mb_per_cpu=(\d+)", text)
    }
    assert memory > 1.5 * 4 * needs.RANK_B / 1e6 and of_core == math.ceil(memory / 4)
    assert re.search(r"resources:.*mem_mb=2000.*runtime=60", text)
    (defaults,) = re.findall(
        r"^default-resources:\n((?:  .*\n)+)", (ROOT / profile[1] / "config.yaml").read_text(), re.M
    )
    for line in defaults.splitlines():
        name, _, value = line.partition(":")
        assert eval(value, {"attempt": 2}) == 2 * eval(value, {"attempt": 1}), name


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ("scale=huge", "there is no scale huge"),
        ("cases=[99]", "there is no case 99"),
        ("cases=a", "cases.0 is 'a', expected a valid integer"),
        ("ranks=0", "ranks is 0, expected greater than or equal to 1"),
        ("sed=7", "key sed is not known, expected seed"),
        ("seeds=0", "seeds is 0, expected greater than or equal to 1"),
    ],
)
def test_a_wrong_choice_is_refused_before_any_job(folder: Path, choice: str, message: str) -> None:
    done = _snakemake(folder, "-n", "--config", choice)
    assert done.returncode != 0
    assert message in done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("given", "code", "key"),
    [
        ({"cases": []}, "config.value", "cases"),
        ({"cases": [2.5]}, "config.value", "cases.0"),
        ({"cases": None}, "config.value", "cases.0"),
        ({"ranks": "two"}, "config.value", "ranks"),
        ({"seed": -1}, "config.value", "seed"),
        ({"scale": ["smoke"]}, "config.value", "scale"),
        ({"laws": {"preset": "exact"}}, "config.not_on_command_line", "laws"),
    ],
)
def test_what_the_command_line_cannot_replace_is_a_sentence(given: dict[str, Any], code: str, key: str) -> None:
    configured = config.load(ROOT / "config").settings
    with raises_code(code, key=key):
        config.chosen(configured, {**configured.model_dump(mode="json"), **given})


def test_cases_of_the_command_line_are_a_list() -> None:
    """One number, a text, a list of texts."""
    configured = config.load(ROOT / "config").settings
    given = configured.model_dump(mode="json")
    chosen = [config.chosen(configured, {**given, "cases": cases}).cases for cases in (2, "2", ["2", "11"])]
    assert chosen == [(2,), (2,), (2, 11)]


def test_one_case_and_its_seed_are_taken_from_the_command_line(folder: Path) -> None:
    """The scene that is built has them."""
    scene = "results/smoke/case01/status/scene.json"
    done = _snakemake(folder, scene, "--config", "cases=1", "seed=7")
    assert done.returncode == 0, done.stderr
    built = json.loads((folder / "results" / "smoke" / "case01" / "scene.json").read_text())
    assert (built["name"], built["seed"]) == ("case01", 7)
    again = _snakemake(folder, "-n", scene, "--config", "cases=1", "seed=8")
    assert _jobs(again.stdout + again.stderr)["scene"] == 1


@pytest.mark.parametrize("job", ["scene", "simulate", "evaluate"])
def test_a_job_on_a_folder_in_use_is_refused_before_its_first_stage(tmp_path: Path, job: str) -> None:
    """Its script, called in another thread while this one has locked the folder."""
    run, word = tmp_path / "run", tmp_path / "word"
    word.write_text("word")
    status = run / "status" / f"{job}.json"
    given = SimpleNamespace(
        input=SimpleNamespace(fingerprint=word),
        output=SimpleNamespace(status=status, results=status),
        params=SimpleNamespace(ranks=1, engine="liggghts"),
        resources={},
        log=[tmp_path / "log"],
    )
    script = ROOT / "workflow" / "scripts" / f"{job}.py"
    with run_folder.hold(run), ThreadPoolExecutor(1) as other, raises_code("lock.active", where=str(run)):
        other.submit(runpy.run_path, str(script), {"snakemake": given}).result()
    assert not status.parent.exists()


def test_a_mistake_and_its_correction_leave_a_run_where_it_is(folder: Path) -> None:
    """A feed bin that cannot hold the feed, and one that can again: the status of the scene, and the run that was there."""
    run, scales = folder / "case01", folder / "config" / "scales.yaml"
    sound, status = scales.read_text(), run / "status" / "scene.json"
    params = SimpleNamespace(config=folder / "config", number=1, preset=None, scale="smoke", engine="liggghts", seed=1)
    given = SimpleNamespace(output=SimpleNamespace(status=status), params=params, log=[folder / "log"])
    for text, code in ((sound, None), (sound.replace("feed_bin_height_mm: {value: 120", "feed_bin_height_mm: {value: 20"),
                                       "packing.crowded"), (sound, None)):  # fmt: skip
        scales.write_text(text)
        runpy.run_path(str(ROOT / "workflow" / "scripts" / "scene.py"), {"snakemake": given})
        assert record.Status.read(run, "scene").code == code
        with run_folder.hold(run):
            write_json(run / "engine" / "run.json", code)
    assert not [*folder.glob("case01.*")] and json.loads((run / "scene.json").read_text())["name"] == "case01"


def _by_hand(folder: Path, failed: str | None = None) -> Path:
    """Leave a run of case 1 as `pywet run` does, of which Snakemake has no records."""
    root = folder / "results" / "smoke"
    run_folder.claim(root / "case01")
    record.leave_identity(root / "case01", stages.fingerprint(config.load(folder / "config"), 1, "smoke"))
    os.utime(root / "case01" / record.IDENTITY, (9e8, 9e8))
    made = [root / "case01" / "status" / f"{stage}.json" for stage in stages.NEEDS]
    run_folder.record(root / "case01", [f"status/{path.name}" for path in made])
    together = [root / name for name in ("picture_cases1.png", "report_cases1.html", "report_cases1.json")]
    for k, path in enumerate([*made, *together]):
        path.parent.mkdir(parents=True, exist_ok=True)
        ok = path.stem != failed
        status = stages.Status(path.stem, ok, 1.0, None if ok else failed, None if ok else "no table")
        path.write_text(json.dumps(status.__dict__))
        os.utime(path, (1e9 + 100 * k, 1e9 + 100 * k))
    for path in (folder / name for name in ("config", "workflow")):
        for file in path.rglob("*"):
            os.utime(file, (9e8, 9e8))
    return root / "case01"


def test_a_changed_configuration_is_seen_after_a_run_by_hand(folder: Path) -> None:
    """The run's own fingerprint: the same one plans nothing of the run, another one all of it, without Snakemake's records."""
    run = _by_hand(folder)
    for word, expected in ((None, set()), ("another", {"scene", "simulate", "evaluate"})):
        if word:
            record.leave_identity(run, word)
        done = _snakemake(folder, "-n", "--config", "cases=1", "both_presets=false")
        assert done.returncode == 0, done.stderr
        assert set(_jobs(done.stdout + done.stderr)) >= expected, done.stdout
        assert expected or not {"scene", "simulate"} & set(_jobs(done.stdout + done.stderr)), done.stdout


def test_a_failed_replay_is_tried_again(folder: Path) -> None:
    """Results, pictures and report of the last call are there and newer; the stage that lost its status runs again."""
    assert stages.judge([_by_hand(folder, failed="replay")])
    done = _snakemake(folder, "-n", "--config", "cases=1", "both_presets=false")
    jobs = set(_jobs(done.stdout + done.stderr))
    assert {"evaluate", "report", "verdict"} <= jobs and "simulate" not in jobs, done.stdout


@pytest.mark.parametrize("cores", [3, 100])
def test_nothing_runs_beside_what_is_timed(folder: Path, cores: int) -> None:
    """A timed job takes all the cores there are, be they few or many."""
    done = _snakemake(folder, "-n", "atlas", "study_accuracy", "wall_collision", "--cores", str(cores))
    assert done.returncode == 0, done.stderr
    jobs = re.findall(r"^rule (\w+):\n(.*?)\n\[", done.stdout + done.stderr, flags=re.DOTALL | re.MULTILINE)
    threads = {name: f"threads: {cores}\n" in text for name, text in jobs}
    assert threads["atlas"] and threads["study_job"] and threads["wall_collision"]


def test_lint_finds_only_what_the_snakefile_answers(folder: Path) -> None:
    done = _snakemake(folder, "--lint")
    findings = {line.strip() for line in (done.stdout + done.stderr).splitlines() if line.startswith("    * ")}
    assert findings <= {"* Specify a conda environment or container for each rule.:"}
    assert "asks for a conda environment or a container" in (folder / "Snakefile").read_text()


def test_failed_cases_stop_nothing_are_reported_and_tried_again(folder: Path) -> None:
    # A feed bin of 20 mm cannot hold the feed: every scene fails, in seconds and without the engine.
    scales = folder / "config" / "scales.yaml"
    text = scales.read_text()
    scales.write_text(text.replace("feed_bin_height_mm: {value: 120", "feed_bin_height_mm: {value: 20"))
    done = _snakemake(folder, "--config", "cases=[1,2]")
    assert done.returncode != 0
    assert "case01: stage scene failed: feed bin:" in done.stderr
    assert "case02: stage scene failed: feed bin:" in done.stderr
    report = (folder / "results" / "smoke" / "report_cases1-2.html").read_text()
    numbers = json.loads((folder / "results" / "smoke" / "report_cases1-2.json").read_text())
    assert (numbers["cases.done"]["value"], numbers["cases.count"]["value"]) == (0, 2)
    assert "stage scene failed: feed bin:" in report
    again = _snakemake(folder, "-n", "--config", "cases=[1,2]")
    assert _jobs(again.stdout + again.stderr)["scene"] == 3  # includes the preset-comparison run of case 2


WAITING = """
rule all:
    input: "done.txt"
rule wait:
    output: "done.txt"
    script: "wait.py"
"""


def _until(there: Callable[[], object]) -> None:
    """Wait until something is so, at most a minute."""
    end = time.monotonic() + 60.0
    while not there():
        assert time.monotonic() < end
        time.sleep(0.1)


def test_the_call_after_a_kill_names_orphans_then_takes_the_lock_away(tmp_path: Path) -> None:
    """Snakemake itself at work, killed with its job alive, with none alive: two sentences, then the way is free."""
    (tmp_path / "Snakefile").write_text(WAITING)
    (tmp_path / "wait.py").write_text("import pathlib, time\npathlib.Path('begun').touch()\ntime.sleep(600)\n")
    assert workflow_lock.release(tmp_path) is None
    main = subprocess.Popen(
        [sys.executable, "-m", "snakemake", "--cores", "1"], cwd=tmp_path, stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL, env={**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")},
    )  # fmt: skip
    jobs: list[int] = []
    try:
        _until((tmp_path / "begun").exists)
        jobs = workflow_lock.at_work(tmp_path)[1]
        message = workflow_lock.release(tmp_path)
        assert message is not None and f"stop it by `kill {main.pid}`" in message
        main.kill()
        main.wait()
        message = workflow_lock.release(tmp_path)
        assert jobs and message is not None and f"`kill {' '.join(map(str, jobs))}`, then call again" in message
    finally:
        main.kill()
        for job in jobs:
            with suppress(ProcessLookupError):
                os.kill(job, signal.SIGKILL)
    _until(lambda: not workflow_lock.at_work(tmp_path)[1])
    (tmp_path / "wait.py").write_text("open('done.txt', 'w').close()\n")
    assert _snakemake(tmp_path).returncode != 0  # locked
    assert workflow_lock.release(tmp_path) is None
    done = _snakemake(tmp_path, "--rerun-incomplete")
    assert done.returncode == 0 and (tmp_path / "done.txt").exists(), done.stderr


def test_the_lock_of_another_machine_or_user_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their processes are not seen here; the advice is Snakemake's own command, after which the next call is of this machine."""
    lock, host = tmp_path / workflow_lock.LOCKS / "0.input.lock", tmp_path / workflow_lock.HOST
    assert workflow_lock.release(tmp_path) is None and host.read_text() == platform.node()
    lock.parent.mkdir()
    for name, user, words in (
        ("node17", os.geteuid(), "of the machine node17 has locked"),
        (platform.node(), 12345, f"of user {os.geteuid()} has locked"),
    ):
        lock.touch()
        host.write_text(name)
        monkeypatch.setattr(os, "geteuid", lambda user=user: user)
        message = workflow_lock.release(tmp_path)
        assert message is not None and words in message and "`snakemake --unlock`" in message and lock.exists()
        monkeypatch.undo()
        lock.unlink()
        assert workflow_lock.release(tmp_path) is None and host.read_text() == platform.node()
    lock.touch()
    assert workflow_lock.release(tmp_path) is None and not lock.exists()


def test_every_rule_depends_on_its_code() -> None:
    """Except those whose inputs or parameters hold a digest of it, a fingerprint of a run or the store of a sweep."""
    known = {"scene", "simulate", "verdict", "sweep_run", "sweep"}
    texts = [path.read_text() for path in sorted((ROOT / "workflow" / "rules").glob("*.smk"))]
    rules = [
        rule for text in texts for rule in re.split(r"^ *rule\b", text, flags=re.MULTILINE)[1:] if "script:" in rule
    ]
    without = {rule.partition(":")[0].strip() for rule in rules if not re.search(r"^ +code=", rule, re.MULTILINE)}
    assert len(rules) > 15 and without == known


def test_the_digest_of_the_program_is_of_all_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    listed: list[Path] = []
    monkeypatch.setattr(sources, "digest", lambda files: listed.extend(Path(os.path.normpath(f)) for f in files) or "")
    sources.digest_of_program.__wrapped__()
    for name in (
        "pywet/report/scene_page.py",
        "studies/buck2018/buck_page.py",
        "reference_impl/faults.py",
        "pywet/scene.py",
    ):
        assert ROOT / name in listed
