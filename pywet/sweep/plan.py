"""Plan of a sweep before its runs: points checked and named, mistakes, number of runs, core-hours, disk."""

from __future__ import annotations

import difflib
import heapq
import math
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from pywet.cost.command import duration
from pywet.errors import ConfigError, PywetError
from pywet.laws import custom_laws as user_laws
from pywet.sweep import bases, description, points, sweep_folder
from pywet.sweep.base_kind import Built, Kind
from pywet.sweep.costs import Cost
from pywet.sweep.description import Function, Point, Sweep
from pywet.sweep.points import Numbered, printed
from pywet.sweep.store import Store
from pywet.util.files import read_if_there

LISTED = 5
"""Number of mistakes of points that are printed; the others are counted."""
Report = Callable[..., None]


class Run(NamedTuple):
    """A row of the table: a point with one seed; `seed` is relative to the base's."""

    point: Numbered
    seed: int
    built: Built


@dataclass(frozen=True)
class Plan:
    """A sweep as read from its file; its points are checked when `runs` is accessed."""

    file: Path
    sweep: Sweep
    kind: Kind
    store: Store
    folder: Path
    chosen: tuple[Point, ...] | None = None
    """Points that adaptive sampling has added, before they are in the folder; None: those in the folder."""

    @property
    def added(self) -> list[Point]:
        """Return the points that adaptive sampling has added to the sweep."""
        if self.chosen is not None:
            return [*self.chosen]
        if sweep_folder.named(self.folder) not in (None, self.file.resolve()):  # of a file that no longer exists
            return []
        path = self.folder / sweep_folder.ADDED
        found = list(read_if_there(path, "remove the file", list[dict[str, description.Value]]) or [])
        if any(point.keys() != self.sweep.axes.keys() for point in found):
            raise ConfigError(
                f"{path} holds points of other axes than {self.file}; expected the same: remove it",
                file=path, code="sweep.added_axes",
            )  # fmt: skip
        return found

    @cached_property
    def points(self) -> list[Numbered]:
        return points.numbered(self.sweep, self.file, self.added)

    @cached_property
    def gather(self) -> list[str | Function]:
        """Return the results to be gathered from each point, in the order of the table."""
        return list(self.sweep.gather or self.kind.results)

    @property
    def results(self) -> list[str]:
        """Return the names of the gathered results."""
        return [g if isinstance(g, str) else g.name for g in self.gather]

    def run(self, number: int, seed: int) -> Run:
        """Return one run by the number of its point."""
        point = self.points[number - 1]
        return Run(point, seed, self.kind.built(point.values, seed))

    @cached_property
    def runs(self) -> list[Run]:
        """List all runs; mistakes of all points are one error, which names the first ones with their points."""
        found, wrong = [], []
        for point in self.points:
            try:
                found += [self.run(point.number, seed) for seed in range(self.sweep.seeds)]
            except PywetError as error:
                wrong.append((point, error))
        _refuse(self.file, wrong)
        return found

    @property
    def missing(self) -> list[Run]:
        """Return the runs that are not in the store, each fingerprint once."""
        there = {run.built.name: run for run in self.runs}
        return [run for name, run in there.items() if self.store.numbers(name, self.kind.engine) is None]

    def cost_of(self, run: Run) -> Cost:
        """Return the predicted cost of a run; without a prediction that of stored runs of its kind, if any."""
        cost = self.kind.cost(run.built)
        return cost if cost.known else self.store.typical(run.built.name) or cost

    def cost(self, report: Report = lambda done, of: None) -> list[tuple[Run, Cost]]:
        """Predict the cost of every missing run; the scene of each missing point is built once, and refused if it is invalid."""
        missing, by_point, wrong = self.missing, {}, []
        first = {run.point.number: run for run in reversed(missing)}
        for k, run in enumerate(first.values()):
            report(k, len(first))
            try:
                by_point[run.point.number] = self.cost_of(run)
            except PywetError as error:
                wrong.append((run.point, error))
        _refuse(self.file, wrong)
        return [(run, by_point[run.point.number]) for run in missing]


