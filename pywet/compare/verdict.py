"""Comparison of two runs or groups: whether they are comparable, what differs, and whether it is significant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import norm

from pywet.compare import common_end, statistics
from pywet.compare.grouping import same_scene
from pywet.compare.quantities import CASE, RESULTS, Quantity, RunData, beyond_seed, facts, read_run, unlike
from pywet.compare.statistics import LEVEL, ROUND_OFF, Sample
from pywet.errors import PywetError
from pywet.products.partition import NORMAL_95
from pywet.runs.distinct_seeds import distinct_seeds
from pywet.runs.rundir import Floats
from reference_impl.replay import whole

WITHIN_ONE = "one run each: numbers of the screen by their 95 % intervals within one run, Holm over these numbers"
"""Name of the method for results of a screen."""
MAIN = "fraction retained"
"""Quantity of the first line, if the runs have it."""


class NotComparable(PywetError):
    """Raised if two runs or groups do not simulate the same case."""

    code = "compare"


@dataclass(frozen=True)
class Row:
    """One quantity: means of both groups (a curve at its largest difference), spread, deviation, verdict."""

    quantity: str
    unit: str
    a: float
    b: float
    deviation: float
    """|a − b| over the quantity's scale, at the largest difference (or |t|)."""
    spread: float | None
    """Pooled standard deviation of a run there, over the scale; None with one run each."""
    interval: float | None
    """Half width of the 95 % confidence interval of b − a there [unit], for this quantity alone; None without scatter.

    With one run each it is that of the scatter within the runs, for results of a screen only.
    """
    time_s: float | None
    t: float | None
    p: float | None
    verdict: str
    different: bool


@dataclass(frozen=True)
class Comparison:
    """Result of a comparison; `verdict` is its one-sentence summary.

    `different`: whether a quantity differs, in single runs of a screen one of its numbers, or a check failed.
    """

    a: list[str]
    b: list[str]
    method: str
    level: float | None
    verdict: str
    different: bool
    rows: list[Row]
    checks: dict[str, Any]
    compared: dict[str, list[str]]
    """Description of the runs of each group, one sentence each."""
    left_out: list[str]
    """Quantities that only some of the runs have."""
    notes: list[str]
    """Cut sizes that sizes on both sides do not enclose, decks that are not steady, ends of parts, with the runs."""
    end: str
    """A quantity in both groups, and its difference with interval.

    It is the fraction retained at the end, for a screen its first number, for other scenes the quantity that differs most,
    where it does.
    """


def runs_in(folder: Path) -> list[Path]:
    """Return the folder itself if it is a run directory, else the run directories directly inside it."""
    folder = Path(folder)
    if (folder / "scene.json").exists():
        return [folder]
    run_dirs = sorted(p.parent for p in folder.glob("*/scene.json"))
    if not run_dirs:
        raise PywetError(
            f"{folder} is no run directory and holds none; expected one with scene.json, or a folder of seeds",
            code="compare.no_run_folder", where=folder,
        )  # fmt: skip
    return run_dirs


def read_groups(
    a: Sequence[Path], b: Sequence[Path], force: bool = False, across: Sequence[str] = ()
) -> list[list[RunData]]:
    """Read both groups; raise `NotComparable` if they differ in more than the settings of `across`, unless `force`.

    Runs of one group differ in the seed only, and each seed is counted once, unless `force`.
    """
    end_s = common_end.of_runs([*a, *b])
    groups = [[read_run(p, end_s) for p in paths] for paths in (a, b)]
    if not force:
        _comparable(groups, across)
        groups = [_seeds(group) for group in groups]
    return groups


def compare(a: Sequence[Path], b: Sequence[Path], force: bool = False, across: Sequence[str] = ()) -> Comparison:
    """Compare two runs (one path each) or two groups, see `read_groups` for `force` and `across`."""
    groups = read_groups(a, b, force, across)
    every = list(dict.fromkeys(n for g in groups for r in g for n in r.quantities))
    names = [n for n in every if all(n in r.quantities for g in groups for r in g)]
    if not names:
        raise NotComparable(
            f"{a[0]} and {b[0]} have no table in common; expected finished runs: run them again",
            code="compare.no_table",
        )
    _same_tables(groups)
    checks, broken = _checks(groups)
    if len(groups[0]) == len(groups[1]) == 1:
        method, rows, verdict = _single(groups[0][0], groups[1][0], names)
        used = None
    else:
        method, rows, verdict = _groups(groups, names)
        used = LEVEL
    if broken:
        verdict += f"; {broken}"
    decisive = [r for r in rows if not method.startswith(WITHIN_ONE) or groups[0][0].quantities[r.quantity].of_screen]
    different = any(r.different for r in decisive) or bool(broken)
    compared = {label: [whole.sentence(r.held) for r in group] for label, group in zip("ab", groups, strict=True)}
    left_out = [n for n in every if n not in names]
    end = _headline(groups, names, rows)
    return Comparison(
        [str(run.path) for run in groups[0]],
        [str(run.path) for run in groups[1]],
        method,
        used,
        verdict,
        different,
        rows,
        checks,
        compared,
        left_out,
        _notes(groups),
        end,
    )


