"""Collect all data of all cases at one scale for the report; a failed case is included with its reason."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.cases.screening import verdict
from pywet.config.cases import Case
from pywet.errors import PywetError
from pywet.planning import audit
from pywet.products import screening_report
from pywet.runs import record
from pywet.runs.distinct_seeds import distinct_seeds, not_counted
from pywet.runs.record import Status
from pywet.runs.rundir import RunDir
from pywet.runs.shapes import Contributions, Summary
from pywet.util.files import read_table


@dataclass(frozen=True)
class CaseResult:
    """One case; data that a failed case lacks are None."""

    case: Case
    problems: tuple[str, ...]
    summary: dict[str, Any] | None = None
    plan: dict[str, Any] | None = None
    agreement: tuple[verdict.Agreement, ...] = ()
    unchecked: tuple[str, ...] = ()
    """Laws that the reference does not have, as text."""
    second: tuple[str, ...] = ()
    """Kinds of custom laws that were compared with a user reference implementation."""
    retained: pd.DataFrame | None = None
    liquid: pd.DataFrame | None = None
    contributions: dict[str, Any] | None = None
    audit: tuple[audit.AuditRow, ...] = ()
    seeds: tuple[pd.DataFrame, ...] = ()
    """Fraction retained of the same case from other initial arrangements, in folders named CASE-SEED."""
    others: tuple[dict[str, Any], ...] = ()
    """Summaries of these runs, if available."""
    screens: tuple[dict[str, Any], ...] = ()
    """Results of the screen, of the run and of further seeds."""
    nothing: tuple[str, ...] = ()
    """Kinds of quantities in the scene for which the replay compared no values."""
    folder: Path | None = None

    @property
    def done(self) -> bool:
        """Return whether the run is complete and it and its further seeds pass all checks."""
        return not self.problems

    @property
    def moist(self) -> bool:
        """Return whether the case has liquid."""
        return self.case.liquid_percent > 0

    @property
    def bridged(self) -> bool:
        """Return whether bridges were or will be simulated; a moist case may have them switched off explicitly."""
        return bool(self.summary["effects"]["bridges"]) if self.summary else self.moist

    @property
    def cross_checked(self) -> bool:
        """Return whether the replay reproduces every quantity."""
        return bool(self.agreement) and all(row.ok for row in self.agreement)

    @property
    def ends(self) -> list[float]:
        """Return the fraction retained at the end for every seed; empty for a case without results."""
        if self.summary is None:
            return []
        further = [float(table["fraction_retained"].iloc[-1]) for table in self.seeds if len(table)]
        return [self.summary["fraction_retained_end"], *further]

    @property
    def dry_ends(self) -> list[float]:
        """Return the fraction of the dry mass retained at the end for every seed; empty for a case without its table."""
        tables = [] if self.retained is None else [self.retained, *self.seeds]
        return [float(table[DRY].iloc[-1]) for table in tables if len(table)]

    def over_seeds(self, *keys: str, factor: float = 1.0) -> list[float]:
        """Return a number of summary.json by its keys for every seed; empty if the run has none."""
        values = [deep(summary, keys) for summary in (self.summary, *self.others)]
        return [] if values[0] is None else [factor * v for v in values if v is not None]

    @property
    def wall_s(self) -> list[float]:
        """Return the wall time of every seed; that of a resumed run is of some of its steps and left out."""
        return [s["wall_s"] for s in (self.summary, *self.others) if s and not s.get("resumed_at_step")]

    @property
    def ledger_error(self) -> float | None:
        """Return the largest error of the liquid ledger over all seeds; None for a dry run."""
        errors = [s["ledger_error"] for s in (self.summary, *self.others) if s and s["ledger_error"] is not None]
        return max(errors, default=None)

    @property
    def configuration(self) -> tuple[str, float, float, tuple[float, ...], float | None, float | None]:
        """Return what cases that differ only in liquid have in common: material, aperture, amplitude, diameters [mm], feed."""
        case = self.case
        feed = case.class_mass_g, case.class_volume_cm3
        return case.material, case.aperture_mm, case.set_amplitude_mm, case.diameters_mm, *feed


def deep(data: Any, keys: Sequence[str]) -> Any:
    """Return a value of nested dictionaries by its keys; None if one is missing."""
    for key in keys:
        data = data.get(key) if data else None
    return data


def grouped(results: Iterable[CaseResult], key: Callable[[CaseResult], Any]) -> dict[Any, list[CaseResult]]:
    """Group results by key, in the order of the keys' first occurrence."""
    groups: dict[Any, list[CaseResult]] = {}
    for result in results:
        groups.setdefault(key(result), []).append(result)
    return groups


