"""What a run directory states about its run, by which a repeated call decides what remains to be done.

`identity.json` holds the fingerprint of all that determines the run, `status/` the outcome of each stage, and
`reference.json` the user reference implementations of custom laws that its replay uses: they do not affect the
simulation, so that after a change only the replay is repeated.
"""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from pywet import run_folder
from pywet.errors import PywetError, one_line, refused
from pywet.laws import custom_laws
from pywet.util import sources
from pywet.util.file_list import LIST, remove
from pywet.util.files import AGAIN, Model, read_bytes, read_json, read_model, write_json
from pywet.util.notices import notice

IDENTITY = "identity.json"
ANY_SEED = 1
"""Seed in place of that of a run, for a fingerprint that does not depend on it."""
REFERENCE = "reference.json"
STATUS = "status/{}.json"
NEEDS = {"scene": None, "simulate": "scene", "results": "simulate", "replay": "simulate", "vtk": "simulate"}
"""Stage -> the stage that it requires; in order of execution."""


@dataclass(frozen=True)
class Identity:
    """Content of `identity.json`."""

    identity: str
    seedless: str | None = None
    """Fingerprint of the run with the seed `ANY_SEED`, which runs have in common that differ only in the seed."""


@dataclass(frozen=True)
class Reference:
    """Content of `reference.json`: a run's user reference implementations by kind of law, with a digest of their code."""

    functions: Mapping[str, str]
    word: str


@dataclass(frozen=True)
class Status:
    """Outcome of a stage; `failed_at` is the stage that failed first, `reason` its one sentence, `code` that of the error."""

    stage: str
    ok: bool
    wall_s: float
    failed_at: str | None = None
    reason: str | None = None
    code: str | None = None
    program: str | None = None
    """Digest of the code that evaluates runs, `sources.EVALUATION`."""

    @classmethod
    def read(cls, run_dir: Path, stage: str) -> Status:
        """Read the status of a stage; a missing or damaged file counts as that of a failed stage, which is repeated."""
        try:
            return _read(run_dir, STATUS.format(stage), cls, "run the case again")
        except PywetError as error:
            return cls(stage, False, 0.0, stage, str(error), error.code)

    def write(self, run_dir: Path) -> None:
        _write(run_dir, STATUS.format(self.stage), self)


def _read(run_dir: Path, name: str, model: type[Model], cure: str = AGAIN) -> Model:
    return read_model(Path(run_dir) / name, model, cure)


def _write(run_dir: Path, name: str, content: Status | Identity | Reference) -> None:
    run_folder.check_held(run_dir)
    write_json(Path(run_dir) / name, asdict(content))


def attempt(run_dir: Path, stage: str, work: Callable[[], Any], aloud: bool = True) -> Status:
    """Run a stage in its locked folder if the one that it requires succeeded; write and return its status.

    An unexpected exception, a fault of pywet, is in the status as well; with `aloud` its traceback and the reason
    of the failure are printed as notices, otherwise it is raised.
    """
    needed, started, fault = NEEDS[stage], time.monotonic(), None
    status = Status.read(run_dir, needed) if needed else Status("", True, 0.0)
    if status.ok:
        reason, code, fault = _failure(work)
        failed_at = None if reason is None else stage
        wall_s, program = time.monotonic() - started, sources.digest_of_evaluation()
        status = Status(stage, reason is None, wall_s, failed_at, reason, code, program)
    else:
        status = replace(status, stage=stage, wall_s=0.0)
    status.write(run_dir)
    if fault is not None and not aloud:
        raise fault
    if fault is not None:
        notice.error("a fault in the program", exc_info=fault)
    if not status.ok and aloud:
        notice.error(f"{Path(run_dir).name}: stage {status.failed_at} failed: {status.reason}")
    return status


def _failure(work: Callable[[], Any]) -> tuple[str | None, str | None, Exception | None]:
    """Run the work; return the reason of a failure in one sentence with its code, and the exception if it is a fault of pywet."""
    try:
        work()
    except PywetError as error:
        return str(error), error.code, None
    except OSError as error:
        return refused(error), None, None
    except Exception as error:
        sentence = f"fault in the program, {type(error).__name__}: {one_line(error)} (traceback in the log)"
        return sentence, None, error
    return None, None, None


def outcome(run_dir: Path, alone: bool = False) -> Status:
    """Return the status of the first stage that failed, otherwise of the last; an incomplete case counts as failed.

    `alone`: a run by `pywet run`, which writes VTK files on demand only.
    """
    for stage in NEEDS:
        there = (Path(run_dir) / STATUS.format(stage)).exists()
        if alone and stage == "vtk" and not there:
            continue
        if not there:
            return Status(stage, False, 0.0, None, f"it was not run to the end: stage {stage} is missing")
        status = Status.read(run_dir, stage)
        if not status.ok:
            break
    return status


def finished(run_dir: Path) -> bool:
    """Return whether a folder contains a run that was simulated, evaluated and replayed, with all its files."""
    return all(Status.read(run_dir, s).ok for s in NEEDS if s != "vtk") and not missing(run_dir)


