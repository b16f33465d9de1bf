"""Damaged checkpoints: the plugin refuses in a sentence what does not fit its scene, whatever the check sum says.

What it was given before leaves no trace in the run that resumes from the sound one.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from pywet.engines import run_store
from pywet.engines.liggghts import checkpoint, driver, state_file
from pywet.engines.pipeline import Job
from tests.engines.liggghts import beds
from tests.error_codes import raises_code
from tests.reliability.kills import assert_same, tables_of
from tests.reliability.mangled import mangled
from tests.reliability.test_fuzzed_files import FEW, MANY


def bed(folder: Path) -> Path:
    beds.prepare(folder, beds.bed((4, 4, 3)), steps=200, checkpoints=3, outputs=4)
    return folder


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with its raw files and checkpoints."""
    stored = pytest.MonkeyPatch()
    stored.setattr(run_store.RunStore, "tidy", lambda store: None)
    run = bed(tmp_path_factory.mktemp("unbroken"))
    driver.run(run, 1, progress=False)
    stored.undo()
    return run


@pytest.mark.engine
@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
def test_the_plugin_takes_up_no_damaged_state(
    unbroken: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, count: int
) -> None:
    """Counts, ids, kinds of bridges and wall parts out of range among them; the run ends with the tables of the unbroken one."""
    given = driver._command

    def command(job: Job, done: int) -> list[str]:
        return [w.replace("pywet.engines.liggghts.worker", "tests.reliability.state_worker") for w in given(job, done)]

    monkeypatch.setattr(driver, "_command", command)
    monkeypatch.setenv("PYWET_DAMAGED", str(count))
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))
    run = bed(tmp_path / "run")
    driver.run(run, 1, progress=False)
    ends = json.loads((run / "engine" / "damaged.json").read_text())
    print(count, "states:", ends)
    assert sum(ends.values()) == count
    refused = "the checkpoint FILE is damaged or of another scene; expected one of this run: remove engine.partial and call again"
    assert ends[refused] > count / 4  # a changed film or force is a valid number and is accepted
    assert_same(tables_of(unbroken), tables_of(run))


@pytest.mark.engine
@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
def test_no_damaged_file_of_a_checkpoint_is_gone_on_from(unbroken: Path, tmp_path: Path, count: int) -> None:
    """Any of its files and logs: passed over with a phrase that names it, for the older checkpoint or the start."""
    folder = Path(shutil.copytree(unbroken / "engine", tmp_path / "engine"))
    point, passed = checkpoint.find(folder)
    assert point is not None and not passed
    last = {folder / name for name in point.logs if point.logs[name][0]}
    paths = sorted(last | set((folder / run_store.CHECKPOINTS).glob(f"*.{point.step}*")))
    whole = {path: path.read_bytes() for path in paths}
    same = older = 0
    for seed in range(count):
        path = paths[seed % len(paths)]
        data = mangled(whole[path], seed)
        path.write_bytes(data)
        found, passed = checkpoint.find(folder)
        if found is not None and found.step == point.step:
            size = point.logs.get(path.name, (len(whole[path]), 0))[0]
            unchanged = (
                data[:size] == whole[path][:size]
                if path.suffix != ".json"
                else json.loads(data) == json.loads(whole[path])
            )
            assert unchanged, (seed, path.name)
            same += 1
        else:
            assert str(point.step) in passed[0] and passed[0].isprintable(), (seed, passed)
            older += 1
        path.write_bytes(whole[path])
    print(count, "files of checkpoints:", same, "as they were,", older, "passed over")
    assert older > count / 2


def test_a_state_that_is_cut_off_is_a_sentence(tmp_path: Path) -> None:
    for size in (0, 50, 104, 111, 112, 150):
        (tmp_path / "state.5").write_bytes(b"\x01" * size)
        with raises_code("checkpoint.records"):
            state_file.places(tmp_path / "state.5")