def _refuse(file: Path, wrong: list[tuple[Numbered, PywetError]]) -> None:
    """Raise the first mistakes, each with its first point and how many others have it, with the data of the first of all."""
    by_message: dict[str, list[Numbered]] = {}
    for point, error in wrong:
        by_message.setdefault(str(error).splitlines()[0], []).append(point)
    lines = []
    for message, where in list(by_message.items())[:LISTED]:
        others = f" (and at {len(where) - 1} other points)" if len(where) > 1 else ""
        lines.append(f"{file}: point {where[0].number} ({printed(where[0].values)}): {message}{others}")
    if len(by_message) > LISTED:
        lines.append(f"{file}: {len(by_message) - LISTED} more mistakes at other points")
    if lines:
        raise ConfigError("\n".join(lines), **{**wrong[0][1].data, "where": file})


def read_file(file: Path, out: Path | None = None, store: Path | None = None, trust: bool = False) -> Plan:
    """Read a sweep from its file, with the folders of its table and of the store; a file with a mistake is refused."""
    sweep = description.read(file)
    kind = bases.kind(sweep.base, file.parent, trust)
    if sweep.seeds > 1 and not kind.seeded:
        raise ConfigError(
            f"{file}: seeds is {sweep.seeds}, but a {sweep.base.kind} has no seed; expected seeds: 1",
            file=file, code="sweep.seeds", key="seeds", given=sweep.seeds, expected=1,
        )  # fmt: skip
    return Plan(file, sweep, kind, Store(store or sweep_folder.STORE), out or sweep_folder.of(file))


def read(file: Path, out: Path | None = None, store: Path | None = None, trust: bool = False) -> Plan:
    """Read a sweep and check its results; functions in files are permitted to run if `trust` is given."""
    plan = read_file(file, out, store, trust)
    _check_gather(plan, trust)
    return plan


def _check_gather(plan: Plan, trust: bool) -> None:
    """Refuse results that the base does not have, and functions that may not run."""
    if not plan.gather:
        raise ConfigError(
            f"{plan.file}: gather is missing, expected results of a {plan.sweep.base.kind}",
            file=plan.file, code="sweep.no_gather", key="gather",
        )  # fmt: skip
    first = plan.points[0]
    try:
        known = plan.kind.known(plan.kind.built(first.values, 0))
    except PywetError:
        known = []  # the check of all points reports the first mistakes
    for name in plan.gather:
        if isinstance(name, Function):
            _check_function(plan.file, name, trust)
        elif known and name not in known and not (name.startswith("energy_") and name.endswith("_J")):
            close = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
            expected = " or ".join(close) if close else f"one of {', '.join(known)}"
            raise ConfigError(
                f"{plan.file}: gather names {name}, which no run has; expected {expected}",
                file=plan.file, code="sweep.unknown_result", key="gather", given=name, expected=expected,
            )  # fmt: skip
    goal = plan.sweep.goal
    if goal is not None and goal.result not in plan.results:
        raise ConfigError(
            f"{plan.file}: goal names {goal.result}; expected a gathered result, {', '.join(plan.results)}",
            file=plan.file, code="sweep.goal", key="goal", given=goal.result, expected=plan.results,
        )  # fmt: skip


def path_of(file: Path, function: Function) -> str:
    """Return a function's name with the full path of its file, which is relative to the sweep's folder."""
    return user_laws.placed(function.function, file.parent)


def _check_function(file: Path, function: Function, trust: bool) -> None:
    name = path_of(file, function)
    user_laws.trust([name], None if trust else file.parent)
    if not Path(name.rpartition(":")[0]).is_file():
        raise ConfigError(
            f"{file}: gather names {function.function}; its file does not exist, expected path/to/file.py:name",
            code="sweep.no_function_file", file=file, key="gather", given=function.function,
        )  # fmt: skip
    refuse_untrusted(file, function)


def refuse_untrusted(file: Path, function: Function) -> None:
    """Refuse a function whose file is not trusted with its present content."""
    if not user_laws.may_run(path_of(file, function)):
        raise ConfigError(
            f"{file}: gather names {function.function}, which was not run: it is not below the folder of the sweep; read it, "
            "then move it there, or give --trust",
            file=file, code="sweep.untrusted", key="gather", given=function.function,
        )  # fmt: skip