def by_liquid(results: Iterable[CaseResult]) -> list[list[CaseResult]]:
    """Group cases that differ only in the amount of one liquid; dry cases are in every group of their configuration."""
    groups: list[list[CaseResult]] = []
    for alike in grouped(results, attrgetter("configuration")).values():
        liquids = dict.fromkeys(r.case.liquid for r in alike if r.moist)
        groups += [[r for r in alike if not r.moist or r.case.liquid == liquid] for liquid in liquids] or [alike]
    return groups


def named(results: Sequence[CaseResult]) -> str:
    """Return the cases by number: `case 2`, `cases 2, 3`."""
    return f"case{'s' if len(results) > 1 else ''} {', '.join(str(r.case.case) for r in results)}"


def collect(folder: Path, cases: Iterable[Case]) -> list[CaseResult]:
    """Read the run directories `folder`/<case name> of the cases given."""
    return [collect_run(Path(folder) / case.name, case) for case in cases]


def collect_run(run_dir: Path, case: Case, alone: bool = False) -> CaseResult:
    """Read one run directory, `alone` if it is not part of a workflow; an unreadable one is a failed case."""
    try:
        return _collect_run(Path(run_dir), case, alone)
    except PywetError as error:
        return CaseResult(case, (str(error),), folder=Path(run_dir))


def _collect_run(run_dir: Path, case: Case, alone: bool) -> CaseResult:
    found, run = tuple(verdict.problems(run_dir, alone)), RunDir(run_dir)
    summary, plan = run.json("summary.json", Summary), run.plan
    if summary is None or not Status.read(run_dir, "results").ok:  # or of an earlier run
        return CaseResult(case, found, plan=plan, folder=run_dir)
    if case.liquid_percent > 0 and (
        not summary["initial_liquid_m3"] or (summary["effects"]["bridges"] and summary["ledger_error"] is None)
    ):
        raise PywetError(
            f"{run_dir}: summary.json is that of a dry run; run case {case.case} again",
            code="report.dry_run", where=run_dir,
        )  # fmt: skip
    replay, others = run.replay, _other_seeds(run_dir)
    found += tuple(f"{path.name}: {problem}" for path in others for problem in verdict.problems(path, alone=True))
    seeds = [path for path in others if (path / RETAINED).exists()]
    return CaseResult(
        case,
        found,
        summary=summary,
        plan=plan,
        agreement=tuple(verdict.agreement(replay)) if replay else (),
        unchecked=tuple(verdict.unchecked_laws(replay)) if replay else (),
        second=tuple(replay.get("second") or ()) if replay else (),
        retained=run.table_if_there("results/fraction_retained"),
        liquid=run.table_if_there("results/liquid_by_holder"),
        contributions=run.json("contributions.json", Contributions),
        audit=tuple(audit.read(run_dir) or ()),
        nothing=tuple(verdict.nothing_compared(replay)) if replay else (),
        seeds=tuple(read_table(path / RETAINED) for path in seeds),
        others=tuple(s for path in seeds if (s := RunDir(path).json("summary.json", Summary))),
        screens=tuple(s for path in (run_dir, *seeds) if (s := screening_report.stored(path))),
        folder=run_dir,
    )


RETAINED = "results/fraction_retained.parquet"
DRY = "fraction_retained_spheres"
"""Column of the fraction retained without liquid."""
OF_ONE_RUN = ("seed", "seeds", "ranks")
"""Settings in which the seeds of a case may differ."""


def _other_seeds(run_dir: Path) -> list[Path]:
    """Return the runs of further seeds of a run, those without results last.

    Those of another configuration, file or version of pywet, or with its seed, are left out with a notice.
    """
    runs = [r for r in run_dir.parent.glob(f"{run_dir.name}-*") if r.name.removeprefix(f"{run_dir.name}-").isdigit()]
    begun = [run for run in runs if any((run / name).exists() for name in (RETAINED, record.IDENTITY, "status"))]
    mine, same = _configured(run_dir), []
    for run in sorted(begun, key=lambda run: (not (run / RETAINED).exists(), run)):
        other = _configured(run)
        if (mine is None or other is None or mine == other) and record.alike(run_dir, run):
            same.append(run)
        else:
            not_counted(run, run_dir)
    return distinct_seeds([run_dir, *same])[1:]


def _configured(run_dir: Path) -> dict[str, Any] | None:
    """Return the configuration of a run, if it has one, without what distinguishes its seeds."""
    found: dict[str, Any] | None = RunDir(run_dir).json("config.json", dict[str, Any])
    if found is None:
        return None
    return {**found, "settings": {k: v for k, v in (found.get("settings") or {}).items() if k not in OF_ONE_RUN}}