def _notes(groups: list[list[RunData]]) -> list[str]:
    """Return the notes on the numbers of the runs, each once with its runs."""
    found: dict[str, list[str]] = {}
    for run in (run for group in groups for run in group):
        for note in run.notes:
            found.setdefault(note, []).append(str(run.path))
    return [f"{note} in {', '.join(runs)}" for note, runs in found.items()]


def _headline(groups: list[list[RunData]], names: list[str], rows: list[Row]) -> str:
    """Describe the quantity of the second line, see `Comparison.end`."""
    if MAIN in names:
        return _described(groups, MAIN)
    row = rows[0] if groups[0][0].quantities[names[0]].of_screen else _foremost(rows)
    return _described(groups, row.quantity, row)


def _foremost(rows: list[Row]) -> Row:
    """Return the row that differs most: of the smallest p, then the largest |t|; of single runs the largest deviation."""
    return min(rows, key=lambda r: (1.0 if r.p is None else r.p, -r.deviation if r.t is None else -r.t))


def _described(groups: list[list[RunData]], name: str, row: Row | None = None) -> str:
    """Describe a quantity in both groups and their difference, each with its interval, at the time of a row or at the end."""
    times, unit = _times(groups, name), groups[0][0].quantities[name].unit
    if row and row.time_s is not None:
        times = times[times <= row.time_s]
    a, b = (np.array([float(r.quantities[name].at(times)[-1]) for r in g]) for g in groups)
    when = f" at {times[-1]:.3g} s" if len(times) else ""
    ends = ", ".join(f"{label} {_mean(values)}" for label, values in (("A", a), ("B", b)))
    message = f"{name}{when}{'' if unit == '1' else f' [{unit}]'}: {ends}, B − A {b.mean() - a.mean():+.3g}"
    half = statistics.of_difference(a, b)
    within = ""
    if half is None and (one := _within(*(g[0].quantities[name] for g in groups))) is not None:
        half, within = one, ", within one run each"
    if half is None:
        return f"{message}; no interval from one run each"
    least = ROUND_OFF * max(abs(a.mean()), abs(b.mean()))
    if abs(b.mean() - a.mean()) <= max(half, least):
        return f"{message} ± {half:.2g} (95 %{within}): not significant"
    if half <= least:
        return f"{message}; no interval, as neither group scatters"
    if row and row.different:
        return f"{message} ± {half:.2g} (95 %{within}): significant"
    return f"{message} ± {half:.2g} (95 %{within}): significant for this quantity alone"


def _within(a: Quantity, b: Quantity) -> float | None:
    """Return the half width of the 95 % interval of b − a from the intervals of both numbers, on the facing sides (MOVER)."""
    x, y = float(a.values[-1]), float(b.values[-1])
    sides = (1, 0) if y >= x else (0, 1)
    ends = [q.interval[k] if q.interval else None for q, k in zip((a, b), sides, strict=True)]
    if ends[0] is None or ends[1] is None:
        return None
    return float(np.hypot(ends[0] - x, ends[1] - y)) or None  # without any scatter nothing is known of it


def _mean(values: Floats) -> str:
    if len(values) < 2:
        return f"{values[0]:.3g} (one run)"
    half = statistics.half_width(float(values.std(ddof=1)), len(values), len(values) - 1, 0.95)
    return f"{values.mean():.3g} ± {half:.2g}"


def _same_tables(groups: list[list[RunData]]) -> None:
    """Refuse runs of which only some have a table of results, since they must not pass as equal."""
    runs = [run for group in groups for run in group]
    for name in RESULTS:
        there = [name in run.held["rows"] for run in runs]
        if any(there) and not all(there):
            raise NotComparable(
                f"{runs[there.index(False)].path} has no {name}.parquet, but {runs[there.index(True)].path} has; "
                "expected both with results: run the case to its end",
                code="compare.one_table", key=name, where=runs[there.index(False)].path,
            )  # fmt: skip


