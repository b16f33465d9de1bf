"""Sweeps of runs of the engine: small drums and a case, killed with their engines, and through the workflow."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pywet.sweep import plan, sweep_command, table
from tests.sweep.files import EXAMPLES, write

ROOT = EXAMPLES.parent
DRUM: dict[str, Any] = {
    "name": "drum", "base": {"scene": str(EXAMPLES / "sweeps" / "small_drum_scene.yaml")},
    "axes": {"liquid.surface_tension_N_per_m": [0.02, 0.07]}, "seeds": 2,
    "gather": ["ruptures", "bridges_per_sphere", "drum_angle_deg", "liquid_wall_mantle_share"],
}  # fmt: skip


def _call(folder: Path, *words: str) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "pywet.cli.app", "sweep", *words]
    return subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )


def _alive(folder: Path, session: int) -> list[str]:
    """Processes of the session that a call was, and engines that work below its folder."""
    words = (["pgrep", "-as", str(session)], ["pgrep", "-af", str(folder / "results")])
    return [
        line
        for w in words
        for line in subprocess.run(w, capture_output=True, text=True, check=False).stdout.splitlines()
    ]


@pytest.mark.engine
@pytest.mark.slow
def test_a_sweep_of_drums_killed_twice_equals_an_unbroken_one(tmp_path: Path) -> None:
    """On two cores, killed with SIGKILL in its first and in a later run: no engine is left, and the table is the same."""
    tables = []
    for name in ("whole", "broken"):
        folder = tmp_path / name
        folder.mkdir()
        file = write(folder, DRUM)
        for count in (0, 1) if name == "broken" else ():
            process, store = _call(folder, str(file), "--cores", "2"), folder / "results" / "sweeps" / "store"
            end = time.monotonic() + 300.0
            while time.monotonic() < end and not (
                len(list(store.glob("*/point.json"))) >= count and list(store.glob("*/engine.partial"))
            ):
                time.sleep(0.02)
            os.kill(process.pid, signal.SIGKILL)
            process.wait()
            end = time.monotonic() + 60.0  # a loaded machine takes a while to end and reap them
            while (alive := _alive(folder, process.pid)) and time.monotonic() < end:
                time.sleep(0.1)
            assert alive == []
            assert len(list(store.glob("*/point.json"))) < 4
        done = _call(folder, str(file), "--cores", "2")
        printed = done.communicate(timeout=600)[0]
        assert done.returncode == 0 and "4 of 4 runs have results" in printed, printed
        tables.append(table.read(folder / "results" / "sweeps" / "sweep"))
    pd.testing.assert_frame_equal(*tables, check_exact=True)
    assert tables[0]["ruptures"].gt(0).all() and tables[0]["drum_angle_deg"].between(0, 90).all()
    assert tables[0]["ruptures"].nunique() > 2  # ruptures depend on seed and surface tension


@pytest.mark.engine
@pytest.mark.slow
def test_a_case_is_a_point_that_a_second_sweep_does_not_run_again(tmp_path: Path) -> None:
    """A short smoke case of two moistures; results of the run's own summary."""
    axes = {"case.liquid_percent": [0.0, 5.0], "scale.duration_s": [0.3]}
    gather = [
        "fraction_retained_end",
        "formations",
        "liquid_wires_share",
        "screen_efficiency",
        "screen_overs_moisture_percent",
    ]
    content = {"name": "moisture", "base": {"case": 2, "config": str(ROOT / "config")}, "axes": axes, "gather": gather}
    asked = plan.read(write(tmp_path, content), tmp_path / "out", tmp_path / "store")
    made = sweep_command.carry_out(asked, 1, 1, 0, print)
    assert made["status"].tolist() == [table.DONE] * 2, made["reason"].tolist()
    assert made["fraction_retained_end"].between(0.3, 1.0).all() and made["screen_efficiency"].between(-1.0, 1.0).all()
    assert made["screen_overs_moisture_percent"].fillna(0.0).gt(0.0).tolist() == [False, True]
    assert made["formations"].isna().tolist() == [True, False] and made["liquid_wires_share"].isna().tolist() == [
        True,
        False,
    ]
    again = plan.read(
        write(tmp_path, {**content, "name": "other"}, "other.yaml"), tmp_path / "other", tmp_path / "store"
    )
    assert again.missing == []


def test_the_workflow_has_a_job_for_each_missing_run_and_none_for_those_there(tmp_path: Path) -> None:
    """A dry run of Snakemake: four runs of the engine; without the key no rule; a wrong file is one sentence.

    A page of runs without results, as a call with failed runs leaves it, does not stand for them.
    """
    shutil.copy(ROOT / "Snakefile", tmp_path)
    for name in ("config", "workflow", "liggghts_inputs"):
        (tmp_path / name).symlink_to(ROOT / name)
    write(tmp_path, DRUM)
    write(tmp_path, {**DRUM, "seeds": 0}, "wrong.yaml")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(tmp_path / "cache")}

    def dry(file: str) -> subprocess.CompletedProcess[str]:
        words = ["-n", "--nolock", "--cores", "2", "sweep", "--config", f"sweep={file}"]
        command = [sys.executable, "-m", "snakemake", *words]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)

    done = dry("sweep.yaml")
    text = done.stdout + done.stderr
    assert done.returncode == 0, text
    jobs = dict(re.findall(r"^(\w+) +(\d+)$", text, flags=re.MULTILINE))
    assert jobs == {"sweep": "1", "sweep_page": "1", "sweep_run": "4", "total": "6"}
    assert len(set(re.findall(r"jobs/(\d-\d)-[0-9a-f]{16}\.json", text))) == 4
    assert re.findall(r"mem_mb=(\d+)", text) == ["1500"] * 4
    asked = plan.read(tmp_path / "sweep.yaml", tmp_path / "out", tmp_path / "results" / "sweeps" / "store")
    first = asked.runs[0].built.name
    (asked.store.place(first)).mkdir(parents=True)
    (asked.store.place(first) / "summary.json").write_text("{}")
    asked.store.leave(
        first, {"ruptures": 1.0, "bridges_per_sphere": 1.0, "drum_angle_deg": 1.0, "liquid_wall_mantle_share": 0.0}
    )
    for name in ("sweep.parquet", "report.html"):
        (tmp_path / "results" / "sweeps" / "sweep").mkdir(exist_ok=True)
        (tmp_path / "results" / "sweeps" / "sweep" / name).write_text("")
    (tmp_path / "results" / "sweeps" / "sweep" / "file.json").write_text('{"file": "../../../sweep.yaml"}')
    again = dry("sweep.yaml")
    assert "sweep_run         3" in again.stdout + again.stderr, again.stdout + again.stderr
    wrong = dry("wrong.yaml")
    assert (
        wrong.returncode != 0
        and "wrong.yaml: seeds is 0, expected greater than or equal to 1" in wrong.stdout + wrong.stderr
    )
