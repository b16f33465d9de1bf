"""Summary at the end of a run: ten lines, and one for each number of a screen, the answer first.

details.txt, or stdout with --verbose, has all.
"""

from __future__ import annotations

import errno
import io
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import mean
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from pywet.cli.showing import err, out, show_audit, tell
from pywet.errors import PywetError, one_line
from pywet.runs.rundir import RunDir
from pywet.runs.shapes import RunSummary, Summary
from pywet.runs.spread import with_interval
from pywet.util.files import atomic_write

DETAILS = "details.txt"
WIDE = 160
"""Width of details.txt in characters."""
LISTED, LARGEST, LARGEST_OF_DECK = 2, 3, 5
"""Number of sentences on what was not checked, and of liquid reservoirs, that are printed; further sentences are counted."""


def show(folders: Sequence[Path], verbose: bool = False) -> None:
    """End `pywet run` and `run-scene`: `folders` are the run, then those of further seeds; raises if a check fails."""
    from pywet.cases.screening import verdict

    report, runs = _report(folders[0]), [RunDir(folder) for folder in folders]
    for run in runs:
        _write_details(run)
        if verbose:
            details(run, out)
    for line in lines(runs, report):
        tell(line)
    wrong = {run.path: verdict.objections(run) for run in runs}
    named = len(folders) > 1
    if message := [f"{folder}: {s}" if named else s for folder, all_of in wrong.items() for s in all_of]:
        raise PywetError(f"{'; '.join(message)}; all results are written and marked", code="cli.objections")


def lines(runs: Sequence[RunDir], report: Path | None) -> Iterator[str]:
    """Yield the summary: what was run, the answer, liquid, whether it was checked, files, the next command."""
    from pywet.cases.screening import verdict

    folder = runs[0].path
    message = _summary(runs[0])
    seeds = f", {len(runs)} seeds" if len(runs) > 1 else ""
    steps, before = message["steps"], message["resumed_at_step"] or 0
    since = f"the last {steps - before} of {steps} steps" if before else f"{steps} steps"
    yield f"{folder}: {sum(message['spheres'].values())} spheres, {since} in {message['wall_s']:.1f} s{seeds}"
    yield from _retained(runs)
    yield from _screen(runs)
    yield from _liquid(runs)
    yield from _deep(runs)
    standings = [(verdict.check_result(run), run) for run in runs]
    worst, where = min(standings, key=lambda s: verdict.ORDER.index(s[0].word))
    alike = "every seed; numbers of " if len({s.word for s, _ in standings}) == 1 else ""
    of = f" ({alike}{where.path.name})" if len(runs) > 1 else ""
    word = "nothing" if worst.word == "–" else worst.word
    yield f"checked: {word}{of}: {verdict.recomputed(where)}"
    if worst.word == "no":
        yield f"  {worst.sentence}"
    else:
        left = verdict.not_checked(where.replay or {})
        yield from (f"  {one if one.startswith('nothing') else f'not checked: {one}'}" for one in left[:LISTED])
        if len(left) > LISTED:
            yield f"  and {len(left) - LISTED} more not checked: {where.path / DETAILS}"
    tables = ("fraction_retained", "liquid_by_holder", "liquid_by_wall", "contact_statistics")
    there = [f"{name}.csv" for name in tables if (folder / "results" / f"{name}.csv").exists()]
    yield f"files: {folder}/: {DETAILS}, summary.json; results/: {', '.join(there)}"
    if report is not None:
        yield f"report: {report}"
    yield f"next: {_next(runs, worst.word)}"


def _summary(run: RunDir) -> Any:
    return run.json("summary.json", RunSummary, required=True)


def _next(runs: Sequence[RunDir], word: str) -> str:
    folders = shlex.join(str(run.path) for run in runs)
    if word == "no":
        return f"pywet replay {folders}"
    return f"pywet screen {folders}" if _screened(runs[0]) else f"pywet plot {folders} --out curves.pdf"


def _screened(run: RunDir) -> bool:
    """Return whether a run is a user-defined scene with screening results."""
    from pywet.products.screening_report import RESULT

    results = run.path / "results"
    return (results / f"{RESULT}.json").exists() and not (results / "fraction_retained.parquet").exists()


def _retained(runs: Sequence[RunDir]) -> Iterator[str]:
    """Yield the fraction retained at the end, over seeds as mean and 95 % interval; nothing for a user-defined scene."""
    if not (runs[0].path / "results" / "fraction_retained.parquet").exists():
        return
    from pywet.report import answer
    from pywet.report.collect import DRY

    read = [run.json("summary.json", Summary, required=True) for run in runs]
    ends, coarse = [s["fraction_retained_end"] for s in read], read[0]["coarse_share"]
    dry = [float(run.table("results/fraction_retained")[DRY].iloc[-1]) for run in runs]
    share = round(mean(answer.passed(dry, coarse)))
    passed = f", so {share} % of what can pass has passed" if coarse < 1.0 else ""
    spread = f" (95 % interval of the mean over {len(ends)} seeds)" if len(ends) > 1 else ""
    yield (f"fraction retained at the end {with_interval(ends)}{spread}; share that cannot pass {coarse:.3f}{passed}")


