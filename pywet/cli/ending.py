"""Summary at the end of a run: at most ten lines, the answer first; details.txt, or stdout with --verbose, has all."""

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
from pywet.runs.shapes import Replay, RunSummary, Summary
from pywet.runs.spread import with_interval
from pywet.util.files import atomic_write, read_if_there, read_json

DETAILS = "details.txt"
WIDE = 160
"""Width of details.txt in characters."""
LISTED, LARGEST = 2, 3
"""Number of sentences on what was not checked, and of liquid reservoirs, that are printed; further sentences are counted."""


def show(folders: Sequence[Path], verbose: bool = False) -> None:
    """End `pywet run` and `run-scene`: `folders` are the run, then those of further seeds; raises if a check fails."""
    from pywet.cases.screening import verdict

    report = _report(folders[0])
    for folder in folders:
        _write_details(folder)
        if verbose:
            details(folder, out)
    for line in lines(folders, report):
        tell(line)
    wrong = {folder: verdict.objections(folder) for folder in folders}
    named = len(folders) > 1
    if message := [f"{folder}: {s}" if named else s for folder, all_of in wrong.items() for s in all_of]:
        raise PywetError(f"{'; '.join(message)}; all results are written and marked", code="cli.objections")


def lines(folders: Sequence[Path], report: Path | None) -> Iterator[str]:
    """Yield the summary: what was run, the answer, liquid, whether it was checked, files, the next command."""
    from pywet.cases.screening import verdict

    folder = folders[0]
    message = read_json(folder / "summary.json", shape=RunSummary)
    seeds = f", {len(folders)} seeds" if len(folders) > 1 else ""
    yield f"{folder}: {sum(message['spheres'].values())} spheres, {message['steps']} steps in {message['wall_s']:.1f} s{seeds}"
    yield from _retained(folders)
    yield from _screen(folders)
    yield from _liquid(folders)
    yield from _deep(folders)
    standings = [(verdict.check_result(f), f) for f in folders]
    worst, where = min(standings, key=lambda s: ("no", "in part", "–", "yes").index(s[0].word))
    of = f" ({where.name})" if len(folders) > 1 else ""
    word = "nothing" if worst.word == "–" else worst.word
    yield f"checked: {word}{of}: {verdict.recomputed(where)}"
    if worst.word == "no":
        yield f"  {worst.sentence}"
    else:
        left = verdict.not_checked(dict(read_if_there(where / "replay.json", shape=Replay) or {}))
        yield from (f"  {one if one.startswith('nothing') else f'not checked: {one}'}" for one in left[:LISTED])
        if len(left) > LISTED:
            yield f"  and {len(left) - LISTED} more not checked: {where / DETAILS}"
    tables = ("fraction_retained", "liquid_by_holder", "liquid_by_wall", "contact_statistics")
    there = [f"{name}.csv" for name in tables if (folder / "results" / f"{name}.csv").exists()]
    yield f"files: {folder}/: {DETAILS}, summary.json; results/: {', '.join(there)}"
    if report is not None:
        yield f"report: {report}"
    yield f"next: {_next(folders, worst.word)}"


def _next(folders: Sequence[Path], word: str) -> str:
    runs = shlex.join(map(str, folders))
    if word == "no":
        return f"pywet replay {runs}"
    return f"pywet screen {runs}" if _screened(folders[0]) else f"pywet plot {runs} --out curves.pdf"


def _screened(folder: Path) -> bool:
    """Return whether a run is a user-defined scene with screening results."""
    from pywet.products.screening_report import RESULT

    results = folder / "results"
    return (results / f"{RESULT}.json").exists() and not (results / "fraction_retained.parquet").exists()


