"""Kinds of mistakes and what they carry: a caller reads attributes, not sentences."""

from __future__ import annotations

import pickle
import shutil
from pathlib import Path

import pytest

from pywet import config, errors
from pywet.engines.liggghts import process
from pywet.laws import registry
from pywet.planning import time_steps
from pywet.util.files import read_json
from tests.cases.screening import synthetic
from tests.error_codes import raises_code

ROOT = Path(__file__).parent.parent


def test_a_mistake_in_the_configuration_names_file_and_key(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "config", tmp_path / "config")
    path = tmp_path / "config" / "config.yaml"
    path.write_text(path.read_text().replace("fraction: {value: ", "fraction: {valu: "))
    with pytest.raises(errors.ConfigError) as caught:
        config.load(tmp_path / "config")
    assert (caught.value.file, caught.value.key) == (str(path), "time_step.fraction.valu")
    with raises_code("config.unknown_name", given=99):
        config.load(ROOT / "config").case(99)


def test_a_file_and_a_law_are_named(tmp_path: Path) -> None:
    with pytest.raises(errors.FileError) as file:
        read_json(tmp_path / "none.json")
    with pytest.raises(errors.LawError) as law:
        registry.get("capillary", "rabinovitch")
    assert (file.value.path, law.value.law) == (tmp_path / "none.json", "rabinovitch")


def test_a_step_beyond_the_limit_says_both() -> None:
    """The advisor's own limit is what is carried: half of it is accepted."""
    scene = synthetic.scene().model_copy(update={"time_step_s": 1e-2})
    with pytest.raises(errors.UnstableStep) as caught:
        time_steps.refuse_unstable(scene)
    assert caught.value.step_s == 1e-2 > caught.value.largest_s > 0.0
    time_steps.refuse_unstable(scene.model_copy(update={"time_step_s": 0.5 * caught.value.largest_s}))


@pytest.mark.parametrize(
    ("message", "spheres", "step"),
    [
        ("ERROR: sphere 12 overlaps sphere 7 by 0.61 of its radius at step 400, allowed is 0.5", (12, 7), 400),
        ("ERROR: the bridge between spheres 3 and 41 at step 9 reaches beyond the ghost cut-off", (3, 41), 9),
        ("ERROR: sphere 2 left the simulated box before step 77 (1 lost in all)", (2,), 77),
        ("ERROR: sphere 5 overlaps wall part 31 by 0.7 of its radius at step 8", (5,), 8),
        ("ERROR on proc 0: Lost atoms: original 3 current 2 (../thermo.cpp:389)", (), None),
    ],
)
def test_a_stopped_run_carries_spheres_and_step(
    message: str, spheres: tuple[int, ...], step: int | None, tmp_path: Path
) -> None:
    """As the engine and the plugin say it; the sentence is what it was, and crosses to another process with its data."""
    (tmp_path / process.OUTPUT).write_text(f"LIGGGHTS\n{message}\n")
    found = process.stopped(synthetic.scene(), tmp_path, 1)
    again = pickle.loads(pickle.dumps(found))
    for error in (found, again):
        assert isinstance(error, errors.EngineError)
        assert (error.spheres, error.step) == (spheres, step)
        assert str(error) == f"case02: LIGGGHTS stopped: {error.reason}" and "ERROR" not in error.reason


def test_ranks_that_srun_did_not_start_are_no_stop_of_the_engine(tmp_path: Path) -> None:
    """Read srun's message on two nodes of one machine: the failed launch is the reason, not the rank that srun killed for it."""
    message = ["Job step aborted: Waiting up to 7 seconds for job step to finish."]
    message += ["error: task 0 launch failed: Unspecified error", "error: second: task 1: Killed"]
    (tmp_path / process.OUTPUT).write_text("".join(f"srun: {line}\n" for line in message))
    error = process.stopped(synthetic.scene(), tmp_path, 137)
    assert error.reason == "task 0 launch failed: Unspecified error"
    assert str(error).startswith(
        f"case02: srun did not start all ranks ({error.reason}); expected nodes that are machines"
    )
    assert "simulate:nodes=1" in str(error) and "LIGGGHTS" not in str(error)


def test_every_kind_is_the_one_that_a_command_shows() -> None:
    """All are `PywetError`, which the command line turns into one sentence, and can be made of a sentence alone."""
    kinds = [value for value in vars(errors).values() if isinstance(value, type) and issubclass(value, Exception)]
    assert len(kinds) >= 8
    for kind in kinds:
        assert (
            issubclass(kind, errors.PywetError) and str(pickle.loads(pickle.dumps(kind("a sentence")))) == "a sentence"
        )
