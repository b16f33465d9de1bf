"""How far a case has come: the status file of each of its stages, and why it does not count as done."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pywet.errors import PywetError
from pywet.files import read_model
from pywet.screening import verdict

NEEDS = {"scene": None, "simulate": "scene", "results": "simulate", "replay": "simulate", "vtk": "simulate"}
"""Stage -> the stage without which it cannot be done; in the order they run."""


@dataclass(frozen=True)
class Status:
    """Outcome of a stage; `failed_at` is the stage that failed first, `reason` its one sentence."""

    stage: str
    ok: bool
    wall_s: float
    failed_at: str | None = None
    reason: str | None = None

    @classmethod
    def read(cls, path: Path) -> Status:
        """Read a status file; a damaged one counts as that of a failed stage, which is tried again."""
        try:
            return read_model(path, cls, "run the case again")
        except PywetError as error:
            return cls(Path(path).stem, False, 0.0, Path(path).stem, str(error))


def status_path(run_dir: Path, stage: str) -> Path:
    return Path(run_dir) / "status" / f"{stage}.json"


def outcome(run_dir: Path) -> Status:
    """Status of the first stage that failed, else of the last; a case that was not run to the end counts as failed."""
    for stage in NEEDS:
        path = status_path(run_dir, stage)
        if not path.exists():
            return Status(stage, False, 0.0, None, f"it was not run to the end: stage {stage} is missing")
        status = Status.read(path)
        if not status.ok:
            break
    return status


def results_made(run_dir: Path) -> bool:
    """Whether the tables of results there are belong to this run: a failed rerun may have left those of an earlier one."""
    path = status_path(run_dir, "results")
    return path.exists() and Status.read(path).ok


def problems(run_dir: Path) -> list[str]:
    """Why a case does not count as done: the stage that failed, or what its checks, ledger and replay found; empty when good."""
    status = outcome(run_dir)
    if not status.ok:
        return [f"stage {status.failed_at} failed: {status.reason}" if status.failed_at else str(status.reason)]
    return verdict.objections(Path(run_dir))
