"""The commands `pywet compare` and `pywet digest`: printed output and exit codes."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from pywet import run_folder
from pywet.compare import digest, verdict
from pywet.errors import PywetError
from pywet.util.files import write_json

SHORT = {"differs beyond the spread": "beyond", "within the spread": "within", "within round-off": "round-off",
         "differs beyond the intervals": "beyond", "within the intervals": "within"}  # fmt: skip
SAME, DIFFERENT = 0, 1
out = Console(highlight=False)


def compare(
    runs: Sequence[Path],
    a: Sequence[Path],
    b: Sequence[Path],
    json_file: Path | None,
    force: bool,
    against: Path | None,
    across: Sequence[str] = (),
    plot: Path | None = None,
) -> int:
    """Compare, print the result and return the exit code."""
    if against is not None:
        if any((a, b, across, json_file, plot)):
            raise PywetError(
                "--digest was given with another option; expected RUN… --digest FILE alone", code="compare.groups"
            )
        return _against(runs, against)
    left, right = _groups(runs, a, b)
    if plot is not None:
        from pywet.report import bands

        bands.check_name(plot)
    with run_folder.reading(*left, *right):
        comparison = verdict.compare(left, right, force, across)
        show(comparison)
        if json_file is not None:
            write_json(json_file, asdict(comparison))
        if plot is not None:
            names = _names(runs[:1] or a, runs[1:] or b)
            typer.echo(f"{bands.write(plot, dict(zip(names, (left, right), strict=True)))}")
    return DIFFERENT if comparison.different else SAME


def _groups(runs: Sequence[Path], a: Sequence[Path], b: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    if len(runs) == 2 and not a and not b:
        left, right = [runs[0]], [runs[1]]
    elif not runs and a and b:
        left, right = list(a), list(b)
    else:
        raise PywetError(
            "expected two runs, RUN_A RUN_B, or two groups, --a DIR --a DIR … --b DIR --b DIR …", code="compare.groups"
        )
    return [r for p in left for r in verdict.runs_in(p)], [r for p in right for r in verdict.runs_in(p)]


def _names(a: Sequence[Path], b: Sequence[Path]) -> tuple[str, str]:
    """Return short names of both groups for a legend: the ends of their paths from where these differ, without seeds.

    >>> _names([Path("deck/dry")], [Path("deck/wet")]), _names([Path("5/1"), Path("5/1-2")], [Path("7/1"), Path("7/1-2")])
    (('A dry', 'B wet'), ('A 5/1', 'B 7/1'))
    """
    one, other = (
        Path(re.sub(r"-\d+$", "", str(group[0].resolve()))) if len(group) > 1 else group[0].resolve()
        for group in (a, b)
    )
    k = next((k for k in range(1, len(one.parts)) if one.parts[-k:] != other.parts[-k:]), 1)
    return f"A {'/'.join(one.parts[-k:])}", f"B {'/'.join(other.parts[-k:])}"


def show(comparison: verdict.Comparison) -> None:
    """Print the verdict and the table, what differs first, at most 80 columns wide."""
    out.print(comparison.verdict, style="red" if comparison.different else "green", soft_wrap=True, markup=False)
    out.print(comparison.end, soft_wrap=True, markup=False)
    several = comparison.level is not None
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in ("quantity", "A", "B", "B − A", "p" if several else "off", "at [s]", ""):
        table.add_column(escape(name), no_wrap=name != "quantity", max_width=24 if name == "quantity" else None)
    shown = [row for row in comparison.rows if row.a or row.b or row.different]
    for row in sorted(shown, key=lambda row: not row.different):
        colour = "red" if row.different else "green"
        unit = "" if row.unit == "1" else f" [{row.unit}]"
        table.add_row(
            escape(f"{row.quantity}{unit}"), _number(row.a), _number(row.b), _difference(row),
            f"{row.p:.2g}" if several else f"{row.deviation:.1e}",
            "" if row.time_s is None else f"{row.time_s:.3g}", f"[{colour}]{SHORT.get(row.verdict, row.verdict)}",
        )  # fmt: skip
    out.print(table)
    if zero := len(comparison.rows) - len(shown):
        out.print(f"{zero} more are 0 in all runs", soft_wrap=True)
    if several:
        out.print(
            "B − A: at the time in the column at [s], where |t| is largest, with the 95 % interval of this quantity alone",
            soft_wrap=True,
            markup=False,
        )
    else:
        out.print(
            "off: |A − B| over the quantity's scale, at the time in the column at [s], where it is largest",
            soft_wrap=True,
            markup=False,
        )
        if any(row.interval is not None for row in comparison.rows):
            out.print("B − A: ± from the 95 % intervals within one run each", soft_wrap=True)
    for name, entry in comparison.checks.items():
        (x, n), (y, m) = entry["a"], entry["b"]
        out.print(f"{name}: passed by {x} of {n} and {y} of {m}, worst {entry['worst']:.2g}", soft_wrap=True)
    counts = {label: dict.fromkeys(s.partition("; rows:")[0] for s in comparison.compared[label]) for label in "ab"}
    for label, sentences in counts.items():
        for sentence in sentences:
            out.print(f"{label.upper()} {sentence}", soft_wrap=True)
    if comparison.left_out:
        out.print(f"not compared, since only some runs have them: {', '.join(comparison.left_out)}", soft_wrap=True)
    for note in comparison.notes:
        out.print(note, soft_wrap=True, markup=False)
    out.print(f"method: {comparison.method}", soft_wrap=True)


def _difference(row: verdict.Row) -> str:
    interval = "" if row.interval is None else f" ± {_number(row.interval, 1)}"
    return f"{'+' if row.b >= row.a else ''}{_number(row.b - row.a, 2)}{interval}"


def _number(value: float, digits: int = 3) -> str:
    """Return a number with a few digits, a large one without exponent.

    >>> _number(12430.0), _number(0.67249), _number(-1043.2, 2)
    ('12430', '0.672', '-1043')
    """
    return f"{value:.0f}" if 10**digits <= abs(value) < 1e7 else f"{value:.{digits}g}"


def _against(runs: Sequence[Path], file: Path) -> int:
    """Compare runs with a stored digest."""
    if not runs:
        raise PywetError(f"no run was given to compare with {file}; expected RUN_DIR …", code="compare.no_run")
    stored = digest.load(file)
    with run_folder.reading(*runs):
        rows = [row for run in runs for row in digest.check(stored, run)]
    for run in dict.fromkeys(row.run for row in rows):
        table = Table(box=None, header_style="bold", pad_edge=False, title=escape(run) if len(runs) > 1 else None)
        for name in ("quantity", "now", "digest", "allowed", "unit", ""):
            table.add_column(name, no_wrap=name != "quantity", max_width=24 if name == "quantity" else None)
        for row in (row for row in rows if row.run == run):
            fits = "[green]as stored" if row.allowed < math.inf else "not judged"
            verdict_of = fits if row.ok else "[red]failed check" if row.failed_check else "[red]changed"
            expected = ("", "") if row.failed_check else (f"{row.mean:.4g}", f"± {row.allowed:.1g}")
            table.add_row(row.quantity, f"{row.value:.4g}", *expected, row.unit, verdict_of)
        out.print(table)
    bad = sorted({row.quantity for row in rows if not row.ok})
    out.print(
        f"changed since {stored.made}: {', '.join(bad)}" if bad else f"as the digest of {stored.made} says",
        style="red" if bad else "green",
        soft_wrap=True,
    )
    return DIFFERENT if bad else SAME


def of_runs(folders: Sequence[Path], out_file: Path | None) -> None:
    """Write the digest of given runs or folders of seeds."""
    if out_file is None or out_file.suffix != ".json":
        raise PywetError(
            f"--out is {out_file or 'not given'}; expected the file of the digest, such as my_case.json",
            code="digest.out", key="--out", given=out_file,
        )  # fmt: skip
    paths = [run for folder in folders for run in verdict.runs_in(folder)]
    message = f"pywet digest {' '.join(map(str, folders))}"
    with run_folder.reading(*paths):
        stored = digest.of_runs(out_file.stem, message, paths)
        written = digest.save(stored, out_file)
    typer.echo(f"{written}: {len(stored.numbers)} numbers of {stored.runs} runs")
    if stored.left_out:
        typer.echo(f"not in the digest, since only some runs have them: {', '.join(stored.left_out)}")