def evaluated_by_this_code(run_dir: Path) -> bool:
    """Return whether the code that evaluated and replayed a run has not changed since."""
    return all(Status.read(run_dir, s).program == sources.digest_of_evaluation() for s in ("results", "replay"))


def leave_replay(run_dir: Path, refusal: str | None) -> None:
    """Write the sentence by which the replay of a run was refused, for its page; None removes an earlier one."""
    if not os.path.lexists(Path(run_dir) / LIST) or not os.access(run_dir, os.W_OK):
        return
    if refusal is not None:
        code, program = "replay.refused", sources.digest_of_evaluation()
        Status("replay", False, 0.0, "replay", refusal, code, program).write(run_dir)
    elif not Status.read(run_dir, "replay").ok:
        remove(run_dir, STATUS.format("replay"))


def missing(run_dir: Path) -> str | None:
    """Name a file of a finished run that is missing or whose size has changed; None if all are intact."""
    promised = [
        "trajectory.parquet",
        "mesh_motion.parquet",
        "history/spheres.parquet",
        "engine/run.json",
        "summary.json",
    ]
    promised += [f"results/{name}.parquet" for name in ("fraction_retained", "liquid_by_holder")]
    index = Path(run_dir) / "engine" / "tables.json"
    try:
        sizes = {name: int(size) for name, (size, _) in read_json(index)["files"].items()} if index.exists() else {}
    except (PywetError, AttributeError, KeyError, TypeError, ValueError):
        return "engine/tables.json"
    if any(name.startswith("history/") for name in sizes):
        promised += ["replay.json", "history/meta.json", "history/transfer.parquet"]
    absent = (name for name in promised if not (Path(run_dir) / name).is_file())
    changed = (n for n, size in sizes.items() if not (p := Path(run_dir) / n).is_file() or p.stat().st_size != size)
    return next(absent, None) or next(changed, None)


def leave_identity(run_dir: Path, word: str, seedless: str | None = None) -> None:
    """Write the fingerprint of the run in a folder, and that of the same run with the seed `ANY_SEED`."""
    _write(run_dir, IDENTITY, Identity(word, seedless))


def left_identity(run_dir: Path) -> str | None:
    """Return the fingerprint of the run in a folder; None if there is none or its file is damaged."""
    return _identity(run_dir).identity or None


def alike(one: Path, other: Path) -> bool:
    """Return whether two runs may differ only in the seed by their fingerprints; true if a run has none without its seed."""
    words = [_identity(run_dir).seedless for run_dir in (one, other)]
    return None in words or words[0] == words[1]


def _identity(run_dir: Path) -> Identity:
    try:
        return _read(run_dir, IDENTITY, Identity)
    except PywetError:
        return Identity("")


def begin(run_dir: Path, word: str, seedless: str | None = None) -> None:
    """Give a locked folder to the run with this fingerprint; one with another fingerprint is moved aside with a notice.

    Called when the run is built and before it is written, so that a run that cannot be built leaves the other in its place.
    """
    there = any((Path(run_dir) / name).exists() for name in ("engine", "engine.partial", "trajectory.parquet"))
    if there and left_identity(run_dir) != word:
        aside = run_folder.make_way(run_dir)
        notice.warning(
            f"{run_dir} held a run of another configuration or version of pywet, which is {aside} from now on"
        )
    leave_identity(run_dir, word, seedless)


def leave_reference(run_dir: Path, functions: Mapping[Any, str]) -> None:
    """Write the names of the user reference implementations that the replay of this run uses."""
    if functions:
        _write(run_dir, REFERENCE, Reference(dict(functions), reference_word(functions)))
    else:
        remove(run_dir, REFERENCE)


def same_reference(run_dir: Path, functions: Mapping[Any, str]) -> bool:
    """Return whether a run used these functions and their code has not changed since."""
    return _reference(run_dir).word == reference_word(functions)


def reference(run_dir: Path) -> dict[str, str]:
    """Return the functions of a run that are permitted to run; any other is omitted with a notice."""
    named = _reference(run_dir).functions
    for name in (name for name in named.values() if not custom_laws.may_run(name)):
        notice.warning(
            f"the user reference implementation {name} was not run: read its file, then name it in config.yaml or give --trust"
        )
    return {kind: name for kind, name in named.items() if custom_laws.may_run(name)}


def trust_reference(run_dir: Path) -> None:
    """Permit the functions that a run names to run with their present content."""
    custom_laws.trust(_reference(run_dir).functions.values())


def reference_word(functions: Mapping[Any, str]) -> str:
    """Return a digest of the names and files of these functions; empty without any."""
    parts = [
        f"{kind} {name}".encode() + read_bytes(Path(name.rpartition(":")[0]), custom_laws.CURE)
        for kind, name in sorted(functions.items())
    ]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()[:16] if parts else ""


def _reference(run_dir: Path) -> Reference:
    there = os.path.lexists(Path(run_dir) / REFERENCE)
    return _read(run_dir, REFERENCE, Reference) if there else Reference({}, "")