def _comparable(groups: list[list[RunData]], across: Sequence[str]) -> None:
    first = groups[0][0]
    for group in groups:
        if differs := _settings(first, group[0], across):
            named = " ".join(f"--across '{name}'" if " " in name else f"--across {name}" for name in differs)
            raise NotComparable(
                f"{first.path} and {group[0].path} differ in {', '.join(differs)}; expected the same case at the same"
                f" scale ({named} compares groups across it, --force whatever differs)",
                code="compare.scenes", given=tuple(differs), where=group[0].path,
            )  # fmt: skip
        for run in group[1:]:
            differs = _settings(group[0], run)
            if not differs and not same_scene(group[0].path, run.path):
                differs = beyond_seed(group[0].scene, run.scene)
            if differs:
                raise NotComparable(
                    f"{group[0].path} and {run.path} of one group differ in {', '.join(differs)}; expected runs of one group to "
                    "differ in the seed only: compare them as two groups (--a, --b), or use --force",
                    code="compare.scenes", given=tuple(differs), where=run.path,
                )  # fmt: skip


def _settings(one: RunData, other: RunData, across: Sequence[str] = ()) -> list[str]:
    """Name the settings in which the cases of two runs differ; the name alone is one for screening cases only."""
    differs = unlike(facts(one.scene, one.path), other.scene, across, other.path)
    return [name for name in differs if name != CASE] or (differs if one.scene.slide else [])


def _seeds(group: list[RunData]) -> list[RunData]:
    """Return the runs of a group, each seed once; refuse runs of different seeds with the same trajectory."""
    runs = {run.path: run for run in group}
    seeds = [runs[path] for path in distinct_seeds([run.path for run in group])]
    marks: dict[str | None, Path] = {}
    for run in seeds:
        mark = run.fingerprint().get("trajectory")
        if mark is not None and mark in marks:
            raise NotComparable(
                f"{run.path} repeats {marks[mark]} digit by digit; expected runs of one group to differ in the seed",
                code="compare.same_run", where=run.path,
            )  # fmt: skip
        marks[mark] = run.path
    return seeds


def _checks(groups: list[list[RunData]]) -> tuple[dict[str, Any], str]:
    """Return the checks by name, passed of all in each group, and a sentence on checks that only one group passes."""
    checks: dict[str, Any] = {}
    for label, group in zip("ab", groups, strict=True):
        for run in group:
            for name, (ok, value) in run.checks.items():
                entry = checks.setdefault(name, {"a": [0, 0], "b": [0, 0], "worst": 0.0})
                entry[label][0] += int(ok)
                entry[label][1] += 1
                entry["worst"] = max(entry["worst"], value)
    failing = [n for n, e in checks.items() if e["a"][0] < e["a"][1] or e["b"][0] < e["b"][1]]
    return checks, f"failed checks: {', '.join(failing)}" if failing else ""


def _times(groups: list[list[RunData]], name: str) -> Floats:
    """Return the times of the first run's curve that all runs cover."""
    curves = [r.quantities[name].times for g in groups for r in g]
    if len(curves[0]) == 0:
        return np.array([])
    low, high = max(t[0] for t in curves), min(t[-1] for t in curves)
    return np.asarray(curves[0][(curves[0] >= low - 1e-12) & (curves[0] <= high + 1e-12)])


def _single(a: RunData, b: RunData, names: list[str]) -> tuple[str, list[Row], str]:
    """Compare two single runs: bit-identical, equal within round-off, or different; significance is not judged."""
    rows = []
    for name in names:
        times = _times([[a], [b]], name)
        x, y = a.quantities[name], b.quantities[name]
        u, v = x.at(times), y.at(times)
        off, scale = np.abs(u - v), max(x.scale, y.scale)
        k = int(off.argmax())
        message = "identical" if off[k] == 0 else "within round-off" if off[k] <= ROUND_OFF * scale else "differs"
        time = float(times[k]) if len(times) else None
        rows.append(
            Row(name, x.unit, float(u[k]), float(v[k]), float(off[k] / scale), None, None, time, None, None, message,
                message == "differs")
        )  # fmt: skip
    rows = _screen_rows(a, b, rows)
    same = a.fingerprint() == b.fingerprint()
    worst = max(rows, key=lambda r: r.deviation)
    if same and worst.deviation == 0:
        verdict = "the runs are bit-identical"
    elif worst.deviation <= ROUND_OFF:
        verdict = f"the runs agree within round-off (largest deviation {worst.deviation:.1e}, {worst.quantity})"
    elif any(a.quantities[name].of_screen for name in names):
        return (
            f"{WITHIN_ONE}; other quantities, which do not decide: equal digit by digit, within round-off, or not",
            rows,
            _of_screen(a, rows),
        )
    else:
        verdict = (
            f"the runs differ (most in {worst.quantity}: {worst.deviation:.2g} of its scale); one run each says nothing"
            " about significance: compare several seeds"
        )
    return "one run each: equal digit by digit, within round-off, or not", rows, verdict