def _screen(runs: Sequence[RunDir]) -> Iterator[str]:
    """Return the lines on the screen of a custom scene, of several seeds the means."""
    from pywet.products import screening_report, until
    from pywet.report.screen_page import five, over_seeds

    if all(_screened(run) for run in runs):
        read = [numbers for run in runs if (numbers := screening_report.stored(run.path))]
        words = five(read[0]) if len(read) == 1 else over_seeds(read)
        names = [f"{name:<{max(map(len, words))}}" for name in words]
        yield from (f"{name}  {value}" for name, value in zip(names, words.values(), strict=True))
        if len(read) > 1:
            yield f"±: 95 % interval of the mean over {len(read)} seeds"
        if warning := next(filter(None, map(screening_report.unsteady, read)), None):
            yield warning
    if known := runs[0].json(until.RESULT, Any):
        yield until.sentence(known)


def _liquid(runs: Sequence[RunDir]) -> Iterator[str]:
    """Yield the line on the largest shares of liquid at the end and on the bridges; none for a dry run.

    With outlets, all spheres that are still inside are one share, and all walls another.
    """
    from pywet.cases.screening.results import class_titles

    read = [_summary(run) for run in runs]
    if not read[0]["initial_liquid_m3"]:
        return
    names = filter(_reservoir, read[0]["liquid_end_m3"])
    shares = {n: [100.0 * s["liquid_end_m3"].get(n, 0.0) / s["initial_liquid_m3"] for s in read] for n in names}
    titles, outlets = class_titles(runs[0].scene), runs[0].scene.outlets
    walls = [name for name in shares if name.startswith("wall_")]
    for name, parts in (("spheres inside", titles), ("walls", walls)) if outlets else ():
        if there := [shares.pop(part) for part in parts if part in shares]:
            shares[name] = [sum(of_run) for of_run in zip(*there, strict=True)]
    largest = sorted(shares.items(), key=lambda entry: -mean(entry[1]))[: LARGEST_OF_DECK if outlets else LARGEST]
    text = ", ".join(f"{with_interval(share)} % {titles.get(n, n.replace('_', ' '))}" for n, share in largest)
    events = [s["events"] for s in read if s["events"]]
    counts = [with_interval([e[kind] for e in events]) for kind in ("formations", "ruptures")] if events else []
    bridges = f"; {counts[0]} bridges formed, {counts[1]} ruptured" if counts else ""
    yield f"liquid at the end: {text}{bridges}"


def _deep(runs: Sequence[RunDir]) -> Iterator[str]:
    """Yield the line on deep overlaps of a user-defined scene, if any."""
    from pywet.report import scene_page
    from pywet.runs.loaded import Run

    if (sentence := scene_page.deep([Run(run.path) for run in runs])) is not None:
        yield sentence


def _reservoir(name: str) -> bool:
    """Return whether a volume of liquid_end_m3 is a reservoir, neither a sum nor one class of spheres."""
    parts = ("coarse_material_", "fines_")
    return name not in ("total", "standing_bridges") and not name.startswith(parts)


def _report(folder: Path) -> Path | None:
    """Write the run's page again; if that fails, print a message to standard error and return None."""
    from pywet.report import scene_page as page

    try:
        return page.of_run(folder)
    except PywetError as error:
        if isinstance(error.__cause__, OSError) and error.__cause__.errno == errno.ENOSPC:
            raise  # the next step would fail as well
        err.print(f"no report: {one_line(str(error))}", soft_wrap=True, markup=False)
        return None


def _write_details(run: RunDir) -> None:
    text = io.StringIO()
    details(run, Console(file=text, width=WIDE, highlight=False, no_color=True))
    with atomic_write(run.path / DETAILS) as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8")


def details(run: RunDir, to: Console) -> None:
    """Print the final liquid, the laws by kind (with the file of a law in a file), the effects, and the replay's findings."""
    for name, volume in _summary(run)["liquid_end_m3"].items():
        to.print(f"liquid at the end, {name:<32}{1e9 * volume:10.4g} mm3", markup=False)
    if laws := run.scene.effects.laws:
        to.print("laws: " + ", ".join(f"{kind} {law.rpartition('/')[2]}" for kind, law in laws.items()), markup=False)
    show_audit(run.path, to)
    if run.replay:
        _agreement(run.replay, to)


def _agreement(replay: dict[str, Any], to: Console) -> None:
    """Print the agreement table, what was not checked, and the diagnosis of a disagreement."""
    from pywet.cases.screening import verdict
    from reference_impl.replay import whole

    table = Table("quantity", "values", "largest", "median", "allowed", "", box=None, header_style="bold")
    for row in verdict.agreement(replay):
        message = "[green]agrees" if row.ok else "[red]disagrees"
        numbers = (f"{row.largest:.1e}", f"{row.median:.1e}", f"{row.limit:.0e}")
        table.add_row(escape(row.quantity), str(row.count), *numbers, message)
    to.print(table)
    sentences = [whole.sentence(replay["compared"])] if "compared" in replay else []
    sentences += [s if s.startswith("nothing") else f"not checked: {s}" for s in verdict.not_checked(replay)]
    for kind, function in (replay.get("second") or {}).items():
        sentences.append(f"{kind}: compared with {Path(function).name}, a reference implementation of the user")
    sentences += [f"not checked: {sentence}" for sentence in verdict.unchecked_laws(replay)]
    sentences += [finding["sentence"] for finding in (replay.get("diagnosis") or {}).get("findings", [])]
    for sentence in sentences:
        to.print(sentence, soft_wrap=True, markup=False)
