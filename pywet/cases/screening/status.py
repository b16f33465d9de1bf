"""Status file of each stage of a case, and the reasons why a case does not count as done."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pywet.cases.screening import verdict
from pywet.errors import PywetError
from pywet.runs.rundir import RunDir
from pywet.util.files import read_json, read_model

NEEDS = {"scene": None, "simulate": "scene", "results": "simulate", "replay": "simulate", "vtk": "simulate"}
"""Stage -> the stage that it requires; in order of execution."""


EVALUATIONS = ("results", "replay", "vtk")
"""Stages that may run at the same time."""


@dataclass(frozen=True)
class Status:
    """Outcome of a stage; `failed_at` is the stage that failed first, `reason` its one sentence, `code` that of the error."""

    stage: str
    ok: bool
    wall_s: float
    failed_at: str | None = None
    reason: str | None = None
    code: str | None = None

    @classmethod
    def read(cls, path: Path) -> Status:
        """Read a status file; a damaged one counts as that of a failed stage, which is repeated."""
        try:
            return read_model(path, cls, "run the case again")
        except PywetError as error:
            return cls(Path(path).stem, False, 0.0, Path(path).stem, str(error), error.code)


def status_path(run_dir: Path, stage: str) -> Path:
    return Path(run_dir) / "status" / f"{stage}.json"


def outcome(run_dir: Path, alone: bool = False) -> Status:
    """Return the status of the first stage that failed, otherwise of the last; an incomplete case counts as failed.

    `alone`: a run by `pywet run`, which writes VTK files on demand only.
    """
    for stage in NEEDS:
        path = status_path(run_dir, stage)
        if alone and stage == "vtk" and not path.exists():
            continue
        if not path.exists():
            return Status(stage, False, 0.0, None, f"it was not run to the end: stage {stage} is missing")
        status = Status.read(path)
        if not status.ok:
            break
    return status


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


def results_made(run_dir: Path) -> bool:
    """Return whether the result tables belong to this run; a failed rerun may have left those of an earlier one."""
    path = status_path(run_dir, "results")
    return path.exists() and Status.read(path).ok


def problems(run_dir: Path, alone: bool = False) -> list[str]:
    """Return the reasons why a case is not complete: a failed stage, or failed checks, ledger or replay; empty if none."""
    status = outcome(run_dir, alone)
    if not status.ok:
        return [f"stage {status.failed_at} failed: {status.reason}" if status.failed_at else str(status.reason)]
    return verdict.objections(RunDir(Path(run_dir)))