def _screen_rows(a: RunData, b: RunData, rows: list[Row]) -> list[Row]:
    """Judge the results of a screen that differ by their intervals within the runs, with Holm's adjustment."""
    halves = {r.quantity: _within(a.quantities[r.quantity], b.quantities[r.quantity]) for r in rows if r.different}
    tested = [r for r in rows if a.quantities[r.quantity].of_screen and halves.get(r.quantity) is not None]
    found = []
    for row in tested:
        half = halves[row.quantity]
        assert half
        t = NORMAL_95 * abs(row.b - row.a) / half
        found.append(statistics.Finding(t, 0, float(2.0 * norm.sf(t))))
    adjusted = dict(zip((r.quantity for r in tested), statistics.holm(found), strict=True))
    return [_judged(r, halves[r.quantity], adjusted[r.quantity]) if r.quantity in adjusted else r for r in rows]


def _judged(row: Row, half: float | None, finding: statistics.Finding) -> Row:
    different = finding.p <= LEVEL
    message = "differs beyond the intervals" if different else "within the intervals"
    return replace(row, interval=half, t=finding.t, p=finding.p, verdict=message, different=different)


def _of_screen(a: RunData, rows: list[Row]) -> str:
    """Return the verdict on the results of a screen from one run each."""
    of = [r for r in rows if a.quantities[r.quantity].of_screen]
    called = [r.quantity for r in of if r.verdict == "differs beyond the intervals"]
    unknown = [r.quantity for r in of if r.verdict == "differs"]
    message = (
        f"{len(called)} of {len(of)} numbers of the screen differ beyond their intervals within one run each"
        f"{f': {_listed(called)}' if called else ''}"
    )
    if unknown:
        message += f"; without an interval, but different: {_listed(unknown)}"
    return f"{message}; other seeds may scatter more: compare several seeds"


def _listed(names: list[str]) -> str:
    return ", ".join(names)


def _groups(groups: list[list[RunData]], names: list[str]) -> tuple[str, list[Row], str]:
    """Compare groups of several seeds: tests over all quantities at once."""
    times = [_times(groups, name) for name in names]
    first = {
        name: replace(groups[0][0].quantities[name], scale=max(r.quantities[name].scale for g in groups for r in g))
        for name in names
    }
    samples = [
        Sample(*(np.array([r.quantities[name].at(at) / first[name].scale for r in g]) for g in groups))
        for name, at in zip(names, times, strict=True)
    ]
    method, findings = statistics.test(samples)
    reported = zip(names, samples, times, findings, strict=True)
    rows = [_row(first[name], s, at, finding) for name, s, at, finding in reported]
    called = [r for r in rows if r.different]
    n, m = len(groups[0]), len(groups[1])
    of = [r for r in rows if first[r.quantity].of_screen]
    if of and called:
        there = [r.quantity for r in of if r.different]
        verdict = (
            f"{len(there)} of {len(of)} numbers of the screen{f' ({_listed(there)})' if there else ''} and"
            f" {len(called) - len(there)} of {len(rows) - len(of)} other quantities differ beyond the spread of {n} and {m} seeds"
        )
    elif called:
        verdict = (
            f"{len(called)} of {len(rows)} quantities differ beyond the spread of {n} and {m} seeds, first of all"
            f" {_foremost(called).quantity}"
        )
    else:
        verdict = f"no difference beyond the spread of {n} and {m} seeds in {len(rows)} quantities"
    return method, rows, verdict


def _row(q: Quantity, s: Sample, times: Floats, finding: statistics.Finding) -> Row:
    k = finding.at
    a, b = float(s.a[:, k].mean()), float(s.b[:, k].mean())
    squares = ((s.a[:, k] - a) ** 2).sum() + ((s.b[:, k] - b) ** 2).sum()
    spread = float(np.sqrt(squares / max(len(s.a) + len(s.b) - 2, 1)))
    different = finding.p <= LEVEL
    half = statistics.of_difference(s.a[:, k], s.b[:, k])
    half = None if half is None or half < ROUND_OFF else half * q.scale
    return Row(
        q.name, q.unit, a * q.scale, b * q.scale, abs(a - b), spread, half,
        float(times[k]) if len(times) else None,
        finding.t, finding.p, "differs beyond the spread" if different else "within the spread", different,
    )  # fmt: skip