def _retained(folders: Sequence[Path]) -> Iterator[str]:
    """Yield the fraction retained at the end, over seeds as mean and 95 % interval; nothing for a user-defined scene."""
    if not (folders[0] / "results" / "fraction_retained.parquet").exists():
        return
    read = [read_json(folder / "summary.json", shape=Summary) for folder in folders]
    ends = [s["fraction_retained_end"] for s in read]
    coarse = read[0]["coarse_share"]
    passed = (1.0 - mean(ends)) / (1.0 - coarse)
    spread = f" (95 % interval of the mean over {len(ends)} seeds)" if len(ends) > 1 else ""
    yield (
        f"fraction retained at the end {with_interval(ends)}{spread}; share that cannot pass {coarse:.3f}, "
        f"so {round(100 * passed)} % of what can pass has passed"
    )


def _screen(folders: Sequence[Path]) -> Iterator[str]:
    """Return the lines on the screen of a custom scene, of several seeds the means."""
    from pywet.products import until
    from pywet.products.screening_report import RESULT
    from pywet.report.screen_page import five, over_seeds, unsteady

    if all(_screened(folder) for folder in folders):
        read: list[dict[str, Any]] = [read_json(folder / "results" / f"{RESULT}.json") for folder in folders]
        words = five(read[0]) if len(read) == 1 else over_seeds(read)
        spread = f" (95 % interval of the mean over {len(read)} seeds)" if len(read) > 1 else ""
        yield ", ".join(f"{name} {value}" for name, value in words.items()) + spread
        if warning := next(filter(None, map(unsteady, read)), None):
            yield warning
    if (known := folders[0] / until.RESULT).exists():
        yield until.sentence(read_json(known))


def _liquid(folders: Sequence[Path]) -> Iterator[str]:
    """Yield the lines on the largest shares of liquid at the end and on the bridges; none for a dry run."""
    from pywet.cases.screening.results import class_titles
    from pywet.runs.rundir import RunDir

    read = [read_json(folder / "summary.json", shape=RunSummary) for folder in folders]
    if not read[0]["initial_liquid_m3"]:
        return
    names = filter(_reservoir, read[0]["liquid_end_m3"])
    shares = {n: [100.0 * s["liquid_end_m3"].get(n, 0.0) / s["initial_liquid_m3"] for s in read] for n in names}
    largest = sorted(shares.items(), key=lambda entry: -mean(entry[1]))[:LARGEST]
    titles = class_titles(RunDir(folders[0]).scene)
    text = ", ".join(f"{with_interval(share)} % {titles.get(n, n.replace('_', ' '))}" for n, share in largest)
    events = [s["events"] for s in read if s["events"]]
    counts = [with_interval([e[kind] for e in events]) for kind in ("formations", "ruptures")] if events else []
    bridges = f"; {counts[0]} bridges formed, {counts[1]} ruptured" if counts else ""
    yield f"liquid at the end: {text}{bridges}"


def _deep(folders: Sequence[Path]) -> Iterator[str]:
    """Yield the line on deep overlaps of a user-defined scene, if any."""
    from pywet.report import scene_page
    from pywet.runs.loaded import Run

    if (sentence := scene_page.deep([Run(folder) for folder in folders])) is not None:
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


def _write_details(folder: Path) -> None:
    text = io.StringIO()
    details(folder, Console(file=text, width=WIDE, highlight=False, no_color=True))
    with atomic_write(folder / DETAILS) as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8")


def details(folder: Path, to: Console) -> None:
    """Print the final liquid, the laws by kind (with the file of a law in a file), the effects, and the replay's findings."""
    from pywet.scene import EngineScene

    message = read_json(folder / "summary.json", shape=RunSummary)
    for name, volume in message["liquid_end_m3"].items():
        to.print(f"liquid at the end, {name:<32}{1e9 * volume:10.4g} mm3", markup=False)
    if laws := EngineScene.read(folder / "scene.json").effects.laws:
        to.print("laws: " + ", ".join(f"{kind} {law.rpartition('/')[2]}" for kind, law in laws.items()), markup=False)
    show_audit(folder, to)
    if replayed := read_if_there(folder / "replay.json", shape=Replay):
        _agreement(replayed, to)


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
