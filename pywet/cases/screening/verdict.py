"""Decide whether a finished run is trusted: its own checks, its liquid ledger, and the independent replay.

The only module that knows the layout of replay.json, which `reference_impl` writes.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pywet.errors import PywetError
from pywet.laws import custom_laws
from pywet.runs import record
from pywet.runs.rundir import RunDir

LEDGER_TOLERANCE = 1e-12
"""Relative error of Σ films + Σ bridges + Σ walls + left against the initial liquid: round-off of sums."""
REPLAY_TOLERANCE = 1e-9
"""Limit on deviations between engine and replay: the same formulas in double precision.

replay.json states the limit of each quantity; only that of the interpolated transfer table is wider.
"""


@dataclass(frozen=True)
class Agreement:
    """Deviations of one quantity between replay and engine over all its records, relative to `scale`."""

    quantity: str
    scale: str
    count: int
    largest: float
    median: float
    limit: float

    @property
    def ok(self) -> bool:
        return self.largest <= self.limit


def agreement(replay: dict[str, Any]) -> list[Agreement]:
    """Rows of the agreement table from the content of replay.json."""
    numbers = ("largest", "median", "tolerance")  # a file may contain numbers as text
    return [
        Agreement(name, str(row["scale"]), int(row["count"]), *(float(row[number]) for number in numbers))
        for name, row in replay["quantities"].items()
    ]


def unchecked_laws(replay: dict[str, Any]) -> list[str]:
    """List the laws that are unknown to the reference, whose terms were taken as logged: `capillary (own law)`."""
    return [
        f"{row['effect']} ({'own law' if custom_laws.is_custom(row['law']) else row['law']})"
        for row in replay.get("unchecked", ())
    ]


ORDER = ("no", "–", "in part", "yes")
"""Statuses of a check result, the worst first."""


@dataclass(frozen=True)
class CheckResult:
    """Verdict on a run at the top of its page: a status, its colour and a sentence."""

    word: str
    grade: Literal["good", "fair", "bad", ""]
    sentence: str


def check_result(run: RunDir) -> CheckResult:
    """Return `no` if any check fails, `in part` if something was not checked, `yes` if all was, `–` if nothing was."""
    if objected := objections(run):
        return CheckResult("no", "bad", "; ".join(objected))
    replay = run.replay
    if not replay:
        return CheckResult("–", "", "Its checks agree; nothing of it could be replayed.")
    if left := not_checked(replay):
        nothing = "".join(f"; nothing compared: {sentence}" for sentence in nothing_compared(replay))
        points = "1 point was" if len(left) == 1 else f"{len(left)} points were"
        return CheckResult("in part", "fair", f"Recomputed and agrees; {points} not checked{nothing}.")
    return CheckResult("yes", "good", "Its checks, its liquid ledger and the independent replay agree.")


def nothing_compared(replay: dict[str, Any]) -> list[str]:
    """Write a sentence for each feature of the scene that the replay could not compare."""
    return [str(sentence) for sentence in replay.get("nothing_compared", ())]


def not_checked(replay: dict[str, Any]) -> list[str]:
    """Return a sentence for each kind of quantity that was not compared, taken as logged, or checked on a sample."""
    nothing = [f"nothing compared: {sentence}" for sentence in nothing_compared(replay)]
    return [*nothing, *(str(sentence) for sentence in replay.get("not_checked", ()))]


def recomputed(run: RunDir) -> str:
    """Describe what was recomputed: quantities, values, largest deviation, error of the ledger."""
    summary, rows = run.summary, agreement(run.replay) if run.replay else []
    parts = []
    if rows:
        exact = [r.largest for r in rows if r.limit <= REPLAY_TOLERANCE]
        largest = f", largest deviation {max(exact):.1g}" if exact else ""
        parts.append(f"{len(rows)} quantities in {sum(r.count for r in rows)} values recomputed{largest}")
    if summary and summary["ledger_error"] is not None:
        parts.append(f"liquid ledger closes to {summary['ledger_error']:.1g} of the total liquid")
    return "; ".join(parts) or "nothing of it could be replayed"


def problems(run_dir: Path, alone: bool = False) -> list[str]:
    """Return the reasons why a case is not complete: a failed stage, or failed checks, ledger or replay; empty if none."""
    status = record.outcome(run_dir, alone)
    return objections(RunDir(Path(run_dir))) if status.ok else [_failure(status)]


def _failure(status: record.Status) -> str:
    return f"stage {status.failed_at} failed: {status.reason}" if status.failed_at else str(status.reason)


def objections(run: RunDir) -> list[str]:
    """Return one sentence for each check that a run does not satisfy; empty for a run that may be believed."""
    try:
        summary, replay = run.summary, run.replay
    except PywetError as unreadable:
        return [str(unreadable)]
    if summary is None:
        return ["there is no summary.json"]
    sentences = [f"check {c['name']} failed: {c['text']}" for c in summary["checks"] if not c["ok"]]
    error = summary["ledger_error"]
    if error is not None and not error <= LEDGER_TOLERANCE:
        sentences.append(
            f"the liquid ledger is off by {error:.2g} of the initial liquid, allowed is {LEDGER_TOLERANCE:g}"
        )
    rows = agreement(replay) if replay else []
    tried = not replay and (run.path / record.STATUS.format("replay")).exists()
    if tried and not (status := record.Status.read(run.path, "replay")).ok:
        sentences.append(_failure(status))
    elif summary["effects"]["bridges"] and not rows:
        sentences.append("the run was not replayed")
    sentences += [
        f"the replay disagrees on {r.quantity}: {r.largest:.2g} relative, allowed is {r.limit:g}"
        for r in rows
        if not r.ok
    ]
    return sentences