def at_a_time(kind: Kind, runs: int, cores: int, ranks: int | None = None) -> tuple[int, int]:
    """Return the number of runs that are executed at a time, and of the cores of each; `ranks`: if not those of the base."""
    if not kind.engine:
        return 1, 1
    each = min(cores, ranks or kind.ranks)
    return max(1, min(runs, cores // each)), each


def lines(plan: Plan, costs: list[tuple[Run, Cost]], cores: int, ranks: int | None = None) -> list[str]:
    """Return the lines of the plan that are printed before the runs; arguments as in `at_a_time`."""
    runs, points_, seeds = len(plan.runs), len(plan.points), plan.sweep.seeds
    left_out = plan.sweep.count // seeds + len(plan.added) - points_
    stored = len({run.built.name for run in plan.runs}) - len(costs)
    why = ["left out by constraints"] * bool(plan.sweep.constraints)
    why += ["repeated"] * (not why or any(axis.whole for axis in plan.sweep.axes.values()))
    seconds, disk = sum(c.seconds for _, c in costs), sum(c.disk_B for _, c in costs)
    constrained = f", {left_out} {' or '.join(why)}" if left_out else ""
    same = f", {shared} have the inputs of others" if (shared := runs - len(costs) - stored) else ""
    takes = "time and disk unknown before one run is in the store"
    if all(c.known for _, c in costs):
        together, each = at_a_time(plan.kind, len(costs), cores, ranks)
        used, ends = together * each, [0.0] * together
        for _, c in costs:  # in the order in which they start, each where one has ended first
            heapq.heapreplace(ends, ends[0] + c.seconds / each)
        on = f"{duration(max(ends))} on {used} core{'s' if used > 1 else ''}"
        takes = f"about {hours(seconds)}, {on}, {disk / 1e9:.2g} GB"
    return [
        f"{plan.sweep.name}: {points_} points, {runs} runs{f' ({seeds} seeds)' if seeds > 1 else ''}{constrained}",
        f"{stored} are in the store, {len(costs)} to run{same}: {takes}",
    ]


def spent(plan: Plan, costs: list[tuple[Run, Cost]]) -> str | None:
    """Report measured and predicted cost of the runs of a call; None if none was measured."""
    both = [(measured, cost) for run, cost in costs if (measured := plan.store.took(run.built.name)) is not None]
    if not both:
        return None
    (seconds, before_s), (disk, before_B) = (
        [sum(c[k] for c in part) for part in zip(*both, strict=True)] for k in (0, 1)
    )
    predicted = "" if math.isnan(before_s) else f" (predicted {hours(before_s)}, {before_B / 1e9:.2g} GB)"
    return f"{len(both)} runs took {hours(seconds)}, {disk / 1e9:.2g} GB{predicted}"


def hours(seconds: float) -> str:
    """Format a time as core-hours."""
    return f"{seconds / 3600.0:.2g} core-hours"


def refuse_too_much(plan: Plan, costs: list[tuple[Run, Cost]]) -> None:
    """Refuse a sweep that exceeds its limits or the free space of the store's disk."""
    seconds, disk = sum(c.seconds for _, c in costs), sum(c.disk_B for _, c in costs)
    where = next(p for p in (plan.store.folder.absolute(), *plan.store.folder.absolute().parents) if p.exists())
    free = shutil.disk_usage(where).free
    for given, what, limit, key in (
        (seconds / 3600.0, "core-hours", plan.sweep.most_core_hours, "most_core_hours"),
        (disk / 1e9, "GB", min(plan.sweep.most_disk_GB, free / 1e9), "most_disk_GB"),
    ):
        if given > limit:
            raise PywetError(
                f"{plan.file}: the runs take about {given:.3g} {what}, expected at most {limit:.3g}: shorten axes, seeds or "
                f"runs, or raise {key}" + (f" (free on the disk: {free / 1e9:.3g} GB)" if what == "GB" else ""),
                code="sweep.too_much", key=key, given=given, expected=limit, where=plan.file,
            )  # fmt: skip
